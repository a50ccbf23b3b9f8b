"""The map is true: ARCHITECTURE.md names the rooms, each room its files, none is too full."""

from __future__ import annotations

import ast
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path
from pkgutil import resolve_name

import networkx as nx
import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "vividc"
MOST = 15
"""Entries of a room, its `__init__.py` aside."""
SIZES = {"vividc": 19}
"""The package itself: seventeen rooms, and `errors` and `formats`, which users import as such."""


def rooms() -> Iterator[Path]:
    for file in sorted(PACKAGE.rglob("__init__.py")):
        yield file.parent


def name_of(room: Path) -> str:
    return room.relative_to(ROOT).as_posix()


def entries(room: Path) -> set[str]:
    """Modules and rooms of a room."""
    files = {file.stem for file in room.glob("*.py")} - {"__init__", "__main__"}
    return files | {one.name for one in room.iterdir() if (one / "__init__.py").exists()}


def imports() -> Iterator[tuple[str, str]]:
    """(module, module that it imports), by dotted names."""
    modules = {}
    for file in PACKAGE.rglob("*.py"):
        dotted = ".".join(file.relative_to(ROOT).with_suffix("").parts)
        modules[dotted.removesuffix(".__init__")] = file
    for dotted, file in modules.items():
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module:
                for alias in node.names:
                    full = f"{node.module}.{alias.name}"
                    yield dotted, full if full in modules else node.module
            elif isinstance(node, ast.Import):
                yield from ((dotted, alias.name) for alias in node.names)


@pytest.mark.parametrize("room", [*rooms()], ids=name_of)
def test_a_room_names_its_entries_and_is_not_too_full(room: Path) -> None:
    text = ast.get_docstring(ast.parse((room / "__init__.py").read_text(encoding="utf-8")))
    named = set(re.findall(r"`(\w+)/?`", text or ""))
    if room == PACKAGE:
        named |= entries(room)  # ARCHITECTURE.md has them
    assert entries(room) <= named, f"{name_of(room)} does not say what they are"
    assert len(entries(room)) <= SIZES.get(name_of(room), MOST)


def test_the_map_names_each_room_and_no_other() -> None:
    text = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    named = set(re.findall(r"^\| `vividc/(\w+)(?:/|\.py)` \|", text, re.MULTILINE))
    assert named == entries(PACKAGE)


def test_paths_in_the_documents_exist() -> None:
    for page in (ROOT / "ARCHITECTURE.md", *sorted((ROOT / "docs").rglob("*.md"))):
        for path in re.findall(r"`((?:vividc|tests|benchmarks|docs)/[\w./-]+)`", page.read_text()):
            assert (ROOT / path).exists(), f"{page.name} names {path}"


def test_rooms_import_each_other_in_no_circle() -> None:
    arrows = list(imports())
    for room in rooms():
        start = f"{'.'.join(room.relative_to(ROOT).parts)}."
        graph = nx.DiGraph()
        for here, there in arrows:
            if here.startswith(start) and there.startswith(start):
                one, other = (name[len(start) :].split(".")[0] for name in (here, there))
                if one != other:
                    graph.add_edge(one, other)
        for circle in nx.strongly_connected_components(graph):
            assert len(circle) == 1, f"{name_of(room)}: {sorted(circle)}"


def private_names(text: str) -> list[str]:
    """Names with a leading underscore that a test takes from the package or the benchmarks."""
    ours = r"(?:vividc|benchmarks)\b[\w.]*"
    imports = re.findall(rf"^from {ours} import (\([^)]*\)|.*)", text, re.MULTILINE)
    names = {"vividc", *(name for some in imports for name in re.findall(r"\w+", some))}
    taken = re.findall(rf"\b({'|'.join(names)})\b(?:\.\w+|\(\))*(?:\.|, \")(_[a-zA-Z]\w*)", text)
    return [
        *(name for name in names if re.match("_[a-zA-Z]", name)),
        *(private for _, private in taken),
        *re.findall(rf'"{ours}\.(_[a-zA-Z]\w*)', text),
    ]


def test_tests_use_no_private_name() -> None:
    """What a test needs is public, or reached by a parameter."""
    files = sorted((ROOT / "tests").rglob("*.py"))
    found = {file.relative_to(ROOT).as_posix(): private_names(file.read_text()) for file in files}
    assert not {name: private for name, private in found.items() if private}


def test_every_door_of_the_walks_exists() -> None:
    text = (ROOT / "docs" / "design" / "walks.md").read_text(encoding="utf-8")
    doors = re.findall(r"`(vividc(?:\.\w+)+)`", text)
    assert len(doors) > 25
    for door in doors:
        resolve_name(door)


def test_each_long_test_exists() -> None:
    """Another name would bring it back to `make test` unnoticed."""
    ids = (ROOT / "tests" / "long.txt").read_text(encoding="utf-8").splitlines()
    assert ids == sorted(set(ids))
    for test in ids:
        file, _, name = test.partition("::")
        text = (ROOT / file).read_text(encoding="utf-8")
        assert f"def {name.partition('[')[0]}(" in text, test


def test_make_test_names_the_rooms_that_it_can_run() -> None:
    """`make test ROOM=...` begins with `make room ROOM=...`."""
    for room, status in (("ssa/rewrite", 0), ("ssa/nothing", 2)):
        command = ["make", "--silent", "room", f"ROOM={room}"]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
        assert done.returncode == status
        assert status == 0 or {"mapper", "mapper/cpsat", "ssa/rewrite"} <= set(done.stderr.split())
