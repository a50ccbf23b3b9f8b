"""What is generated from a legal tree means what the part meant, whatever the tree."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import vividc
from tests.marks import with_slow
from tests.ssa.polyhedral.nests import (
    DTYPES,
    arguments,
    random_nest,
    random_stencil,
    temporary,
    with_known,
)
from vividc.errors import SSAError
from vividc.machine.opcodes import Opcode
from vividc.machine.params import DType
from vividc.ssa.analysis.levels import with_own_latches
from vividc.ssa.check import check_function
from vividc.ssa.flow import find_loops
from vividc.ssa.interpret import interpret
from vividc.ssa.ir import Function
from vividc.ssa.polyhedral.forms import Form, symbol
from vividc.ssa.polyhedral.generate import generate
from vividc.ssa.polyhedral.loops import loops_of
from vividc.ssa.polyhedral.orders.search import (
    at,
    describe,
    fronts,
    has_masks,
    is_legal,
    loops_in,
    orders,
    put,
    skewed,
    with_factors,
)
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.scop import Scop, find_scop
from vividc.ssa.polyhedral.trees import Loop, tree_of
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy


def parts_of(function: Function) -> list[Scop]:
    """Static-control parts of the outermost loops."""
    loops = find_loops(function)
    outer = [o for o in loops if not any(o.header in p.blocks and p is not o for p in loops)]
    found = (find_scop(with_own_latches(function, loop.header), loop.header) for loop in outer)
    return [scop for scop in found if isinstance(scop, Scop)]


NUMBERS = (0, 1, 2, 5, -1, -(1 << 31))


def demand_same(
    before: Function, after: Function, what: str, numbers: tuple[int, ...] = NUMBERS
) -> None:
    assert check_function(after) == [], what
    for n in numbers:
        old, new = (
            (*arguments(before, abs(n), n), *[temporary(before) for _ in before.params[3:]])
            for _ in "12"
        )
        try:
            interpret(before, *old, max_blocks=20_000)
        except SSAError:
            continue  # it leaves its arrays, or counts for too long
        interpret(after, *new, max_blocks=40_000)
        same = all(np.array_equal(x, y) for x, y in zip(old, new, strict=True))
        assert same, f"{what}, n = {n}"


@vividc.kernel("void(float32[:, ::1], float32[:, ::1])")
def triangular(a, b):
    """Each row of b takes those below it, times a column of a."""
    for i in range(b.shape[0]):
        for j in range(b.shape[1]):
            for k in range(i + 1, b.shape[0]):
                b[i, j] += a[k, i] * b[k, j]


def test_sums_of_a_jammed_triangle_stay_in_registers() -> None:
    """Terms that only some rows of a group have come before those of all, not under tests among
    them: those would send sums through memory.
    """
    [scop] = parts_of(tidy(triangular.lower()))
    relations = Relations(scop)
    tree = tree_of(scop)
    rows, columns = [path for path, _ in loops_in(tree)][:2]
    jammed = with_factors(tree, {rows: 4, columns: 4})
    assert is_legal(jammed, relations)
    loops = loops_of(jammed, relations)
    assert not isinstance(loops, Refusal)
    made = generate(scop, loops)
    assert not isinstance(made, Refusal)
    function = tidy(made.function)
    found = find_loops(function)
    inner = [loop for loop in found if not any(o.header in loop.blocks for o in found if o != loop)]
    opcodes = [
        [i.op for block in function.blocks if block.name in loop.blocks for i in block.instrs]
        for loop in inner
    ]
    assert max(ops.count(Opcode.FMUL) for ops in opcodes) == 16
    assert not any(Opcode.STORE in ops for ops in opcodes)


def some_trees(scop: Scop, relations: Relations, chance: random.Random, most: int) -> list[Loop]:
    """Legal trees of a part, with random factors."""
    trees = orders(tree_of(scop), relations)
    base = chance.choice(trees)
    moved = (*skewed(base), *fronts(base, scop))
    later = [tree for tree in moved if is_legal(tree, relations)]
    trees += chance.sample(later, min(len(later), 2))
    chosen = []
    for tree in chance.sample(trees, min(most, len(trees))):
        if is_legal(tree, relations):  # not with iterations run together only
            chosen.append(tree)
        paths = [path for path, _ in loops_in(tree)]
        for _ in range(2):
            some = chance.sample(paths, min(len(paths), chance.randint(1, 2)))
            factors = {path: chance.choice([2, 3, 4, 8]) for path in some}
            jammed = with_factors(tree, factors, masked=chance.random() < 0.5)
            if chance.random() < 0.5:
                path = chance.choice(paths)
                jammed = put(jammed, path, replace(at(jammed, path), in_order=True))
            if is_legal(jammed, relations):
                chosen.append(jammed)
    return chosen


def demand_trees_mean_the_same(
    seed: int,
    most: int = 3,
    known: int | None = None,
    dtype: DType = DType.I32,
    nest: Callable[[int, DType], Function] = random_nest,
) -> int:
    """How many trees were generated of a random nest, perhaps with a known `n`."""
    function = nest(seed, dtype)
    function = tidy(function if known is None else with_known(function, known))
    numbers = NUMBERS if known is None else (known,)
    count = 0
    for scop in parts_of(function):
        relations = Relations(scop)
        for tree in some_trees(scop, relations, random.Random(seed), most):
            loops = loops_of(tree, relations)
            masks = has_masks(tree)
            for shares in (False, True)[: 1 + masks]:
                made = loops
                if not isinstance(loops, Refusal):
                    made = generate(scop, loops, masks=masks, shares=shares)
                if isinstance(made, Refusal):
                    continue
                count += 1
                text = f"seed {seed}: {describe(tree)}, {shares}"
                demand_same(function, tidy(made.function), text, numbers)
    return count


@pytest.mark.parametrize("seed", with_slow(range(16), {5}))
def test_random_trees(seed: int) -> None:
    demand_trees_mean_the_same(seed)


@pytest.mark.parametrize("seed", range(16))
def test_random_trees_of_known_sizes(seed: int) -> None:
    demand_trees_mean_the_same(seed, known=NUMBERS[seed % 5])


@pytest.mark.parametrize("dtype", DTYPES[1:], ids=lambda dtype: dtype.value)
def test_random_trees_of_small_elements(dtype: DType) -> None:
    seeds = range(100, 106)
    assert sum(demand_trees_mean_the_same(seed, most=2, dtype=dtype) for seed in seeds) > 1


@pytest.mark.parametrize("seed", range(8))
def test_random_trees_of_stencils(seed: int) -> None:
    demand_trees_mean_the_same(seed, nest=random_stencil)


def test_a_scalar_has_one_name_in_a_branch_that_says_what_a_counter_is() -> None:
    """isl writes `if (c1 == c0 + 1) S5(c0, c0 + 1, ...)` in the loop of c1."""
    seed = 168
    function = tidy(random_stencil(seed, DTYPES[seed % len(DTYPES)]))
    [scop] = parts_of(function)
    relations = Relations(scop)
    wanted = "i0[S1, i2[S3, i4+1i2[S5], S6], S7]"
    tree = next(one for one in skewed(tree_of(scop)) if describe(one).startswith(wanted))
    jammed = with_factors(tree, {(1,): 8, (1, 1): 3})
    assert is_legal(jammed, relations)
    loops = loops_of(jammed, relations)
    assert not isinstance(loops, Refusal)
    made = generate(scop, loops)
    assert not isinstance(made, Refusal)
    demand_same(function, tidy(made.function), describe(jammed), (4, 5, 6))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8, 700))
def test_more_random_trees_of_stencils(seed: int) -> None:
    known = NUMBERS[seed % 5] if seed % 2 else None
    dtype = DTYPES[seed % len(DTYPES)]
    demand_trees_mean_the_same(seed, most=8, known=known, dtype=dtype, nest=random_stencil)


@pytest.mark.parametrize(
    ("seed", "dtype", "known"),
    [
        (133, DType.U16, None),
        (226, DType.I32, 1),
        pytest.param(238, DType.I32, 5, marks=pytest.mark.slow),
        (515, DType.I32, 0),
        pytest.param(622, DType.I8, None, marks=pytest.mark.slow),
        pytest.param(686, DType.U8, None, marks=pytest.mark.slow),
        pytest.param(440, DType.I32, None, marks=pytest.mark.slow),
    ],
)
def test_a_scalar_has_one_name_where_bounds_tell_an_iteration(
    seed: int, dtype: DType, known: int | None
) -> None:
    """isl writes the number that a counter must be, or another counter that it equals."""
    demand_trees_mean_the_same(seed, most=8, known=known, dtype=dtype, nest=random_stencil)


def test_a_part_without_parameters_can_be_jammed() -> None:
    """isl reads `[]` before a schedule's arrow as the schedule."""
    sized = triangular.sized({"a": (8, 8), "b": (8, 12)})
    [scop] = parts_of(tidy(sized.lower()))
    assert not scop.symbols
    relations = Relations(scop)
    tree = tree_of(scop)
    columns = next(path for path, loop in loops_in(tree) if "i1" in loop.over.values())
    assert is_legal(with_factors(tree, {columns: 4}), relations)


