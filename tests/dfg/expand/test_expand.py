"""The expansion of `exp`: its operations, and its accuracy against binary64."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.dfg.expand.vectorised import fma
from vividc.dfg.check import check
from vividc.dfg.expand.builder import EXPONENT_SHIFT
from vividc.dfg.expand.exp import (
    LOG2_E,
    MINUS_LN2_HIGH,
    MINUS_LN2_LOW,
    POLYNOMIAL,
    ROUNDED_LIMIT,
    ROUNDING_MAGIC,
    SMALLEST_ARGUMENT,
)
from vividc.dfg.expand.expand import expand_math
from vividc.dfg.forms.text import parse
from vividc.dfg.interpret.interpreter import interpret_region
from vividc.dfg.ir import DFG, Control
from vividc.machine.words import float_of

GRAPH = """dfg "exp"
%0 = iv
%1 = live_in "&x"
%2 = load "x" %0 shift 2 base %1
%3 = exp %2 !k.py:3
%4 = store "x" %0, %3 shift 2 base %1 after %2
"""
MAX_ULP = 0.892
SMALLEST_RESULT = 2.0**-125.5
CHUNK = 1 << 20


def expanded(words: np.ndarray) -> np.ndarray:
    """The interpreter's result of the expanded graph for each word."""
    memory = words.astype(np.uint32)
    dfg = expand_math(parse(GRAPH))
    interpret_region(dfg, "loop", len(words), {"&x": 0}, memory)
    return memory


def twin(words: np.ndarray) -> np.ndarray:
    """The expanded sequence, operation by operation, in numpy."""
    x = words.view(np.float32)

    def constant(word: int) -> np.ndarray:
        return np.array([word], np.uint32).view(np.float32)

    shifted = np.fmin(fma(x, constant(LOG2_E), constant(ROUNDING_MAGIC)), constant(ROUNDED_LIMIT))
    n = shifted - constant(ROUNDING_MAGIC)
    r = fma(n, constant(MINUS_LN2_HIGH), x)
    r = fma(n, constant(MINUS_LN2_LOW), r)
    value = np.broadcast_to(constant(POLYNOMIAL[0]), x.shape)
    for coefficient in POLYNOMIAL[1:]:
        value = fma(value, r, constant(coefficient))
    scale = (shifted.view(np.uint32) << np.uint32(EXPONENT_SHIFT)).view(np.float32)
    result = np.where(
        constant(SMALLEST_ARGUMENT) > x, np.float32(0), fma(value, scale, np.float32(0))
    )
    bits = result.astype(np.float32).view(np.uint32)
    return np.where(np.isnan(result), np.uint32(0x7FC00000), bits)


def worst_ulp(words: np.ndarray, results: np.ndarray) -> float:
    """Largest error in ulp of the exact result; flushed and overflowed inputs are checked here."""
    x = words.view(np.float32).astype(np.float64)
    y = results.view(np.float32).astype(np.float64)
    exact = np.exp(x)
    nan = np.isnan(x)
    assert np.all(results[nan] == 0x7FC00000)
    small = exact < SMALLEST_RESULT * (1 - 1e-6)
    assert np.all(results[small] == 0)
    overflow = exact >= float(np.finfo(np.float32).max) * (1 + 2.0**-25)
    assert np.all(np.isposinf(y[overflow]))
    inside = ~(nan | overflow) & (exact >= SMALLEST_RESULT * (1 + 1e-6))
    assert np.all(np.isfinite(y[inside]))
    exponent = np.maximum(np.frexp(exact[inside])[1], -125)
    error = np.abs(y[inside] - exact[inside]) / np.ldexp(1.0, exponent - 24)
    return float(error.max(initial=0.0))


