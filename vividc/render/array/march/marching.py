"""The ray-marched renderers on the array: `radiance.volume.render_rays`, stage by stage.

Every sample and every pixel is computed by kernels (kernels/render/marching.py). The host makes the
launch graphs: it reads how many samples a block of rays has, and how many survive, between two
jobs, as the host of a GPU would.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vividc import LoopOptions
from vividc.machine.words import WORD_BYTES
from vividc.render.array.device.device import Device
from vividc.render.array.device.frame import Ledger
from vividc.render.array.device.gather import Word, gather_rows, joined
from vividc.render.array.device.launches import Launch, Move, run_launches
from vividc.render.array.march.bricks import Bricks, pack_bricks
from vividc.render.array.models.field import ArrayField, Features
from vividc.render.arrays import Float32Array, Int32Array
from vividc.render.camera import Camera
from vividc.render.errors import SceneError
from vividc.render.radiance import March

SIDE = 8
"""Pixels of a block's side."""
RAYS = SIDE * SIDE
_KERNELS = "render/marching"
_RAYS_AT_ONCE = 16
"""Rays of a launch of the marching kernel; a divisor of those of a block."""
_RAY_WORDS = 6
_SAMPLES_AT_ONCE = 720
"""Samples of a launch of the other kernels: five words of each fit a scratchpad twice."""
_SAMPLE_WORDS = 5
"""Of each sample in a launch of the kernels behind the marching one."""
_OTHER_BYTES = 2048
"""Of the arrays in such a launch that are not by sample, and what aligning takes."""
_SPARE_WORDS = 256
"""For the other small arrays of the marching kernel, and what aligning them takes."""
_MOST_STEPS = 1 << 15
_FEWEST_SAMPLES = 72


@dataclass(frozen=True, slots=True)
class Block:
    """Rays in a row in the batch, and its samples: numbers in the batch."""

    first_ray: int
    rays: int
    first: int = 0
    samples: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class _Survivors:
    """What a batch's colour is computed of: numbers of samples and rays, and weights.

    Each block's are at the head of its own part of the arrays: `blocks` says where, `listed` how
    many.
    """

    samples: Int32Array
    rays: Int32Array
    weights: Float32Array
    blocks: tuple[Block, ...]
    listed: tuple[int, ...]

    @property
    def total(self) -> int:
        """Of all blocks."""
        return sum(self.listed)

    def parts(self) -> Iterator[slice]:
        """Yield where each block's are."""
        for block, count in zip(self.blocks, self.listed, strict=True):
            yield slice(block.first, block.first + count)


