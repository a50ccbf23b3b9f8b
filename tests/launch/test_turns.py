"""How work is dealt out to tiles and places."""

from __future__ import annotations

from vividc.launch.turns import Turns, deal, neighbours


def test_each_tile_gets_a_chunk_before_any_gets_its_next_one() -> None:
    turns = Turns([3, 5], places=2)
    taken = [turns.take()[:2] for _ in range(6)]
    assert taken == [(3, 0), (5, 0), (3, 1), (5, 1), (3, 0), (5, 0)]


def test_a_chunk_waits_for_what_frees_its_place() -> None:
    turns = Turns([0], places=2)
    for step in (10, 20):
        tile, place, before = turns.take()
        assert before == ()
        turns.free(tile, place, step, step + 1)
    assert [turns.take()[2] for _ in range(2)] == [(10, 11), (20, 21)]


def test_the_costliest_goes_to_the_tile_with_the_least_to_do() -> None:
    assert deal([1, 5, 3, 3], tiles=2) == [[1, 0], [2, 3]]
    assert deal([], tiles=2) == [[], []]


def test_equal_costs_are_dealt_in_order() -> None:
    assert deal([2, 2, 2, 2, 2], tiles=3) == [[0, 3], [1, 4], [2]]


def test_neighbours_are_even_shares_of_a_row() -> None:
    assert neighbours(7, 3) == [(0, 2), (2, 4), (4, 7)]
    assert neighbours(1, 3) == [(0, 0), (0, 0), (0, 1)]
