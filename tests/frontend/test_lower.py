"""Lowered kernels against numba: integers bit for bit."""

from __future__ import annotations

import copy
import warnings
from collections.abc import Callable

import numpy as np
import pytest

from tests.frontend import kernels as k
from vividc.errors import VividcWarning
from vividc.frontend import KernelFunction
from vividc.machine.opcodes import Opcode
from vividc.ssa.check import check_function
from vividc.ssa.interpret import interpret as run
from vividc.ssa.ir import Function, Instr

# numba contracts nothing, and float64 that runs in float32 costs a few units in the last place.
TOLERANCE = {"rtol": 2e-5, "atol": 2e-6}

RNG = np.random.default_rng(7)


def floats(*shape: int) -> np.ndarray:
    return RNG.standard_normal(shape).astype(np.float32)


def ints(*shape: int, low: int = -100, high: int = 100) -> np.ndarray:
    return RNG.integers(low, high, shape).astype(np.int32)


def words(*shape: int) -> np.ndarray:
    return ints(*shape, low=-(2**31), high=2**31)


def gaussians(scale: float) -> np.ndarray:
    rows = np.abs(floats(40, 7))
    rows[:, 3] *= 0.1
    rows[:, 5] = RNG.random(40) * scale
    return rows


SPECIAL = np.array([0.0, -0.0, np.nan, np.inf, -np.inf, 1.0], dtype=np.float32)
CASES: list[tuple[KernelFunction, tuple[object, ...]]] = [
    (k.saxpy, (floats(9), floats(9), 9)),
    (k.saxpy, (floats(3), floats(3), -2)),
    (k.saxpy_float32, (floats(9), floats(9), 9, np.float32(0.3))),
    (k.dot, (floats(7), floats(7))),
    (k.fir, (floats(12), floats(4), floats(9))),
    (k.prefix_sum, (words(30), ints(30))),
    (k.relu_gemv, (floats(4, 6), floats(6), floats(4))),
    (k.break_continue, (ints(40), 40)),
    (k.break_continue, (ints(40, high=80), 40)),
    (k.with_helper, (floats(5), 5)),
    (k.exponential, (floats(6), floats(6), 6)),
    (k.elementary, (floats(6), floats(6), 6)),
    (k.mean, (floats(7),)),
    (k.load_of_three, (ints(9), ints(9), ints(9, low=0, high=12), 6)),
    (k.matmul, (words(4, 5), words(5, 3), ints(4, 3))),
    (k.planes, (ints(3, 4, 2), ints(3))),
    (k.blend, (gaussians(0.2), np.float32(0.4), np.float32(0.5), 40)),
    (k.blend, (gaussians(1.0), np.float32(0.4), np.float32(0.5), 40)),
    (k.while_loop, (ints(30, low=0, high=9), 5)),
    (k.while_loop, (ints(30), 1000)),
    (k.while_loop, (ints(0), 1)),
    (k.binary_search, (np.sort(ints(33)), 7)),
    (k.range_steps, (ints(30), 1, 30, 5)),
    (k.range_steps, (ints(30), 25, 2, -5)),
    (k.negative_indices, (ints(20), 7)),
    (k.hashing, (words(20).view(np.uint32), 20)),
    (k.powers_of_two, (words(40), ints(40), 40)),
    (k.powers_of_two, (np.array([-(2**31), 2**31 - 1], np.int32), ints(2), 2)),
    (k.count, (floats(20), 20)),
    (k.conversions, (floats(20) * 50, ints(20), ints(20), True)),
    (k.conversions, (floats(20) * 50, ints(20), ints(20), False)),
    (k.choose, (floats(20), floats(20), ints(20))),
    (k.choose, (np.repeat(SPECIAL, 6), np.tile(SPECIAL, 6), ints(36))),
    (k.contains, (ints(20), 5)),
    (k.contains, (np.arange(9, dtype=np.int32), 5)),
    (k.zipped, (words(20), ints(20))),
    (k.zipped, (words(20), ints(10))),
    (k.one_or_the_other, (ints(9), ints(9), 9)),
    (k.view, (ints(4, 5), 2)),
    (k.view, (ints(4, 5), -1)),
    (k.rotate, (0xDEADBEEF, 5)),
    (k.powers_and_ufuncs, (floats(9), 9)),
    (k.nested_break, (ints(6, 5), 80)),
    (k.nested_break, (ints(6, 5, low=-100, high=0), 80)),
    (k.awkward_names, (4, 5, True, 6, ints(2))),
    (k.awkward_names, (4, 5, False, 6, ints(2))),
    (k.special_constants, (np.array([4, -4, 0, 1, -1, np.inf, np.nan], np.float32),)),
    (k.small_tuple, (floats(9), 9)),
    (k.nested_count, (ints(6, 5, low=-10, high=10),)),
    (k.unsigned_and_signed, (words(30), words(30).view(np.uint32), ints(30))),
]


