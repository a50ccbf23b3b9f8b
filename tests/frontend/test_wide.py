"""64-bit integers in two words: against numba bit for bit, and in one word wherever that does."""

from __future__ import annotations

import itertools
import random

import numpy as np
import pytest

from tests.frontend import wide_kernels
from vividc.frontend import KernelFunction, kernel
from vividc.machine.opcodes import Opcode
from vividc.machine.params import DType
from vividc.ssa.interpret import interpret as run
from vividc.ssa.ir import Function
from vividc.ssa.rewrite.tidy import tidy

KERNELS = [item for item in vars(wide_kernels).values() if isinstance(item, KernelFunction)]
BY_NAME = {item.name: item for item in KERNELS}
BITS = {DType.I32: 32, DType.U32: 32, DType.I64: 64, DType.U64: 64, DType.BOOL: 1}
UNSIGNED = {DType.U32, DType.U64, DType.BOOL}
BOUNDS = {
    ("root", 0): (-10, 2**31 - 1),
    ("gcd_by_subtraction", 0): (2**40, 2**40 + 2**36),
    ("gcd_by_subtraction", 1): (2**38, 2**39),
    ("shifts", 1): (0, 63),
    ("unsigned_shifts", 1): (0, 63),
    ("splitmix_word", 1): (0, 4),
    ("crosses", 1): (0, 20),
    # Numba leaves an overflow of 64 signed bits undefined.
    ("extremes", 0): (-(2**60), 2**60),
    ("extremes", 1): (-(2**60), 2**60),
}
TRIALS = 60


def scalar(rng: random.Random, dtype: DType) -> int:
    """Any value of a type, those next to powers of two more often than others."""
    bits = BITS[dtype]
    word = rng.getrandbits(rng.randint(1, bits))
    if rng.random() < 0.4:
        word = (1 << rng.randint(0, bits)) + rng.randint(-2, 2)
    word = -word if rng.random() < 0.4 else word
    word %= 1 << bits
    return word if dtype in UNSIGNED or not word >> bits - 1 else word - (1 << bits)


def argument(rng: random.Random, tested: KernelFunction, position: int) -> object:
    param = tested.params[position]
    if param.ndim:
        values = [scalar(rng, param.dtype) for _ in range(7)]
        return np.array(values, param.dtype.value)
    if (tested.name, position) in BOUNDS:
        return rng.randint(*BOUNDS[tested.name, position])
    if tested.name == "crosses" and rng.random() < 0.7:
        return rng.choice([2**31, 2**32, -(2**31)]) - rng.randint(0, 40)
    return scalar(rng, param.dtype)


@pytest.mark.parametrize("tested", KERNELS, ids=lambda k: k.name)
def test_kernels_compute_what_numba_computes(tested: KernelFunction) -> None:
    function = tested.lower()
    rng = random.Random(7)
    for _ in range(TRIALS):
        args = [argument(rng, tested, position) for position in range(len(tested.params))]
        if tested.name.startswith("divides") and args[-1] == 0:
            continue
        expected = tested(*args)
        actual = run(function, *args, max_blocks=200_000)
        assert actual == expected, f"{tested.name}{tuple(args)}"


def operations(function: Function) -> int:
    return sum(len(block.instrs) for block in function.blocks)


@kernel("void(int32[::1], int32[::1])")
def low_bits_only(x, y):
    for i in range(len(x)):
        y[i] = (x[i] * x[i] + (x[i] << 7)) * 3 ^ x[i]


@kernel("void(int32[::1], int64)")
def counts_to_a_parameter(x, n):
    for i in range(n):
        x[i & 3] = i


@kernel("int32(int32[::1], int64, int64)")
def sums_a_slice(x, first, last):
    total = np.int32(0)
    for i in range(first, last):
        total += x[i]
    return total


@kernel("int64(int64, int64)")
def sums_far_numbers(first, last):
    total = 0
    for i in range(first, last):
        total ^= i
    return total


@kernel("int64(int32[::1])")
def counts_matches(x):
    found = 0
    for value in x:
        if value == 7:
            found += 1
    return found


def test_high_words_are_computed_only_where_something_reads_them() -> None:
    function = low_bits_only.lower()
    high = {Opcode.MULHS, Opcode.MULHU}
    assert not [i for block in function.blocks for i in block.instrs if i.op in high]
    assert operations(function) <= 8


def test_a_result_that_fits_is_one_word() -> None:
    ends = [block.branch for block in counts_matches.lower().blocks if not block.branch.successors]
    assert [branch.high for branch in ends] == [None] * len(ends)