class Marcher:
    """Renders blocks of a camera's pixels."""

    def __init__(self, device: Device, field: ArrayField, camera: Camera, lookahead: bool) -> None:
        self._device = device
        self._field = field
        self._camera = camera
        self._lookahead = lookahead
        self._ledger = Ledger()
        march = field.march
        self._geometry = geometry_of(march, camera)
        self._bricks = pack_bricks(march.occupied)
        self._room = _room(march, self._bricks, device.scratchpad_bytes)
        self._limits = np.array([field.transmittance_min, field.weight_min], dtype=np.float32)
        self._directions = np.empty((0, 3), dtype=np.float32)

    def render(self, corners: Int32Array, ledger: Ledger) -> Float32Array:
        """Return r, g, b over white and transmittance, [n, 64, 4], of blocks of 8x8 pixels; what
        they cost is booked in `ledger`.

        Parameters
        ----------
        corners
            [n, 2] int32 first column and row of each.
        """
        camera = self._camera
        self._ledger = ledger
        self._directions = self._camera_rays(corners)
        inside = np.minimum((camera.width, camera.height) - corners, SIDE)
        ledger.count(rays=int(inside.prod(axis=1).sum()))
        blocks, items, entries = self._march(len(corners))
        points, rays = self._points(blocks, items, entries)
        ledger.count(density_samples=len(points))
        thickness = np.zeros(0, dtype=np.float32)
        features: Features = np.zeros((0, 1), dtype=np.float32)
        if len(points):
            thickness, features = self._field.density(points, ledger)
        survivors, left = self._light(blocks, thickness, rays)
        counted = sum(np.count_nonzero(survivors.weights[part]) for part in survivors.parts())
        ledger.count(colour_samples=survivors.total, counted_samples=int(counted))
        colours = np.zeros((0, 3), dtype=np.float32)
        if survivors.total:
            compacted = self._compacted(survivors, points, features)
            colours = self._field.colour(*compacted, self._directions, ledger)
        return self._accumulate(survivors, colours, left).reshape(-1, RAYS, 4)

    def _camera_rays(self, corners: Int32Array) -> Float32Array:
        camera = self._camera
        pose = np.ascontiguousarray(camera.c2w[:3, :3], dtype=np.float32)
        focal = camera.focal
        lens = np.array([camera.width, camera.height, focal, 1 / focal], dtype=np.float32)
        directions = np.zeros((len(corners), RAYS, 3), dtype=np.float32)
        kernel = f"{_KERNELS}:camera_rays"
        self._device.spread(self._ledger, "ray generation", kernel, pose, lens, corners, directions)
        return directions.reshape(-1, 3)

    def _march(self, count: int) -> tuple[list[Block], list[list[Int32Array]], Float32Array]:
        """Return blocks with how many samples each has, their items, and where rays enter.

        A launch marches some of a block's rays. Where these have more samples than there is room
        for, they are cut into halves and marched again.
        """
        entries = np.zeros(count * RAYS, dtype=np.float32)
        todo = [Block(first, _RAYS_AT_ONCE) for first in range(0, count * RAYS, _RAYS_AT_ONCE)]
        done: dict[int, Int32Array] = {}
        while todo:
            rooms = [np.zeros(self._room, dtype=np.int32) for _ in todo]
            launches = [
                self._march_launch(part, room, entries)
                for part, room in zip(todo, rooms, strict=True)
            ]
            counts = self._run("ray marching", "march_rays", launches)
            again: list[Block] = []
            for part, room, samples in zip(todo, rooms, counts, strict=True):
                if samples > self._room:
                    _check_divisible(part, samples, self._room)
                    again += _halves(part)
                else:
                    done[part.first_ray] = room[:samples]
            todo = again
        blocks, items = _joined(done, count * RAYS)
        return blocks, items, entries

    def _march_launch(self, block: Block, items: Int32Array, entries: Float32Array) -> Launch:
        bricks = self._bricks
        shared = {
            "geometry": self._geometry,
            "grid": bricks.grid,
            "coarse": bricks.coarse,
            "ranks": bricks.ranks,
            "bricks": bricks.cells,
        }
        rays = slice(block.first_ray, block.first_ray + block.rays)
        return Launch(
            shapes={"exits": (block.rays,), "steps": (block.rays,), "candidates": items.shape},
            inputs={"directions": self._directions[rays]},
            outputs={"entries": entries[rays], "items": items},
            shared=shared,
            scalars={"most": self._field.march.samples, "base": block.first_ray % RAYS},
        )

    def _points(
        self,
        blocks: Sequence[Block],
        items: Sequence[Sequence[Int32Array]],
        entries: Float32Array,
    ) -> tuple[Float32Array, Int32Array]:
        """Return the place [n, 3] and the ray [n] of each sample."""
        total = sum(block.samples for block in blocks)
        points = np.zeros((total, 3), dtype=np.float32)
        rays = np.zeros(total, dtype=np.int32)
        launches = []
        for block, listed in zip(blocks, items, strict=True):
            if not block.samples:
                continue
            part = slice(block.first, block.first + block.samples)
            first_ray = block.first_ray - block.first_ray % RAYS
            of_rays = slice(first_ray, first_ray + RAYS)
            launches.append(
                Launch(
                    shapes={"items": (block.samples,)},
                    inputs={
                        "directions": self._directions[of_rays],
                        "entries": entries[of_rays],
                        "items": _in_a_row(listed),
                    },
                    outputs={"points": points[part], "rays": rays[part]},
                    shared={"geometry": self._geometry},
                    scalars={"first_ray": first_ray},
                    cost=block.samples + 20,
                )
            )
        self._run("ray marching", "sample_points", launches)
        return points, rays

    def _light(
        self, blocks: Sequence[Block], thickness: Float32Array, rays: Int32Array
    ) -> tuple[_Survivors, Float32Array]:
        """Return the samples whose colour is computed, and the light behind all samples [rays]."""
        kept, kept_rays = np.zeros_like(rays), np.zeros_like(rays)
        weights = np.zeros_like(thickness)
        left = np.zeros(len(self._directions), dtype=np.float32)
        launches = []
        for block in blocks:
            part = slice(block.first, block.first + block.samples)
            of_rays = slice(block.first_ray, block.first_ray + block.rays)
            launches.append(
                Launch(
                    inputs={"thickness": thickness[part], "rays": rays[part]},
                    outputs={
                        "left": left[of_rays],
                        "kept": kept[part],
                        "kept_rays": kept_rays[part],
                        "weights": weights[part],
                    },
                    shared={"limits": self._limits},
                    scalars={
                        "first_ray": block.first_ray,
                        "first_sample": block.first,
                        "keep_all": int(not self._lookahead),
                    },
                    cost=block.samples + 40,
                )
            )
        counts = self._run("transmittance", "transmittance", launches)
        return _Survivors(kept, kept_rays, weights, tuple(blocks), tuple(counts)), left

    def _compacted(
        self, survivors: _Survivors, points: Float32Array, features: Features
    ) -> tuple[Float32Array, Features, Int32Array]:
        """Return points, features and rays of the survivors: rows that DMA gathers.

        Without lookahead all samples survive, and points and features are where they should be.
        """
        rays = [survivors.rays[part] for part in survivors.parts()]
        listed = joined(self._device, self._ledger, "compaction", rays)
        if not self._lookahead:
            return points, features, listed
        samples = [survivors.samples[part] for part in survivors.parts()]
        return self._gathered(points, samples), self._gathered(features, samples), listed

    def _gathered(self, table: npt.NDArray[Word], rows: Sequence[Int32Array]) -> npt.NDArray[Word]:
        return gather_rows(self._device, self._ledger, "compaction", table, rows)

    def _accumulate(
        self, survivors: _Survivors, colours: Float32Array, left: Float32Array
    ) -> Float32Array:
        """Return r, g, b over white and transmittance of each ray [n, 4]."""
        out = np.zeros((len(left), 4), dtype=np.float32)
        launches, first = [], 0
        for block, part in zip(survivors.blocks, survivors.parts(), strict=True):
            of_rays = slice(block.first_ray, block.first_ray + block.rays)
            samples = part.stop - part.start
            of_block = colours[first : first + samples]
            first += samples
            launches.append(
                Launch(
                    inputs={
                        "weights": survivors.weights[part],
                        "rays": survivors.rays[part],
                        "colours": of_block,
                        "left": left[of_rays],
                    },
                    outputs={"out": out[of_rays]},
                    scalars={"first_ray": block.first_ray},
                    cost=samples + 40,
                )
            )
        self._run("accumulation", "accumulate", launches)
        return out

    def _run(self, stage: str, kernel: str, launches: Sequence[Launch]) -> list[int]:
        """Run launches, and count what the host reads of them: a word each."""
        name = f"{_KERNELS}:{kernel}"
        returned = run_launches(
            self._device, self._ledger, stage, name, launches, loops=LoopOptions(auto=False)
        )
        self._ledger.count(words_read_by_host=len(launches))
        return returned


