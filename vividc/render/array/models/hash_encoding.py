"""The multiresolution hash encoding on the array: tables stay in DRAM, rows are gathered."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from vividc.machine.words import WORD_BYTES
from vividc.render.array.device.blocks import BLOCK
from vividc.render.array.device.device import Device
from vividc.render.array.device.launch import Fetched, Launch
from vividc.render.array.device.lookups import Part, run_lookups, sizes_for
from vividc.render.array.records import UInt32Array
from vividc.render.arrays import Float32Array
from vividc.render.errors import SceneError
from vividc.render.radiance.instant_ngp import InstantNGP, Level

_CACHE: Final = 128
"""Cells of a level that a launch remembers, as in the kernel."""
_CORNERS: Final = 8
_FEATURES: Final = 2
_PAIR: Final = 2
"""Levels of a launch."""
_FIRST: Final = 8
"""Word from which fetched rows lie, as in the kernel."""
_SPARE_WORDS: Final = 160
"""What aligning a launch's arrays takes."""
_FINEST: Final = 1022
"""Largest scale of a level: a cell's number on an axis has ten bits."""
_AXES: Final = 3


class _Level(NamedTuple):
    """A level as the kernels take it: cells in a unit of the world; resolution (0: hashed), entries
    (hashed: less one), first row.
    """

    scale: np.float32
    resolution: int
    entries: int
    offset: int


@dataclass(frozen=True, slots=True, eq=False)
class HashEncoding:
    """The grids of an Instant-NGP model as the kernels take them.

    Attributes
    ----------
    table
        [rows, 1 or 2] uint32: rows of two float16 in a word, or of two float32.
    low
        [3]: lowest corner of the cube.
    pairs
        Levels two by two; a last one alone is there twice.
    is_fp8
        Whether features are float8.
    """

    table: UInt32Array
    low: Float32Array
    pairs: tuple[tuple[_Level, _Level], ...]
    is_fp8: bool

    def encode(self, device: Device, stage: str, points: Float32Array, out: Float32Array) -> None:
        """Put the encoding of points [n, 3], n a multiple of 16, into `out`, [n / 16, words, 16]:
        two features of each level, or a word of each two levels. What is behind is left alone.
        """
        most, room = self._sizes(device)
        pairs = [*enumerate(self.pairs)]
        parts = [*enumerate(Part(points, 0).cut(most))]
        # Fine levels take most rows: tiles are not to ask for them all at the same time.
        work = [
            (pairs[(at + turn) % len(pairs)], part)
            for turn, part in parts
            for at in _order(len(pairs))
        ]

        def launch(pair: tuple[int, tuple[_Level, _Level]], part: Part) -> Launch:
            return self._launch(*pair, part, room, out)

        cells = run_lookups(device, stage, self._kernel, work, launch, room)
        device.ledger.count(encoded_cells=cells)

    @property
    def features(self) -> int:
        """Numbers that a point becomes; the last two may be there twice."""
        return _PAIR * _FEATURES * len(self.pairs)

    @property
    def _words(self) -> int:
        """Of what a launch makes of a point."""
        return 1 if self.is_fp8 else _PAIR * _FEATURES

    @property
    def _kernel(self) -> str:
        return "render/hash_grid:two_levels" + ("_fp8" if self.is_fp8 else "")

    def _sizes(self, device: Device) -> tuple[int, int]:
        """Return samples of a launch, and cells of two levels that there is room for: at least one
        for each sample, so that half the samples' always fit.
        """
        words = device.scratchpad_bytes // WORD_BYTES - 2 * _PAIR * _CACHE - _SPARE_WORDS
        return sizes_for(
            words - 2 * (_PAIR + _FIRST),
            2 * _CORNERS * self.table.shape[1],
            _AXES + _PAIR + 2 * (1 + self._words),
            lambda samples: samples + _PAIR * BLOCK,
        )

    def _launch(
        self,
        number: int,
        levels: tuple[_Level, _Level],
        part: Part,
        room: int,
        out: Float32Array,
    ) -> Launch:
        samples, width = len(part.points), self._words
        features = out[part.blocks, width * number : width * (number + 1)]
        made = features[:, 0].view(np.uint32) if self.is_fp8 else features
        one, other = levels
        caches = ("seen", "where", "seen_1", "where_1")
        return Launch(
            shapes={"slots": (samples + _PAIR,)},
            outputs={"out": made},
            shared={"points": part.points},
            fetched={"rows": Fetched(self.table, _CORNERS * room, _FIRST)},
            work={**dict.fromkeys(caches, (_CACHE,)), "cells": (_PAIR * samples,)},
            scalars={
                **{f"low_{axis}": self.low[k] for k, axis in enumerate("xyz")},
                **one._asdict(),
                **{f"{name}_1": value for name, value in other._asdict().items()},
                "room": room,
            },
        )


def _order(count: int) -> list[int]:
    """Return 0, the last, 1, the last but one, ...: coarse and fine in turn."""
    return [number // 2 if number % 2 == 0 else count - 1 - number // 2 for number in range(count)]


def hash_encoding(model: InstantNGP, scale: np.float32 | None) -> HashEncoding:
    """Return the encoding of a model.

    Parameters
    ----------
    scale
        What features are multiplied by, a power of two, to become float8; None: they are float32.

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
    first_rows = np.cumsum([0, *sizes[:-1]]).tolist()
    levels = [
        _Level(level.scale / np.float32(model.cube_side), *_grid(level, row))
        for level, row in zip(model.levels, first_rows, strict=True)
    ]
    table = np.concatenate([level.table for level in model.levels])
    if scale is not None:
        table = (table * scale).astype(np.float16)
    return HashEncoding(
        np.ascontiguousarray(table).view(np.uint32),
        model.cube_low,
        tuple(zip(levels[::2], levels[1::2] + levels[-1:], strict=False)),
        is_fp8=scale is not None,
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
