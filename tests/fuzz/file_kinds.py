"""Every kind of file that vividc reads: a good one to start from, and what reads it."""

from __future__ import annotations

import io
import json
import os
import shutil
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

import click
import numpy as np
from click.testing import CliRunner
from numpy.typing import NDArray
from PIL import Image

from tests.fuzz.file_scenes import POSE, SCENES, ply_bytes, views
from tests.mapper.graphs import accumulator
from vividc import dfg, program
from vividc.cli import completion, main
from vividc.host import cache, compiled_files, machine_code
from vividc.paper.frames import Key, Row, measured
from vividc.paper.scenes import Scenes
from vividc.program import kept
from vividc.render import load_cameras, load_reference_images

ROOT: Final = Path(__file__).parents[2]

KERNEL: Final = '''"""A kernel."""

import numpy as np
import vividc

SCALE = np.float32(2.0)


@vividc.kernel("int32(int32[::1], int32[::1], int32)")
def sums(x, y, n):
    s = 0
    for i in range(n):
        y[i] = 3 * x[i]
        s += y[i]
    return s
'''
_PARALLEL: Final = """import vividc
from numba import prange


@vividc.kernel("void(int32[::1], int32[::1])")
def double(x, y):
    for i in prange(len(y)):
        y[i] = x[i] + x[i]
"""
_DOT: Final = """digraph g {
  // a ring with a load
  x [op=load, array=x]; a [op=add, label="add a"]; b [op=mul]; c [opcode=const, const=7];
  x -> a [operand=0, distance=0]; a -> b [distance=0]; c -> b [operand=RHS];
  b -> a [distance=1, operand=1];
}
"""
_XML: Final = """<?xml version="1.0"?>
<MutexBB></MutexBB>
<DFG count="3">
<Node idx="1" ASAP="0" ALAP="0" BB="a" CONST="4">
<OP>LOAD</OP>
<BasePointerName size="16">x</BasePointerName>
<Inputs>
</Inputs>
<Outputs>
<Output idx="2" nextiter="0" type="I1"/>
</Outputs>
</Node>
<Node idx="2" ASAP="1" ALAP="1" BB="a">
<OP>ADD</OP>
<Inputs>
<Input idx="1"/>
</Inputs>
<Outputs>
<Output idx="2" nextiter="1" type="I2"/>
<Output idx="3" nextiter="0" type="I1"/>
</Outputs>
</Node>
<Node idx="3" ASAP="2" ALAP="2" BB="a">
<OP>ADD</OP>
<Inputs>
<Input idx="2"/>
</Inputs>
<Outputs>
</Outputs>
</Node>
</DFG>
"""
_COSTS: Final = ROOT / "vividc/arch/cost_tables/vivid-45nm.yaml"
_FABRICS: Final = ROOT / "vividc/arch"


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of file.

    Attributes
    ----------
    form
        Of `file_damage`.
    file
        Its name; it lies beside the others.
    arguments
        Of the command line, with {file}, {out} and {home}, the folder of the others.
    call
        Instead of a command: reads the file; raises nothing but `VividcError`.
    share
        How often it is drawn; at most 3: its runs take long.
    alone
        Each file needs a process that has read no other.
    codes
        Exit codes, if not all but that of an internal error.
    """

    name: str
    form: str
    file: str
    data: bytes
    arguments: tuple[str, ...] = ()
    call: Callable[[Path], object] | None = None
    share: int = 10
    alone: bool = False
    codes: tuple[int, ...] = (0, 2, 3, 4, 5)


def kinds(home: Path) -> tuple[Kind, ...]:
    """All kinds; the files that they need beside themselves are written to `home`."""
    with _own_caches(home):
        _programs(home)
        _graphs(home)
        _scenes(home)
        return (
            *_of_programs(home),
            *_of_graphs(home),
            *_of_machines(home),
            *_of_scenes(home),
            *_of_entries(home),
        )


@contextmanager
def _own_caches(home: Path) -> Iterator[None]:
    before = dict(os.environ)
    os.environ |= {"VIVIDC_CACHE_DIR": str(home / "cache"), "XDG_STATE_HOME": str(home / "state")}
    try:
        yield
    finally:
        os.environ.clear()
        os.environ |= before


def _run(*args: object) -> None:
    done = CliRunner().invoke(main, [str(arg) for arg in args])
    assert done.exit_code == 0, done.output


def _programs(home: Path) -> None:
    (home / "sums.py").write_text(KERNEL)
    (home / "double.py").write_text(_PARALLEL)
    _run("compile", home / "sums.py", "--fabric", "mesh-2x2", "-o", home / "sums.vivid")
    _run("compile", home / "double.py", "-o", home / "double.vivid")
    shutil.copy(ROOT / "tests/frontend/c/loops.ll", home / "loops.ll")
    x = np.arange(6, dtype=np.int32)
    np.savez(home / "sums.npz", x=x, y=x, n=np.int32(6))
    np.savez(home / "double.npz", x=x, y=x)


def _of_programs(home: Path) -> Iterator[Kind]:
    sums, double = ((home / name).read_bytes() for name in ("sums.vivid", "double.vivid"))
    run = ("simulate", "{file}", "--inputs", "{home}/sums.npz", "--cycle-limit", "20000")
    to = ("--outputs", "{out}", "--json")
    reference, native = ("--engine", "reference"), ("--engine", "native")
    yield Kind("program", "bundle", "p.vivid", sums, (*run, *reference, *to), share=30)
    yield Kind("program on native code", "bundle", "p.vivid", sums, (*run, *native, *to))
    reports = ("--energy", "--trace", "{out}", "--window", "0:50", *reference)
    yield Kind("program with reports", "bundle", "p.vivid", sums, (*run, *reports))
    tiles = ("simulate", "{file}", "--inputs", "{home}/double.npz", "--fabric", "vivid", *to)
    yield Kind(
        "program on tiles", "bundle", "p.vivid", double, (*tiles, "--cycle-limit", "20000"), share=3
    )
    check = (*run, *reference, "--check")
    yield Kind("program to check", "bundle", "p.vivid", sums, check, share=2)
    yield Kind("program to disassemble", "bundle", "p.vivid", sums, ("disasm", "{file}"))
    inputs = ("simulate", "{home}/sums.vivid", "--inputs", "{file}", *run[4:], *reference, *to)
    npz, npy = (home / "sums.npz").read_bytes(), io.BytesIO()
    np.save(npy, np.arange(3))
    yield Kind("arguments", "npz", "in.npz", npz, inputs, share=30)
    yield Kind("npy as arguments", "npy", "in.npy", npy.getvalue(), inputs, share=2, codes=(2,))
    compiling = ("compile", "{file}", "--fabric", "mesh-2x2", "--time-limit", "3", "-o", "{out}")
    yield Kind("kernel", "text", "k.py", KERNEL.encode(), compiling, share=3)
    c_file = (home / "loops.ll").read_bytes()
    in_c = ("compile", "{file}:up", *compiling[2:])
    yield Kind("kernel in C", "text", "k.ll", c_file, in_c, share=3)
    seen = ("view", "{file}", "--inputs", "{home}/sums.npz", "--cycles", "0:20", "-o", "{out}")
    yield Kind("program to view", "bundle", "p.vivid", sums, seen, share=3)
    beside = ("view", "{home}/sums.vivid", "--source", "{file}", "-o", "{out}")
    yield Kind("source to view", "text", "k.py", KERNEL.encode(), beside, share=3)
    yield Kind("kernel to complete", "text", "k.py", KERNEL.encode(), call=_complete)


def _complete(path: Path) -> object:
    """What TAB offers behind the file's name."""
    command = click.Command("compile")
    return completion.kernel(click.Context(command), click.Option(["--of"]), f"{path}:")


