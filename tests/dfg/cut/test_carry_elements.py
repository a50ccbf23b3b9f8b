"""What all iterations of a loop load and store at one place is in a register meanwhile."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

import vividc
from tests.dfg.cut.test_build import meaning
from tests.programs import Access, Assign, Nest, lower
from vividc.dfg.cut.carry_elements import carry_elements
from vividc.machine.opcodes import Opcode
from vividc.ssa.check import check_function
from vividc.ssa.flow import pipelined_loops
from vividc.ssa.interpret import interpret
from vividc.ssa.ir import Function
from vividc.ssa.rewrite.normalize import normalize
from vividc.ssa.rewrite.tidy import tidy

V, M = "float32[::1]", "float32[:, ::1]"


@vividc.kernel(f"void({V}, {M}, {V})")
def product(y, a, x):
    for i in range(len(y)):
        for j in range(len(x)):
            y[i] += a[i, j] * x[j]


@vividc.kernel("void(int32[:, ::1])")
def best_parts(t):
    """The row and the column that are read do not reach the element."""
    n = t.shape[0]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            for k in range(i + 1, j):
                t[i, j] = max(t[i, j], t[i, k] + t[k + 1, j])


@vividc.kernel(f"void({V}, int32)")
def twice(y, i):
    """Two additions to one element."""
    for j in range(1, len(y) // 2):
        y[0] += y[j]
        y[0] *= np.float32(0.5)


@vividc.kernel(f"void({V})")
def reaches_itself(y):
    for j in range(len(y)):
        y[2] += y[j]


@vividc.kernel(f"void({V}, int32, int32)")
def perhaps_beside(y, i, k):
    """Whether they are one element is only known at the launch."""
    for j in range(len(y)):
        y[i] += np.float32(j)
        y[k] *= np.float32(0.5)


@vividc.kernel(f"void({V}, {V})")
def sometimes(y, x):
    for j in range(len(x)):
        if x[j] > np.float32(0.5):
            y[0] += x[j]


def stores(function: Function) -> int:
    """In innermost loops."""
    inside = {name for loop in pipelined_loops(function) for name in loop.blocks}
    blocks = (block for block in function.blocks if block.name in inside)
    return sum(instr.op is Opcode.STORE for block in blocks for instr in block.instrs)


@pytest.mark.parametrize(
    ("kernel", "left"),
    [
        (product, 0),
        (best_parts, 0),
        (twice, 0),
        (reaches_itself, 1),
        (perhaps_beside, 2),
        (sometimes, 1),
    ],
    ids=lambda value: getattr(value, "name", str(value)),
)
def test_it_is_stored_behind_the_loop_if_nothing_else_may_touch_it(
    kernel: vividc.KernelFunction, left: int
) -> None:
    function = carry_elements(normalize(tidy(kernel.lower())))
    assert check_function(function) == []
    assert stores(function) == left


def test_an_empty_loop_touches_nothing() -> None:
    """Neither before nor after: the element may lie outside of its array."""
    function = carry_elements(normalize(tidy(twice.lower())))
    interpret(function, np.empty(0, dtype=np.float32), 0)


def test_the_recurrence_is_that_of_the_arithmetic() -> None:
    program = vividc.compile(best_parts, loops=vividc.LoopOptions(auto=False))
    [loop] = [region for region in program.regions if region.kind == "loop"]
    assert loop.ii == 2  # a comparison and a choice: what does not change of the sum is apart
    mine, theirs = (np.random.default_rng(0).integers(-9, 9, (9, 9), dtype=np.int32) for _ in "12")
    best_parts(theirs)
    vividc.simulate(program, mine)
    assert np.array_equal(mine, theirs)


def elements() -> st.SearchStrategy[Nest]:
    """Nests whose inner loop adds an element at a fixed place to a sum, and stores the sum there;
    and touches others, some of which it reaches.
    """

    def access(column: int) -> st.SearchStrategy[Access]:
        kind = st.sampled_from(["load", "store"])
        return st.builds(Access, kind, st.integers(0, 1), st.just(column), st.integers(0, 2))

    other = st.lists(access(0) | access(1) | st.just(Assign(2, "mul", 2, 2, 3)), max_size=2)
    work = st.tuples(access(0), other, other, other).map(
        lambda parts: (
            *parts[1],
            replace(parts[0], kind="load"),
            *parts[2],
            replace(parts[0], kind="store"),
            *parts[3],
        )
    )
    few, sizes = st.lists(access(0), max_size=1).map(tuple), st.integers(0, 4)
    return st.builds(Nest, sizes, sizes, few, work, few, st.booleans())


def carried(nest: Nest) -> Function:
    return carry_elements(normalize(tidy(lower(nest.program))))


@settings(max_examples=100)
@given(elements())
def test_programs_mean_what_they_meant(nest: Nest) -> None:
    function = carried(nest)
    event(f"{stores(function)} stores in loops")
    assert check_function(function) == []
    memory = np.arange(16, dtype=np.int32)
    interpret(function, memory)
    assert [int(word) for word in memory.view(np.uint32)] == meaning(nest.program)
