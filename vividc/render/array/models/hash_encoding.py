"""The multiresolution hash encoding on the array: tables stay in DRAM, rows are gathered."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
import numpy.typing as npt

from vividc.launch.turns import neighbours
from vividc.machine.words import WORD_BYTES
from vividc.render.array.device.device import Device
from vividc.render.array.device.frame import Ledger
from vividc.render.array.device.launches import Gathered, Launch, run_shares
from vividc.render.array.network.networks import SAMPLES
from vividc.render.arrays import Float32Array
from vividc.render.errors import SceneError
from vividc.render.radiance.instant_ngp import InstantNGP, Level

UInt32Array = npt.NDArray[np.uint32]

CHUNK: Final = 128
"""Samples that share gathered cells; a multiple of a block's."""
_LEVELS: Final = 8
"""Levels that a launch looks for cells in."""
_CACHE: Final = 128
"""Cells that a launch remembers of a level, as in the kernel."""
_LARGEST: Final = 15_872
"""Bytes of a launch of the interpolation: two fit a scratchpad beside what is resident."""
_CORNERS: Final = 8
_FEATURES: Final = 2
_FINEST: Final = 1022
"""Largest scale of a level: a cell's number on an axis has ten bits."""


@dataclass(frozen=True, slots=True, eq=False)
class HashEncoding:
    """The grids of an Instant-NGP model as the kernels take them.

    Attributes
    ----------
    table
        [rows, 2] float32, of all levels.
    low
        [3]: lowest corner of the cube.
    scales
        [L] float32: cells of a level in a unit of the world.
    grids
        [L, 3] uint32: resolution (0: hashed), entries (hashed: less one), first row.
    """

    table: Float32Array
    low: Float32Array
    scales: Float32Array
    grids: UInt32Array

    @property
    def features(self) -> int:
        """Numbers that a point becomes."""
        return _FEATURES * len(self.scales)

    def encode(
        self,
        device: Device,
        ledger: Ledger,
        stage: str,
        points: Float32Array,
        out: Float32Array | None = None,
    ) -> Float32Array:
        """Return the encoding [B, 2 L, 16] float32 of blocks of 16 points, [B, 16, 3].

        It is in `out`, if that is given, whose features behind the encoding's are left alone.
        """
        if out is None:
            out = np.empty((len(points), self.features, SAMPLES), dtype=np.float32)
        for first in range(0, len(self.scales), _LEVELS):
            last = min(first + _LEVELS, len(self.scales))
            part = HashEncoding(
                self.table, self.low, self.scales[first:last], self.grids[first:last]
            )
            features = out[:, _FEATURES * first : _FEATURES * last]
            _Passes(part, device, ledger, stage, points.reshape(-1, 3), features).run()
        return out


def hash_encoding(model: InstantNGP) -> HashEncoding:
    """Return the encoding of a model.

    Raises
    ------
    SceneError
        A level is finer than a cell's number has bits for, a dense one has too few entries, rows
        have another number of features than two, or the box leaves the cube of the grids.
    """
    for level in model.levels:
        _check(level)
    high = model.cube_low + np.float32(model.cube_side)
    slack = np.float32(1e-5 * model.cube_side)
    if (model.march.box[0] < model.cube_low - slack).any() or (
        model.march.box[1] > high + slack
    ).any():
        raise SceneError("aabb leaves the cube that cube_lo and cube_side give to the grids")
    sizes = [len(level.table) for level in model.levels]
    first_rows = np.cumsum([0, *sizes[:-1]])
    return HashEncoding(
        np.ascontiguousarray(np.concatenate([level.table for level in model.levels])),
        np.ascontiguousarray(model.cube_low),
        np.array([level.scale / np.float32(model.cube_side) for level in model.levels], np.float32),
        np.array(
            [_grid(level, int(row)) for level, row in zip(model.levels, first_rows, strict=True)],
            dtype=np.uint32,
        ),
    )


def _check(level: Level) -> None:
    """Refuse a level that the kernels do not support."""
    entries, features = level.table.shape
    hint = "render it with --engine reference"
    if level.scale > _FINEST:
        raise SceneError(
            f"a level has {level.scale:g} cells a side, and the array's kernels number up to "
            f"{_FINEST}",
            hint=hint,
        )
    if features != _FEATURES:
        raise SceneError(
            f"the table has {features} features a row, and the array's kernels interpolate "
            f"{_FEATURES}",
            hint=hint,
        )
    last = int(level.scale + np.float32(0.5)) + 1
    needed = last * (1 + level.resolution + level.resolution**2)
    if level.dense and needed >= 2 * entries:
        raise SceneError(
            f"a dense level of {level.resolution} nodes a side has {entries} entries, and the "
            "array's kernels wrap around once",
            hint=hint,
        )


