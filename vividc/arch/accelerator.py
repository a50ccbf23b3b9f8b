"""The accelerator around the tiles, as data: tiles by place, DRAM, NoC, DMA engines, configuration.

`docs/accelerator.md` gives the timing rules that these parameters feed; nothing here is an
algorithm.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from vividc.arch.fabric import Fabric

Orientation = Literal["nw", "ne", "sw", "se"]


@dataclass(frozen=True, slots=True)
class DRAM:
    """The main memory: one channel.

    Attributes
    ----------
    bytes_per_cycle
        Bandwidth of the channel.
    latency
        Cycles from the last byte leaving the channel to its arrival at the NoC.
    granule_bytes
        Smallest access: a burst moves whole aligned granules. A power of two.
    """

    bytes_per_cycle: int
    latency: int
    granule_bytes: int

    def cycles(self, start: int, end: int) -> int:
        """Cycles of the channel for the bytes of an array from `start` to before `end`, if it
        begins at a granule.
        """
        granules = -(-end // self.granule_bytes) - start // self.granule_bytes
        return granules * -(-self.granule_bytes // self.bytes_per_cycle)


@dataclass(frozen=True, slots=True)
class NoC:
    """The network between the DMA engines and the tiles: bandwidth of its trunk in bytes a cycle,
    latency in cycles. Each tile has a port of its own, as wide as a line of its scratchpad.
    """

    bytes_per_cycle: int
    latency: int


@dataclass(frozen=True, slots=True)
class DMA:
    """The DMA engines: `setup_cycles` before each transfer, then bursts of up to `burst_bytes`."""

    engines: int
    setup_cycles: int
    burst_bytes: int


@dataclass(frozen=True, slots=True)
class Configuration:
    """How programs get into the tiles: `entries_per_cycle` over one stream for all tiles. Without
    `double_buffered` memories a tile cannot run while it is loaded.
    """

    entries_per_cycle: int
    double_buffered: bool


@dataclass(frozen=True)
class TileGroup:
    """Tiles that work as one array, with their scratchpads and controllers joined.

    Attributes
    ----------
    fabric
        The joined array.
    tiles
        Which tiles it consists of.
    """

    fabric: Fabric
    tiles: tuple[int, ...]


@dataclass(frozen=True)
class Accelerator:
    """Tiles and what feeds them, built by `vividc.arch.load`; `source` is its YAML text.

    Attributes
    ----------
    tiles
        Fabric of each tile, row by row. A tile's place in its 2x2 cluster says on which two edges
        its load/store units are: each is a reflection of the north-west one.
    groups
        Other forms that the tiles take: arrays of several tiles.
    """

    name: str
    rows: int
    cols: int
    tiles: tuple[Fabric, ...]
    dram: DRAM
    noc: NoC
    dma: DMA
    configuration: Configuration
    source: str = ""
    groups: tuple[TileGroup, ...] = ()

    def __repr__(self) -> str:
        return f"<Accelerator {self.name}: {self.rows}x{self.cols} tiles>"

    @cached_property
    def units(self) -> tuple[Fabric, ...]:
        """Fabrics of the tiles, and behind them of the groups: all that can run a program."""
        return (*self.tiles, *(group.fabric for group in self.groups))

    @cached_property
    def sharing(self) -> tuple[frozenset[int], ...]:
        """For each unit the others that consist of some of the same tiles: one of them is in use
        at a time.
        """
        parts = [{tile} for tile in range(len(self.tiles))]
        parts += [set(group.tiles) for group in self.groups]
        return tuple(
            frozenset(k for k, other in enumerate(parts) if k != unit and mine & other)
            for unit, mine in enumerate(parts)
        )

    def orientation(self, tile: int) -> Orientation:
        """The outer corner of tile number `tile` within its 2x2 cluster; no group is mirrored."""
        if tile >= len(self.tiles):
            return "nw"
        row, col = divmod(tile, self.cols)
        if row % 2 == 0:
            return "nw" if col % 2 == 0 else "ne"
        return "sw" if col % 2 == 0 else "se"

    @property
    def fabric(self) -> Fabric:
        """The north-west tile, for which programs are mapped."""
        return self.tiles[0]
