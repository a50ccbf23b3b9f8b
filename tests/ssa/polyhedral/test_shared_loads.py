"""What iterations of a group load under guards of their own is loaded once, where that is safe."""

from __future__ import annotations

import numpy as np
import pytest

import vividc
from tests.ssa.polyhedral.test_generate import parts_of
from tests.ssa.polyhedral.test_streams import innermost
from vividc.machine.opcodes import Opcode
from vividc.ssa.interpret import interpret
from vividc.ssa.ir import Function
from vividc.ssa.polyhedral.generate import generate
from vividc.ssa.polyhedral.loops import loops_of
from vividc.ssa.polyhedral.orders.search import is_legal, with_factors
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.trees import tree_of
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy


@vividc.kernel("void(int32[:, ::1])")
def eliminate(a):
    """All rows below row k need it."""
    for k in range(a.shape[0]):
        for i in range(k + 1, a.shape[0]):
            for j in range(k + 1, a.shape[1]):
                a[i, j] -= a[i, k] * a[k, j]


@vividc.kernel("void(int32[:, ::1], int32[::1], int32[::1])")
def guarded(a, b, c):
    """Only rows behind the length of `c` need `b`, which may be empty if there are none."""
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            a[i, j] += 1
            if i >= len(c):
                a[i, j] += b[j]


def grouped(
    kernel: vividc.KernelFunction, path: tuple[int, ...], factor: int, *, shares: bool
) -> Function:
    """The kernel with iterations of a loop run together, masked."""
    [scop] = parts_of(tidy(kernel.lower()))
    relations = Relations(scop)
    tree = with_factors(tree_of(scop), {path: factor}, masked=True)
    assert is_legal(tree, relations)
    loops = loops_of(tree, relations)
    assert not isinstance(loops, Refusal)
    made = generate(scop, loops, masks=True, shares=shares)
    assert not isinstance(made, Refusal)
    return tidy(made.function)


def numbers(*shape: int) -> np.ndarray:
    return np.random.default_rng(1).integers(-99, 99, shape).astype(np.int32)


@pytest.mark.parametrize("factor", [2, 4])
def test_rows_below_load_their_pivot_row_once(factor: int) -> None:
    made = grouped(eliminate, (0,), factor, shares=True)
    assert innermost(made, Opcode.LOAD) == factor + 1
    assert innermost(made, Opcode.SELECT) == 0  # no row is the pivot's where it is stored
    for shape in ((0, 0), (1, 1), (5, 5), (6, 9), (8, 3)):
        mine, theirs = numbers(*shape), numbers(*shape)
        interpret(made, mine)
        interpret(tidy(eliminate.lower()), theirs)
        assert np.array_equal(mine, theirs), shape


@pytest.mark.parametrize("shares", [False, True])
def test_what_may_be_no_element_is_loaded_where_it_is_needed_only(shares: bool) -> None:
    made = grouped(guarded, (), 4, shares=shares)
    for rows, spared, length in ((6, 6, 0), (6, 3, 5), (7, 0, 5), (3, 9, 0)):
        mine, theirs = numbers(rows, 5), numbers(rows, 5)
        given = numbers(length), numbers(spared)
        interpret(made, mine, *given)
        interpret(tidy(guarded.lower()), theirs, *given)
        assert np.array_equal(mine, theirs), (rows, spared)


@vividc.kernel("void(int32[:, ::1])")
def rows_of_its_own(a):
    """All columns behind column k need what the kernel keeps of it."""
    q = np.empty(a.shape, np.int32)
    for k in range(a.shape[1]):
        for i in range(a.shape[0]):
            q[i, k] = a[i, k] + k
        for j in range(k + 1, a.shape[1]):
            for i in range(a.shape[0]):
                a[i, j] -= q[i, k]


@vividc.kernel("void(int32[:, ::1])")
def above_the_diagonal(a):
    """What lies between the accessed elements may lie behind the last one."""
    q = np.empty(a.shape, np.int32)
    for k in range(a.shape[1]):
        for i in range(a.shape[0] - k):
            q[i, k] = a[i, k] + k
        for j in range(k + 1, a.shape[1]):
            for i in range(a.shape[0] - k):
                a[i, j] -= q[i, k]


@pytest.mark.parametrize(
    ("kernel", "is_safe"), [(rows_of_its_own, True), (above_the_diagonal, False)]
)
def test_elements_of_own_arrays_are_shared_up_to_the_last_one(
    kernel: vividc.KernelFunction, is_safe: bool
) -> None:
    made = grouped(kernel, (1,), 4, shares=True)
    instrs = [instr for block in made.blocks for instr in block.instrs]
    loads = [one for one in instrs if one.op is Opcode.LOAD and one.array != "a"]
    assert len(loads) == (1 if is_safe else 4)
    for shape in ((0, 0), (1, 1), (5, 5), (9, 6), (3, 8)):
        mine, theirs = numbers(*shape), numbers(*shape)
        interpret(made, mine)
        interpret(tidy(kernel.lower()), theirs)
        assert np.array_equal(mine, theirs), shape
