"""Placement of arrays in the scratchpad."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vividc.arch import Scratchpad
from vividc.errors import ArgumentError
from vividc.program import place_arrays


def test_arrays_start_in_successive_banks() -> None:
    placed = place_arrays([("a", 16), ("b", 16), ("c", 3), ("d", 1)], Scratchpad(4096, 8))
    assert list(placed) == ["a", "b", "c", "d"]
    assert [address // 4 % 8 for address in placed.values()] == [0, 1, 2, 3]


def test_gaps_are_given_up_before_space_is_short() -> None:
    assert place_arrays([("a", 8), ("b", 8)], Scratchpad(64, 8)) == {"a": 0, "b": 32}


def test_too_large() -> None:
    with pytest.raises(ArgumentError, match="need 68 bytes and the scratchpad has 64") as caught:
        place_arrays([("a", 8), ("b", 9)], Scratchpad(64, 8))
    assert "a 32, b 36" in caught.value.reason
    assert caught.value.hint


@given(st.lists(st.integers(0, 40), max_size=8), st.sampled_from([1, 2, 8]))
def test_no_overlap_and_inside(sizes: list[int], banks: int) -> None:
    pad = Scratchpad(4 * 128, banks)
    arrays = [(f"a{k}", words) for k, words in enumerate(sizes)]
    if sum(sizes) > pad.words:
        with pytest.raises(ArgumentError):
            place_arrays(arrays, pad)
        return
    placed = place_arrays(arrays, pad)
    cells = [placed[name] // 4 + k for name, words in arrays for k in range(words)]
    assert len(set(cells)) == len(cells)
    assert all(0 <= cell < pad.words for cell in cells)


def test_accesses_may_meet_in_a_bank() -> None:
    """Against every alignment of the first of two accesses a number of bytes apart."""
    pad = Scratchpad(256, 4)
    for gap in range(-40, 41):
        starts = range(64, 64 + 4 * 4)
        same = [start // 4 % 4 == (start + gap) // 4 % 4 for start in starts]
        assert pad.may_meet(gap) is any(same)
