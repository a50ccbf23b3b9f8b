"""Two versions of a kernel mean what it meant for arguments of all sizes, traps included, and the
first has nothing left that asks for sizes.
"""

from __future__ import annotations

import copy

import numpy as np
import pytest

import vividc
from tests.ssa.loops.sizes.expressions import arguments_of, kernel_of
from tests.ssa.loops.sizes.slices import KERNELS, M, V, apart, arguments, factors, products, ranked
from vividc.errors import SSAError
from vividc.frontend import KernelFunction
from vividc.machine.opcodes import Opcode
from vividc.machine.params import TRAP
from vividc.ssa.analysis.levels import with_own_latches
from vividc.ssa.check import check_function
from vividc.ssa.flow import find_loops
from vividc.ssa.interpret import interpret
from vividc.ssa.ir import Function
from vividc.ssa.loops.sizes.versions import Sized, for_sizes, without_arrays_between
from vividc.ssa.polyhedral.scop import find_scop
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy


def sized(kernel: KernelFunction) -> Sized:
    made = for_sizes(tidy(kernel.lower()))
    assert made is not None
    return made


def agreeing(made: Sized) -> Function:
    """The version for sizes that agree."""
    others = {block.name for block in made.function.blocks if ".other" in block.name}
    blocks = tuple(b for b in made.function.blocks if b.name not in others)
    return Function(made.function.name, made.function.params, blocks)


def outcome(function: Function, args: list[object]) -> tuple[object, ...]:
    """Arrays, what is returned, and whether an exception was raised."""
    args = copy.deepcopy(args)
    try:
        value = interpret(function, *args, max_blocks=20_000)
    except SSAError:
        value = "raises"
    arrays = tuple(arg.tobytes() for arg in args if isinstance(arg, np.ndarray))
    return np.asarray(value).tobytes(), *arrays


@pytest.mark.parametrize("kernel", KERNELS, ids=lambda kernel: kernel.name)
def test_both_versions_mean_the_same(kernel: KernelFunction) -> None:
    before = tidy(kernel.lower())
    after = sized(kernel).function
    assert check_function(after) == []
    outcomes = [outcome(before, args) for args in arguments(kernel)]
    for after_it in (after, tidy(after)):
        assert [outcome(after_it, args) for args in arguments(kernel)] == outcomes


@pytest.mark.parametrize("kernel", KERNELS, ids=lambda kernel: kernel.name)
def test_nothing_is_raised_where_sizes_agree(kernel: KernelFunction) -> None:
    instrs = [i for block in agreeing(sized(kernel)).blocks for i in block.instrs]
    assert not any(instr.array.startswith(TRAP) for instr in instrs)


@pytest.mark.parametrize("kernel", [ranked, factors, apart], ids=lambda kernel: kernel.name)
def test_slices_are_not_clamped_where_sizes_agree(kernel: KernelFunction) -> None:
    inside = {name for loop in find_loops(sized(kernel).function) for name in loop.blocks}
    blocks = [block for block in agreeing(sized(kernel)).blocks if block.name in inside]
    clamps = {Opcode.SMIN, Opcode.SMAX, Opcode.SELECT}
    assert not any(instr.op in clamps for block in blocks for instr in block.instrs)


def test_arrays_between_products_go() -> None:
    """alpha * a is made where it is multiplied, and the product is a sum's value where it is added
    to beta * c: one nest is left.
    """
    made = agreeing(sized(products))
    stored = {i.array for b in made.blocks for i in b.instrs if i.op is Opcode.STORE}
    assert stored == {"c"}


@vividc.kernel(f"void({V}, {V})")
def by_hand(x, y):
    for i in range(min(x.shape[0], 4)):
        x[i] = y[i]


@vividc.kernel(f"void({V}, {V}, {V})")
def filtered(x, taps, y):
    """There are fewer taps than samples."""
    for i in range(x.shape[0]):
        total = np.float32(0.0)
        for k in range(min(taps.shape[0], i + 1)):
            total += taps[k] * x[i - k]
        y[i] = total


@pytest.mark.parametrize("kernel", [by_hand, filtered], ids=lambda kernel: kernel.name)
def test_a_user_clamps_as_before(kernel: KernelFunction) -> None:
    assert for_sizes(tidy(kernel.lower())) is None


@vividc.kernel(f"void({V}, {V}, int32)")
def up_to_a_scalar(x, y, n):
    for i in range(n):
        x[:i] += y[i]


def test_slices_up_to_a_scalar_ask_for_sizes() -> None:
    assert for_sizes(tidy(up_to_a_scalar.lower())) is not None


@vividc.kernel(f"void({V}, {V}, int32)")
def of_scalars(x, y, n):
    for i in range(n):
        x[i] = y[i]


def test_loops_that_ask_for_no_sizes_have_one_version() -> None:
    assert for_sizes(tidy(of_scalars.lower())) is None


@pytest.mark.parametrize("kernel", [ranked, factors], ids=lambda kernel: kernel.name)
def test_a_program_runs_for_all_sizes(kernel: KernelFunction) -> None:
    """On the array as by numba, whatever sizes are; numba would raise where this does."""
    program = vividc.compile(kernel, cache=False)
    before = tidy(kernel.lower())
    for args in arguments(kernel):
        shapes = [arg.shape for arg in args if isinstance(arg, np.ndarray)]
        if any(0 in shape for shape in shapes):
            continue
        mine, theirs = copy.deepcopy(args), copy.deepcopy(args)
        try:
            interpret(before, *theirs, max_blocks=20_000)
        except SSAError:
            with pytest.raises(vividc.VividcError):
                vividc.simulate(program, *mine)
            continue
        vividc.simulate(program, *mine)
        for one, other in zip(mine, theirs, strict=True):
            np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("seed", range(1, 5))