def _graphs(home: Path) -> None:
    (home / "g.dot").write_text(_DOT)
    graph = dfg.load(home / "g.dot")
    (home / "g.json").write_text(json.dumps(dfg.to_json(graph), indent=1))
    (home / "g.dfg").write_text(dfg.to_text(graph))
    (home / "g.xml").write_text(_XML)
    lines = dfg.to_json(accumulator())
    for number, node in enumerate(lines["nodes"]):
        node["loc"] = f"{home}/sums.py:{number}"
    (home / "lines.json").write_text(json.dumps(lines))
    for name in ("g.json", "lines.json"):
        to = (home / name).with_suffix(".map")
        _run("map", home / name, "--fabric", "mesh-3x3", "-o", to)


def _of_graphs(home: Path) -> Iterator[Kind]:
    mapping = (
        "map",
        "{file}",
        "--fabric",
        "mesh-2x2",
        "--time-limit",
        "2",
        "--json",
        "-o",
        "{out}",
    )
    forms = {"JSON": ("g.json", "json"), "DOT": ("g.dot", "text"), "XML": ("g.xml", "text")}
    forms |= {"text": ("g.dfg", "text")}
    for name, (file, form) in forms.items():
        yield Kind(f"graph {name}", form, file, (home / file).read_bytes(), mapping, share=8)
    stages = ("compile", home / "sums.py", "--fabric", "mesh-2x2", "--stop-after", "frontend")
    _run(*stages, "--print-to", home / "stages")
    function = next((home / "stages").glob("*-frontend.txt")).read_bytes()
    passes = ("opt", "{file}", "--passes", "normalize,hoist-loads,merge-diamonds,tidy")
    yield Kind("function text", "text", "f.ssa", function, passes, share=20)
    read = next((home / "stages").glob("*-straighten-single-trips.txt"))
    narrowing = "recover-extensions,straighten-single-trips,unrotate,load-flags,extend-loads,"
    narrowing += "store-low-bits,fold-by-ranges,sign-quotients,narrow"
    passes = ("opt", "{file}", "--passes", narrowing)
    yield Kind("function text of LLVM", "text", "f.ssa", read.read_bytes(), passes, share=20)
    passes = ("opt", "{file}", "--passes", "fold-constants,expand-math,balance-reductions")
    yield Kind("graph of opt", "text", "g.dfg", (home / "g.dfg").read_bytes(), passes)
    published = (ROOT / "tests/data/foreign_accumulate.json").read_bytes()
    yield Kind("graph published", "json", "g.json", published, mapping, share=4)
    lines = (home / "lines.json").read_bytes()
    yield Kind("graph with lines", "json", "g.json", lines, mapping, share=4)
    verify = ("verify", "{file}", "--json")
    for name in ("g.map", "lines.map"):
        data = (home / name).read_bytes()
        yield Kind("mapping", "json", "m.json", data, verify, share=20)
    other = ("verify", "{home}/g.map", "--dfg", "{file}")
    yield Kind("graph to verify", "json", "g.json", (home / "g.json").read_bytes(), other)
    yield Kind("networkx", "tree", "n.json", _node_link(home), call=_from_networkx)


