"""Operation semantics against numpy's binary32 and an exact rational oracle."""

from __future__ import annotations

import random
from fractions import Fraction

import numpy as np
import pytest

from vividc.errors import InternalError
from vividc.machine.opcodes import OPCODES, LatencyClass, Opcode
from vividc.machine.semantics import SEMANTICS, evaluate, evaluate_predicated
from vividc.machine.words import CANONICAL_NAN, float_of, signed, word_of

SAMPLES = 4000
SPECIAL = (
    *(0, 1, 0x007FFFFF, 0x00800000, 0x3F800000, 0x3F7FFFFF, 0x7F7FFFFF, 0x7F800000),
    *(0x7FC00000, 0x7F800001, 0x7FFFFFFF, 0x4F000000, 0x4EFFFFFF, 0x4B800000),
)


def bit_patterns(count: int, seed: int) -> np.ndarray:
    """Random words: any bits, nearby exponents, and special values of both signs."""
    rng = np.random.default_rng(seed)
    anything = rng.integers(0, 1 << 32, count, dtype=np.uint64)
    near_one = rng.integers(0x3E000000, 0x41000000, count, dtype=np.uint64)
    near_one ^= rng.integers(0, 2, count, dtype=np.uint64) << np.uint64(31)
    tiny = rng.integers(0, 0x02000000, count, dtype=np.uint64)
    special = np.array([word ^ sign for word in SPECIAL for sign in (0, 1 << 31)], dtype=np.uint64)
    picked = rng.choice(special, count)
    kinds = np.stack([anything, near_one, tiny, picked])
    return kinds[rng.integers(0, 4, count), np.arange(count)].astype(np.uint32)


def canonical(values: np.ndarray) -> list[int]:
    words = values.astype(np.float32).view(np.uint32)
    return np.where(np.isnan(values), np.uint32(CANONICAL_NAN), words).tolist()


@pytest.mark.parametrize(
    ("op", "ufunc"),
    [(Opcode.FADD, np.add), (Opcode.FSUB, np.subtract), (Opcode.FMUL, np.multiply)],
)
def test_arithmetic_equals_numpy_bit_for_bit(op: Opcode, ufunc: np.ufunc) -> None:
    a, b = bit_patterns(SAMPLES, 1), bit_patterns(SAMPLES, 2)
    with np.errstate(all="ignore"):
        expected = canonical(ufunc(a.view(np.float32), b.view(np.float32)))
    pairs = zip(a.tolist(), b.tolist(), strict=True)
    assert [evaluate(op, pair) for pair in pairs] == expected