def test_random_kernels_mean_the_same(seed: int) -> None:
    kernel = kernel_of(seed)
    before = tidy(kernel.lower())
    after = for_sizes(before)
    assert after is not None
    assert check_function(after.function) == []
    for args in arguments_of(seed):
        assert outcome(after.function, args) == outcome(before, args)


@vividc.kernel(f"void(int64, {M}, {V})")
def of_rows(n, a, x):
    """Ends of slices from a scalar, which numba computes in 64 bits."""
    for i in range(1, n - 1):
        a[1 : n - 1, i] = a[1 : n - 1, i - 1] * np.float32(2)
        x[1:n] = x[: n - 1] + a[i, 1:n]


def test_ends_from_scalars_are_words_where_sizes_agree() -> None:
    made = agreeing(sized(of_rows))
    ops = {instr.op for block in made.blocks for instr in block.instrs}
    assert ops.isdisjoint({Opcode.SMIN, Opcode.SMAX, Opcode.SELECT, Opcode.ASHR, Opcode.ICMP_ULT})


@vividc.kernel(f"{V}(float32, float32, {M}, {M}, {V})")
def summed(alpha, beta, a, b, x):
    return alpha * a @ x + beta * b @ x


def test_expressions_of_the_same_rows_are_one_nest() -> None:
    made = sized(summed).function
    others = {block.name for block in made.blocks if ".other" in block.name}
    assert len([one for one in find_loops(made) if one.header not in others]) == 2


@vividc.kernel(f"void(int64, int64, float32[:, :, ::1], {M})")
def deep(nr, nq, a, c):
    """doitgen: rows of an array of three dimensions, up to scalars."""
    for r in range(nr):
        for q in range(nq):
            a[r, q, :] = a[r, q, :] @ c


def test_rows_of_three_dimensions_are_where_scalars_are_no_more_than_these() -> None:
    made = sized(deep).function
    others = {block.name for block in made.blocks if ".other" in block.name}
    outer = max(
        (one for one in find_loops(made) if one.header not in others), key=lambda o: len(o.blocks)
    )
    part = find_scop(with_own_latches(tidy(made), outer.header), outer.header)
    assert not isinstance(part, Refusal), part.reason


@vividc.kernel(f"void({M})")
def one_shape(a):
    """deriche: columns of one array, which ask for nothing."""
    for j in range(2, a.shape[1]):
        a[:, j] = a[:, j] + np.float32(2) * a[:, j - 1]


@vividc.kernel(f"void({M}, {V})")
def kept(a, x):
    """What is summed last is stored first."""
    t = np.zeros(x.shape[0], np.float32)
    for i in range(a.shape[0]):
        for j in range(x.shape[0]):
            t[j] += a[i, j]
    for j in range(x.shape[0]):
        x[j] = t[x.shape[0] - 1 - j]


def test_arrays_between_go_where_no_sizes_are_asked_for() -> None:
    before = tidy(one_shape.lower())
    assert for_sizes(before) is None
    after = without_arrays_between(before)
    assert after is not None
    assert check_function(after) == []
    assert not [one for b in after.blocks for one in b.instrs if one.array.startswith("local")]
    for size in (0, 1, 4):
        args = [np.arange(size * size, dtype=np.float32).reshape(size, size)]
        assert outcome(after, args) == outcome(before, args)


def test_arrays_that_are_needed_stay() -> None:
    before = tidy(kept.lower())
    after = without_arrays_between(before) or before
    assert [one for b in after.blocks for one in b.instrs if one.array.startswith("local")]


@vividc.kernel(f"void(int64, {M})")
def swept(n, a):
    """seidel_2d: as many elements of a row as the array has, then as many as a scalar says."""
    for i in range(1, n - 1):
        a[i, 1:-1] += a[i - 1, :-2] + a[i, 2:] + a[i + 1, 1:-1]
        for j in range(1, n - 1):
            a[i, j] += a[i, j - 1]


def test_loops_that_are_one_for_sizes_that_agree_ask_for_them() -> None:
    before = tidy(swept.lower())
    made = sized(swept)
    assert check_function(made.function) == []
    loops = [one for one in find_loops(made.function) if one.header not in made.others]
    assert len(loops) == 2
    for n, rows, columns in ((0, 3, 3), (1, 1, 1), (2, 2, 2), (4, 4, 4), (3, 4, 5), (7, 7, 6)):
        a = np.arange(rows * columns, dtype=np.float32).reshape(rows, columns)
        assert outcome(made.function, [n, a]) == outcome(before, [n, a])


@vividc.kernel("int32[:, ::1](int64, int32[::1])")
def triangle(n, x):
    """nussinov: from the last row up, of an array that the kernel makes."""
    t = np.zeros((n, n), np.int32)
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            if j - 1 >= 0:
                t[i, j] = max(t[i, j], t[i, j - 1])
            if i + 1 < n:
                t[i, j] = max(t[i, j], t[i + 1, j] + x[j])
    return t


def test_rows_of_an_array_that_is_returned_are_known() -> None:
    before = tidy(triangle.lower())
    assert for_sizes(before) is None
    after = without_arrays_between(before)
    assert after is not None
    parts = []
    for function in (before, after):
        outer = max(find_loops(function), key=lambda one: len(one.blocks))
        parts.append(find_scop(with_own_latches(function, outer.header), outer.header))
    assert isinstance(parts[0], Refusal)
    assert not isinstance(parts[1], Refusal), parts[1].reason
