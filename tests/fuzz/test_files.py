"""Damaged files of every kind: a message or a result, and the list of kinds is complete."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from random import Random
from typing import Final

import pytest

import vividc
from tests.fuzz.file_damage import damaged
from tests.fuzz.file_kinds import Kind, kinds
from tests.fuzz.files import Children, draw, file_of, judge
from vividc.errors import SourceLoc

OWN: Final = "files of the package itself, and /dev/null"
READERS: Final[dict[str, tuple[str, ...]]] = {
    "arch/cost/tables.py": ("costs", "costs of a run"),
    "arch/yaml/layers.py": ("fabric", "base of a fabric", "fabric of a map"),
    "arch/yaml/load_machine.py": ("accelerator", "base of an accelerator"),
    "compiler/kept_programs.py": ("kernel",),
    "cli/arrays.py": ("arguments", "npy as arguments"),
    "cli/completion.py": ("kernel to complete",),
    "cli/main.py": (OWN,),
    "cli/kernels.py": ("kernel", "kernel in C"),
    "cli/reference.py": ("program to check",),
    "cli/commands/verify.py": ("mapping",),
    "cli/commands/view.py": ("program to view",),
    "cli/commands/opt.py": ("function text", "graph of opt"),
    "dfg/forms/load.py": ("graph JSON", "graph DOT", "graph XML", "graph text", "graph to verify"),
    "errors.py": ("graph with lines", "kernel"),
    "host/files.py": ("kernel", "graph JSON"),
    "frontend/refused/source.py": ("kernel",),
    "frontend/numba/lines.py": ("kernel",),
    "frontend/c/source.py": ("kernel in C",),
    "host/inputs.py": ("graph JSON",),
    "host/processes/beside.py": (OWN,),
    "program/kept.py": (OWN,),
    "host/machine_code/origin.py": (OWN,),
    "host/machine_code/shipped.py": (OWN,),
    "host/machine_code/unit.py": (OWN,),
    "host/npz.py": ("arguments", "scene: means"),
    "page/source.py": ("source to view",),
    "page/write.py": (OWN,),
    "paper/frames.py": ("kept frames",),
    "paper/reproduce.py": (OWN,),
    "program/bundle.py": ("program", "program to disassemble"),
    "program/encoder/encode.py": ("kernel",),
    "render/archive.py": ("scene: table", "scene: net_index", "scene: density_plane_0"),
    "render/array/device/programs.py": (OWN,),
    "render/camera.py": ("cameras",),
    "render/ply.py": ("scene ply", "scene ply in text"),
    "render/scenes.py": ("scene without an ending",),
    "render/views.py": ("views", "views npz", "picture PNG", "picture JPEG", "picture WEBP"),
    "sim/native/compiler.py": (OWN,),
    "frontend/llvm/child/server.py": (OWN,),
    "host/store.py": ("entry: engine", "entry: loops", "entry: stage", "entry: compiled"),
}
"""Modules that open files, and kinds that get there."""

PACKAGE = Path(vividc.__file__).parent
OPENS = {"open", "read_text", "read_bytes", "opened_npz", "read_npz", "read_archive", "memmap"}
OPENS |= {"load_npz", "fromfile", "loadtxt", "genfromtxt", "ZipFile", "fdopen"}


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, tuple[Kind, ...]]:
    home = tmp_path_factory.mktemp("files")
    return home, kinds(home)


@pytest.mark.filterwarnings("ignore")
def test_damaged_files(found: tuple[Path, tuple[Kind, ...]]) -> None:
    home, every = found
    cheap = [kind for kind in every if not kind.alone and kind.share > 3]  # of shares, see there
    for kind in cheap:
        assert judge(kind, kind.data, home).fate in ("exit 0", "read"), kind.name
    for seed in range(150):
        kind = draw(cheap, seed)
        outcome = judge(kind, file_of(kind, seed), home)
        assert not outcome.find, (seed, kind.name, outcome)


def test_names_in_a_program_command_no_terminal(found: tuple[Path, tuple[Kind, ...]]) -> None:
    home, every = found
    shown = next(kind for kind in every if kind.name == "program to disassemble")
    program = vividc.load(home / "sums.vivid")
    rows = tuple(
        replace(row, loc=SourceLoc("\0\x1b[2J", 12), name="\x1b[2J") for row in program.debug
    )
    replace(program, debug=rows).save(home / "odd.vivid")
    outcome = judge(shown, (home / "odd.vivid").read_bytes(), home)
    assert (outcome.fate, outcome.find) == ("exit 0", "")


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_many_damaged_files(found: tuple[Path, tuple[Kind, ...]]) -> None:
    home, every = found
    children = Children(every, home)
    for first in range(1000, 6000, 100):
        drawn = [(seed, draw(every, seed)) for seed in range(first, first + 100)]
        files = [(kind, file_of(kind, seed)) for seed, kind in drawn if not kind.alone]
        for (kind, _), outcome in zip(files, children.judge(files), strict=True):
            assert not outcome.find, (first, kind.name, outcome)


def test_a_find_is_seen(tmp_path: Path) -> None:
    def raises(path: Path) -> object:
        raise KeyError(path.read_bytes())

    outcome = judge(Kind("odd", "bytes", "f", b"x", call=raises), b"y", tmp_path)
    assert outcome.find == "KeyError: b'y'"
    held: list[bytearray] = []  # until it was looked at: not every kernel knows of a short peak
    grows = Kind("large", "bytes", "f", b"x", call=lambda _: held.append(bytearray(100 << 20)))
    assert "MiB, and may 48" in judge(grows, b"y", tmp_path).find
    told = Kind("told", "bytes", "f", b"x", ("simulate", "{file}", "--inputs", "x"), codes=(0,))
    assert judge(told, b"y", tmp_path).find.startswith("exit code 2: vividc: ")


def test_every_form_of_damage_changes_something() -> None:
    for form in ("bytes", "text", "yaml"):
        data = b"a: 1\nb: [1, 2]\n"
        assert len({damaged(Random(seed), data, form) for seed in range(50)}) > 30


def test_every_module_that_opens_files_is_entered() -> None:
    """A new reader is entered in `READERS`, with a kind of file that gets there."""
    opening = {path for path, tree in _modules() if any(_opens(node) for node in ast.walk(tree))}
    assert opening == set(READERS)


def test_every_reader_has_a_kind(found: tuple[Path, tuple[Kind, ...]]) -> None:
    names = {kind.name for kind in found[1]} | {OWN}
    assert {name for used in READERS.values() for name in used} <= names


def _modules() -> Iterator[tuple[str, ast.Module]]:
    for path in sorted(PACKAGE.rglob("*.py")):
        yield path.relative_to(PACKAGE).as_posix(), ast.parse(path.read_text())


def _opens(node: ast.AST) -> bool:
    if not isinstance(node, ast.Call):
        return False
    called = node.func
    if isinstance(called, ast.Name):
        return called.id in OPENS
    if not isinstance(called, ast.Attribute):
        return False
    of = getattr(called.value, "id", getattr(called.value, "attr", ""))
    return (called.attr in OPENS and of != "chain") or (of == "np" and called.attr == "load")