@pytest.mark.parametrize(
    ("tested", "words"),
    [
        (counts_to_a_parameter, [1, 1]),
        (sums_a_slice, [1, 1, 1]),
        (sums_far_numbers, [2, 2]),
        (BY_NAME["shifts"], [2, 2]),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_parameters_that_count_or_index_are_words(tested: KernelFunction, words: list[int]) -> None:
    assert [param.words for param in tested.lower().params] == words


def test_a_loop_over_far_numbers() -> None:
    first = 2**40 - 3
    function = sums_far_numbers.lower()
    assert run(function, first, first + 9) == sums_far_numbers(first, first + 9)
    assert run(function, 5, -5) == 0


def test_divisions_by_constants_take_no_estimate() -> None:
    """Only a variable divisor needs a reciprocal at run time."""
    for name in ("divides_by_constants", "modular_product"):
        ops = [i.op for block in BY_NAME[name].lower().blocks for i in block.instrs]
        assert Opcode.UITOFP not in ops


@kernel("void(int32[:, ::1])")
def shortest_paths(paths):
    """The sum of two words is a word and its carry; the least of it and a word is a word."""
    for k in range(len(paths)):
        for i in range(len(paths)):
            for j in range(len(paths)):
                paths[i, j] = min(paths[i, j], paths[i, k] + paths[k, j])


def test_the_least_of_a_word_and_a_sum_takes_one_operation_on_the_recurrence() -> None:
    """What makes the sum pass words is told by its terms: `paths[i, k]` stays as it is for all j,
    so that its limits are shared; the word that a loop carries takes part in one minimum.
    """
    blocks = tidy(shortest_paths.lower()).blocks
    ops = [instr.op for block in blocks for instr in block.instrs]
    assert Opcode.ICMP_ULT not in ops  # no carry
    assert [ops.count(op) for op in (Opcode.SELECT, Opcode.ICMP_SLE)] == [1, 1]


@kernel("void(int32[::1], int32[::1], int32[::1], boolean[::1])")
def sums_against_words(w, x, y, out):
    """Sums of two words against a word: of terms of any sign, of known sign, of one element."""
    for i in range(len(w)):
        one = 1 if y[i] > 3 else 0
        w[i] = max(w[i], x[i] + y[i])
        w[i] = min(w[i], x[i] - y[i])
        w[i] = max(w[i], x[i] + one)
        w[i] = min(w[i], one + x[i])
        w[i] = max(w[i], x[i] - one)
        w[i] = min(x[i] - one, w[i])
        w[i] = max(7 - x[i], w[i])
        w[i] = min(x[i] + y[2], w[i])
        w[i] = max(x[i] - y[2], w[i])
        w[i] = max(w[i], x[i] + y[i])
        out[i] = (x[i] + y[i] == 3) ^ (x[i] - y[i] == -5) ^ (x[i] + y[i] != -2147483648)


def test_sums_that_no_word_holds_are_compared_as_numba_compares_them() -> None:
    ends = [0, 1, -1, 3, -5, 2**31 - 1, 2**31 - 3, -(2**31), 5 - 2**31, 2**30, -(2**30), 2**30 + 1]
    x, y = (np.array(one, np.int32) for one in zip(*itertools.product(ends, ends), strict=True))
    lowered = sums_against_words.lower()
    for offset in (0, 2**31 - 1, -(2**31)):
        words = np.roll(x, 5) ^ np.int32(offset)
        expected, actual = ((words.copy(), np.zeros(len(x), bool)) for _ in range(2))
        sums_against_words(expected[0], x, y, expected[1])
        run(lowered, actual[0], x, y, actual[1])
        assert np.array_equal(actual[0], expected[0])
        assert np.array_equal(actual[1], expected[1])


@kernel("int32(int32, int32)")
def adds_up(x, y):
    return np.int32(1) if x + y == 3 else np.int32(0)


@kernel("int32(int32, int32, boolean)")
def largest_of_a_step(x, y, step):
    return np.int32(max(y, x + step))


@pytest.mark.parametrize(("tested", "most"), [(adds_up, 5), (largest_of_a_step, 4)])
def test_a_sum_of_two_words_needs_no_carry(tested: KernelFunction, most: int) -> None:
    assert operations(tidy(tested.lower())) <= most


@kernel("void(int32[::1], float32[::1])")
def floats_near_a_word(x, out):
    """Floats of sums that may pass all words by little, and by more than a float's rounding."""
    n = len(x)
    for i in range(n):
        for j in range(4):
            out[4 * i + j] = np.float32(x[i] + j - 1)
            out[4 * n + 4 * i + j] = np.float32(j - 55 + x[i])
            out[8 * n + 4 * i + j] = np.float32(x[i] - 31 - (j + 26))
            out[12 * n + 4 * i + j] = np.float32(x[i] + 60)
            out[16 * n + 4 * i + j] = np.float32(x[i] + j + 600)
            out[20 * n + 4 * i + j] = np.float32(j - x[i])


def test_a_sum_near_a_word_is_rounded_once() -> None:
    """The largest words and those behind them are the same float, up to half a float apart."""
    near = np.arange(0, 400, 3)
    x = np.concatenate([near - 200, 2**31 - 1 - near, near - 2**31]).astype(np.int32)
    expected, actual = (np.zeros(24 * len(x), np.float32) for _ in range(2))
    floats_near_a_word(x, expected)
    run(floats_near_a_word.lower(), x, actual, max_blocks=100_000)
    assert np.array_equal(actual.view(np.int32), expected.view(np.int32))


@kernel("float32(int32, boolean)")
def float_of_a_step(x, step):
    return np.float32(x + step)


def test_a_float_of_a_word_and_a_step_needs_no_second_word() -> None:
    ops = [instr.op for block in tidy(float_of_a_step.lower()).blocks for instr in block.instrs]
    assert ops == [Opcode.SMIN, Opcode.ADD, Opcode.SITOFP]