def block_corners(camera: Camera) -> Int32Array:
    """Return the first column and row of each block of 8x8 pixels, [n, 2] int32, row by row."""
    columns = np.arange(0, camera.width, SIDE)
    rows = np.arange(0, camera.height, SIDE)
    corners = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    return corners.astype(np.int32)


def geometry_of(march: March, camera: Camera) -> Float32Array:
    """Return the table that kernels/render/marching.py calls `geometry`."""
    cells = np.array(march.occupied.shape, dtype=np.float32) / (march.box[1] - march.box[0])
    rest = (march.near, march.far, march.step)
    parts = (camera.position, march.box[0], march.box[1], cells, rest)
    return np.concatenate(parts, dtype=np.float32)


def _room(march: March, bricks: Bricks, scratchpad_bytes: int) -> int:
    """Return how many samples of a block of rays there is room for in the scratchpad.

    If it can be, as many as a ray has steps; a ray of more steps is refused when so many of them
    are in bricks that hold an occupied cell.

    Raises
    ------
    SceneError
        Not even for a tenth of a usual launch's, or a ray has more steps than its samples' numbers
        have bits for.
    """
    free = scratchpad_bytes - bricks.size_bytes
    words = free // WORD_BYTES - _SPARE_WORDS - _RAY_WORDS * _RAYS_AT_ONCE
    behind = (scratchpad_bytes - _OTHER_BYTES) // (WORD_BYTES * _SAMPLE_WORDS)
    wanted = min(march.samples, behind)
    most = words // 4 if words // 4 >= wanted else words // 2
    if most < _FEWEST_SAMPLES:
        raise SceneError(
            f"the occupancy of {' x '.join(map(str, march.occupied.shape))} cells takes "
            f"{bricks.size_bytes} bytes of a scratchpad of {scratchpad_bytes}, and the samples of "
            "a ray must fit beside it",
            hint="store a coarser occupancy, or use a fabric with larger scratchpads",
        )
    if march.samples > _MOST_STEPS:
        raise SceneError(
            f"a ray has {march.samples} steps, and the array numbers {_MOST_STEPS}",
            hint="store fewer and longer steps",
        )
    return min(max(_SAMPLES_AT_ONCE, wanted), most, behind)


