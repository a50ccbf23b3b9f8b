"""A scene of any method, rendered on the array."""

from __future__ import annotations

from collections.abc import Callable

from vividc.errors import demand_callable, demand_type
from vividc.host.watch import to_tell
from vividc.render.array.device.ahead import compile_ahead
from vividc.render.array.device.device import Device, open_device
from vividc.render.array.device.frame import ArrayFrame
from vividc.render.array.device.kernels import kernels_of
from vividc.render.array.march.batches import batch_count, render_blocks
from vividc.render.array.march.crew import Work
from vividc.render.array.march.depths import block_corners
from vividc.render.array.march.fields import open_field
from vividc.render.array.options import (
    NETWORK_MODES,
    PRECISIONS,
    ArrayOptions,
    RenderPrecision,
)
from vividc.render.array.pieces import SIDE
from vividc.render.array.sampling import expected_samples, pixels_of, sampled
from vividc.render.array.splats.frame import render_splats
from vividc.render.arrays import Int32Array
from vividc.render.camera import Camera
from vividc.render.errors import SceneError
from vividc.render.ply import Gaussians
from vividc.render.radiance import InstantNGP, KiloNeRF, March, TensoRF
from vividc.render.radiance.volume import check_weight
from vividc.render.scenes import Scene, demand_scene

_NARROW: dict[type, tuple[RenderPrecision, ...]] = {
    Gaussians: ("fp16", "fp8"),
    KiloNeRF: ("fp8",),
    InstantNGP: ("fp16", "fp8"),
    TensoRF: ("fp16", "fp8"),
}
"""Formats other than fp32 that scenes are rendered with."""
_METHODS: dict[type, str] = {
    KiloNeRF: "kilonerf",
    InstantNGP: "instant-ngp",
    TensoRF: "tensorf",
}


def render_array(
    scene: Scene,
    camera: Camera,
    options: ArrayOptions | None = None,
    progress: Callable[[float], None] | None = None,
    tell: Callable[[str], None] | None = None,
) -> ArrayFrame:
    """Render a scene on the simulated accelerator.

    Parameters
    ----------
    progress
        Called with the share of the blocks that are done, 0 to 1.
    tell
        Called with a line for each kernel that has to be compiled.

    Raises
    ------
    SceneError
        The method is not rendered on the array, the scene does not fit it, or an option is out of
        its range.
    ArchError
        The fabric is unknown, faulty or a single tile.
    """
    demand_scene(scene)
    demand_type(camera, Camera, "the camera", "give a Camera, as orbit_camera makes one")
    options = ArrayOptions() if options is None else options
    demand_type(options, ArrayOptions, "the options", "give ArrayOptions(...)")
    demand_callable(progress, "progress")
    progress = to_tell(progress)
    demand_callable(tell, "tell")
    demand_type(options.sample, (int, float), "the share of blocks", "give a number")
    if not 0 < options.sample <= 1:
        raise SceneError(
            f"a share of {options.sample} of the blocks cannot be simulated",
            loc="--sample",
            hint="give a number above 0 and at most 1",
        )
    check_precision(options.precision, scene)
    check_mode(options.mode, options.precision, scene)
    check_weight(options.weight_min)
    if isinstance(scene, Gaussians):
        device = open_device(options.fabric, options.engine, tell, options.mode)
        _compile(device, "3dgs", options, scene.sh_degree)
        return render_splats(scene, camera, options, progress, device)
    return _render_marched(scene, camera, options, progress, tell)


def _render_marched(
    scene: KiloNeRF | InstantNGP | TensoRF,
    camera: Camera,
    options: ArrayOptions,
    progress: Callable[[float], None] | None,
    tell: Callable[[str], None] | None,
) -> ArrayFrame:
    device, field = open_field(scene, options, tell)
    _compile(device, _METHODS[type(scene)], options)
    corners = _sampled_corners(field.march, camera, options.sample)
    image, ledger = render_blocks(
        device,
        field,
        camera,
        corners,
        options=options,
        progress=progress,
        work=Work(scene, camera, options),
    )
    share = len(corners) / len(block_corners(camera))
    stages = tuple(ledger.stages.values())
    simulated = None if options.sample == 1 else pixels_of(corners, SIDE, camera)
    seen = len(corners) - ledger.counts["empty_blocks"]
    again = batch_count(round(seen / share)) / max(batch_count(seen), 1)
    late, counts = device.programs.late, dict(ledger.counts)
    return ArrayFrame(image, stages, counts, device.clock_ghz, share, again, simulated, late)


def _compile(device: Device, method: str, options: ArrayOptions, degree: int = 0) -> None:
    """Have what a frame usually runs compiled on all cores; the rest is when it is needed."""
    if options.lookahead and options.mode == "auto":
        compile_ahead(device.programs, kernels_of(method, options.precision, degree))


def _sampled_corners(march: March, camera: Camera, share: float) -> Int32Array:
    corners = block_corners(camera)
    if share == 1:
        return corners
    return corners[sampled(expected_samples(march, camera, corners), share)]


def check_precision(precision: str, scene: Scene) -> None:
    """Refuse a format that no renderer, or not this one, supports.

    Raises
    ------
    SceneError
        No such format, or not of this method.
    """
    known = ", ".join(PRECISIONS)
    if precision not in PRECISIONS:
        raise SceneError(f"unknown format {precision!r}", loc="--precision", hint=known)
    formats = ("fp32", *_NARROW.get(type(scene), ()))
    if precision not in formats:
        raise SceneError(
            f"the array renders scenes of this method in {' or '.join(formats)} only",
            loc="--precision",
            hint="leave it out",
        )


def check_mode(mode: str, precision: RenderPrecision, scene: Scene) -> None:
    """Refuse a mode that the scene's networks do not have.

    Raises
    ------
    SceneError
        No such mode, or not of this method, or of this format.
    """
    if mode not in NETWORK_MODES:
        raise SceneError(f"unknown mode {mode!r}", loc="--mode", hint=", ".join(NETWORK_MODES))
    if mode != "auto" and not isinstance(scene, InstantNGP | TensoRF):
        raise SceneError(
            "only the networks of Instant-NGP and TensoRF have one",
            loc="--mode",
            hint="leave it out",
        )
    if mode == "gpu" and precision != "fp32":
        raise SceneError(
            f"layers of {precision} numbers run in the TPU-like modes only",
            loc="--mode",
            hint="leave it out, or --precision fp32",
        )
