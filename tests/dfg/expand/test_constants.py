"""Division, remainder and powers with a constant operand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.dfg.expand.test_divide import assert_rounded
from tests.dfg.expand.vectorised import SPECIALS, by_semantics, evaluate_many, random_words
from vividc.dfg.check import check
from vividc.dfg.expand.expand import expand_math
from vividc.dfg.forms.text import parse
from vividc.dfg.ir import DFG
from vividc.machine.opcodes import Opcode
from vividc.machine.words import word_of

GRAPH = """dfg "constant"
%0 = iv
%1 = live_in "&x"
%2 = load "x" %0 shift 2 base %1
%3 = const {word:#010x}
%4 = {op} %2, %3
%5 = store "x" %0, %4 shift 2 base %1 after %2
"""
NOT_OPERATIONS = 2


def graph(op: Opcode, constant: float) -> DFG:
    after = expand_math(parse(GRAPH.format(op=op.value, word=word_of(constant))))
    assert check(after) == []
    return after


def results(op: Opcode, constant: float, words: np.ndarray) -> np.ndarray:
    dfg = graph(op, constant)
    [result] = [edge.src for edge in dfg.edges if edge.dst == 5 and edge.port == 1]
    return evaluate_many(dfg, result, {2: words, 3: np.full(len(words), word_of(constant))})


def sample() -> np.ndarray:
    subnormal = np.arange(0, 1 << 23, 30011, dtype=np.uint32)
    edges = (np.array([0x1F800000, 0x5F800000])[:, None] + np.arange(-20, 20)).ravel()
    negative = edges.astype(np.uint32) | np.uint32(0x80000000)
    return np.concatenate(
        [SPECIALS, random_words(4000, 3), subnormal, edges.astype(np.uint32), negative]
    )


@pytest.mark.parametrize(
    "constant",
    [
        *(
            3.0,
            -7.0,
            6.0,
            -9.0,
            255.0,
            96.0,
            1e7,
            2.0**21 - 1,
            -(2.0**24 - 8),
            2.0**21 + 1,
            2.0**24 - 1,
        ),
        *(0.1, 0.7, 1.5, 1.9999999, 1.0000001, 1e-6, 1e30, -1e-30, 1e-40),
    ],
)
def test_quotients_are_rounded_as_by_the_general_division(constant: float) -> None:
    words = sample()
    divisors = np.full(len(words), word_of(constant), np.uint32)
    assert_rounded(words, divisors, results(Opcode.FDIV, constant, words))


@pytest.mark.parametrize("constant", [3.0, -9.0, 255.0, 641.0 * 64, 2.0**21 - 1])
def test_quotients_by_integers_near_a_middle_are_rounded(constant: float) -> None:
    """Dividends whose quotients are 1/(2D) of a unit, and a few times that, from a middle."""
    odd = int(abs(constant)) // (int(abs(constant)) & -int(abs(constant)))
    middles = np.random.default_rng(5).integers(1 << 23, 1 << 24, 5000) * 2 + 1
    powers = (1 << np.arange(23, 25)) * 2 + np.arange(-7, 8)[:, None]
    dividends = np.concatenate([middles, powers.ravel()]) * odd // 2 + np.arange(-1, 3)[:, None]
    bits = np.maximum(np.ceil(np.log2(dividends.ravel())).astype(int) - 24, 0)
    near = (dividends.ravel() >> bits << bits).astype(np.float32)  # as many of them as are numbers
    words = np.concatenate([near, near * np.float32(2.0**-150), near * np.float32(2.0**70)])
    divisors = np.full(len(words), word_of(constant), np.uint32)
    assert_rounded(
        words.view(np.uint32), divisors, results(Opcode.FDIV, constant, words.view(np.uint32))
    )


@pytest.mark.parametrize("constant", [2.0, -0.5, 1.0, 2.0**-126, 2.0**-127, 2.0**127, -(2.0**100)])
def test_a_division_by_a_power_of_two_is_one_multiplication(constant: float) -> None:
    words = sample()
    divisors = np.full(len(words), word_of(constant), np.uint32)
    exact = by_semantics(Opcode.FDIV, words, divisors)
    assert np.array_equal(results(Opcode.FDIV, constant, words), exact)
    assert len(graph(Opcode.FDIV, constant).operations) == NOT_OPERATIONS + 1


@pytest.mark.parametrize(
    ("constant", "count"),
    [(3.0, 4), (-96.0, 4), (2.0**21 - 1, 4), (2.0**21 + 1, 13), (1.5, 13), (0.1, 16), (1e30, 46)],
)
def test_operations_of_a_division_by_a_constant(constant: float, count: int) -> None:
    assert len(graph(Opcode.FDIV, constant).operations) == NOT_OPERATIONS + count


@pytest.mark.parametrize(
    ("constant", "count"), [(1.0, 14), (-1024.0, 14), (6.2831855, 116), (360.0, 106)]
)
def test_remainders_are_exact(constant: float, count: int) -> None:
    words = sample()
    divisors = np.full(len(words), word_of(constant), np.uint32)
    exact = by_semantics(Opcode.FREM, words, divisors)
    assert np.array_equal(results(Opcode.FREM, constant, words), exact)
    assert len(graph(Opcode.FREM, constant).operations) == NOT_OPERATIONS + count


@pytest.mark.parametrize("constant", [0.5, 0.1, 1e-40, float("inf"), float("nan"), 0.0, -3e38])
def test_remainders_by_unusual_constants_are_exact(constant: float) -> None:
    words = sample()
    divisors = np.full(len(words), word_of(constant), np.uint32)
    exact = by_semantics(Opcode.FREM, words, divisors)
    assert np.array_equal(results(Opcode.FREM, constant, words), exact)


@pytest.mark.parametrize("constant", [-2.0, -1.0, 1.0, 2.0, 3.0, 4.0, 5.0, 0.0, 0.5, -0.5, 2.2])
def test_powers_are_near(constant: float) -> None:
    words = sample()
    ours = results(Opcode.POW, constant, words).view(np.float32)
    with np.errstate(all="ignore"):
        # An array of exponents: numpy takes the root for a scalar 0.5, which -infinity has not.
        exponents = np.full(len(words), np.float32(constant), np.float64)
        exact = np.power(words.view(np.float32).astype(np.float64), exponents)
        rounded = exact.astype(np.float32)
        assert np.array_equal(np.isnan(ours), np.isnan(exact))
        near = np.abs(ours - exact) <= 3 * np.spacing(np.abs(rounded))
    same = (ours == rounded) & (np.signbit(ours) == np.signbit(rounded))
    assert np.all(near | same | np.isnan(exact))


@pytest.mark.parametrize(("constant", "count"), [(2.0, 1), (3.0, 2), (4.0, 2), (-2.0, 47)])
def test_operations_of_constant_powers(constant: float, count: int) -> None:
    assert len(graph(Opcode.POW, constant).operations) == NOT_OPERATIONS + count
