"""What the hints of messages say helps: each row makes a mistake, and then does what its hint says.

Hints about numpy's functions are tried in `tests/frontend/test_hints.py`.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import vividc
from tests import hint_kernels as k
from vividc import arch, dfg
from vividc.cli import main
from vividc.frontend import KernelFunction
from vividc.mapper import map_dfg

BLOCKS = vividc.LoopOptions(auto=False)
GRAPH = dfg.from_json(
    {
        "name": "g",
        "nodes": [{"id": 0, "op": "live_in", "name": "a"}, {"id": 1, "op": "add"}],
        "edges": [
            {"src": 0, "dst": 1, "distance": 0, "operand": 0},
            {"src": 1, "dst": 1, "distance": 1, "operand": 1},
        ],
    }
)


@dataclass(frozen=True)
class Row:
    """A mistake, what its hint says, and the same with that done."""

    wrong: Callable[[], object]
    says: str
    mended: Callable[[], object]


SIGNATURE = "void(int32[::1], int32[::1], int32)"


def kernel(function=k.add, signature=SIGNATURE, **how):
    return vividc.kernel(signature, **how)(function)


def compiled(function=k.add, signature=SIGNATURE, fabric="vivid-tile", **how):
    return vividc.compile(kernel(function, signature), fabric, effort="fast", **how)


@pytest.fixture(scope="module", autouse=True)
def program():
    """One program for all rows about launches."""
    made = compiled()
    ROWS_OF["program"] = made
    return made


ROWS_OF: dict[str, vividc.Program] = {}


def run(x, y=None, n=4, **how):
    y = np.zeros(8, np.int32) if y is None else y
    return vividc.simulate(ROWS_OF["program"], x, y, n, **how)


X = np.arange(8, dtype=np.int32)
WIDE = np.arange(16, dtype=np.int32)


def lowered(function, signature=SIGNATURE):
    return KernelFunction(function, signature, None).lower()


FABRIC = "extends: mesh-4x4\nname: mine\n"


def yaml(text):
    return lambda: arch.load_text(text, "mine.yaml")


ROWS = {
    "strides": Row(lambda: run(WIDE[::2]), r"np\.ascontiguousarray", lambda: run(WIDE[::2].copy())),
    "dtype": Row(
        lambda: run(X.astype(np.float64)),
        r"convert it: np\.ascontiguousarray\(x, np\.int32\)",
        lambda: run(np.ascontiguousarray(X.astype(np.float64), np.int32)),
    ),
    "axes": Row(
        lambda: run(X.reshape(2, 4)),
        r"x\.reshape\(-1\)",
        lambda: run(X.reshape(2, 4).reshape(-1)),
    ),
    "mask": Row(
        lambda: run(np.ma.masked_array(X)),
        r"x\.filled\(0\)",
        lambda: run(np.ma.masked_array(X).filled(0)),
    ),
    "read-only": Row(
        lambda: run(X, np.frombuffer(bytes(32), np.int32)),
        "pass a copy",
        lambda: run(X, np.frombuffer(bytes(32), np.int32).copy()),
    ),
    "overlap": Row(lambda: run(X, X), r"pass x\.copy\(\)", lambda: run(X.copy(), X)),
    "float for an integer": Row(
        lambda: run(X, n=4.0), r"convert it with int\(", lambda: run(X, n=int(4.0))
    ),
    "cycle limit": Row(
        lambda: run(X, cycle_limit=2), "raise cycle_limit", lambda: run(X, cycle_limit=10_000)
    ),
    "cycle limit of 0": Row(
        lambda: run(X, cycle_limit=0), "from 1 on", lambda: run(X, cycle_limit=1_000)
    ),
    "engine": Row(
        lambda: run(X, engine="fast"), "native, reference", lambda: run(X, engine="reference")
    ),
    "index": Row(lambda: run(X, n=9), "an index may leave its array", lambda: run(X, n=8)),
    "save": Row(lambda: ROWS_OF["program"].save(None), r"program\.save\('saxpy", lambda: None),
    "no signature": Row(
        lambda: vividc.kernel(k.add), r'@vividc\.kernel\("void\(', lambda: kernel(k.add)
    ),
    "parameters": Row(
        lambda: kernel(k.add, "void(int32[::1])"), "one type for each parameter", kernel
    ),
    "layout": Row(
        lambda: kernel(k.add, "void(int32[:], int32[::1], int32)"), r"write int32\[::1\]", kernel
    ),
    "error model": Row(
        lambda: kernel(error_model="fast"), "numpy", lambda: kernel(error_model="numpy")
    ),
    "undecorated": Row(lambda: vividc.compile(k.add), r"@vividc\.kernel", lambda: kernel().lower()),
    "threads without prange": Row(
        lambda: compiled(loops=vividc.LoopOptions(threads=2)),
        r"for i in prange\(n\)",
        lambda: compiled(k.spread, loops=vividc.LoopOptions(threads=2)),
    ),
    "threads": Row(
        lambda: vividc.LoopOptions(threads=9),
        "give 1 to 8",
        lambda: vividc.LoopOptions(threads=8),
    ),
    "factor": Row(
        lambda: vividc.LoopOptions(unroll={12: 3}),
        "a power of two",
        lambda: vividc.LoopOptions(unroll={12: 2}),
    ),
    "line": Row(
        lambda: vividc.LoopOptions(unroll={0: 2}),
        "from 1",
        lambda: vividc.LoopOptions(unroll={1: 2}),
    ),
    "transform": Row(
        lambda: compiled(transform="off"),
        r"LoopOptions\(auto=False\)",
        lambda: compiled(loops=BLOCKS),
    ),
    "precision": Row(
        lambda: compiled(precision={"sin": "fp8"}),
        "exp",
        lambda: compiled(precision={"exp": "fp8"}),
    ),
    "format": Row(
        lambda: compiled(precision={"exp": "fp9"}),
        "fp8",
        lambda: compiled(precision={"exp": "fp8"}),
    ),
    "mode": Row(
        lambda: compiled(fabric="vivid", mode="tpu-unified"),
        "mode gpu",
        lambda: compiled(fabric="vivid", mode="gpu"),
    ),
    "fabric": Row(
        lambda: arch.load("vivid-tyle"),
        "did you mean `vivid-tile`",
        lambda: arch.load("vivid-tile"),
    ),
    "endless": Row(lambda: lowered(k.endless), "a condition or a break", lambda: lowered(k.broken)),
    "size": Row(lambda: lowered(k.unsized), r"np\.zeros\(len\(x\)", lambda: lowered(k.sized)),
    "returned": Row(
        lambda: lowered(k.texts, "int32(int32[::1], int32[::1], int32)"),
        "use integers",
        lambda: lowered(k.numbers, "int32(int32[::1], int32[::1], int32)"),
    ),
    "spelling": Row(
        lambda: lowered(k.misspelt), r"did you mean `np\.minimum`", lambda: lowered(k.spelt)
    ),
    "print": Row(
        lambda: lowered(k.printing), "store the values into an array", lambda: lowered(k.storing)
    ),
    "dict": Row(lambda: lowered(k.dicts), "keys as indices", lambda: lowered(k.keys_as_indices)),
    "truth": Row(lambda: lowered(k.truth), r"\.any\(\)", lambda: lowered(k.truth_of_some)),
    "try": Row(lambda: lowered(k.tries), "test the condition", lambda: lowered(k.tested)),
    "tuple": Row(lambda: lowered(k.mixed), "choose by if and elif", lambda: lowered(k.chosen)),
    "complex": Row(lambda: lowered(k.complexes), "integers or floats", lambda: lowered(k.floats)),
    "generator": Row(lambda: lowered(k.generates), "write a loop", lambda: lowered(k.loops)),
    "item": Row(lambda: lowered(k.item), r"take an element: x\[0\]", lambda: lowered(k.element)),
    "undefined": Row(lambda: lowered(k.undefined), "define or import", lambda: lowered(k.defined)),
    "topology": Row(
        yaml("rows: 2\ncols: 2\n"),
        "give it, or inherit it: `extends: vivid-tile`",
        lambda: (
            yaml("rows: 2\ncols: 2\ntopology: mesh\n")(),
            yaml("extends: vivid-tile\nrows: 2\ncols: 2\n")(),
        ),
    ),
    "key": Row(
        yaml(FABRIC + "controler: {contexts: 8}\n"),
        "did you mean `controller`",
        yaml(FABRIC + "controller: {contexts: 8}\n"),
    ),
    "no fabric": Row(
        yaml("- 1\n"), "start with `extends: vivid-tile`", yaml("extends: vivid-tile\n")
    ),
    "bank": Row(
        yaml(FABRIC + "scratchpad: {size_bytes: 1002, banks: 8}\n"),
        "992 would be",
        yaml(FABRIC + "scratchpad: {size_bytes: 992, banks: 8}\n"),
    ),
    "memory": Row(
        yaml(FABRIC + "pe: {memory: false}\n"),
        r"or say `absent: \[memory\]`",
        yaml(FABRIC + "pe: {memory: false}\nabsent: [memory]\n"),
    ),
    "II": Row(
        lambda: map_dfg(GRAPH, arch.load("mesh-2x2"), ii="2"),
        "a whole number",
        lambda: map_dfg(GRAPH, arch.load("mesh-2x2"), ii=2),
    ),
    "effort": Row(
        lambda: map_dfg(GRAPH, arch.load("mesh-2x2"), effort="most"),
        "choose one of: .*fast",
        lambda: map_dfg(GRAPH, arch.load("mesh-2x2"), effort="fast"),
    ),
    "mapper": Row(
        lambda: map_dfg(GRAPH, arch.load("mesh-2x2"), mapper="best"),
        "choose one of: .*auto",
        lambda: map_dfg(GRAPH, arch.load("mesh-2x2"), mapper="auto"),
    ),
    "objective": Row(
        lambda: map_dfg(GRAPH, arch.load("mesh-2x2"), objective="heat"),
        "choose one of: .*hops",
        lambda: map_dfg(GRAPH, arch.load("mesh-2x2"), objective="hops"),
    ),
    "constraints": Row(
        lambda: map_dfg(GRAPH, arch.load("mesh-2x2"), mapper="ims", extend=lambda model: None),
        "auto, cpsat or decoupled",
        lambda: map_dfg(GRAPH, arch.load("mesh-2x2"), mapper="cpsat", extend=lambda model: None),
    ),
    "workers": Row(
        lambda: map_dfg(GRAPH, arch.load("mesh-2x2"), workers=0),
        "give 1 to",
        lambda: map_dfg(GRAPH, arch.load("mesh-2x2"), workers=1),
    ),
    "node": Row(
        lambda: map_dfg(GRAPH, arch.load("mesh-2x2"), allowed={7: frozenset({0})}),
        "by their ids",
        lambda: map_dfg(GRAPH, arch.load("mesh-2x2"), allowed={1: frozenset({0})}),
    ),
    "PE": Row(
        lambda: map_dfg(GRAPH, arch.load("mesh-2x2"), allowed={1: frozenset({4})}),
        "PEs are 0 to 3",
        lambda: map_dfg(GRAPH, arch.load("mesh-2x2"), allowed={1: frozenset({3})}),
    ),
}


@pytest.mark.parametrize("row", ROWS.values(), ids=ROWS)
def test_what_a_hint_says_helps(row: Row) -> None:
    with pytest.raises(vividc.VividcError) as caught:
        row.wrong()
    assert re.search(row.says, str(caught.value)), str(caught.value)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        row.mended()


@pytest.fixture(scope="module")
def folder(tmp_path_factory, program):
    folder = tmp_path_factory.mktemp("hints")
    program.save(folder / "add.vivid")
    np.savez(folder / "in.npz", x=X, y=np.zeros(8, np.int32), n=8)
    (folder / "g.json").write_text('{"name": "g", "nodes": [{"id": 0, "op": "foo"}], "edges": []}')
    (folder / "two.py").write_text(
        "import vividc\n"
        "@vividc.kernel('void(int32[::1])')\ndef one(x):\n    x[0] = 1\n"
        "@vividc.kernel('void(int32[::1])')\ndef two(x):\n    x[0] = 2\n"
    )
    (folder / "none.py").write_text("def one(x):\n    x[0] = 1\n")
    return folder


COMMANDS = {
    "no program": ("simulate two.py --inputs in.npz", "vividc compile", None),
    "several kernels": ("compile two.py", r"choose one: two\.py:one", "compile two.py:one"),
    "no such kernel": ("compile two.py:three", "its kernels: one, two", "compile two.py:two"),
    "no kernel": ("compile none.py", r"mark a function with `@vividc\.kernel", None),
    "operation": (
        "map g.json --fabric mesh-2x2 --unknown-ops refuse",
        "--unknown-ops generic",
        "map g.json --fabric mesh-2x2 --unknown-ops generic",
    ),
    "window": (
        "simulate add.vivid --inputs in.npz --vcd t.vcd --window 5000:5010",
        "--window FIRST:END",
        "simulate add.vivid --inputs in.npz --vcd t.vcd --window 0:10",
    ),
    "cycles": (
        "view add.vivid --inputs in.npz --cycles 5000:5010 -o p.html",
        "--cycles FIRST:END",
        "view add.vivid --inputs in.npz --cycles 0:10 -o p.html",
    ),
    "picture": (
        "simulate add.vivid --inputs in.npz --plot p.gif",
        r"end it in \.svg or \.png",
        "simulate add.vivid --inputs in.npz --plot p.svg",
    ),
    "same file": (
        "simulate add.vivid --inputs in.npz --outputs in.npz",
        "name another file",
        "simulate add.vivid --inputs in.npz --outputs out.npz",
    ),
    "fabric": (
        "simulate add.vivid --inputs in.npz --fabric vivid-tile",
        "accelerators: .*vivid",
        None,
    ),
}


@pytest.mark.parametrize(("wrong", "says", "mended"), COMMANDS.values(), ids=COMMANDS)
def test_what_the_hint_of_a_command_says_helps(
    folder: Path, monkeypatch: pytest.MonkeyPatch, wrong: str, says: str, mended: str | None
) -> None:
    monkeypatch.chdir(folder)
    done = CliRunner().invoke(main, wrong.split())
    assert done.exit_code == 2
    assert re.search(f"hint: .*{says}", done.stderr), done.stderr
    if mended is not None:
        done = CliRunner().invoke(main, mended.split())
        assert done.exit_code == 0, done.stderr
