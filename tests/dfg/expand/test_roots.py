"""The expansion of `sqrt`: correctly rounded everywhere."""

from __future__ import annotations

import numpy as np
import pytest

from tests.dfg.expand.vectorised import (
    SPECIALS,
    by_semantics,
    expanded,
    graph,
    interpreted,
    latency,
    random_words,
)
from vividc.dfg.check import check
from vividc.dfg.expand.expand import expand_math
from vividc.machine.opcodes import Opcode

CHUNK = 1 << 21


def sample() -> np.ndarray:
    """Words of all kinds, subnormals, and both sides of the scaled range's end, 2**-96."""
    rng = np.random.default_rng(7)
    subnormal = rng.integers(0, 1 << 23, 500).astype(np.uint32)
    around = np.arange(0x0F800000 - 50, 0x0F800000 + 50, dtype=np.uint32)
    return np.concatenate([SPECIALS, random_words(2000, 5), subnormal, around])


def test_every_result_is_correctly_rounded_on_a_sample() -> None:
    words = sample()
    ours = interpreted(Opcode.SQRT, words)
    assert np.array_equal(ours, by_semantics(Opcode.SQRT, words))
    for straight in (False, True):
        assert np.array_equal(ours, expanded(Opcode.SQRT, words, straight=straight))


def test_the_hardest_roots() -> None:
    """Of two binades, those within 2**-21 ulp of the middle of two numbers (there are about 16)."""
    words = np.arange(0x3F800000, 0x40800000, dtype=np.uint32)
    root = np.sqrt(words.view(np.float32).astype(np.float64)) * 2**23
    hard = words[np.abs(root - np.floor(root) - 0.5) < 2.0**-21]
    assert len(hard) > 8
    for straight in (False, True):
        ours = expanded(Opcode.SQRT, hard, straight=straight)
        assert np.array_equal(ours, by_semantics(Opcode.SQRT, hard))


@pytest.mark.parametrize(("straight", "operations", "cycles"), [(False, 23, 48), (True, 29, 35)])
def test_operations(straight: bool, operations: int, cycles: int) -> None:
    after = expand_math(graph(Opcode.SQRT, straight=straight))
    assert check(after) == []
    assert len(after.operations) == (0 if straight else 2) + operations
    assert latency(after, 2, 5) == cycles


@pytest.mark.slow
def test_all_mantissas_of_two_binades() -> None:
    for start in range(0x3F800000, 0x40800000, CHUNK):
        words = np.arange(start, start + CHUNK, dtype=np.uint32)
        exact = np.sqrt(words.view(np.float32)).view(np.uint32)
        for straight in (False, True):
            assert np.array_equal(expanded(Opcode.SQRT, words, straight=straight), exact)
