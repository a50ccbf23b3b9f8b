"""Plane and line factors of TensoRF on the array: planes stay in DRAM, their rows are gathered."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np
import numpy.typing as npt

from vividc.machine.words import WORD_BYTES
from vividc.render.array.device.blocks import BLOCK
from vividc.render.array.device.device import Device
from vividc.render.array.device.launch import Fetched, Launch
from vividc.render.array.device.lookups import Part, run_lookups, sizes_for
from vividc.render.array.records import UInt32Array
from vividc.render.array.steering import SAMPLES_A_CELL
from vividc.render.arrays import Float32Array
from vividc.render.radiance.occupancy import March
from vividc.render.radiance.tensorf import LINE_AXES, PLANE_AXES, Factors

Number: TypeAlias = np.float32 | np.int32

CHANNELS: Final = 16
"""Channels that a launch computes."""
_CACHE: Final = 64
"""Cells that a launch remembers of a plane, as in the kernel."""
_CORNERS: Final = 4
"""Rows of a cell; half as many of float16, where a row holds the next column, too."""
_LANES: Final = 4
"""Numbers of float8 in a word."""
_FIRST: Final = 8
"""Word from which fetched rows lie, as in the kernel."""
_AXES: Final = 3
_SPARE_WORDS: Final = 160
"""What aligning a launch's arrays takes."""
KERNELS: Final = "render/tensor_factors"


@dataclass(frozen=True, slots=True, eq=False)
class Pair:
    """16 channels of plane number `plane` and its line, as words: [rows * columns, 16] and [nodes,
    16 or 8] uint32 of one float32 or two float16, which are a channel of a plane in a column and in
    the next one, and two channels of a line.
    """

    number: int
    plane: UInt32Array
    line: UInt32Array


