"""Links of the regular topologies, in the order in which a fabric numbers them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, Literal

_NORTH, _EAST, _SOUTH, _WEST = (-1, 0), (0, 1), (1, 0), (0, -1)
_DIRECTIONS: Final[dict[Topology, tuple[tuple[int, int], ...]]] = {
    "mesh": (_NORTH, _EAST, _SOUTH, _WEST),
    "torus": (_NORTH, _EAST, _SOUTH, _WEST),
    "king": (_NORTH, (-1, 1), _EAST, (1, 1), _SOUTH, (1, -1), _WEST, (-1, -1)),
    "mesh_plus": (_NORTH, _EAST, _SOUTH, _WEST, (-2, 0), (0, 2), (2, 0), (0, -2)),
    "none": (),
}


def topology_links(topology: Topology, rows: int, cols: int) -> tuple[tuple[int, int], ...]:
    """(source, destination) PE ids, by source and then clockwise from north.

    On a torus of one or two PEs a side, both ways round lead to the same PE: it gets one link; and
    no PE has a link to itself.
    """
    wraps = topology == "torus"
    pairs: dict[tuple[int, int], None] = {}
    for row, col in _positions(rows, cols):
        for down, right in _DIRECTIONS[topology]:
            to_row, to_col = row + down, col + right
            if wraps:
                to_row, to_col = to_row % rows, to_col % cols
            inside = 0 <= to_row < rows and 0 <= to_col < cols
            if inside and (to_row, to_col) != (row, col):
                pairs[row * cols + col, to_row * cols + to_col] = None
    return tuple(pairs)


def _positions(rows: int, cols: int) -> Iterator[tuple[int, int]]:
    return ((row, col) for row in range(rows) for col in range(cols))


Topology = Literal["mesh", "torus", "king", "mesh_plus", "none"]