@pytest.mark.parametrize(
    ("op", "holds"),
    [
        (Opcode.FCMP_OEQ, lambda a, b, nan: (a == b) & ~nan),
        (Opcode.FCMP_UNE, lambda a, b, nan: (a != b) | nan),
        (Opcode.FCMP_OLT, lambda a, b, nan: (a < b) & ~nan),
        (Opcode.FCMP_OLE, lambda a, b, nan: (a <= b) & ~nan),
        (Opcode.FCMP_ULT, lambda a, b, nan: (a < b) | nan),
        (Opcode.FCMP_ULE, lambda a, b, nan: (a <= b) | nan),
        (Opcode.FCMP_ONE, lambda a, b, nan: (a != b) & ~nan),
        (Opcode.FCMP_UEQ, lambda a, b, nan: (a == b) | nan),
        (Opcode.FCMP_ORD, lambda a, b, nan: ~nan),
        (Opcode.FCMP_UNO, lambda a, b, nan: nan),
    ],
)
def test_float_comparisons_equal_numpy(op: Opcode, holds: object) -> None:
    a, b = bit_patterns(SAMPLES, 3), bit_patterns(SAMPLES, 4)
    b[: SAMPLES // 4] = a[: SAMPLES // 4]
    x, y = a.view(np.float32), b.view(np.float32)
    nan = np.isnan(x) | np.isnan(y)
    expected = holds(x, y, nan).astype(int).tolist()  # type: ignore[operator]
    pairs = zip(a.tolist(), b.tolist(), strict=True)
    assert [evaluate(op, pair) for pair in pairs] == expected


def test_conversions_equal_numpy() -> None:
    words = bit_patterns(SAMPLES, 5)
    expected = canonical(words.view(np.int32).astype(np.float32))
    assert [evaluate(Opcode.SITOFP, [word]) for word in words.tolist()] == expected
    expected = canonical(words.astype(np.float32))
    assert [evaluate(Opcode.UITOFP, [word]) for word in words.tolist()] == expected


def test_fptosi_truncates_and_saturates() -> None:
    for word in bit_patterns(SAMPLES, 6).tolist():
        value = float_of(word)
        if value != value:  # noqa: PLR0124
            expected = 0
        else:
            limited = max(-(2.0**31), min(value, 2.0**31 - 1))
            expected = int(limited) & 0xFFFFFFFF
        assert evaluate(Opcode.FPTOSI, [word]) == expected, hex(word)


def exact(word: int) -> Fraction:
    """Value of a finite word."""
    exponent, mantissa = word >> 23 & 0xFF, word & 0x7FFFFF
    significand = mantissa if exponent == 0 else mantissa | 1 << 23
    value = Fraction(significand) * Fraction(2) ** (max(exponent, 1) - 150)
    return -value if word >> 31 else value


def rounded(value: Fraction) -> int:
    """Nearest word of a nonzero rational, ties to even; no float arithmetic."""
    sign = 1 << 31 if value < 0 else 0
    value = abs(value)
    exponent = max(value.numerator.bit_length() - value.denominator.bit_length(), -126)
    while exponent > -126 and value < Fraction(2) ** exponent:
        exponent -= 1
    while value >= Fraction(2) ** (exponent + 1):
        exponent += 1
    scaled = value / Fraction(2) ** (exponent - 23)
    whole, rest = divmod(scaled.numerator, scaled.denominator)
    half = Fraction(rest, scaled.denominator)
    whole += half > Fraction(1, 2) or (half == Fraction(1, 2) and whole % 2 == 1)
    bits = whole + ((exponent + 126) << 23)  # a carry out of the significand raises the exponent
    return sign | min(bits, 0x7F800000)


def is_finite(word: int) -> bool:
    return word & 0x7F800000 != 0x7F800000


def hard_fma_cases(count: int) -> list[tuple[int, int, int]]:
    """Products near the tie of the sum, cancellation, and results around the subnormals."""
    rng = random.Random(7)
    cases = []
    for _ in range(count):
        a, b = rng.getrandbits(32), rng.getrandbits(32)
        product = word_of(float_of(a) * float_of(b))
        shift = rng.randint(-26, 26) << 23
        near = (product ^ rng.choice((0, 1 << 31))) + rng.randint(-2, 2)
        c = rng.choice((near, near + shift, rng.getrandbits(32))) & 0xFFFFFFFF
        cases.append((a, b, c))
        low = rng.randint(40, 70) << 23 | rng.getrandbits(23)
        cases.append((low, low + (rng.randint(-16, 16) << 23), rng.getrandbits(26)))
        sparse = 0x3F800000 | 1 << rng.randint(0, 22)
        cases.append((sparse, sparse, rng.choice((1, 0x33800000, 0xB3800000, 0x0D800000))))
    return cases


FUSED = {
    Opcode.FMA: lambda a, b, c: a * b + c,
    Opcode.FMS: lambda a, b, c: a * b - c,
    Opcode.FNMA: lambda a, b, c: c - a * b,
}


@pytest.mark.parametrize("op", FUSED)
def test_fused_products_round_once(op: Opcode) -> None:
    checked = 0
    for words in hard_fma_cases(2500):
        if not all(map(is_finite, words)):
            continue
        value = FUSED[op](*map(exact, words))
        if value:
            assert evaluate(op, words) == rounded(value), [hex(word) for word in words]
            checked += 1
    assert checked > 5000


def test_fma_differs_from_a_binary64_sum_where_that_ties() -> None:
    """1.0000001**2 is just above a tie once a tiny addend is lost in binary64."""
    a, c = 0x3F800001, word_of(2.0**-80)
    tie = word_of(1.0 + 2.0**-12), word_of(1.0 + 2.0**-12)
    assert evaluate(Opcode.FMA, (a, a, c)) == rounded(exact(a) ** 2 + exact(c))
    assert evaluate(Opcode.FMA, (*tie, c)) == rounded(exact(tie[0]) ** 2 + exact(c))
    minus = c ^ 0x80000000
    assert evaluate(Opcode.FMA, (*tie, minus)) == rounded(exact(tie[0]) ** 2 - exact(c))
    assert evaluate(Opcode.FMA, (*tie, c)) != evaluate(Opcode.FMA, (*tie, minus))


INF, NINF, NAN, ZERO, NZERO, ONE = 0x7F800000, 0xFF800000, CANONICAL_NAN, 0, 0x80000000, 0x3F800000


@pytest.mark.parametrize(
    ("operands", "expected"),
    [
        ((INF, ZERO, ONE), NAN),
        ((INF, ONE, NINF), NAN),
        ((INF, ONE, ONE), INF),
        ((ONE, ONE, NINF), NINF),
        ((0x7F7FFFFF, 0x7F7FFFFF, NINF), NINF),
        ((0x7F7FFFFF, 0x40000000, ZERO), INF),
        ((ONE, 0xFFC12345, ONE), NAN),
        ((NZERO, ONE, NZERO), NZERO),
        ((NZERO, ONE, ZERO), ZERO),
        ((ONE, ONE, 0xBF800000), ZERO),
    ],
)
def test_fma_of_special_values(operands: tuple[int, int, int], expected: int) -> None:
    a, b, c = operands
    assert evaluate(Opcode.FMA, operands) == expected
    assert evaluate(Opcode.FMS, (a, b, c ^ NZERO)) == expected
    assert evaluate(Opcode.FNMA, (a ^ NZERO, b, c)) == expected
    assert evaluate(Opcode.FNMA, (a, b ^ NZERO, c)) == expected


@pytest.mark.parametrize(
    ("a", "b", "least", "greatest"),
    [
        (NAN, ONE, ONE, ONE),
        (ONE, 0xFFC00001, ONE, ONE),
        (0x7FC12345, 0xFFC00001, NAN, NAN),
        (ZERO, NZERO, NZERO, ZERO),
        (NZERO, ZERO, NZERO, ZERO),
        (NINF, INF, NINF, INF),
        (ONE, ONE, ONE, ONE),
        (0x40000000, ONE, ONE, 0x40000000),
    ],
)
def test_fmin_and_fmax_are_minimum_and_maximum_number(
    a: int, b: int, least: int, greatest: int
) -> None:
    assert evaluate(Opcode.FMIN, (a, b)) == least
    assert evaluate(Opcode.FMAX, (a, b)) == greatest


def test_integer_operations_wrap_and_compare_as_numpy_does() -> None:
    a, b = bit_patterns(SAMPLES, 8), bit_patterns(SAMPLES, 9)
    i, j = a.view(np.int32), b.view(np.int32)
    amount = b & np.uint32(31)
    expected = {
        Opcode.ADD: a + b,
        Opcode.SUB: a - b,
        Opcode.MUL: a * b,
        Opcode.MULHS: i.astype(np.int64) * j >> 32,
        Opcode.MULHU: a.astype(np.uint64) * b >> np.uint64(32),
        Opcode.AND: a & b,
        Opcode.OR: a | b,
        Opcode.XOR: a ^ b,
        Opcode.SHL: a << amount,
        Opcode.LSHR: a >> amount,
        Opcode.ASHR: (i >> amount.astype(np.int32)).view(np.uint32),
        Opcode.SMIN: np.minimum(i, j).view(np.uint32),
        Opcode.SMAX: np.maximum(i, j).view(np.uint32),
        Opcode.ICMP_EQ: a == b,
        Opcode.ICMP_NE: a != b,
        Opcode.ICMP_SLT: i < j,
        Opcode.ICMP_SLE: i <= j,
        Opcode.ICMP_ULT: a < b,
        Opcode.ICMP_ULE: a <= b,
    }
    for op, words in expected.items():
        got = [evaluate(op, pair) for pair in zip(a.tolist(), b.tolist(), strict=True)]
        assert got == words.astype(np.uint32).tolist(), op


def test_select_mov_and_sign_operations_keep_bits() -> None:
    payload = 0xFF812345
    assert evaluate(Opcode.SELECT, (1, payload, 2)) == payload
    assert evaluate(Opcode.SELECT, (0, payload, 2)) == 2
    assert evaluate(Opcode.MOV, [payload]) == payload
    assert evaluate(Opcode.FNEG, [payload]) == 0x7F812345
    assert evaluate(Opcode.FABS, [payload]) == 0x7F812345


def test_exp_of_the_whole_range() -> None:
    assert evaluate(Opcode.EXP, [ZERO]) == ONE
    assert evaluate(Opcode.EXP, [INF]) == INF
    assert evaluate(Opcode.EXP, [NINF]) == ZERO
    assert evaluate(Opcode.EXP, [word_of(1e30)]) == INF
    assert evaluate(Opcode.EXP, [0xFFC00001]) == NAN
    assert evaluate(Opcode.EXP, [word_of(-100.0)]) == word_of(3.7200759760208361e-44)


def test_a_predicated_operation_passes_its_last_operand() -> None:
    assert evaluate_predicated(Opcode.FMA, 0, (ONE, ONE, 7)) == 7
    assert evaluate_predicated(Opcode.FMA, 1, (ONE, ONE, ONE)) == 0x40000000
    assert evaluate_predicated(Opcode.FMS, 0, (ONE, ONE, 7)) == 7
    assert evaluate_predicated(Opcode.FNMA, 0, (ONE, ONE, 7)) == 7


def test_the_table_has_every_operation_that_computes() -> None:
    silent = {LatencyClass.SOURCE, LatencyClass.SINK, LatencyClass.LOAD, LatencyClass.STORE}
    computing = {
        op
        for op, info in OPCODES.items()
        if info.latency_class not in silent and op is not Opcode.GENERIC
    }
    assert set(SEMANTICS) == computing
    with pytest.raises(InternalError):
        evaluate(Opcode.LOAD, [0])


def test_signed_is_twos_complement() -> None:
    assert [signed(word) for word in (0, 1, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)] == [
        *(0, 1, 2**31 - 1, -(2**31), -1)
    ]


@pytest.mark.parametrize(
    ("op", "operands", "result"),
    [
        (Opcode.EXP2, [word_of(-3.0)], word_of(0.125)),
        (Opcode.EXP2, [word_of(1e30)], INF),
        (Opcode.EXP2, [NINF], ZERO),
        (Opcode.FDIV, [ONE, word_of(3.0)], 0x3EAAAAAB),
        (Opcode.FDIV, [word_of(-1.0), ZERO], NINF),
        (Opcode.FDIV, [ONE, NZERO], NINF),
        (Opcode.FDIV, [ZERO, NZERO], NAN),
        (Opcode.FDIV, [INF, NINF], NAN),
        (Opcode.FDIV, [word_of(-2.0), INF], NZERO),
        (Opcode.FDIV, [0xFFC00001, ZERO], NAN),
        (Opcode.SQRT, [word_of(2.0)], 0x3FB504F3),
        (Opcode.SQRT, [NZERO], NZERO),
        (Opcode.SQRT, [word_of(-1.0)], NAN),
        (Opcode.SQRT, [INF], INF),
        (Opcode.FLOOR, [word_of(-0.5)], word_of(-1.0)),
        (Opcode.FLOOR, [NINF], NINF),
        (Opcode.CEIL, [word_of(-0.5)], NZERO),
        (Opcode.CEIL, [0xFFC00001], NAN),
        (Opcode.UDIV, [7, 0], 0),
        (Opcode.UREM, [7, 0], 7),
        (Opcode.SDIV, [-7 & 0xFFFFFFFF, 2], -3 & 0xFFFFFFFF),
        (Opcode.SREM, [-7 & 0xFFFFFFFF, 2], -1 & 0xFFFFFFFF),
        (Opcode.SDIV, [0x80000000, 0xFFFFFFFF], 0x80000000),
        (Opcode.SREM, [0x80000000, 0xFFFFFFFF], 0),
        (Opcode.CTLZ, [0], 32),
        (Opcode.CTTZ, [0], 32),
        (Opcode.BSWAP, [0x12345678], 0x78563412),
        (Opcode.BITREVERSE, [0x00000013], 0xC8000000),
    ],
)
def test_elementary_functions_at_their_edges(op: Opcode, operands: list[int], result: int) -> None:
    assert evaluate(op, operands) == result