def _node_link(home: Path) -> bytes:
    graph = dfg.to_networkx(dfg.load(home / "g.json"))
    nodes = [[name, dict(given)] for name, given in graph.nodes(data=True)]
    edges = [[*ends, dict(given)] for *ends, given in graph.edges(data=True)]
    return json.dumps({"nodes": nodes, "edges": edges}).encode()


def _from_networkx(path: Path) -> object:
    """A graph as a user's own reader makes it, of whatever values."""
    import networkx as nx  # noqa: PLC0415

    try:
        tree = json.loads(path.read_text())
        graph = nx.MultiDiGraph()
        for name, given in tree["nodes"]:
            graph.add_node(name, **given)
        for one, other, given in tree["edges"]:
            graph.add_edge(one, other, **given)
    except (ValueError, TypeError, KeyError, RecursionError, nx.NetworkXException):
        return None
    return dfg.from_networkx(graph)


def _of_machines(home: Path) -> Iterator[Kind]:
    tile = (_FABRICS / "presets/vivid-tile.yaml").read_bytes()
    own = b"extends: mesh-2x2\nname: own\nclock_ghz: 0.5\nlatencies: {float: 2, load: 3}\nlinks:\n"
    own += b"  extra:\n    - {from: [0, 0], to: [1, 1]}\noverrides:\n  - at: {rows: 0}\n"
    own += b"    memory: true\n"
    (home / "derived.yaml").write_text("extends: base.yaml\nclock_ghz: 0.5\n")
    area = ("area", "{file}", "--json")
    yield Kind("fabric", "yaml", "f.yaml", tile, area, share=15)
    yield Kind("fabric of a map", "yaml", "f.yaml", own, _mapped_on("{file}"), share=10)
    base = b"extends: mesh-2x2\nrows: 3\npe: {constants: 8}\n"
    yield Kind("base of a fabric", "yaml", "base.yaml", base, ("area", "{home}/derived.yaml"))
    machine = (_FABRICS / "accelerators/vivid.yaml").read_bytes()
    yield Kind("accelerator", "yaml", "a.yaml", machine, area, share=15)
    (home / "machine.yaml").write_text("extends: under.yaml\nnoc: {latency: 3}\n")
    under = b"extends: vivid\ntiles: {rows: 2, cols: 2, fabric: mesh-2x2}\n"
    yield Kind(
        "base of an accelerator", "yaml", "under.yaml", under, ("area", "{home}/machine.yaml")
    )
    costs = _COSTS.read_bytes()
    yield Kind(
        "costs", "yaml", "c.yaml", costs, ("area", "vivid-tile", "--costs", "{file}"), share=6
    )
    run = ("simulate", "{home}/sums.vivid", "--inputs", "{home}/sums.npz", "--engine", "reference")
    yield Kind(
        "costs of a run", "yaml", "c.yaml", costs, (*run, "--costs", "{file}", "--energy"), share=6
    )


