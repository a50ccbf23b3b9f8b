"""A device whose kernels are run by numba, and samples of a model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vividc import KernelFunction
from vividc.gemm.packed import packed
from vividc.render.array import ArrayField, Device
from vividc.render.array.device.launch import Gathered, Launch, Move
from vividc.render.array.device.launches import Phase
from vividc.render.array.device.programs import kernel_folder, kernel_module
from vividc.render.array.march.light import light_along, picture_of
from vividc.render.array.pieces import RAYS, Piece, Rays, pieces_of
from vividc.render.array.records import Kept
from vividc.render.arrays import Float32Array
from vividc.render.radiance import March

PIECE = 50
"""Samples of a piece: others than the first begin within a block of 16."""


class _Kernels:
    """Programs that are the kernels themselves."""

    def get(self, kernel: str, **options: object) -> KernelFunction:
        path, _, name = kernel.partition(":")
        found: KernelFunction = getattr(kernel_module(kernel_folder() / f"{path}.py"), name)
        return found


class Host(Device):
    """A device of which numba runs the kernels: none is mapped, and no stage takes cycles."""

    tiles = 16
    scratchpad_bytes = 32768
    line_bytes = 32

    def __init__(self) -> None:
        super().__init__(_Kernels())  # type: ignore[arg-type]

    def spread(self, stage: str, kernel: str, *arguments: object) -> None:
        with self.ledger.timed(stage):
            self.programs.get(kernel)(*arguments)

    def run_phases(self, stage: str, phases: Sequence[Phase]) -> list[list[list[int]]]:
        if not any(any(phase.shares) for phase in phases):
            return super().run_phases(stage, phases)
        with self.ledger.timed(stage):
            return [self._run(phase) for phase in phases]

    def _run(self, phase: Phase) -> list[list[int]]:
        assert len(phase.shares) <= self.tiles
        if phase.kernel is None:
            return [[_copied(launch) for launch in share] for share in phase.shares]
        function: Any = self.programs.get(phase.kernel)
        found = [[_launched(self, function, launch) for launch in share] for share in phase.shares]
        self.ledger.count(words_read_by_host=sum(map(len, found)))
        return found


def _copied(launch: Launch) -> int:
    for name, array in launch.outputs.items():
        array[...] = _rows(launch.inputs[name])
    return 0


def _launched(host: Host, function: KernelFunction, launch: Launch) -> int:
    flat = {parameter.name: parameter.ndim == 1 for parameter in function.params}
    assert sum(launch.sizes.values()) <= host.scratchpad_bytes
    given: dict[str, Any] = dict(launch.scalars)
    kinds = {parameter.name: parameter.dtype.value for parameter in function.params}
    shapes = {**launch.shapes, **launch.work}
    given |= {name: np.zeros(shape, kinds[name]) for name, shape in shapes.items()}
    for name, array in {**launch.shared, **launch.inputs}.items():
        if isinstance(array, np.ndarray | Gathered):
            rows = _rows(array)
            given[name] = rows.flatten() if flat[name] else rows.copy()
        else:
            _put(given[name], array)
    given |= {name: np.zeros(some.shape, np.uint32) for name, some in launch.fetched.items()}
    for name, array in launch.outputs.items():
        if isinstance(array, np.ndarray):
            given.setdefault(name, np.zeros(array.size if flat[name] else array.shape, array.dtype))
    if launch.fetched:
        function(*({**given, "phase": 0}[name] for name in flat))
        given["phase"] = 1
    for name, some in launch.fetched.items():
        listed = given[name]
        rows = some.table[listed[1 : 1 + min(listed[0], some.most)]].view(np.uint32).ravel()
        listed[some.first : some.first + len(rows)] = rows
    for name, array in launch.carried.items():
        given[name] = array.reshape(-1) if flat[name] else array
    value = function(*(given[name] for name in flat))
    for name, array in launch.outputs.items():
        if isinstance(array, np.ndarray):
            array[...] = given[name].reshape(array.shape)
        else:
            _take(given[name], array)
    return int(value or 0)


def _put(room: np.ndarray, moves: Sequence[Move]) -> None:
    for move in moves:
        rows = _rows(move.array).ravel().view(room.dtype)
        room.reshape(-1)[move.first : move.first + rows.size] = rows


def _take(room: np.ndarray, moves: Sequence[Move]) -> None:
    for move in moves:
        rows = room.reshape(-1)[move.first : move.first + move.array.size]
        move.array[...] = rows.view(move.array.dtype).reshape(move.array.shape)


def _rows(array: np.ndarray | Gathered) -> np.ndarray:
    return array.table[array.indices] if isinstance(array, Gathered) else array


@dataclass(frozen=True)
class GivenPoints:
    """Stands for `records.Listed` of pieces of at most 50 samples, each of another ray."""

    where: Float32Array
    pieces: Sequence[Piece]

    def points(self) -> Float32Array:
        return self.where


@dataclass(frozen=True)
class GivenKept(Kept):
    """`records.Kept` of points that no rays lead to."""

    where: Float32Array

    def located(self) -> tuple[Float32Array, Float32Array]:
        rays = [piece.first_ray + (piece.items >> 16 & RAYS - 1) for piece in self.pieces]
        return self.where, self.directions[np.concatenate(rays)]


def shown(
    device: Device,
    field: ArrayField,
    points: Float32Array,
    directions: Float32Array,
    least: float = -1,
) -> tuple[Float32Array, Float32Array]:
    """Return alpha [n] and r, g, b [n, 3] of points that are seen along directions; 0 of those with
    an alpha of at most `least`.
    """
    firsts = range(0, len(points), PIECE)
    items = [
        np.arange(len(points[first : first + PIECE]), dtype=np.int32) << 16 for first in firsts
    ]
    pieces = list(pieces_of([[some] for some in items], PIECE))
    own = np.concatenate([np.arange(len(piece)) + piece.first_ray for piece in pieces])
    seen = np.zeros((len(pieces) * RAYS, 3), np.float32)
    seen[own] = directions
    found = field.densities(GivenPoints(points, pieces))  # type: ignore[arg-type]
    limits, left = np.array([0, least], np.float32), np.ones(len(seen), np.float32)
    survivors = light_along(device, pieces, found, limits, left, keep_all=False)
    rays = Rays(seen, left, np.zeros(len(seen), np.uint32))
    numbers = np.concatenate([one.places.start + (one.items.view("u4") >> 22) for one in survivors])
    kept = GivenKept(device, left, rays, survivors, points[numbers])
    alpha = np.zeros(len(points), np.float32)
    alpha[numbers] = np.concatenate([one.weights for one in survivors])
    whole = [replace(one, weights=np.ones_like(one.weights)) for one in survivors]
    rgb = picture_of(device, whole, field.colours(kept), np.zeros_like(left))[own, :3]
    return alpha, rgb


def as_float8(blocks: np.ndarray, scale: np.float32) -> np.ndarray:
    """Words of four float8 by sample, [n, F / 2], of blocks [B, F, 16] of two float16 in a word."""
    words = np.ascontiguousarray(blocks.view(np.uint32).transpose(0, 2, 1))
    numbers = words.view(np.float16).astype(np.float32).reshape(-1, 2 * blocks.shape[1])
    return packed(numbers * scale, "e4m3").view(np.uint32)


def samples_of(march: March, count: int) -> tuple[Float32Array, Float32Array]:
    """Random points in occupied cells, neighbours next to each other, and directions."""
    rng = np.random.default_rng(7)
    cells = np.argwhere(march.occupied)
    chosen = cells[np.sort(rng.integers(0, len(cells), count))]
    place = (chosen + rng.random((count, 3))) / march.occupied.shape
    points = march.box[0] + place.astype(np.float32) * (march.box[1] - march.box[0])
    directions = rng.standard_normal((count, 3)).astype(np.float32)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return np.clip(points, march.box[0], march.box[1]).astype(np.float32), directions