def _check_divisible(block: Block, samples: int, room: int) -> None:
    if block.rays == 1:
        raise SceneError(
            f"a ray has {samples} samples in bricks that hold an occupied cell, and a launch has "
            f"room for {room}",
            hint="store a finer occupancy or a longer step, or use a fabric with larger "
            "scratchpads",
        )


def _joined(parts: dict[int, Int32Array], rays: int) -> tuple[list[Block], list[list[Int32Array]]]:
    """Join parts of a block, by first ray, while their samples fit one launch."""
    blocks: list[Block] = []
    items: list[list[Int32Array]] = []
    samples = 0
    for ray, listed in sorted(parts.items()):
        last = blocks[-1] if blocks else None
        if last is None or ray % RAYS == 0 or last.samples + len(listed) > _SAMPLES_AT_ONCE:
            blocks.append(Block(ray, 0, samples))
            items.append([])
        here = blocks[-1]
        blocks[-1] = Block(here.first_ray, 0, here.first, here.samples + len(listed))
        items[-1] += [listed] if len(listed) else []
        samples += len(listed)
    ends = [*(block.first_ray for block in blocks[1:]), rays]
    whole = [
        Block(block.first_ray, end - block.first_ray, block.first, block.samples)
        for block, end in zip(blocks, ends, strict=True)
    ]
    return whole, items


def _in_a_row(arrays: Sequence[Int32Array]) -> tuple[Move, ...]:
    """Return moves that put arrays one after the other."""
    ends = np.cumsum([len(array) for array in arrays])
    return tuple(
        Move(array, int(end) - len(array)) for array, end in zip(arrays, ends, strict=True)
    )


def _halves(block: Block) -> tuple[Block, Block]:
    left = block.rays // 2
    return Block(block.first_ray, left), Block(block.first_ray + left, block.rays - left)
