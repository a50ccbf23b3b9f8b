"""The expansion of `fdiv`: correctly rounded normal quotients, special operands, and the proof."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest

from tests.dfg.expand.vectorised import (
    OPERATIONS,
    SPECIALS,
    by_semantics,
    evaluate_many,
    expanded,
    fma,
    graph,
    interpreted,
    latency,
    random_words,
)
from vividc.dfg.check import check
from vividc.dfg.expand.divide import (
    RECIPROCAL_MAGIC,
    prepared,
    prepared_soon,
    quotient_by,
    quotient_soon_by,
)
from vividc.dfg.expand.expand import expand_math, late_divisors, waiting_parts
from vividc.dfg.forms.text import parse
from vividc.dfg.interpret.interpreter import interpret_region
from vividc.machine.division import Emit
from vividc.machine.opcodes import Opcode
from vividc.machine.words import float_of, word_of

SMALLEST_NORMAL = 0x00800000
WAYS: list[dict[str, bool]] = [{}, {"straight": True}, {"straight": True, "late_dividend": True}]
MAX_SUBNORMAL_ULP = Fraction(3, 4)
HARD_DIVISORS = 2
MANTISSAS = np.arange(0x3F800000, 0x40000000, dtype=np.uint32)
ESTIMATE_ERROR = 6.7e-6
BEYOND, NEAR = 55, 2.0**-10
"""Divisors whose reciprocal is more than half a unit in the last place off, and how much more."""


def is_subnormal(words: np.ndarray) -> np.ndarray:
    magnitude = words & np.uint32(0x7FFFFFFF)
    return (magnitude > 0) & (magnitude < SMALLEST_NORMAL)


def assert_rounded(a: np.ndarray, d: np.ndarray, ours: np.ndarray) -> None:
    """The table's word where that is no subnormal number, else within the bound."""
    exact = by_semantics(Opcode.FDIV, a, d)
    small = is_subnormal(exact) | is_subnormal(ours)
    assert np.array_equal(ours[~small], exact[~small])
    for x, y, word in zip(*(v[small].tolist() for v in (a, d, ours)), strict=True):
        quotient = Fraction(float_of(x)) / Fraction(float_of(y))
        error = abs(Fraction(float_of(word)) - quotient) * 2**149
        assert error <= MAX_SUBNORMAL_ULP, (hex(x), hex(y), hex(word))


def reciprocal(mantissas: np.ndarray, *, cubic: bool) -> np.ndarray:
    """The sequence's 1/d for words of [1, 2), by a last step that is cubic or Newton's."""
    d = mantissas.view(np.float32)
    one = np.ones(1, np.float32)
    y = (np.uint32(RECIPROCAL_MAGIC) - mantissas).view(np.float32)
    error = fma(-d, y, one)
    first = fma(y, error, y)
    y = fma(first, error * error, first)
    error = fma(-d, y, one)
    return fma(y, fma(error, error, error) if cubic else error, y)


def hardest(divisor: int) -> list[int]:
    """Dividends in [2**23, 2**24) whose quotients are 1/(2 divisor) ulp from a middle: solutions of
    2**(s+1) dividend - odd divisor = +-1.
    """
    dividends = []
    for scale in (24, 25):
        for distance in (1, -1):
            odd = -distance * pow(divisor, -1, 1 << scale) % (1 << scale)
            dividend = (odd * divisor + distance) >> scale
            if 1 << 23 <= dividend < 1 << 24 and 1 << 24 <= odd < 1 << 25:
                dividends.append(dividend)
    return dividends


def test_special_operands() -> None:
    a, d = (grid.ravel() for grid in np.meshgrid(SPECIALS, SPECIALS))
    ours = interpreted(Opcode.FDIV, a, d)
    assert_rounded(a, d, ours)
    for way in WAYS:
        assert np.array_equal(ours, expanded(Opcode.FDIV, a, d, **way))


def test_random_operands() -> None:
    a, d = random_words(3000, 1), random_words(3000, 2)
    ours = interpreted(Opcode.FDIV, a, d)
    assert_rounded(a, d, ours)
    for way in WAYS:
        assert np.array_equal(ours, expanded(Opcode.FDIV, a, d, **way))


