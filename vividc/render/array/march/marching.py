"""The ray-marched renderers on the array: `radiance.volume.render_rays`, stage by stage.

Every sample and every pixel is computed by kernels (kernels/render/marching.py). The host makes the
launch graphs: it reads how many samples a block of rays has, and how many survive, between two
jobs, as the host of a GPU would.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vividc.machine.words import WORD_BYTES
from vividc.render.array.device.device import Device
from vividc.render.array.device.launch import Launch
from vividc.render.array.march.bricks import Bricks, pack_bricks
from vividc.render.array.march.depths import Blocks
from vividc.render.array.march.light import light_along, picture_of
from vividc.render.array.models.field import ArrayField
from vividc.render.array.options import ArrayOptions
from vividc.render.array.pieces import RAYS, Piece, Rays, pieces_of, total
from vividc.render.array.records import MARCHING, Kept, Listed
from vividc.render.array.steering import LEAST_PARTS, STEPS_AT_ONCE
from vividc.render.arrays import Float32Array, Int32Array
from vividc.render.camera import Camera
from vividc.render.errors import SceneError
from vividc.render.radiance import March

_RAY_WORDS = 5
_CANDIDATE_WORDS = 2
_OTHER_WORDS = 512
"""Of the arrays in a launch of the kernels behind the marching one that are not by sample, and what
aligning takes.
"""
_SPARE_WORDS = 128
"""For the other small arrays of the marching kernel, and what aligning them takes."""
_MOST_STEPS = 1 << 15
_COUNT_BIT = 16
"""Above it the marching kernel returns how many samples there are, below it where to go on."""


class Marcher:
    """Renders blocks of a camera's pixels."""

    def __init__(
        self, device: Device, field: ArrayField, camera: Camera, options: ArrayOptions
    ) -> None:
        self._device = device
        self._field = field
        self._camera = camera
        self._lookahead = options.lookahead
        march = field.march
        self._geometry = geometry_of(march, camera)
        bricks = pack_bricks(march.occupied)
        self._tables = {
            "geometry": self._geometry,
            "grid": bricks.grid,
            "coarse": bricks.coarse,
            "ranks": bricks.ranks,
            "bricks": bricks.cells,
        }
        self._at_once, self._room = _room(march, bricks, device.scratchpad_bytes)
        least = max(field.weight_min, options.weight_min)
        self._limits = np.array([field.transmittance_min, least], dtype=np.float32)

    def render(self, blocks: Blocks) -> Float32Array:
        """Return r, g, b over white and transmittance, [n, 64, 4], of blocks of 8x8 pixels."""
        ledger = self._device.ledger
        rays = self._camera_rays(blocks)
        pieces = self._march(blocks, rays)
        ledger.count(density_samples=total(pieces))
        if not pieces:
            return np.ones((len(blocks), RAYS, 4), dtype=np.float32)
        device, field, given = self._device, self._field, (self._device, self._geometry, rays)
        found, left = field.densities(Listed(*given, pieces)), np.ones_like(rays.entries)
        survivors = light_along(device, pieces, found, self._limits, left, not self._lookahead)
        counted = sum(np.count_nonzero(piece.weights) for piece in survivors)
        ledger.count(colour_samples=total(survivors), counted_samples=int(counted))
        colours = field.colours(Kept(*given, survivors))
        return picture_of(device, survivors, colours, left).reshape(-1, RAYS, 4)

    def _camera_rays(self, blocks: Blocks) -> Rays:
        camera = self._camera
        pose = np.ascontiguousarray(camera.c2w[:3, :3], dtype=np.float32)
        focal = camera.focal
        lens = np.array([camera.width, camera.height, focal, 1 / focal], dtype=np.float32)
        shape = (len(blocks), RAYS)
        directions = np.zeros((*shape, 3), dtype=np.float32)
        entries, steps = np.zeros(shape, dtype=np.float32), np.zeros(shape, dtype=np.uint32)
        self._device.spread(
            *("ray generation", f"{MARCHING}:camera_rays"),
            *(pose, lens, self._geometry, self._field.march.samples),
            *(blocks.corners, blocks.depths, directions, entries, steps),
        )
        return Rays(directions.reshape(-1, 3), entries.reshape(-1), steps.reshape(-1))

    def _march(self, blocks: Blocks, rays: Rays) -> list[Piece]:
        """Return the samples of all blocks.

        Where a launch has no room for all samples of a block, another one goes on.
        """
        ends = parts_of(self._field.march, blocks, self._at_once)
        found: list[list[Int32Array]] = [[] for _ in ends]
        todo = [(number, 0) for number in range(len(ends))]
        while todo:
            rooms = [np.zeros(self._room, dtype=np.int32) for _ in todo]
            launches = [
                self._march_launch(number, start, ends[number], rays, room)
                for (number, start), room in zip(todo, rooms, strict=True)
            ]
            returned = self._device.run("ray marching", f"{MARCHING}:march_rays", launches)
            again: list[tuple[int, int]] = []
            for (number, _), room, word in zip(todo, rooms, returned, strict=True):
                samples, goes_on = word >> _COUNT_BIT, word & ((1 << _COUNT_BIT) - 1)
                if samples:
                    found[number].append(room[:samples])
                if goes_on:
                    again.append((number, goes_on))
            todo = again
        most = self._device.fitting(self._field.sample_words, _OTHER_WORDS)
        return list(pieces_of(found, min(most, self._field.most_samples)))

    def _march_launch(
        self, number: int, start: int, end: int, rays: Rays, items: Int32Array
    ) -> Launch:
        block = slice(number * RAYS, (number + 1) * RAYS)
        room = (RAYS * self._at_once,)
        return Launch(
            shapes={"count": (1,)},
            work={"candidates": room, "bricks_of": room},
            inputs={
                "directions": rays.directions[block],
                "entries": rays.entries[block],
                "steps": rays.steps[block],
            },
            outputs={"items": items},
            counted={"items": "count"},
            shared=self._tables,
            scalars={"start": start, "end": end, "at_once": self._at_once},
            cost=end - start + 1,
        )


