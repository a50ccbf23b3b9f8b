"""Samples of blocks cut into pieces, and the survivors of each."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vividc.render.array.pieces import RAYS, pieces_of, survivors_of, total


def test_pieces_are_no_longer_than_asked_for_and_in_order() -> None:
    lists = [[np.arange(5)], [], [np.arange(7), np.arange(2)]]
    pieces = list(pieces_of([[part.astype(np.int32) for part in one] for one in lists], 3))
    assert [len(piece.items) for piece in pieces] == [3, 2, 3, 2, 2, 2]
    assert [piece.first_ray for piece in pieces] == [0, 0, *[2 * RAYS] * 4]
    assert [piece.turn for piece in pieces] == [0, 1, 0, 1, 2, 3]
    assert [piece.is_last for piece in pieces] == [False, True, False, False, False, True]
    assert [piece.first for piece in pieces] == [0, 3, 5, 8, 10, 12]
    assert total(pieces) == 14
    np.testing.assert_array_equal(
        np.concatenate([piece.items for piece in pieces[2:]]), [*range(7), *range(2)]
    )


def test_survivors_are_at_the_head_of_their_pieces_places() -> None:
    items = np.arange(14, dtype=np.int32)
    pieces = list(pieces_of([[items[:5]], [items[5:]]], 9))
    pieces.append(replace(pieces[1], number=2, first=14))
    words = [2 << 20 | 1 << 10 | 4, 4 << 20 | 0 << 10 | 7, 0]
    survivors = list(survivors_of(pieces, words, items, 10 * items.astype(np.float32)))
    assert [list(one.weights) for one in survivors] == [[0, 10], [50, 60, 70, 80], []]
    assert [one.samples for one in survivors] == [slice(0, 2), slice(2, 6), slice(6, 6)]
    assert [one.places for one in survivors] == [slice(0, 5), slice(5, 14), slice(14, 23)]
    assert [one.span for one in survivors] == [slice(1, 5), slice(5, 13), slice(14, 14)]