def _grid(level: Level, first_row: int) -> tuple[int, int, int]:
    entries = len(level.table)
    return (level.resolution, entries, first_row) if level.dense else (0, entries - 1, first_row)


class _Passes:
    """The three jobs of some levels: find cells, list rows of the table, gather and interpolate."""

    def __init__(
        self,
        grids: HashEncoding,
        device: Device,
        ledger: Ledger,
        stage: str,
        points: Float32Array,
        out: Float32Array,
    ) -> None:
        self._grids, self._device, self._ledger, self._stage = grids, device, ledger, stage
        self._points, self._out = points, out
        self._chunks = -(-len(points) // CHUNK)
        levels = len(grids.scales)
        self._cells = np.empty((self._chunks, levels * CHUNK), np.uint32)
        self._slots = np.empty((self._chunks, levels, CHUNK), np.uint32)
        self._ends = np.zeros((self._chunks, levels + 1), np.uint32)
        self._constants = {"low": grids.low, "scales": grids.scales}
        self._tables = {"grids": grids.grids}

    def run(self) -> None:
        """Fill `out`."""
        self._run("find_cells", [[self._finding(chunk)] for chunk in range(self._chunks)])
        total = int(self._ends[:, -1].sum())
        rows = np.empty(_CORNERS * total, np.uint32)
        starts = _CORNERS * np.cumsum([0, *self._ends[:, -1]])
        parts = [
            rows[first:last].reshape(-1, _CORNERS) for first, last in pairwise(starts.tolist())
        ]
        ranges = [list(self._ranges(chunk)) for chunk in range(self._chunks)]
        self._run(
            "corner_rows",
            [
                [self._listing(chunk, parts[chunk], *levels) for levels in ranges[chunk]]
                for chunk in range(self._chunks)
            ],
        )
        self._run(
            "interpolate",
            [
                [self._interpolating(chunk, parts[chunk], *levels) for levels in ranges[chunk]]
                for chunk in range(self._chunks)
            ],
        )
        self._ledger.count(encoded_cells=total)

    def _run(self, kernel: str, by_chunk: Sequence[Sequence[Launch]]) -> None:
        """Neighbouring chunks to the same tile."""
        shares = [
            [launch for chunk in by_chunk[first:last] for launch in chunk]
            for first, last in neighbours(self._chunks, self._device.tiles)
        ]
        run_shares(self._device, self._ledger, self._stage, f"render/hash_grid:{kernel}", shares)

    def _span(self, chunk: int) -> tuple[int, int]:
        """Points of a chunk."""
        return chunk * CHUNK, min((chunk + 1) * CHUNK, len(self._points))

    def _ranges(self, chunk: int) -> Iterator[tuple[int, int]]:
        """Levels whose cells fit a launch together."""
        first, last = self._span(chunk)
        ends = self._ends[chunk].tolist()
        fixed = self._points[first:last].nbytes
        by_level = (1 + _FEATURES) * WORD_BYTES * (last - first)
        start = 0
        for stop in range(1, len(ends)):
            cells = ends[stop] - ends[start]
            size = fixed + (stop - start) * by_level + cells * _CORNERS * _FEATURES * WORD_BYTES
            if size > _LARGEST and stop - start > 1:
                yield start, stop - 1
                start = stop - 1
        yield start, len(ends) - 1

    def _finding(self, chunk: int) -> Launch:
        first, last = self._span(chunk)
        return Launch(
            inputs={"points": self._points[first:last]},
            outputs={
                "cells": self._cells[chunk],
                "slots": self._slots[chunk, :, : last - first],
                "ends": self._ends[chunk],
            },
            shared=self._constants,
            shapes={"seen": (_CACHE,), "where": (_CACHE,)},
        )

    def _listing(self, chunk: int, rows: UInt32Array, level: int, stop: int) -> Launch:
        ends = self._ends[chunk]
        begin, end = int(ends[level]), int(ends[stop])
        return Launch(
            inputs={"cells": self._cells[chunk, begin:end], "ends": ends},
            outputs={"rows": rows[begin:end]},
            scalars={"level": level, "stop": stop},
            shared=self._tables,
        )

    def _interpolating(self, chunk: int, rows: UInt32Array, level: int, stop: int) -> Launch:
        first, last = self._span(chunk)
        begin, end = int(self._ends[chunk, level]), int(self._ends[chunk, stop])
        blocks = self._out[first // SAMPLES : -(-last // SAMPLES)]
        return Launch(
            inputs={
                "points": self._points[first:last],
                "table": Gathered(self._grids.table, rows[begin:end].reshape(-1)),
                "slots": self._slots[chunk, level:stop, : last - first],
            },
            outputs={"out": blocks[:, _FEATURES * level : _FEATURES * stop]},
            scalars={"level": level, "first": begin},
            shared=self._constants,
        )
