"""Two nests that go through one matrix as one part, and orders in which they are one nest."""

from __future__ import annotations

from collections.abc import Callable, Iterable

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
from vividc.ssa.polyhedral.orders.in_memory import in_memory
from vividc.ssa.polyhedral.orders.joined import divided, together
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.scop import Scop
from vividc.ssa.polyhedral.trees import Loop, tree_of
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy

Search = Callable[[Loop, Relations], Iterable[Loop]]

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
def sums_in_scalars(b, x, y, z):
    """As `rows_and_columns`, with sums that scalars keep until they are stored."""
    for i in range(b.shape[0]):
        total = np.float32(0.0)
        for j in range(b.shape[1]):
            total += b[i, j] * z[j]
        x[i] = total
    for i in range(b.shape[1]):
        total = np.float32(0.0)
        for j in range(b.shape[0]):
            total += b[j, i] * z[j]
        y[i] = total


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


def trees_of(part: Scop, search: Search = together) -> list[Function]:
    """The functions in which two nests are one."""
    relations = Relations(part)
    found = []
    for tree in search(tree_of(part), relations):
        loops = loops_of(tree, relations)
        made = loops if isinstance(loops, Refusal) else generate(part, loops)
        if not isinstance(made, Refusal):
            found.append(tidy(made.function))
    return found


def loads_inside(function: Function) -> int:
    """Loads of the matrix in innermost loops."""
    loops = find_loops(function)
    inner = [a for a in loops if not any(b.header in a.blocks - {a.header} for b in loops)]
    inside = {name for loop in inner for name in loop.blocks}
    instrs = (i for block in function.blocks if block.name in inside for i in block.instrs)
    return sum(i.array == "b" for i in instrs)


def demand_same(function: Function, made: Function) -> None:
    """Both compute the same of four matrices."""
    for rows, columns in ((0, 3), (1, 1), (5, 9), (9, 4)):
        chance = np.random.default_rng(1)
        given = [chance.random((rows, columns)), *chance.random((3, 9))]
        mine, theirs = ([one.astype(np.float32) for one in given] for _ in "12")
        interpret(function, *mine)
        interpret(made, *theirs)
        assert all(np.array_equal(a, b) for a, b in zip(mine, theirs, strict=True))


def test_a_matrix_is_loaded_once_for_rows_and_columns() -> None:
    """Of eight orders one has the loops of both around one load of the matrix."""
    function = tidy(rows_and_columns.lower())
    [part] = parts_of(function)
    trees = trees_of(part)
    assert len(trees) == 8
    for made in trees:
        demand_same(function, made)
    assert 1 in map(loads_inside, trees)


def test_sums_begin_in_loops_of_their_own() -> None:
    """Only once they wait in memory the nests may be one around one load of the matrix."""
    function = tidy(sums_in_scalars.lower())
    [part] = parts_of(function)
    assert 1 not in map(loads_inside, trees_of(part))
    trees = trees_of(in_memory(part), divided)
    for made in trees:
        demand_same(function, made)
    assert 1 in map(loads_inside, trees)


@pytest.mark.parametrize(("tested", "parts"), [(from_the_end, 1), (of_vectors, 0)])
def test_no_order_makes_them_one(tested: vividc.KernelFunction, parts: int) -> None:
    found = parts_of(tidy(tested.lower()))
    assert len(found) == parts
    assert not any(trees_of(part, search) for part in found for search in (together, divided))


def test_of_one_nest_there_are_no_pairs() -> None:
    function = tidy(rows_and_columns.lower())
    [part] = parts_of(function)
    [first, _] = tree_of(part).children
    assert isinstance(first, Loop)
    assert not [*together(first, Relations(part)), *divided(first, Relations(part))]
