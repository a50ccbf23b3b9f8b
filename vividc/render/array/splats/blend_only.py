"""3DGS blending by the array: small blocks of pixels, spread over the tiles of an accelerator.

Projection, lists and sorting are the host's (`vividc.render.splat.splat`); every pixel is blended
by the simulated machine.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

import vividc
from vividc.errors import demand_type
from vividc.launch import At, Job, JobStats
from vividc.launch.turns import Turns, deal
from vividc.machine.words import WORD_BYTES
from vividc.render.arrays import Float32Array
from vividc.render.camera import Camera
from vividc.render.crop import Crop
from vividc.render.errors import SceneError
from vividc.render.ply import Gaussians
from vividc.render.splat.blocks import BlendLaunch, assemble, cut_small_launches
from vividc.render.splat.splat import TileLists, tile_lists

PARAMETERS = (
    *("mean_x", "mean_y", "conic_a", "conic_b", "conic_c", "opacity", "red", "green", "blue"),
    *("out", "x0", "y0", "width", "height", "n"),
)
"""Of the blending kernel, as in `kernels/gs_blend.py`."""
_CYCLES_A_MS_AT_1_GHZ = 1e6
_PLACES = (2, 1)
"""Launches that lie in a scratchpad at once, at best: one runs while the next is moved in."""


@dataclass(frozen=True, slots=True, eq=False)
class ArrayPicture:
    """A picture that the array blended.

    Attributes
    ----------
    image
        [height, width, 3] float32 over white, not clipped.
    cycles
        Of the whole job, with transfers and configuration.
    milliseconds
        They take at the tiles' clock.
    launches
        Blocks that were blended; those in which no splat can be seen are left white.
    stats
        Where the cycles of the tiles went.
    """

    image: Float32Array
    cycles: int
    milliseconds: float
    launches: int
    stats: JobStats


def blend_on_array(
    program: vividc.Program,
    scene: Gaussians,
    camera: Camera,
    accelerator: str = "vivid",
    engine: str = "auto",
) -> ArrayPicture:
    """Blend a view of `scene` with `program`, the compiled blending kernel.

    Raises
    ------
    SceneError
        The program is not that of a blending kernel, or a pixel's list fits no scratchpad.
    ArgumentError
        The program was not compiled for the accelerator's tile.
    """
    demand_type(program, vividc.Program, "the program", "give what compile or load returned")
    demand_type(camera, Camera, "the camera", "give a Camera, as orbit_camera makes one")
    names = tuple(parameter.name for parameter in program.params)
    if names != PARAMETERS:
        raise SceneError(
            f"`{program.name}` is not a blending kernel: its parameters are {', '.join(names)}",
            hint="compile kernels/gs_blend.py, or a kernel with the same parameters",
        )
    crop = Crop(0, 0, camera.width, camera.height)
    job = Job(accelerator)
    size_bytes = job.accelerator.fabric.scratchpad.size_bytes
    places, launches = _cut(tile_lists(scene, camera), crop, size_bytes // WORD_BYTES)
    outputs = [_white(launch) for launch in launches]
    busy = [pair for pair in zip(launches, outputs, strict=True) if len(pair[0].splats)]
    work = [len(launch.splats) * launch.block.pixels for launch, _ in busy]
    for tile, share in enumerate(deal(work, len(job.accelerator.tiles))):
        _add_tile(job, tile, program, [busy[number] for number in share], places)
    result = job.simulate(engine=engine)
    return ArrayPicture(
        image=assemble(crop, launches, outputs),
        cycles=result.cycles,
        milliseconds=result.cycles / job.accelerator.fabric.clock_ghz / _CYCLES_A_MS_AT_1_GHZ,
        launches=len(busy),
        stats=result.stats,
    )


def _cut(
    lists: TileLists, crop: Crop, spm_words: int
) -> tuple[tuple[int, ...], tuple[BlendLaunch, ...]]:
    """Return the places of a scratchpad, in bytes, and launches of which each fits one."""
    for count in _PLACES[:-1]:
        words = spm_words // count
        try:
            launches = cut_small_launches(lists, crop, words)
        except SceneError:  # a pixel's list is too long: perhaps not for a larger place
            continue
        return tuple(WORD_BYTES * words * place for place in range(count)), launches
    return (0,), cut_small_launches(lists, crop, spm_words)


def _white(launch: BlendLaunch) -> Float32Array:
    out = np.zeros((launch.block.pixels, 4), dtype=np.float32)
    out[:, 3] = 1
    return out.ravel()


def _add_tile(
    job: Job,
    tile: int,
    program: vividc.Program,
    share: Sequence[tuple[BlendLaunch, Float32Array]],
    places: Sequence[int],
) -> None:
    """Add the steps of one tile: in, run, out of each launch, alternating between the places."""
    turns = Turns([tile], len(places))
    for launch, out in share:
        _, place, freed = turns.take()
        start = places[place]
        columns = launch.splats.arrays()
        splats = np.concatenate(list(columns.values()))
        here = job.move_in(tile, splats, start, after=freed)
        count = len(launch.splats)
        block = launch.block
        end = start + splats.nbytes
        arguments: dict[str, object] = {
            name: At(start + WORD_BYTES * count * i, (count,)) for i, name in enumerate(columns)
        }
        arguments |= {"out": At(end, (4 * block.pixels,)), "x0": block.x0, "y0": block.y0}
        arguments |= {"width": block.width, "height": block.height, "n": count}
        run = job.run(tile, program, after=[here, *freed], **arguments)
        turns.free(tile, place, job.move_out(tile, end, out, after=[run]))
