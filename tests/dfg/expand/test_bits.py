"""The expansions of bit counts and permutations: every word is the table's."""

from __future__ import annotations

import numpy as np
import pytest

from tests.dfg.expand.vectorised import by_semantics, expanded, graph, interpreted, random_words
from vividc.dfg.expand.expand import expand_math
from vividc.machine.opcodes import Opcode

POWERS = np.array([(1 << k) + step & 0xFFFFFFFF for k in range(33) for step in (-1, 0, 1)])
WORDS = np.concatenate([POWERS.astype(np.uint32), ~POWERS.astype(np.uint32)])
OPERATIONS = {
    Opcode.CTPOP: 12,
    Opcode.CTLZ: 7,
    Opcode.CTTZ: 7,
    Opcode.BSWAP: 9,
    Opcode.BITREVERSE: 24,
}


@pytest.mark.parametrize("op", OPERATIONS)
def test_words(op: Opcode) -> None:
    assert np.array_equal(interpreted(op, WORDS), by_semantics(op, WORDS))
    for shift in range(0, 32, 5):
        words = random_words(2000, shift) >> np.uint32(shift)
        assert np.array_equal(expanded(op, words), by_semantics(op, words))


@pytest.mark.parametrize("op", OPERATIONS)
def test_operations(op: Opcode) -> None:
    assert len(expand_math(graph(op, 1)).operations) == 2 + OPERATIONS[op]