def _mapped_on(fabric: str) -> tuple[str, ...]:
    return ("map", "{home}/g.json", "--fabric", fabric, "--time-limit", "2", "-o", "{out}")


def _scenes(home: Path) -> None:
    small = {name: array() for name, array in SCENES.items()}
    for name, arrays in small.items():
        np.savez(home / f"{name}.npz", **arrays)
    for form in ("ascii", "binary_little_endian"):
        (home / f"{form}.ply").write_bytes(ply_bytes(form))
    pixels = np.random.default_rng(1).integers(0, 255, (8, 8, 4)).astype(np.uint8)
    for form in ("PNG", "JPEG", "WEBP", "BMP"):
        picture = Image.fromarray(pixels)
        picture = picture.convert("RGB") if form in ("JPEG", "BMP") else picture
        picture.save(home / f"picture.{form.lower()}", form)
        frame = {"file_path": f"picture.{form.lower()}", "transform_matrix": POSE}
        seen = {"camera_angle_x": 0.7, "frames": [frame, {**frame, "file_path": "./none"}]}
        (home / f"views-{form.lower()}.json").write_text(json.dumps(seen))
    np.savez(home / "views.npz", **views())


def _of_scenes(home: Path) -> Iterator[Kind]:
    draw = ("render", "{file}", "--size", "6x4", "--json")
    for name in SCENES:
        data = (home / f"{name}.npz").read_bytes()
        yield Kind(f"scene: {name}", "npz", "s.npz", data, draw, share=12)
    binary, text = (
        (home / f"{form}.ply").read_bytes() for form in ("binary_little_endian", "ascii")
    )
    yield Kind("scene ply", "ply", "s.ply", binary, draw, share=12)
    yield Kind("scene ply in text", "ply", "s.ply", text, draw, share=12)
    yield Kind("scene without an ending", "ply", "scene", binary, draw, share=2)
    seen = ("render", "{home}/means.npz", "--views", "{file}", "-o", "{out}.png")
    named = (home / "views-png.json").read_bytes()
    yield Kind("views", "json", "v.json", named, seen, share=12)
    yield Kind("views npz", "npz", "v.npz", (home / "views.npz").read_bytes(), seen, share=12)
    for form in ("png", "jpeg", "webp", "bmp"):
        data = (home / f"picture.{form}").read_bytes()
        by = ("render", "{home}/means.npz", "--views", f"{{home}}/views-{form}.json")
        yield Kind(f"picture {form.upper()}", "bytes", f"picture.{form}", data, by, share=5)
    cameras = (home / "views.npz").read_bytes()
    yield Kind("cameras", "npz", "v.npz", cameras, call=_cameras, share=5)