def test_many_nests_are_parts() -> None:
    parts = [parts_of(tidy(random_nest(seed))) for seed in range(40)]
    assert sum(map(bool, parts)) > 20
    assert sum(any(s.guards for scop in some for s in scop.statements) for some in parts) > 5


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(16, 1040))
def test_more_random_trees(seed: int) -> None:
    demand_trees_mean_the_same(seed, most=10, dtype=DTYPES[seed % len(DTYPES)])


@vividc.kernel("void(float32[::1], float32[::1], float32[::1])")
def in_place(a, b, c):
    """Neighbours to the left and right, and sums so far."""
    for t in range(c.shape[0]):
        for i in range(1, a.shape[0] - 1):
            a[i] = a[i - 1] + a[i] * a[i + 1]
            b[i] = b[i - 1] + c[t]


def _loads(function: Function) -> list[str]:
    """Arrays that the innermost loop loads from."""
    inner = find_loops(function)[0]
    instrs = [i for b in function.blocks if b.name in inner.blocks for i in b.instrs]
    return sorted(i.array for i in instrs if i.op is Opcode.LOAD)


def test_what_the_iteration_before_had_is_not_loaded_again() -> None:
    [scop] = parts_of(tidy(in_place.lower()))
    loops = loops_of(tree_of(scop), Relations(scop))
    assert not isinstance(loops, Refusal)
    made = generate(scop, loops)
    assert not isinstance(made, Refusal)
    function = tidy(made.function)
    loaded = generate(scop, loops, carries=False)
    assert not isinstance(loaded, Refusal)
    assert _loads(tidy(loaded.function)) == ["a", "a", "a", "b"]
    assert _loads(function) == ["a"]
    for length in (0, 1, 2, 3, 9):
        mine, theirs = ([np.arange(length, dtype=np.float32) for _ in "ab"] for _ in "12")
        interpret(function, *mine, np.ones(2, np.float32))
        interpret(tidy(in_place.lower()), *theirs, np.ones(2, np.float32))
        assert all(np.array_equal(x, y) for x, y in zip(mine, theirs, strict=True))


