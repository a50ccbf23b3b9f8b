"""Kernels that fetch rows of tables for runs of points: what does not fit is cut into halves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import TypeVar

from vividc.launch.turns import neighbours
from vividc.render.array.device.blocks import BLOCK
from vividc.render.array.device.device import Device
from vividc.render.array.device.launch import Launch
from vividc.render.arrays import Float32Array

Table = TypeVar("Table")


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Points of a launch, [n, 3], and the number of the first of them among all."""

    points: Float32Array
    first: int

    @property
    def blocks(self) -> slice:
        """Which of all blocks they are."""
        return slice(self.first // BLOCK, (self.first + len(self.points)) // BLOCK)

    def cut(self, most: int) -> list[Part]:
        """Return parts of at most so many points."""
        starts = range(0, len(self.points), most)
        return [Part(self.points[at : at + most], self.first + at) for at in starts]

    def halves(self) -> list[Part]:
        """Return both halves, in whole blocks."""
        return self.cut(-(-len(self.points) // (2 * BLOCK)) * BLOCK)


def sizes_for(
    words: int, of_cell: int, of_sample: int, least: Callable[[int], int]
) -> tuple[int, int]:
    """Return how many samples a launch of which there are two at a time has, in whole blocks, and
    for how many cells there is room then: as many samples as leave room for enough cells.

    Parameters
    ----------
    words
        Of a scratchpad that two launches share.
    of_cell, of_sample
        Words of each in both launches together.
    least
        Cells that so many samples shall have room for.
    """
    samples, cells = BLOCK, least(BLOCK)
    for more in range(BLOCK, words, BLOCK):
        room = (words - of_sample * more) // of_cell
        if room < least(more):
            break
        samples, cells = more, room
    return samples, cells


def run_lookups(
    device: Device,
    stage: str,
    kernel: str,
    work: Sequence[tuple[Table, Part]],
    launch: Callable[[Table, Part], Launch],
    room: int,
) -> int:
    """Run a kernel that returns how many cells of a table's grid the points lie in, neighbouring
    work on the same tile; return the sum.

    Parameters
    ----------
    work
        Tables and points. Those that lie in more cells than `room` are computed anew in halves.
    room
        Cells; at least as many as a block can lie in.
    """
    total = 0
    while work:
        launches = [launch(table, part) for table, part in work]
        by_tile = neighbours(len(launches), device.tiles)
        shares = [launches[first:last] for first, last in by_tile]
        cells = [*chain(*device.run_shares(stage, kernel, shares))]
        total += sum(count for count in cells if count <= room)
        again = [one for one, count in zip(work, cells, strict=True) if count > room]
        halves = {id(part): part.halves() for _, part in again}
        work = [(table, half) for table, part in again for half in halves[id(part)]]
    return total