@dataclass(frozen=True, slots=True, eq=False)
class FactorGrid:
    """The box of the factors as the kernels take it, and the device that computes them.

    Attributes
    ----------
    device
        Where it is computed.
    low, scales, last
        By axis: lowest corner, nodes in a unit of the world, and the last node but one.
    """

    device: Device
    low: Float32Array
    scales: Float32Array
    last: npt.NDArray[np.int32]

    def sums(
        self, stage: str, points: Float32Array, pairs: Sequence[Pair], out: Float32Array
    ) -> None:
        """Put into [P, B, 16] of points [B * 16, 3]: for each pair of a plane and a line the sum
        over its channels of their product.
        """
        kernel = "factor_sums" + ("_fp16" if _is_narrow(pairs) else "")
        self._run(stage, kernel, points, pairs, list(out))

    def products(self, stage: str, points: Float32Array, pairs: Sequence[Pair]) -> Float32Array:
        """Return [B, C, 16] float32, blocks of 16 samples: plane times line of all channels, the
        planes one after the other. Of float16 pairs: as float8, four to a word, [B, C / 4, 16].
        """
        narrow = _is_narrow(pairs)
        width = CHANNELS // _LANES if narrow else CHANNELS
        out = np.empty((len(points) // BLOCK, width * len(pairs), BLOCK), np.float32)
        parts = [out[:, width * k : width * (k + 1)] for k in range(len(pairs))]
        if narrow:
            targets = [part.view(np.uint32) for part in parts]
            self._run(stage, "factor_products_fp8", points, pairs, targets)
        else:
            self._run(stage, "factor_products", points, pairs, parts)
        return out

    def _run(
        self,
        stage: str,
        kernel: str,
        points: Float32Array,
        pairs: Sequence[Pair],
        targets: Sequence[Float32Array | UInt32Array],
    ) -> None:
        """Fill `targets`, [B, ...] for each pair."""
        most, room = self._sizes(pairs, targets[0][:1].size // BLOCK)
        corners = _CORNERS // (2 if _is_narrow(pairs) else 1)
        parts = Part(points, 0).cut(most)
        work = [(number, part) for number in range(len(pairs)) for part in parts]

        def launch(number: int, part: Part) -> Launch:
            pair, samples = pairs[number], len(part.points)
            return Launch(
                inputs={"points": part.points},
                outputs={"out": targets[number][part.blocks]},
                shapes={"slots": (samples + 1,)},
                shared={"line": pair.line},
                fetched={"rows": Fetched(pair.plane, corners * room, _FIRST)},
                work={"seen": (_CACHE,), "where": (_CACHE,)},
                scalars={**self._along(pair.number), "room": room},
            )

        name = f"{KERNELS}:{kernel}"
        cells = run_lookups(self.device, stage, name, work, launch, room)
        self.device.ledger.count(plane_cells=cells)

    def _sizes(self, pairs: Sequence[Pair], width: int) -> tuple[int, int]:
        """Return samples of a launch that makes `width` words of each, and cells that there is room
        for, so that half the samples' fit at last.
        """
        line = max(pair.line.size for pair in pairs)
        lines = 1 if len({id(pair.line) for pair in pairs}) == 1 else 2
        words = self.device.scratchpad_bytes // WORD_BYTES - lines * line - 2 * _CACHE
        return sizes_for(
            words - _SPARE_WORDS - 2 * (1 + _FIRST),
            2 * CHANNELS * _CORNERS // (2 if _is_narrow(pairs) else 1),
            2 * (_AXES + 1 + width),
            lambda samples: max(BLOCK, samples // SAMPLES_A_CELL),
        )

    def _along(self, plane: int) -> dict[str, Number]:
        """Return the scalars that tell the axes of a plane's columns and rows, and of its line."""
        found: dict[str, Number] = {}
        for name, axis in zip("xyz", (*PLANE_AXES[plane], LINE_AXES[plane]), strict=True):
            found |= {
                f"low_{name}": self.low[axis],
                f"scale_{name}": self.scales[axis],
                f"last_{name}": self.last[axis],
                f"axis_{name}": np.int32(axis),
            }
        return found


def factor_grid(march: March, resolution: Sequence[int], device: Device) -> FactorGrid:
    """Return the grid of factors with `resolution` nodes along each axis of the box."""
    low, high = march.box
    scales = (np.asarray(resolution, dtype=np.float32) - np.float32(1)) / (high - low)
    last = np.asarray(resolution, dtype=np.int32) - np.int32(2)
    return FactorGrid(device, low, scales.astype(np.float32), last)


def channel_pairs(factors: Sequence[Factors], narrow: bool, scale: np.float32) -> list[Pair]:
    """Return the pairs of planes and lines cut into 16 channels each, as float16 if `narrow`;
    missing ones are 0. Products come times `scale`, a power of two.
    """
    cut = (_pairs(number, pair, narrow, scale) for number, pair in enumerate(factors))
    return [one for pairs in cut for one in pairs]


def _pairs(number: int, pair: Factors, narrow: bool, scale: np.float32) -> list[Pair]:
    channels = pair.line.shape[1]
    missing = -channels % CHANNELS
    plane = np.pad(pair.plane, ((0, 0), (0, 0), (0, missing)))
    line = np.pad(pair.line * scale, ((0, 0), (0, missing)))
    dtype = np.float16 if narrow else np.float32
    if narrow:  # a cell never begins in the last column
        plane = np.stack((plane, np.roll(plane, -1, axis=1)), axis=-1)

    def words(array: Float32Array, first: int) -> UInt32Array:
        part = array[:, first : first + CHANNELS].reshape(len(array), -1)
        return np.ascontiguousarray(part.astype(dtype)).view(np.uint32)

    rows = plane.reshape(-1, *plane.shape[2:])
    starts = range(0, channels, CHANNELS)
    return [Pair(number, words(rows, first), words(line, first)) for first in starts]


def _is_narrow(pairs: Sequence[Pair]) -> bool:
    return bool(pairs[0].line.shape[1] < CHANNELS)
