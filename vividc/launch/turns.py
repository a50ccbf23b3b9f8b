"""Deals work out to tiles and to places in a scratchpad, so that one place is filled or emptied
while the tile works on another.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import pairwise


class Turns:
    """Deals chunks out to tiles, and on each tile to its places, and keeps what they wait for.

    Parameters
    ----------
    tiles
        Their numbers, in the order in which they get chunks, again and again.
    places
        Of each tile.
    """

    def __init__(self, tiles: Sequence[int], places: int = 2) -> None:
        self._tiles, self._places = tiles, places
        self._taken = 0
        self._turn: Counter[int] = Counter()
        self._freed: dict[tuple[int, int], tuple[int, ...]] = {}

    def take(self) -> tuple[int, int, tuple[int, ...]]:
        """Return tile and place of the next chunk, and the steps that free the place."""
        tile = self._tiles[self._taken % len(self._tiles)]
        self._taken += 1
        place = self._turn[tile] % self._places
        self._turn[tile] += 1
        return tile, place, self._freed.get((tile, place), ())

    def free(self, tile: int, place: int, *steps: int) -> None:
        """Let the next chunk of a place wait for these steps."""
        self._freed[tile, place] = steps


def deal(costs: Sequence[float], tiles: int) -> list[list[int]]:
    """Return the numbers of what each tile gets: the costliest first, each to the tile with the
    least to do (Graham 1969).
    """
    shares: list[list[int]] = [[] for _ in range(tiles)]
    loads = [0.0] * tiles
    for number in sorted(range(len(costs)), key=lambda number: -costs[number]):
        tile = loads.index(min(loads))
        shares[tile].append(number)
        loads[tile] += costs[number]
    return shares


def neighbours(count: int, tiles: int) -> list[tuple[int, int]]:
    """Return first item, and the one after the last, of what each tile gets of a row of items."""
    return [*pairwise(count * tile // tiles for tile in range(tiles + 1))]