def parts_of(march: March, blocks: Blocks, at_once: int) -> list[int]:
    """Return how many parts of some steps each block's rays have at most."""
    parts: list[int] = np.ceil(steps_of(march, blocks) / at_once).astype(np.int64).tolist()
    return parts


def steps_of(march: March, blocks: Blocks) -> npt.NDArray[np.float64]:
    """Return how many steps the rays of each block have at most."""
    between = (blocks.depths[:, 1].astype(np.float64) - blocks.depths[:, 0]) / march.step
    return np.clip(between + 2, 0, march.samples)  # both ends lie within a step


def geometry_of(march: March, camera: Camera) -> Float32Array:
    """Return the table that kernels/render/marching.py calls `geometry`."""
    cells = np.array(march.occupied.shape, dtype=np.float32) / (march.box[1] - march.box[0])
    rest = (march.near, march.far, march.step, 1 / march.step)
    parts = (camera.position, march.box[0], march.box[1], cells, rest)
    return np.concatenate(parts, dtype=np.float32)


def _room(march: March, bricks: Bricks, scratchpad_bytes: int) -> tuple[int, int]:
    """Return how many steps of all rays of a block are looked at at once, and how many samples in
    occupied cells there is room for.

    Raises
    ------
    SceneError
        There is no room for those of a step, or a ray has more steps than items have bits for.
    """
    free = scratchpad_bytes - bricks.size_bytes
    words = free // WORD_BYTES - _SPARE_WORDS - _RAY_WORDS * RAYS
    if march.samples > _MOST_STEPS:
        raise SceneError(
            f"a ray has {march.samples} steps, and the array numbers {_MOST_STEPS}",
            hint="store fewer and longer steps",
        )
    for at_once in STEPS_AT_ONCE:
        room = words - _CANDIDATE_WORDS * RAYS * at_once
        if room >= (LEAST_PARTS if at_once > 1 else 1) * RAYS * at_once:
            return at_once, room
    raise SceneError(
        f"the occupancy of {' x '.join(map(str, march.occupied.shape))} cells takes "
        f"{bricks.size_bytes} bytes of a scratchpad of {scratchpad_bytes}, and the samples of a "
        "step must fit beside it",
        hint="store a coarser occupancy, or use a fabric with larger scratchpads",
    )
