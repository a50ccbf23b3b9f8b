"""3D Gaussian Splatting (Kerbl et al. 2023) rendered by the array."""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt

import numpy as np

from vividc.render.array.device.device import Device, open_device
from vividc.render.array.device.frame import ArrayFrame
from vividc.render.array.options import ArrayOptions
from vividc.render.array.sampling import pixels_of, sampled
from vividc.render.array.splats.blend import EXP_EXCESS, Culling, blend_splats
from vividc.render.array.splats.project import project_on_array
from vividc.render.array.splats.scene import device_scene, screen_tiles
from vividc.render.array.splats.sort import sort_on_array
from vividc.render.arrays import Float32Array
from vividc.render.camera import Camera
from vividc.render.crop import TILE_PX
from vividc.render.errors import SceneError
from vividc.render.ply import Gaussians
from vividc.render.splat.blend_reference import BlendOptions

Progress = Callable[[float], None]
_SCRATCHPAD_BYTES = 32_768
"""Where the launches put their arrays goes up to there."""
_PROJECTED, _SORTED = 0.05, 0.15
"""Rough shares of the time."""


def render_splats(
    scene: Gaussians,
    camera: Camera,
    options: ArrayOptions | None = None,
    progress: Progress | None = None,
    device: Device | None = None,
    culling: Culling | None = None,
) -> ArrayFrame:
    """Render a view of a scene of Gaussians on the array.

    Every value of splats, lists and pixels is computed by kernels of `kernels/render`; the host
    makes the launch graphs, and reads counts between them.

    Parameters
    ----------
    options
        Switches. With `sample` below 1 only that share of the screen tiles is blended; projection
        and sorting are always of the whole frame.
    progress
        Called with the share that is done, 0 to 1.
    device
        The accelerator with its programs; None: that of `options.fabric`.
    culling
        How far Lookahead Culling II goes; None: to pixels if `options.lookahead`, else nowhere.

    Raises
    ------
    SceneError
        A parameter of the scene is not finite, the image is too large, more splats are seen than
        can be sorted, or the tiles have smaller scratchpads than the launches are laid out for.
    """
    chosen = ArrayOptions() if options is None else options
    machine = open_device(chosen.fabric, chosen.engine) if device is None else device
    tell = progress if progress is not None else _silent
    _check_scratchpad(machine)
    columns, rows = screen_tiles(camera)
    arrays = device_scene(scene)
    machine.settle()  # of what failed before
    ledger = machine.ledger
    # A margin with which lookahead may go wrong does nothing without it.
    margin = chosen.exponent_margin if chosen.lookahead else BlendOptions().margin
    margin += EXP_EXCESS[chosen.precision]
    splats = project_on_array(machine, arrays, camera, margin)
    tell(_PROJECTED)
    screens = np.arange(columns * rows, dtype=np.int32)
    image = _white(camera)
    if len(splats):
        lists = sort_on_array(machine, splats, columns, rows)
        screens = sampled(np.diff(lists.start), chosen.sample)
        for stage in ledger.stages.values():
            stage.whole = True
        tell(_SORTED)
        culling = culling or ("pixels" if chosen.lookahead else "none")
        image = blend_splats(machine, splats, lists, camera, culling, screens, chosen.precision)
        ledger.count(splats=len(splats), list_entries=len(lists.slots))
    tell(1.0)
    corners = TILE_PX * np.stack((screens % columns, screens // columns), axis=1)
    return ArrayFrame(
        image,
        tuple(ledger.stages.values()),
        dict(ledger.counts),
        machine.clock_ghz,
        len(screens) / (columns * rows),
        sqrt(columns * rows / max(len(screens), 1)),  # what shares of one job differ in
        None if chosen.sample == 1 else pixels_of(corners, TILE_PX, camera),
        machine.programs.late,
    )


def _check_scratchpad(device: Device) -> None:
    if device.scratchpad_bytes < _SCRATCHPAD_BYTES:
        raise SceneError(
            f"the launches of 3DGS take scratchpads of {_SCRATCHPAD_BYTES} bytes, and those of "
            f"{device.programs.machine.name} have {device.scratchpad_bytes}",
            hint="use a fabric with larger scratchpads",
        )


def _white(camera: Camera) -> Float32Array:
    return np.ones((camera.height, camera.width, 3), dtype=np.float32)


def _silent(_: float) -> None:
    """Ignore the progress."""
