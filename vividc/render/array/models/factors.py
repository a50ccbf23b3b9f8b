"""Plane and line factors of TensoRF on the array: planes stay in DRAM, their rows are gathered."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import numpy.typing as npt

from vividc.launch.turns import neighbours
from vividc.render.array.device.device import Device
from vividc.render.array.device.frame import Ledger
from vividc.render.array.device.launches import Gathered, Launch, Words, run_shares
from vividc.render.array.network.networks import SAMPLES
from vividc.render.arrays import Float32Array
from vividc.render.radiance.occupancy import March
from vividc.render.radiance.tensorf import LINE_AXES, PLANE_AXES, Factors

UInt32Array = npt.NDArray[np.uint32]

CHANNELS: Final = 16
"""Channels that a launch computes."""
_CHUNK: Final = 32
"""Samples that share gathered rows; a multiple of a block's."""
_CACHE: Final = 64
"""Cells that a launch remembers of a plane, as in the kernel."""
_CORNERS: Final = 4
_LANES: Final = 4
"""Numbers of float8 in a word."""


@dataclass(frozen=True, slots=True, eq=False)
class Pair:
    """16 channels of a plane and its line: [rows * columns, 16] and [nodes, 16] float32."""

    plane: Float32Array
    line: Float32Array


@dataclass(frozen=True, slots=True, eq=False)
class PlaneCells:
    """The plane cells that some points lie in, by chunk of neighbouring points.

    Attributes
    ----------
    points
        [n, 3] float32.
    rows
        [chunks, 3, 4 * samples] uint32: rows of the planes, four a cell.
    slots
        [chunks, 3, samples] uint32: the cell of each point.
    counts
        [chunks, 3] uint32: cells.
    """

    points: Float32Array
    rows: UInt32Array
    slots: UInt32Array
    counts: UInt32Array

    @classmethod
    def of(cls, points: Float32Array) -> PlaneCells:
        """Room for the cells of points."""
        chunks, planes = -(-len(points) // _CHUNK), len(PLANE_AXES)
        return cls(
            points,
            np.empty((chunks, planes, _CORNERS * _CHUNK), np.uint32),
            np.empty((chunks, planes, _CHUNK), np.uint32),
            np.empty((chunks, planes), np.uint32),
        )

    @property
    def spans(self) -> list[tuple[int, int]]:
        """First and last point (excluded) of each chunk."""
        count = len(self.points)
        return [(first, min(first + _CHUNK, count)) for first in range(0, count, _CHUNK)]


@dataclass(frozen=True, slots=True, eq=False)
class FactorGrid:
    """The box of the factors as the kernels take it, and the device that computes them.

    Attributes
    ----------
    device
        Where it is computed.
    placement
        `low` [3], `scales` [3] float32 (nodes in a unit of the world) and `nodes` [3] int32.
    """

    device: Device
    placement: dict[str, Words]

    def cells(self, ledger: Ledger, stage: str, points: Float32Array) -> PlaneCells:
        """Find the plane cells of points [n, 3], n a multiple of 16."""
        cells = PlaneCells.of(points)
        axes = np.array(PLANE_AXES, dtype=np.int32)
        resident = {**self.placement, "axes": axes}
        launches = [
            Launch(
                inputs={"points": points[first:last]},
                outputs={
                    "rows": cells.rows[chunk, :, : _CORNERS * (last - first)],
                    "slots": cells.slots[chunk, :, : last - first],
                    "counts": cells.counts[chunk],
                },
                shared=resident,
                shapes={"seen": (_CACHE,), "where": (_CACHE,)},
            )
            for chunk, (first, last) in enumerate(cells.spans)
        ]
        self._run(ledger, stage, "find_plane_cells", launches)
        ledger.count(plane_cells=int(cells.counts.sum()))
        return cells

    def sums(
        self, ledger: Ledger, stage: str, cells: PlaneCells, pairs: Sequence[Sequence[Pair]]
    ) -> Float32Array:
        """Return [B, P, 16] float32, blocks of 16 samples: for each pair of a plane and a line the
        sum over its channels of their product.
        """
        return self._per_pair(ledger, stage, "factor_sums", cells, pairs, 1)

    def products(
        self,
        ledger: Ledger,
        stage: str,
        cells: PlaneCells,
        pairs: Sequence[Sequence[Pair]],
        scale: np.float32 | None = None,
    ) -> Float32Array:
        """Return [B, C, 16] float32, blocks of 16 samples: plane times line of all channels, the
        planes one after the other.

        With a scale: times it, as float8, four channels to a word, [B, C / 4, 16].
        """
        if scale is None:
            return self._per_pair(ledger, stage, "factor_products", cells, pairs, CHANNELS)
        width, kernel = CHANNELS // _LANES, "factor_products_fp8"
        return self._per_pair(ledger, stage, kernel, cells, pairs, width, {"scale": scale})

    def _per_pair(
        self,
        ledger: Ledger,
        stage: str,
        kernel: str,
        cells: PlaneCells,
        pairs: Sequence[Sequence[Pair]],
        width: int,
        scalars: Mapping[str, object] | None = None,
    ) -> Float32Array:
        """Return what a kernel makes of each pair, `width` words of each."""
        flat = [(k, pair) for k, group in enumerate(pairs) for pair in group]
        out = np.empty((len(cells.points) // SAMPLES, width * len(flat), SAMPLES), np.float32)
        for number, (k, pair) in enumerate(flat):
            part = out[:, width * number : width * (number + 1)]
            if scalars:
                part = part.view(np.uint32)
            resident = self._resident(k, pair)
            launches = [
                replace(
                    self._factors(cells, chunk, k, pair, resident),
                    outputs={"out": part[first // SAMPLES : last // SAMPLES]},
                    scalars=scalars or {},
                )
                for chunk, (first, last) in enumerate(cells.spans)
            ]
            self._run(ledger, stage, kernel, launches)
        return out

    def _factors(
        self,
        cells: PlaneCells,
        chunk: int,
        k: int,
        pair: Pair,
        resident: dict[str, Words],
    ) -> Launch:
        first, last = cells.spans[chunk]
        rows = cells.rows[chunk, k, : _CORNERS * int(cells.counts[chunk, k])]
        return Launch(
            inputs={
                "points": cells.points[first:last],
                "plane": Gathered(pair.plane, rows),
                "slots": cells.slots[chunk, k, : last - first],
            },
            shared=resident,
        )

    def _resident(self, k: int, pair: Pair) -> dict[str, Words]:
        axes = np.array((*PLANE_AXES[k], LINE_AXES[k]), dtype=np.int32)
        return {**self.placement, "axes": axes, "line": pair.line}

    def _run(self, ledger: Ledger, stage: str, kernel: str, launches: Sequence[Launch]) -> None:
        """Neighbouring chunks to the same tile."""
        parts = neighbours(len(launches), self.device.tiles)
        shares = [launches[first:last] for first, last in parts]
        run_shares(self.device, ledger, stage, f"render/tensor_factors:{kernel}", shares)


def factor_grid(march: March, resolution: Sequence[int], device: Device) -> FactorGrid:
    """Return the grid of factors with `resolution` nodes along each axis of the box."""
    low, high = march.box
    scales = (np.asarray(resolution, dtype=np.float32) - np.float32(1)) / (high - low)
    placement: dict[str, Words] = {
        "low": np.ascontiguousarray(low),
        "scales": scales.astype(np.float32),
        "nodes": np.asarray(resolution, dtype=np.int32),
    }
    return FactorGrid(device, placement)


def channel_pairs(factors: Sequence[Factors]) -> list[list[Pair]]:
    """Return the pairs of planes and lines cut into 16 channels each; missing ones are 0."""
    return [_pairs(pair) for pair in factors]


def _pairs(pair: Factors) -> list[Pair]:
    channels = pair.line.shape[1]
    missing = -channels % CHANNELS
    plane = np.pad(pair.plane.reshape(-1, channels), ((0, 0), (0, missing)))
    line = np.pad(pair.line, ((0, 0), (0, missing)))
    return [
        Pair(
            np.ascontiguousarray(plane[:, first : first + CHANNELS]),
            np.ascontiguousarray(line[:, first : first + CHANNELS]),
        )
        for first in range(0, channels, CHANNELS)
    ]
