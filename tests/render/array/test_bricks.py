"""Occupancy in bricks: every cell is found again through coarse bits, ranks and bricks."""

from __future__ import annotations

import numpy as np
import pytest

from vividc.render.array.march.bricks import Bricks, pack_bricks


def cell(bricks: Bricks, x: int, y: int, z: int) -> bool:
    """One cell, read as the marching kernel does."""
    columns, rows = map(int, bricks.grid[4:])
    brick = ((x >> 2) * columns + (y >> 2)) * rows + (z >> 2)
    word = int(bricks.coarse[brick >> 5])
    if not word >> (brick & 31) & 1:
        return False
    before = int(bricks.ranks[brick >> 5]) + (word & ((1 << (brick & 31)) - 1)).bit_count()
    bit = (x & 3) << 4 | (y & 3) << 2 | (z & 3)
    return bool(int(bricks.cells[2 * before + (bit >> 5)]) >> (bit & 31) & 1)


@pytest.mark.parametrize("share", [0.0, 0.01, 0.3, 1.0])
def test_cells_are_found_again(share: float) -> None:
    occupied = np.random.default_rng(1).random((9, 18, 13)) < share
    bricks = pack_bricks(occupied)
    found = [cell(bricks, *place) for place in np.ndindex(occupied.shape)]
    np.testing.assert_array_equal(np.reshape(found, occupied.shape), occupied)
    assert list(bricks.grid) == [9, 18, 13, 3, 5, 4]
    assert bricks.size_bytes == sum(map(len, (bricks.coarse, bricks.ranks, bricks.cells))) * 4


def test_places_of_set_bricks_are_packed() -> None:
    occupied = np.zeros((9, 18, 13), np.bool_)
    occupied[8, 17, 12] = occupied[0, 0, 4] = True
    places = pack_bricks(occupied).places
    assert places is not None
    assert [(place & 2047, place >> 11 & 2047, place >> 22) for place in map(int, places)] == [
        (0, 0, 1),
        (2, 4, 3),
    ]


def test_bricks_of_an_axis_too_long_for_a_word_have_no_places() -> None:
    assert pack_bricks(np.ones((1, 1, 4096), np.bool_)).places is not None
    assert pack_bricks(np.ones((1, 1, 4097), np.bool_)).places is None