def _cameras(path: Path) -> object:
    return load_cameras(path), load_reference_images(path)


def _of_entries(home: Path) -> Iterator[Kind]:
    """Entries of the cache as files, and what stands in them under a right checksum."""
    os.environ["VIVIDC_CACHE_DIR"] = str(home / "cache")
    run = ("simulate", "{home}/sums.vivid", "--inputs", "{home}/sums.npz", "--engine", "native")
    _run(*(part.format(home=home) for part in run))
    found = program.load(home / "sums.vivid")
    kept.write_program("stage", "fuzz", found)
    before = [file for file in (home / "cache/entries").iterdir() if "loops-" in file.name]
    in_child(lambda: _run_loops(home))  # so that this process has not loaded it
    compiled_files.note(str(home / "sums.py"), found.provenance.kernel_sha256)
    entries = sorted((home / "cache/entries").iterdir())
    by_kind = {file.name.partition("-")[0]: file for file in entries if file not in before}
    engine, loops, stage = (by_kind[kind] for kind in ("engine", "loops", "stage"))
    to_entry = "cache/entries/"
    yield Kind(
        "entry: engine",
        "bytes",
        to_entry + engine.name,
        engine.read_bytes(),
        run,
        share=3,
        codes=(0,),
    )
    yield Kind(
        "entry: loops",
        "bytes",
        to_entry + loops.name,
        loops.read_bytes(),
        call=_run_loops,
        alone=True,
        share=3,
    )
    yield Kind(
        "entry: stage",
        "bytes",
        to_entry + stage.name,
        stage.read_bytes(),
        call=_read_stage,
        share=5,
    )
    yield Kind(
        "content of a stage", "bundle", "kept.vivid", found.to_bytes(), call=_read_resigned, share=5
    )
    record = next((home / "state/vividc/compiled").iterdir())
    yield Kind(
        "entry: compiled",
        "bytes",
        f"state/vividc/compiled/{record.name}",
        record.read_bytes(),
        call=_read_record,
        share=3,
    )
    row = Row(Key("mic", "3dgs", 200, 0), "done", 179.0, {"blend": 5e6}, energy_mj=2.0)
    line = json.dumps({"made_by": "", **asdict(row)}).encode() + b"\n"
    yield Kind("kept frames", "text", "frames.jsonl", 2 * line, call=_read_frames)


@machine_code.Compiler()
def _tripled(x: NDArray[np.int64]) -> int:
    total = 0
    for i in range(len(x)):
        total += 3 * x[i]
    return total


def in_child(work: Callable[[], object]) -> None:
    """Do something in a process of its own.

    Raises
    ------
    ChildProcessError
        It failed there.
    """
    child = os.fork()
    if not child:
        try:
            work()
            os._exit(0)
        finally:
            os._exit(1)
    if os.waitpid(child, 0)[1]:
        raise ChildProcessError


def _run_loops(_: Path) -> object:
    assert _tripled(np.arange(5)) == 30, "machine code that is not what was kept"
    return None


def _read_stage(_: Path) -> object:
    return kept.read_program("stage", "fuzz")


def _read_resigned(path: Path) -> object:
    cache.write("stage", "resigned", zlib.compress(path.read_bytes(), 1))
    return kept.read_program("stage", "resigned")


def _read_frames(path: Path) -> object:
    return next(iter(measured([], Scenes(()), path)))


def _read_record(path: Path) -> object:
    source = path.parents[3] / "sums.py"
    return compiled_files.is_noted(
        source, program.load(path.parents[3] / "sums.vivid").provenance.kernel_sha256
    )