@vividc.kernel("void(float32[:, ::1])", like={"v": (20, 20)})
def upwards(v):
    """Columns from their last row, which is known and so an index in bytes, to the first."""
    for i in range(20):
        v[19, i] = 1.0
        for j in range(18, -1, -1):
            v[j, i] += v[j + 1, i]


def test_indices_in_bytes_and_in_elements_are_of_the_same_elements() -> None:
    function = tidy(upwards.lower())
    indices = {instr.shift for block in function.blocks for instr in block.instrs if instr.array}
    assert indices == {0, 2}
    [scop] = parts_of(function)
    stores = [a for s in scop.statements for a in s.accesses.values() if a.is_store]
    [last] = [access for access in stores if access.instr.shift == 0]
    assert last.subscripts == (Form((), 19), symbol("i0"))
    relations = Relations(scop)
    tree = replace(tree_of(scop), factor=4)
    loops = loops_of(tree, relations)
    assert not isinstance(loops, Refusal)
    made = generate(scop, loops)
    assert not isinstance(made, Refusal)
    mine, theirs = (np.random.default_rng(0).random((20, 20), dtype=np.float32) for _ in "12")
    interpret(function, mine)
    interpret(tidy(made.function), theirs)
    assert np.array_equal(mine, theirs)


@vividc.kernel("void(int32[:, ::1])")
def reaches(p):
    """Row k and column k are written in the iterations that read them; k < rows, columns."""
    for k in range(min(p.shape[0], p.shape[1])):
        for i in range(p.shape[0]):
            for j in range(p.shape[1]):
                p[i, j] = p[i, j] | (p[i, k] - 2 * p[k, j])


