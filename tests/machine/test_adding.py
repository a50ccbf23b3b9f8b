"""docs/design/adding.md is true: its patches add an opcode and a pass that work."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "design" / "adding.md").read_text(encoding="utf-8")
MOST_FILES = 4

USE_OPCODE = """
import numpy as np
import vividc
from vividc.dfg.builder import GraphBuilder
from vividc.dfg.ir import Node
from vividc.dfg.pipeline import optimize
from vividc.gemm.elementwise import loop_program
from vividc.machine.opcodes import Opcode
from vividc.machine.params import DType, Param

b = GraphBuilder("clip")
i, limit = b.iv(), b.const(0x80000005)
x = b.add_node(Node(0, Opcode.LOAD, name="x", shift=2), [i], base=b.live_in("&x"))
least = b.add(Opcode.SELECT, [b.add(Opcode.ICMP_ULT, [x, limit]), x, limit])
b.add_node(Node(0, Opcode.STORE, name="y", shift=2), [i, least], base=b.live_in("&y"))
graph = b.build()
assert Opcode.UMIN in {node.op for node in optimize(graph).nodes}
params = (Param("x", DType.U32, 1), Param("y", DType.U32, 1), Param("n", DType.I32))
program = loop_program("clip", graph, params)
x = np.array([0, 7, 0x7FFFFFFF, 0x80000004, 0x80000006, 0xFFFFFFFF] * 5, np.uint32)
for engine in ("reference", "native"):
    y = np.zeros_like(x)
    vividc.simulate(program, x, y, len(x), engine=engine)
    assert np.array_equal(y, np.minimum(x, np.uint32(0x80000005))), engine
"""
USE_PASS = """
from pathlib import Path

from tests.dfg.support import GRAPHS
from tests.rules import cases_of_passes
from vividc.compiler.passes import GRAPH_PASSES, STAGES
from vividc.dfg.builder import GraphBuilder
from vividc.dfg.ir import Node
from vividc.errors import SourceLoc
from vividc.machine.opcodes import Opcode

assert "forget-lines" in {stage.name for stage in STAGES}
b = GraphBuilder("g")
word = b.add(Opcode.ADD, [b.live_in("n"), b.const(3)], loc=SourceLoc("k.py", 4))
b.add_node(Node(0, Opcode.LIVE_OUT, name="m"), [word])
made = GRAPH_PASSES["forget-lines"](b.build())
assert all(node.loc is None for node in made.nodes)
assert GRAPH_PASSES["forget-lines"](made) is made
[(name, case)] = cases_of_passes(Path("tests"))
GRAPHS.check(case, GRAPH_PASSES[name])
"""


def section(title: str) -> list[tuple[str, str]]:
    """Language and text of the blocks below a heading."""
    part = PAGE[PAGE.index(title) :].split("\n## ", 1)[0]
    return re.findall(r"```(\w+)\n(.*?)```", part, re.DOTALL)


def hunks(patch: str) -> Iterator[tuple[str, str]]:
    """Text before and after."""
    for hunk in patch.split("@@\n"):
        lines = hunk.splitlines(keepends=True)
        before = "".join(line[1:] for line in lines if line[0] == " ")
        yield before, "".join(line[1:] for line in lines)


def patched(blocks: list[tuple[str, str]], folder: Path) -> set[str]:
    """Patch a copy of the package, and return the files that the blocks touch."""
    shutil.copytree(ROOT / "vividc", folder / "vividc")
    touched = set()
    for language, text in blocks:
        header, _, rest = text.partition("\n")
        name = header.removeprefix("# file: ").removeprefix("--- ")
        touched.add(name)
        file = folder / name
        if language != "diff":
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(rest, encoding="utf-8")
            continue
        for before, after in hunks(rest):
            source = file.read_text(encoding="utf-8")
            assert source.count(before) == 1, f"{name} no longer has\n{before}"
            file.write_text(source.replace(before, after), encoding="utf-8")
    return touched


def run(script: str, folder: Path) -> None:
    path = os.pathsep.join(map(str, (folder, ROOT)))
    environment = os.environ | {"PYTHONPATH": path, "VIVIDC_CACHE_DIR": str(folder)}
    done = subprocess.run(
        [sys.executable, "-c", script],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_an_opcode_takes_four_files(tmp_path: Path) -> None:
    assert len(patched(section("## An opcode"), tmp_path)) == MOST_FILES
    run(USE_OPCODE, tmp_path)


def test_an_operation_without_fu_takes_four_files() -> None:
    named = [
        file.relative_to(ROOT).as_posix()
        for file in (ROOT / "vividc").rglob("*.py")
        if re.search(r"\bRINT\b", file.read_text(encoding="utf-8"))
    ]
    assert len(named) == MOST_FILES, named


@pytest.mark.slow
def test_a_pass_takes_its_file_its_cases_and_the_list(tmp_path: Path) -> None:
    touched = patched(section("## A pass"), tmp_path)
    assert touched == {
        "vividc/dfg/passes/forget_lines.py",
        "tests/dfg/passes/forget_lines.cases",
        "vividc/dfg/pipeline.py",
    }
    run(USE_PASS, tmp_path)
