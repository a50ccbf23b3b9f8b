"""Accesses of less than a word, against numpy's memory."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vividc.machine.words import loaded, stored

WORDS = st.integers(0, 2**32 - 1)
PLACES = [(byte, width) for width in (1, 2, 4) for byte in range(0, 4, width)]


@pytest.mark.parametrize(("byte", "width"), PLACES)
@given(word=WORDS)
def test_loads(byte: int, width: int, word: int) -> None:
    raw = np.array([word], "<u4").view(np.uint8)[byte : byte + width]
    for kind, is_signed in (("u", False), ("i", True)):
        value = int(raw.view(f"<{kind}{width}")[0])
        assert loaded(word, 4096 + byte, width, is_signed) == value % 2**32


@pytest.mark.parametrize(("byte", "width"), PLACES)
@given(word=WORDS, value=WORDS)
def test_stores(byte: int, width: int, word: int, value: int) -> None:
    memory = np.array([word], "<u4")
    low = np.array([value], "<u4").view(np.uint8)[:width]
    memory.view(np.uint8)[byte : byte + width] = low
    assert stored(word, value, 4096 + byte, width) == memory[0]