@pytest.mark.parametrize("masked", [False, True])
@pytest.mark.parametrize("path", [(), (0,), (0, 0)])
def test_what_a_loop_may_store_to_stays_in_registers(path: tuple[int, ...], masked: bool) -> None:
    """Each is what was stored where it is the same element: a loop over columns of four rows loads
    these and row k, and what they have of column k before.
    """
    function = tidy(reaches.lower())
    [scop] = parts_of(function)
    relations = Relations(scop)
    tree = with_factors(tree_of(scop), {path: 4}, masked=masked) if path else tree_of(scop)
    assert is_legal(tree, relations)
    loops = loops_of(tree, relations)
    assert not isinstance(loops, Refusal)
    made = generate(scop, loops, masks=masked)
    assert not isinstance(made, Refusal)
    after = tidy(made.function)
    inner = {(): 2, (0,): 5, (0, 0): 8}
    most = max(
        sum(i.op is Opcode.LOAD for b in after.blocks if b.name in loop.blocks for i in b.instrs)
        for loop in find_loops(after)
        if not any(o.header in loop.blocks for o in find_loops(after) if o != loop)
    )
    assert most == inner[path]
    for shape in ((1, 1), (5, 5), (4, 9), (9, 4), (0, 3)):
        mine, theirs = (
            np.random.default_rng(1).integers(-(2**31), 2**31, shape).astype(np.int32) for _ in "12"
        )
        interpret(function, mine)
        interpret(after, theirs)
        assert np.array_equal(mine, theirs), shape


@vividc.kernel("void(int32[::1], int32[::1], int32[:, ::1])")
def changed_within(t, b, c):
    for i in range(b.shape[0]):
        b[i] = t[1]
        for j in range(c.shape[0]):
            c[j, i] = i
            for k in range(c.shape[1]):
                t[1] = 5 + j + k


@vividc.kernel("void(int32[::1], int32[::1], int32[:, ::1])")
def stored_within(t, b, c):
    t[1] = 3
    for i in range(b.shape[0]):
        t[1] = b[i]
        for j in range(c.shape[0]):
            c[j, i] = i
            for k in range(c.shape[1]):
                t[1] = 5 + j + k


@vividc.kernel("void(int32[::1], int32[::1], int32[:, ::1])")
def changed_behind(t, b, c):
    for i in range(b.shape[0]):
        for j in range(c.shape[0]):
            c[j, i] = i
            for k in range(c.shape[1]):
                t[1] = (t[1] ^ i) + 2 * k
        t[1] = (t[1] ^ 3) + b[i]


@pytest.mark.parametrize("kernel", [changed_within, stored_within, changed_behind])
@pytest.mark.parametrize("path", [(), (0,), (1,)])
def test_what_loops_within_change_in_memory_is_known_after_them(
    kernel: vividc.KernelFunction, path: tuple[int, ...]
) -> None:
    """An iteration begins with t[1] as inner loops left it, which have no place for it."""
    function = tidy(kernel.lower())
    [scop] = parts_of(function)
    relations = Relations(scop)
    tree = tree_of(scop)
    paths = [found for found, _ in loops_in(tree)]
    tree = with_factors(tree, {path: 4}) if path in paths and path else tree
    loops = loops_of(tree, relations)
    assert not isinstance(loops, Refusal)
    made = generate(scop, loops)
    assert not isinstance(made, Refusal)
    after = tidy(made.function)
    for rows, columns in ((0, 3), (3, 0), (1, 1), (5, 6)):
        mine, theirs = (
            [
                np.arange(4, dtype=np.int32),
                np.arange(7, 7 + columns, dtype=np.int32),
                np.zeros((rows, columns), np.int32),
            ]
            for _ in "12"
        )
        interpret(function, *mine)
        interpret(after, *theirs)
        assert all(map(np.array_equal, mine, theirs)), (rows, columns)