def lowered(kernel: KernelFunction) -> Function:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VividcWarning)
        return kernel.lower()


def instrs(function: Function) -> list[Instr]:
    return [instr for block in function.blocks for instr in block.instrs]


def opcodes(function: Function) -> set[Opcode]:
    return {instr.op for instr in instrs(function)}


def assert_same(expected: object, actual: object) -> None:
    kind = np.asarray(expected).dtype.kind
    if kind == "f":
        np.testing.assert_allclose(actual, expected, **TOLERANCE)
    else:
        np.testing.assert_array_equal(actual, expected)


@pytest.mark.parametrize(("kernel", "args"), CASES, ids=lambda value: getattr(value, "name", ""))
def test_the_lowered_kernel_computes_what_numba_computes(
    kernel: KernelFunction, args: tuple[object, ...]
) -> None:
    expected, actual = copy.deepcopy(args), copy.deepcopy(args)
    expected_result = kernel(*expected)
    actual_result = run(lowered(kernel), *actual)
    if expected_result is None:
        assert actual_result is None
    else:
        assert_same(expected_result, actual_result)
    for one, other in zip(expected, actual, strict=True):
        assert_same(one, other)


@pytest.mark.parametrize("kernel", k.KERNELS, ids=lambda kernel: kernel.name)
def test_the_lowered_kernel_is_well_formed_and_has_source_lines(kernel: KernelFunction) -> None:
    function = lowered(kernel)
    assert check_function(function) == []
    assert {kernel for kernel, _ in CASES} >= {kernel}
    lines = {instr.loc.line for instr in instrs(function) if instr.loc is not None}
    assert lines
    assert all(i.loc is None or i.loc.file == kernel.file for i in instrs(function))
    assert min(lines) >= min(kernel.line, k.weight.py_func.__code__.co_firstlineno)


def test_a_counted_loop_is_one_induction_and_one_signed_comparison_in_the_header() -> None:
    [header] = [block for block in lowered(k.saxpy_float32).blocks if block.phis]
    [phi] = header.phis
    assert [i.op for i in header.instrs if i.op is not Opcode.ADD] == [Opcode.ICMP_SLT]
    assert header.branch.cond is not None
    assert any(value.word == 0 for _, value in phi.incoming if hasattr(value, "word"))


def test_an_index_that_is_not_negative_needs_no_wraparound() -> None:
    for kernel in (k.saxpy, k.fir, k.relu_gemv, k.matmul):
        found = opcodes(lowered(kernel)) - {Opcode.FMAX}
        assert Opcode.SELECT not in found or kernel is k.relu_gemv


def test_an_index_that_may_be_negative_keeps_its_wraparound() -> None:
    assert Opcode.SELECT in opcodes(lowered(k.negative_indices))


def test_a_row_offset_is_computed_before_the_inner_loop() -> None:
    function = lowered(k.relu_gemv)
    loops = [block for block in function.blocks if block.phis]
    [inner] = [block for block in loops if block.phis[-1].type.name == "F32"]
    multiplying = [b.name for b in function.blocks if any(i.op is Opcode.MUL for i in b.instrs)]
    outside = [name for phi in inner.phis for name, _ in phi.incoming]
    assert multiplying
    assert set(multiplying) <= set(outside)


def test_small_integer_powers_and_scalar_ufuncs_leave_no_loop_behind() -> None:
    assert len([b for b in lowered(k.powers_and_ufuncs).blocks if b.phis]) == 1


def test_a_helper_is_inlined_with_the_callers_line_where_it_has_no_file() -> None:
    locs = {i.loc.line for i in instrs(lowered(k.with_helper)) if i.op is Opcode.FMUL and i.loc}
    first = k.weight.py_func.__code__.co_firstlineno
    assert locs <= set(range(first, first + 7))


def test_float64_arithmetic_warns_once_for_its_line() -> None:
    fresh = KernelFunction(k.saxpy.py_func, "void(float32[::1], float32[::1], int32)", None)
    with pytest.warns(VividcWarning) as record:
        fresh.lower()
    [warning] = record
    line = k.saxpy.line + 3
    assert f"kernels.py:{line}: float64 arithmetic runs in float32" in str(warning.message)


def test_exact_float64_constants_do_not_warn() -> None:
    def halve(x, n):
        for i in range(n):
            if x[i] > 0.5:
                x[i] = np.float32(x[i] * 0.5)

    function = KernelFunction(halve, "void(float32[::1], int32)", None).lower(strict_fp=True)
    assert Opcode.FMUL in opcodes(function)


def test_lowering_is_deterministic() -> None:
    def again(kernel: KernelFunction, signature: str) -> Callable[[], Function]:
        return lambda: lowered(KernelFunction(kernel.py_func, signature, kernel.name))

    make = again(k.binary_search, "int32(int32[::1], int32)")
    assert make() == make() == lowered(k.binary_search)