def test_quotients_around_the_smallest_normal_and_the_largest_number() -> None:
    rng = np.random.default_rng(3)
    count = 2000
    d = rng.integers(0x3F000000, 0x40000000, 2 * count).astype(np.uint32)
    low = rng.integers(0x00000001, 0x01000000, count)
    high = rng.integers(0x7F000000, 0x7F800000, count)
    a = np.concatenate([low, high]).astype(np.uint32)
    ours = expanded(Opcode.FDIV, a, d)
    assert_rounded(a, d, ours)
    for way in WAYS:
        assert np.array_equal(ours, expanded(Opcode.FDIV, a, d, **way))


@pytest.mark.parametrize("divisor", [0x3F7FFFFF, 0x3F7FFFFD, 0x3F7FFFFB, 0x3F7FFFF9])
def test_the_hardest_quotients(divisor: int) -> None:
    mantissa = divisor & 0x7FFFFF | 0x800000
    dividends = [word_of(float(dividend)) for dividend in hardest(mantissa)]
    assert dividends
    a = np.array(dividends, np.uint32)
    d = np.full(len(dividends), divisor, np.uint32)
    for way in WAYS:
        ours = expanded(Opcode.FDIV, a, d, **way)
        assert np.array_equal(ours, by_semantics(Opcode.FDIV, a, d))


def test_operations() -> None:
    after = expand_math(graph(Opcode.FDIV, 1))
    assert check(after) == []
    assert len(after.operations) == 3 + 46
    assert (latency(after, 3, 5), latency(after, 2, 5)) == (61, 36)  # from divisor and dividend


def test_operations_where_latency_binds() -> None:
    after = expand_math(graph(Opcode.FDIV, straight=True))
    assert check(after) == []
    assert len(after.operations) == 52
    assert (latency(after, 2, 5), latency(after, 3, 5)) == (25, 37)
    after = expand_math(graph(Opcode.FDIV, straight=True, late_dividend=True))
    assert check(after) == []
    assert len(after.operations) == 7 + 52
    assert (latency(after, 13, 5), latency(after, 3, 5)) == (18, 43)


def by_halves(a: np.ndarray, d: np.ndarray, way: Callable[..., np.ndarray]) -> np.ndarray:
    """The quotients of divisors that were prepared, both in one of `HALVES`."""

    def emit(opcode: Opcode, *operands: np.ndarray | int) -> np.ndarray:
        with np.errstate(all="ignore"):
            return np.broadcast_to(OPERATIONS[opcode](*map(words, operands)), a.shape)

    def words(operand: np.ndarray | int) -> np.ndarray:
        return np.ascontiguousarray(np.broadcast_to(np.asarray(operand, np.uint32), a.shape))

    return way(emit, a, d)


def cheaply(emit: Emit[np.ndarray], a: np.ndarray, d: np.ndarray) -> np.ndarray:
    return quotient_by(emit, a, prepared(emit, d))


def soon(emit: Emit[np.ndarray], a: np.ndarray, d: np.ndarray) -> np.ndarray:
    return quotient_soon_by(emit, a, prepared_soon(emit, d))


def soon_prepared(emit: Emit[np.ndarray], a: np.ndarray, d: np.ndarray) -> np.ndarray:
    return quotient_by(emit, a, prepared_soon(emit, d, exact=True))


def soon_by_either(emit: Emit[np.ndarray], a: np.ndarray, d: np.ndarray) -> np.ndarray:
    return quotient_soon_by(emit, a, prepared_soon(emit, d, exact=True))


HALVES = [cheaply, soon, soon_prepared, soon_by_either]


def by_normal_divisors(emit: Emit[np.ndarray], a: np.ndarray, d: np.ndarray) -> np.ndarray:
    return quotient_soon_by(emit, a, prepared_soon(emit, d, normal=True))


