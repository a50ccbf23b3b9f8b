"""The expansion of `exp2`: its accuracy against binary64."""

from __future__ import annotations

import numpy as np
import pytest

from tests.dfg.expand.vectorised import SPECIALS, expanded, graph, interpreted, random_words
from vividc.dfg.check import check
from vividc.dfg.expand.expand import expand_math
from vividc.machine.opcodes import Opcode

MAX_ULP = 0.79
CHUNK = 1 << 20


def worst_ulp(words: np.ndarray, results: np.ndarray) -> float:
    """Largest error in ulp; flushed and overflowed results and NaNs are checked here."""
    with np.errstate(all="ignore"):
        x = words.view(np.float32).astype(np.float64)
        exact = np.exp2(x)
    assert np.all(results[np.isnan(x)] == 0x7FC00000)
    assert np.all(results[x <= -125.5] == 0)
    assert np.all(results[x >= 128] == 0x7F800000)
    inside = (x > -125.5) & (x < 128)
    exponent = np.maximum(np.frexp(exact[inside])[1], -125)
    ours = results[inside].view(np.float32).astype(np.float64)
    error = np.abs(ours - exact[inside]) / np.ldexp(1.0, exponent - 24)
    return float(error.max(initial=0.0))


def sample() -> np.ndarray:
    rng = np.random.default_rng(13)
    inside = rng.uniform(-126.0, 128.5, 3000).astype(np.float32).view(np.uint32)
    integers = np.arange(-130, 131).astype(np.float32).view(np.uint32)
    return np.concatenate([SPECIALS, inside, integers, random_words(2000, 17)])


def test_the_error_bound_holds_on_a_sample() -> None:
    words = sample()
    ours = interpreted(Opcode.EXP2, words)
    assert worst_ulp(words, ours) <= MAX_ULP
    assert np.array_equal(ours, expanded(Opcode.EXP2, words))


def test_integers_are_exact() -> None:
    powers = np.arange(-125, 129).astype(np.float32)
    ours = expanded(Opcode.EXP2, powers.view(np.uint32)).view(np.float32)
    with np.errstate(over="ignore"):
        assert np.array_equal(ours, np.exp2(powers.astype(np.float64)).astype(np.float32))


def test_operations() -> None:
    after = expand_math(graph(Opcode.EXP2))
    assert check(after) == []
    assert len(after.operations) == 2 + 13


@pytest.mark.slow
def test_the_error_bound_holds_over_a_dense_sweep() -> None:
    worst = 0.0
    for start in range(0, 1 << 32, 251 * CHUNK):
        stop = min(start + 251 * CHUNK, 1 << 32)
        words = np.arange(start, stop, 251, dtype=np.uint64).astype(np.uint32)
        worst = max(worst, worst_ulp(words, expanded(Opcode.EXP2, words)))
    assert worst <= MAX_ULP
