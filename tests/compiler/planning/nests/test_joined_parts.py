"""Two nests that go through one matrix as one part, and orders in which they are one nest."""

from __future__ import annotations

import numpy as np
import pytest

import vividc
from vividc.compiler.planning.nests.parts import joined_parts
from vividc.compiler.planning.state import State
from vividc.ssa.analysis.frequency import expected_trips
from vividc.ssa.flow import find_loops
from vividc.ssa.interpret import interpret
from vividc.ssa.ir import Function
from vividc.ssa.polyhedral.generate import generate
from vividc.ssa.polyhedral.loops import loops_of
from vividc.ssa.polyhedral.orders.search import together
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.scop import Scop
from vividc.ssa.polyhedral.trees import tree_of
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy

SIGNATURE = "void(float32[:, ::1], float32[::1], float32[::1], float32[::1])"


@vividc.kernel(SIGNATURE)
def rows_and_columns(b, x, y, z):
    """One nest goes through the matrix by rows, one by columns."""
    for i in range(b.shape[0]):
        for j in range(b.shape[1]):
            x[i] += b[i, j] * z[j]
    for i in range(b.shape[1]):
        for j in range(b.shape[0]):
            y[i] += b[j, i] * z[j]


@vividc.kernel(SIGNATURE)
def from_the_end(b, x, y, z):
    """The second nest needs the last row of the first in its first iteration."""
    for i in range(b.shape[0]):
        for j in range(b.shape[1]):
            b[i, j] = b[i, j] + x[i] * z[j]
    for i in range(b.shape[0] - 1, -1, -1):
        for j in range(b.shape[1] - 1, -1, -1):
            y[i] += b[i, j] * z[j]


@vividc.kernel(SIGNATURE)
def of_vectors(b, x, y, z):
    """No matrix is shared."""
    for i in range(b.shape[0]):
        for j in range(b.shape[1]):
            x[i] += b[i, j] * z[j]
    for i in range(len(y)):
        for j in range(len(y)):
            y[i] += x[j] * z[j]


def parts_of(function: Function) -> list[Scop]:
    state = State(function, expected_trips(function, {}))
    return [part for _, _, part in joined_parts(state)]


def trees_of(part: Scop) -> list[Function]:
    """The functions in which two nests are one."""
    relations = Relations(part)
    found = []
    for tree in together(tree_of(part), relations):
        loops = loops_of(tree, relations)
        made = loops if isinstance(loops, Refusal) else generate(part, loops)
        if not isinstance(made, Refusal):
            found.append(tidy(made.function))
    return found


def test_a_matrix_is_loaded_once_for_rows_and_columns() -> None:
    """Of eight orders one has the loops of both around one load of the matrix."""
    function = tidy(rows_and_columns.lower())
    [part] = parts_of(function)
    trees = trees_of(part)
    assert len(trees) == 8
    loads = []
    for made in trees:
        loops = find_loops(made)
        inner = [a for a in loops if not any(b.header in a.blocks - {a.header} for b in loops)]
        inside = {name for loop in inner for name in loop.blocks}
        instrs = (i for block in made.blocks if block.name in inside for i in block.instrs)
        loads.append(sum(i.array == "b" for i in instrs))
        for rows, columns in ((0, 3), (1, 1), (5, 9), (9, 4)):
            chance = np.random.default_rng(1)
            given = [chance.random((rows, columns)), *chance.random((3, 9))]
            mine, theirs = ([one.astype(np.float32) for one in given] for _ in "12")
            interpret(function, *mine)
            interpret(made, *theirs)
            assert all(np.array_equal(a, b) for a, b in zip(mine, theirs, strict=True))
    assert 1 in loads


@pytest.mark.parametrize(("tested", "parts"), [(from_the_end, 1), (of_vectors, 0)])
def test_no_order_makes_them_one(tested: vividc.KernelFunction, parts: int) -> None:
    found = parts_of(tidy(tested.lower()))
    assert len(found) == parts
    assert not any(trees_of(part) for part in found)