def sample(count: int) -> np.ndarray:
    """Arguments over the range of results, over all bits, and the edges."""
    rng = np.random.default_rng(11)
    inside = rng.uniform(-104.0, 89.5, count).astype(np.float32).view(np.uint32)
    small = rng.uniform(-1.0, 1.0, count).astype(np.float32).view(np.uint32)
    anything = rng.integers(0, 1 << 32, count, dtype=np.uint64).astype(np.uint32)
    edges = np.array(
        [88.0, 88.72, 88.722839, 88.73, -86.99, -87.0, -87.34, -87.7, -104.0, 1e30, -1e30]
    )
    near = edges.astype(np.float32).view(np.uint32)
    around = (near[:, None] + np.arange(-40, 41)).astype(np.uint32).ravel()
    special = np.array([0, 1 << 31, 0x7F800000, 0xFF800000, 0x7FC00000, 0xFFC00001, 0x7F800001])
    return np.concatenate([inside, small, anything, around, special.astype(np.uint32)])


def test_the_error_bound_holds_on_a_sample() -> None:
    words = sample(3000)
    with np.errstate(all="ignore"):
        assert worst_ulp(words, expanded(words)) <= MAX_ULP


def test_the_numpy_twin_is_the_sequence() -> None:
    words = sample(2000)
    with np.errstate(all="ignore"):
        assert np.array_equal(twin(words), expanded(words))


@pytest.mark.parametrize(
    ("argument", "word"),
    [
        (0x00000000, 0x3F800000),
        (0x80000000, 0x3F800000),
        (0x7F800000, 0x7F800000),
        (0xFF800000, 0x00000000),
        (0xFFC12345, 0x7FC00000),
        (0x42B17217, 0x7F7FFF84),
        (0x42B17218, 0x7F800000),
    ],
)
def test_special_arguments(argument: int, word: int) -> None:
    assert int(expanded(np.array([argument]))[0]) == word


def test_the_result_is_what_math_exp_gives_to_one_ulp() -> None:
    (word,) = expanded(np.array([0x3F800000])).tolist()
    assert math.isclose(float_of(word), math.e, rel_tol=2**-23)


def test_fourteen_operations_replace_it_and_keep_its_line() -> None:
    before = parse(GRAPH)
    after = expand_math(before)
    assert check(after) == []
    assert len(after.operations) == len(before.operations) - 1 + 14
    new = [node for node in after.operations if node.id > 4]
    assert {str(node.loc) for node in new} == {"k.py:3"}


def test_two_of_them_share_their_constants() -> None:
    text = GRAPH + '%5 = exp %3\n%6 = store "x" %0, %5 shift 2 base %1 after %4\n'
    dfg = expand_math(parse(text))
    words = [node.const for node in dfg.nodes if node.const is not None]
    assert len(words) == len(set(words))


def test_a_graph_without_it_is_returned_as_it_is() -> None:
    dfg: DFG = parse(GRAPH.replace("exp %2", "fabs %2"))
    assert expand_math(dfg) is dfg


def test_a_predicated_exp_passes_its_operand() -> None:
    text = GRAPH.replace("exp %2", "exp %2 if %5") + "%5 = icmp.slt %0, %0\n"
    dfg = expand_math(parse(text))
    memory = np.array([0x3F800000], np.uint32)
    interpret_region(dfg, "loop", 1, {"&x": 0}, memory)
    assert memory.tolist() == [0x3F800000]


@pytest.mark.slow
def test_the_error_bound_holds_over_a_dense_sweep() -> None:
    """Every 61st word; all 2**32 were swept once when the bound was measured."""
    worst = 0.0
    with np.errstate(all="ignore"):
        for start in range(0, 1 << 32, 61 * CHUNK):
            stop = min(start + 61 * CHUNK, 1 << 32)
            words = np.arange(start, stop, 61, dtype=np.uint64).astype(np.uint32)
            worst = max(worst, worst_ulp(words, twin(words)))
    assert worst <= MAX_ULP


def test_a_quotient_that_is_a_trip_count_stays_one() -> None:
    """The controller would have waited in vain for the trip count of `range(n // 3)`."""
    graph = 'dfg "trips"\n%0 = live_in "n"\n%1 = const 3\n%2 = udiv %0, %1 trip\n'
    nodes = expand_math(parse(graph)).nodes
    assert [node.control for node in nodes if node.control is not None] == [Control.TRIP]
