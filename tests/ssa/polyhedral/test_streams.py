"""Elements that iterations of a skewed loop access one after another are loaded once."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import vividc
from tests.ssa.polyhedral.test_generate import parts_of
from vividc.machine.opcodes import Opcode
from vividc.ssa.flow import find_loops
from vividc.ssa.interpret import interpret
from vividc.ssa.ir import Function, Input
from vividc.ssa.polyhedral.forms import ZERO, Form
from vividc.ssa.polyhedral.generate import generate
from vividc.ssa.polyhedral.loops import loops_of
from vividc.ssa.polyhedral.orders.search import describe, is_legal, loops_in, skewed, with_factors
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.scop import Scop
from vividc.ssa.polyhedral.trees import Loop, tree_of
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy

TILES = "i0*2?[i1+1i0*3?[i2+4i0+2i1"
ROWS = "i0[i1*4?[i2+2i1"


@vividc.kernel("void(float32[:, ::1], int32)")
def stencil(a, steps):
    """In place, of neighbours on all sides."""
    for _ in range(steps):
        for i in range(1, a.shape[0] - 1):
            for j in range(1, a.shape[1] - 1):
                above = a[i - 1, j - 1] + a[i - 1, j] - a[i - 1, j + 1]
                below = a[i + 1, j - 1] - a[i + 1, j] + a[i + 1, j + 1]
                a[i, j] = above + a[i, j - 1] * a[i, j] - a[i, j + 1] + below


@vividc.kernel("void(int32[:, ::1], int32[:, ::1])")
def anchored(a, b):
    """All of a row read its third element, which some iterations that others follow store."""
    for i in range(1, a.shape[0] - 1):
        for j in range(1, a.shape[1] - 1):
            b[i, j] = 7 * a[i, 2] - b[i, j]
            if j >= i:
                a[i, j] = 3 * a[i, j - 1] - 5 * a[i, j + 1] + a[i, j]


def trees(scop: Scop, relations: Relations) -> dict[str, Loop]:
    """The skewed trees with rows and tiles that run together, by what they are called."""
    found = {}
    for tree in skewed(tree_of(scop)):
        paths = [path for path, _ in loops_in(tree)]
        for given in ({paths[0]: 2, paths[1]: 3}, {paths[1]: 4}):
            made = with_factors(tree, given, masked=True)
            if is_legal(made, relations):
                found[describe(made)] = made
    return found


@cache
def generated(name: str, *, carries: bool = True) -> Function:
    """The stencil in the order of a tree that is called so."""
    [scop] = parts_of(tidy(stencil.lower()))
    relations = Relations(scop)
    [tree] = [tree for text, tree in trees(scop, relations).items() if text.startswith(name)]
    loops = loops_of(tree, relations)
    assert not isinstance(loops, Refusal)
    made = generate(scop, loops, masks=True, carries=carries)
    assert not isinstance(made, Refusal)
    return tidy(made.function)


def innermost(function: Function, opcode: Opcode) -> int:
    """How many of its instructions are of an opcode."""
    inner = find_loops(function)[0]
    blocks = (block for block in function.blocks if block.name in inner.blocks)
    return sum(instr.op is opcode for block in blocks for instr in block.instrs)


@pytest.mark.parametrize("name", [ROWS, TILES])
def test_each_of_six_rows_is_loaded_from_once_an_iteration(name: str) -> None:
    assert innermost(generated(name), Opcode.LOAD) == 6
    assert innermost(generated(name, carries=False), Opcode.LOAD) > 20


@pytest.mark.parametrize("name", [ROWS, TILES])
def test_what_is_carried_is_what_memory_has(name: str) -> None:
    function, plain = generated(name), tidy(stencil.lower())
    for shape in ((1, 1), (3, 3), (4, 8), (8, 5)):
        for steps in (0, 1, 3):
            mine, theirs = (np.random.default_rng(1).random(shape, np.float32) for _ in "12")
            interpret(function, mine, np.int32(steps))
            interpret(plain, theirs, np.int32(steps))
            assert np.array_equal(mine, theirs), (shape, steps)


@pytest.mark.parametrize("factor", [2, 3])
def test_a_register_beside_a_stream_is_what_memory_has(factor: int) -> None:
    """What is stored to a row may be what is in the register: their subscripts are compared."""
    plain = tidy(anchored.lower())
    [scop] = parts_of(plain)
    relations = Relations(scop)
    tree = with_factors(tree_of(scop), {(): factor}, masked=True)
    assert is_legal(tree, relations)
    loops = loops_of(tree, relations)
    assert not isinstance(loops, Refusal)
    made = generate(scop, loops, masks=True)
    assert not isinstance(made, Refusal)
    function = tidy(made.function)
    assert innermost(function, Opcode.LOAD) == 2 * factor
    for shape in ((3, 4), (4, 7), (7, 5), (6, 3)):
        mine, theirs = (
            np.random.default_rng(1).integers(-(2**31), 2**31, (2, *shape)).astype(np.int32)
            for _ in "12"
        )
        interpret(function, *mine)
        interpret(plain, *theirs)
        assert np.array_equal(mine, theirs), shape


def test_elements_between_those_accessed_are_in_a_box() -> None:
    [scop] = parts_of(tidy(stencil.lower()))
    box = Relations(scop).box("a")
    assert box is not None
    assert [first for first, _ in box] == [ZERO, ZERO]
    a0, a1 = (Input(f"a.shape{axis}") for axis in (0, 1))
    shape = scop.symbols
    ends = [last.plus(Form((), 1)) for _, last in box]
    assert all(len(end.terms) == 1 and not end.constant for end in ends)
    assert {shape[name] for end in ends for name in end.names} == {a0, a1}
