"""The expansions of `floor` and `ceil` are exact."""

from __future__ import annotations

import numpy as np
import pytest

from tests.dfg.expand.vectorised import (
    SPECIALS,
    by_semantics,
    expanded,
    graph,
    interpreted,
    random_words,
)
from vividc.dfg.check import check
from vividc.dfg.expand.expand import expand_math
from vividc.machine.opcodes import Opcode

BOTH = pytest.mark.parametrize("op", [Opcode.FLOOR, Opcode.CEIL])


def sample() -> np.ndarray:
    """Words of all kinds, and halves around the integers near 0."""
    near = (np.arange(-400, 401) / np.float32(8)).astype(np.float32)
    beside = np.nextafter(near, np.float32(1e9)).astype(np.float32)
    words = np.concatenate([near, beside]).astype(np.float32).view(np.uint32)
    return np.concatenate([SPECIALS, words, random_words(2000, 9)])


@BOTH
def test_every_result_is_exact(op: Opcode) -> None:
    words = sample()
    ours = interpreted(op, words)
    assert np.array_equal(ours, by_semantics(op, words))
    assert np.array_equal(ours, expanded(op, words))


@BOTH
def test_operations(op: Opcode) -> None:
    after = expand_math(graph(op))
    assert check(after) == []
    assert len(after.operations) == 2 + 10


@BOTH
@pytest.mark.slow
def test_a_dense_sweep_equals_numpy(op: Opcode) -> None:
    function = np.floor if op is Opcode.FLOOR else np.ceil
    words = np.arange(0, 1 << 32, 1021, dtype=np.uint64).astype(np.uint32)
    with np.errstate(invalid="ignore"):  # of signalling NaNs
        exact = function(words.view(np.float32))
    bits = np.where(np.isnan(exact), np.uint32(0x7FC00000), exact.view(np.uint32))
    assert np.array_equal(expanded(op, words), bits)