def of_all_exponents(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Operands with each pair of exponents, of random signs and mantissas that are often short."""
    rng = np.random.default_rng(seed)
    fields = np.arange(256, dtype=np.uint32)
    grids = (grid.ravel() for grid in np.meshgrid(fields, fields))

    def number(exponents: np.ndarray) -> np.ndarray:
        size = exponents.size
        sign = rng.integers(0, 2, size, np.uint32) << np.uint32(31)
        mantissa = rng.integers(0, 1 << 23, size, np.uint32) >> rng.integers(0, 24, size, np.uint32)
        return sign | exponents << np.uint32(23) | mantissa

    a, d = map(number, grids)
    return a, d


def near_the_ends(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Operands whose quotients are subnormal, or nearly, or about the largest number."""
    rng = np.random.default_rng(seed)
    d = rng.integers(0, 1 << 32, 1 << 15).astype(np.uint32)
    low = rng.integers(1, 1 << 24, d.size).astype(np.uint32)
    high = rng.integers(0x7F000000, 0x7F800000, d.size).astype(np.uint32)
    wanted = np.where(rng.integers(0, 2, d.size) == 1, low, high).view(np.float32)
    with np.errstate(all="ignore"):
        a = (wanted.astype(np.float64) * d.view(np.float32)).astype(np.float32)
    return a.view(np.uint32), d


@pytest.mark.parametrize("way", HALVES)
def test_halves_have_the_words_of_the_whole(way: Callable[..., np.ndarray]) -> None:
    grids = np.meshgrid(np.asarray(SPECIALS, np.uint32), np.asarray(SPECIALS, np.uint32))
    specials = grids[0].ravel(), grids[1].ravel()
    for a, d in (specials, of_all_exponents(1), near_the_ends(2)):
        assert np.array_equal(by_halves(a, d, way), expanded(Opcode.FDIV, a, d))


def test_a_divisor_that_cannot_be_subnormal_takes_less() -> None:
    grids = np.meshgrid(np.asarray(SPECIALS, np.uint32), np.asarray(SPECIALS, np.uint32))
    specials = grids[0].ravel(), grids[1].ravel()
    for a, d in (specials, of_all_exponents(3), near_the_ends(4)):
        normal = np.where(is_subnormal(d), np.uint32(0x3F800000), d)
        whole = expanded(Opcode.FDIV, a, normal)
        assert np.array_equal(by_halves(a, normal, by_normal_divisors), whole)


ROOT = """dfg "by_root"
%0 = live_in "a"
%1 = live_in "d"
%2 = sqrt %1
%3 = fdiv %0, %2
%4 = live_out "%v" %3
"""


def test_quotients_by_a_root_have_the_same_words() -> None:
    dfg = expand_math(parse(ROOT))
    [result] = [edge.src for edge in dfg.edges if edge.dst == 4]
    grids = np.meshgrid(np.asarray(SPECIALS, np.uint32), np.asarray(SPECIALS, np.uint32))
    a, d = (
        np.concatenate(both)
        for both in zip((grids[0].ravel(), grids[1].ravel()), of_all_exponents(5), strict=True)
    )
    root = expanded(Opcode.SQRT, d)
    whole = expanded(Opcode.FDIV, a, root)
    assert np.array_equal(evaluate_many(dfg, result, {0: a, 1: d}), whole)


MASKED_ROOT = ROOT.replace("%2 = sqrt %1", '%5 = live_in "p"\n%2 = sqrt %1 if %5')
ROOT_BEFORE = """dfg "by_the_root_before"
%0 = iv
%1 = live_in "&x"
%2 = live_in "start"
%3 = load "x" %0 shift 2 base %1
%4 = sqrt %5
%5 = fdiv %3, %4@1(init=%2)
%6 = store "x" %0, %5 shift 2 base %1 after %3
"""
SMALL, LARGE = 0x00012345, 0x01234567


def test_what_is_not_always_a_root_may_be_subnormal() -> None:
    """A masked root passes its operand on, and the first iteration divides by what it begins
    with.
    """
    dfg = expand_math(parse(MASKED_ROOT))
    [result] = [edge.src for edge in dfg.edges if edge.dst == 4]
    a, d = np.array([LARGE], np.uint32), np.array([SMALL], np.uint32)
    given = {0: a, 1: d, 5: np.zeros(1, np.uint32)}
    whole = by_semantics(Opcode.FDIV, a, d)
    assert np.array_equal(evaluate_many(dfg, result, given), whole)
    memory = a.copy()
    loop = expand_math(parse(ROOT_BEFORE))
    interpret_region(loop, "loop", 1, {"&x": 0, "start": SMALL}, memory)
    assert np.array_equal(memory, whole)


@pytest.mark.parametrize("divisor", [0x3F7FFFFF, 0x3F7FFFFD, 0x3F7FFFFB, 0x3F7FFFF9])
def test_the_hardest_quotients_by_halves(divisor: int) -> None:
    dividends = hardest(divisor & 0x7FFFFF | 0x800000)
    a = np.array([word_of(float(dividend)) for dividend in dividends], np.uint32)
    d = np.full(len(a), divisor, np.uint32)
    for way in HALVES:
        assert np.array_equal(by_halves(a, d, way), by_semantics(Opcode.FDIV, a, d))


@pytest.mark.slow
@pytest.mark.parametrize("way", HALVES)
def test_halves_have_the_words_of_the_whole_in_a_dense_sweep(
    way: Callable[..., np.ndarray],
) -> None:
    """Every mantissa of a divisor, too: the preparation is wrong for none."""
    for seed in range(16):
        for a, d in (of_all_exponents(seed), near_the_ends(seed)):
            assert np.array_equal(by_halves(a, d, way), expanded(Opcode.FDIV, a, d))
    a = random_words(len(MANTISSAS), 7)
    whole = expanded(Opcode.FDIV, a, MANTISSAS)
    assert np.array_equal(by_halves(a, MANTISSAS, way), whole)


TWO_QUOTIENTS = """dfg "two"
%0 = iv
%1 = live_in "&x"
%2 = live_in "start"
%3 = load "x" %0 shift 2 base %1
%4 = fdiv %3, {divisor}
%5 = fadd %4, %3
%6 = fdiv %3, %5
%7 = store "x" %0, %6 shift 2 base %1 after %3
"""


@pytest.mark.parametrize(("divisor", "operations"), [("%5@1(init=%2)", 52), ("%3@1(init=%2)", 46)])
def test_latency_binds_on_a_recurrence(divisor: str, operations: int) -> None:
    after = expand_math(parse(TWO_QUOTIENTS.format(divisor=divisor)))
    assert check(after) == []
    assert len(after.operations) == 3 + operations + 46


RECURRENCE = """dfg "recurrence"
%0 = iv
%1 = live_in "&x"
%2 = live_in "start"
%3 = load "x" %0 shift 2 base %1
%4 = fadd %5@1(init=%2), %3
%5 = fdiv {operands}
%6 = store "x" %0, %5 shift 2 base %1 after %3
"""
STRAIGHT = """dfg "straight"
%0 = live_in "a"
%1 = live_in "d"
%2 = fadd %0, %0
%3 = fadd %2, %2
%4 = fdiv {operands}
%5 = live_out "%v" %4
"""


@pytest.mark.parametrize(
    ("text", "operands", "late"),
    [
        (RECURRENCE, "%3, %4", True),
        (RECURRENCE, "%4, %3", False),
        (RECURRENCE, "%4, %4", True),
        (RECURRENCE, "%5@1(init=%2), %4", True),
        (RECURRENCE, "%4, %5@1(init=%2)", True),
        (STRAIGHT, "%0, %1", True),
        (STRAIGHT, "%0, %3", True),
        (STRAIGHT, "%2, %1", True),  # four cycles later
        (STRAIGHT, "%3, %1", False),  # eight
    ],
)
def test_what_waits_for_its_divisor(text: str, operands: str, late: bool) -> None:
    """What is outside a recurrence does not hold up what is on it."""
    dfg = parse(text.format(operands=operands))
    [divided] = [node.id for node in dfg.nodes if node.op is Opcode.FDIV]
    assert late_divisors(dfg, waiting_parts(dfg)) == ({divided} if late else set())


def test_a_quotient_by_a_root_is_there_sooner() -> None:
    after = expand_math(parse(ROOT))
    root = latency(expand_math(graph(Opcode.SQRT, straight=True)), 2, 5)
    assert (root, latency(after, 1, 4) - root) == (35, 34)


@pytest.mark.slow
def test_every_divisor_is_correctly_rounded_by_two_corrections() -> None:
    """The reciprocal's relative error times the last residual, half an ulp and 2**-20 of one at
    most, must stay below 1/(2d) ulp; where it does not, the dividends of that distance are tried.
    """
    d = MANTISSAS.view(np.float32).astype(np.float64)
    reach = np.abs(1 - d * reciprocal(MANTISSAS, cubic=True)) * d * 2**23  # in units of 1/(2d) ulp
    hard = MANTISSAS[reach >= 1 - 2.0**-19]
    assert len(hard) == HARD_DIVISORS
    assert reach.max() < 2  # only distance 1 is in reach: distances are integers
    for word in hard.tolist():
        dividends = hardest(word & 0x7FFFFF | 0x800000)
        a = np.array([word_of(float(dividend)) for dividend in dividends], np.uint32)
        divisors = np.full(len(a), word, np.uint32)
        assert np.array_equal(
            expanded(Opcode.FDIV, a, divisors), by_semantics(Opcode.FDIV, a, divisors)
        )


@pytest.mark.slow
def test_every_divisor_is_correctly_rounded_by_one_step() -> None:
    """Where |1 - d y| is at most 2**-24, a * y is less than one unit in the last place from a / d
    before it is rounded, and one and a half after, so that one step brings it to the nearest
    number. Of the other divisors all dividends are tried that are near enough to be more.
    """
    d = MANTISSAS.view(np.float32).astype(np.float64)
    reach = np.abs(1 - d * reciprocal(MANTISSAS, cubic=False)) * 2**24
    beyond = reach > 1
    assert beyond.sum() == BEYOND
    assert reach.max() < 1 + NEAR
    for word in MANTISSAS[beyond].tolist():
        divisor = np.array([word], np.uint32)
        nearest = word - np.arange(int(2**24 * 2 * NEAR), dtype=np.uint32)
        a = np.concatenate([nearest, nearest + np.uint32(1 << 10)])
        exact = (a.view(np.float32) / divisor.view(np.float32)).view(np.uint32)
        divisors = np.full(len(a), word, np.uint32)
        assert np.array_equal(
            expanded(Opcode.FDIV, a, divisors, straight=True, late_dividend=True), exact
        )
        assert np.array_equal(by_halves(a, divisors, soon), exact)


@pytest.mark.slow
def test_the_estimate_is_never_too_high() -> None:
    """By more than its roundings, so that a product with it is in the quotient's binade, where it
    is rounded by half a unit at most, unless the quotient is as near to the next one as those of
    `test_quotients_beside_one`. The Newton step leaves the square of what it is too low by.
    """
    d = MANTISSAS.view(np.float32)
    y = (np.uint32(RECIPROCAL_MAGIC) - MANTISSAS).view(np.float32)
    error = fma(-d, y, np.ones(1, np.float32))
    first = fma(y, error, y)
    low = 1 - d.astype(np.float64) * fma(first, error * error, first)
    assert low.min() > -(2.0**-23)
    assert low.max() < ESTIMATE_ERROR


@pytest.mark.slow
@pytest.mark.parametrize("units", [-2, -1, 1, 2, 3, 4])
def test_quotients_beside_one(units: int) -> None:
    """By dividends so many units below their divisor."""
    d = MANTISSAS[4:-4]
    a = d - np.int32(units).view(np.uint32)
    exact = (a.view(np.float32) / d.view(np.float32)).view(np.uint32)
    assert np.array_equal(expanded(Opcode.FDIV, a, d, straight=True), exact)
    assert np.array_equal(by_halves(a, d, soon), exact)


@pytest.mark.slow
def test_a_dense_sweep_equals_numpy() -> None:
    for seed in range(8):
        a, d = random_words(1 << 20, 2 * seed), random_words(1 << 20, 2 * seed + 1)
        ours = expanded(Opcode.FDIV, a, d)
        for way in WAYS:
            assert np.array_equal(ours, expanded(Opcode.FDIV, a, d, **way))
        with np.errstate(all="ignore"):
            quotient = a.view(np.float32) / d.view(np.float32)
        exact = np.where(np.isnan(quotient), np.uint32(0x7FC00000), quotient.view(np.uint32))
        normal = ~(is_subnormal(exact) | is_subnormal(ours))
        assert np.array_equal(ours[normal], exact[normal])
        assert np.abs(ours.astype(np.int64) - exact)[~normal].max() <= 1
