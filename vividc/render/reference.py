"""The float32 reference of all four methods behind one call."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass

import numpy as np

from vividc.errors import demand_callable, demand_type
from vividc.host.watch import to_tell
from vividc.render.arrays import Float32Array
from vividc.render.camera import Camera
from vividc.render.errors import SceneError
from vividc.render.ply import Gaussians
from vividc.render.radiance import Layer, RadianceField, linear, render_field
from vividc.render.scenes import Scene, demand_scene
from vividc.render.splat.blend_reference import EXACT, BlendOptions, blend_image, over_background
from vividc.render.splat.splat import tile_lists


@dataclass(frozen=True, slots=True)
class ReferenceOptions:
    """Switches of the reference renderers.

    Attributes
    ----------
    lookahead
        Lookahead Culling: I for ray-marched models, II for Gaussians.
    blend
        Of the Gaussians' blending; its `lookahead` is overridden by the one above.
    layer
        The linear layers of the ray-marched models' networks.
    weight_min
        Of ray-marched models: a sample's colour counts only if its weight is above this, too.
    """

    lookahead: bool = True
    blend: BlendOptions = EXACT
    layer: Layer = linear
    weight_min: float = 0.0


DEFAULT = ReferenceOptions()


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """A rendered picture and what it cost.

    Attributes
    ----------
    image
        [height, width, 3] float32 over white, not clipped.
    counts
        Work by name: what was computed, and how much of it counted.
    seconds
        Wall time of rendering, without loading.
    """

    image: Float32Array
    counts: dict[str, int]
    seconds: float


def render_reference(
    scene: Scene,
    camera: Camera,
    options: ReferenceOptions = DEFAULT,
    progress: Callable[[float], None] | None = None,
) -> Picture:
    """Render a scene in float32 numpy; `progress` gets the share of pixels done, 0 to 1.

    Raises
    ------
    SceneError
        Values of the scene are so large that pixels are not finite, or an option is out of its
        range.
    """
    demand_scene(scene)
    demand_type(camera, Camera, "the camera", "give a Camera, as orbit_camera makes one")
    demand_type(options, ReferenceOptions, "the options", "give ReferenceOptions(...)")
    demand_callable(progress, "progress")
    progress = to_tell(progress)
    start = time.perf_counter()
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):  # told of at the end
        if isinstance(scene, Gaussians):
            rgbt, counts = _render_gaussians(scene, camera, options, progress)
        else:
            rgbt, counts = _render_marched(scene, camera, options, progress)
        image = over_background(rgbt)
    odd = int(np.count_nonzero(~np.isfinite(image).all(axis=2)))
    if odd:
        raise SceneError(
            f"{odd} of {camera.width * camera.height} pixels are not finite: values of the scene "
            "or the camera leave the range of float32",
            hint="the training diverged, or a file is damaged",
        )
    return Picture(image, counts, time.perf_counter() - start)


def _render_gaussians(
    scene: Gaussians,
    camera: Camera,
    options: ReferenceOptions,
    progress: Callable[[float], None] | None,
) -> tuple[Float32Array, dict[str, int]]:
    lists = tile_lists(scene, camera)
    given = options.blend
    switches = BlendOptions(options.lookahead, given.margin, given.exponential)
    blended = blend_image(lists, options=switches, progress=progress)
    counts = {
        "gaussians": len(scene),
        "visible_gaussians": len(lists.splats),
        "list_entries": len(lists.order),
        "evaluated": int(blended.evaluated.sum()),
        "exponentials": int(blended.exponentials.sum()),
        "blended": int(blended.blended.sum()),
    }
    return blended.rgbt, counts


def _render_marched(
    scene: RadianceField,
    camera: Camera,
    options: ReferenceOptions,
    progress: Callable[[float], None] | None,
) -> tuple[Float32Array, dict[str, int]]:
    rgbt, counts = render_field(
        *(scene, camera),
        lookahead=options.lookahead,
        weight_min=options.weight_min,
        layer=options.layer,
        progress=progress,
    )
    return rgbt, asdict(counts)
