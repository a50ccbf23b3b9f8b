"""Emission and absorption along rays, with Lookahead Culling I as a switch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from vividc.errors import demand_type
from vividc.render.arrays import Float32Array, Int64Array
from vividc.render.camera import Camera
from vividc.render.errors import SceneError
from vividc.render.radiance.layers import Layer, linear
from vividc.render.radiance.occupancy import March, occupied_samples, pixel_rays

_RAYS_AT_ONCE = 4096
_SAMPLES_AT_ONCE = 2 << 20
_ONE = np.float32(1.0)


class Sampled(Protocol):
    """How the samples of a model are taken, and which of them count."""

    @property
    def march(self) -> March:
        """How rays are sampled."""
        ...

    @property
    def weight_min(self) -> float:
        """A sample's colour counts only if its weight is above this."""
        ...

    @property
    def transmittance_min(self) -> float:
        """A sample's colour counts only if the light before it is at least this."""
        ...


class RadianceField(Sampled, Protocol):
    """A model that gives density and colour of points."""

    def density(self, points: Float32Array, layer: Layer) -> tuple[Float32Array, Float32Array]:
        """Return optical thickness [n] of one step at `points` [n, 3], and features [n, F]."""
        ...

    def colour(
        self, points: Float32Array, features: Float32Array, directions: Float32Array, layer: Layer
    ) -> Float32Array:
        """Return r, g, b [n, 3] of points seen along unit `directions` [n, 3]."""
        ...


@dataclass(frozen=True, slots=True)
class MarchCounts:
    """What a ray-marched picture cost.

    Attributes
    ----------
    rays
        Pixels.
    density_samples
        Samples in occupied cells: each runs the density network.
    colour_samples
        Samples for which the colour network ran.
    counted_samples
        Samples whose colour counts; with lookahead these are all that ran.
    """

    rays: int = 0
    density_samples: int = 0
    colour_samples: int = 0
    counted_samples: int = 0

    def __add__(self, other: MarchCounts) -> MarchCounts:
        return MarchCounts(
            self.rays + other.rays,
            self.density_samples + other.density_samples,
            self.colour_samples + other.colour_samples,
            self.counted_samples + other.counted_samples,
        )

    @property
    def avoided_colour_share(self) -> float:
        """Share of density samples whose colour network did not run."""
        return 1 - self.colour_samples / self.density_samples if self.density_samples else 0.0


def render_field(
    field: RadianceField,
    camera: Camera,
    *,
    lookahead: bool = True,
    weight_min: float = 0.0,
    layer: Layer = linear,
    progress: Callable[[float], None] | None = None,
) -> tuple[Float32Array, MarchCounts]:
    """Render a model; emission and absorption as in Max (1995), accumulated front to back.

    Parameters
    ----------
    lookahead
        Lookahead Culling I: which samples count is decided right after the density network, and
        the colour network runs on those alone. Without, it runs on every sample, and those that
        do not count are dropped after it: the picture is the same to the last bit.
    weight_min
        A sample's colour counts only if its weight is above this and above the field's own: 0.003
        leaves out a third of them.
    layer
        The linear layers of the networks.
    progress
        Called with the share of pixels that are done, 0 to 1.

    Raises
    ------
    SceneError
        There is no such weight.

    Returns
    -------
    rgbt
        [height, width, 4] float32: r, g, b without background, transmittance.
    counts
        The work that was done.
    """
    check_weight(weight_min)
    pixels = camera.width * camera.height
    rgbt = np.empty((pixels, 4), dtype=np.float32)
    counts = MarchCounts()
    at_once = max(1, min(_RAYS_AT_ONCE, _SAMPLES_AT_ONCE // field.march.samples))
    for first in range(0, pixels, at_once):
        directions = pixel_rays(camera, first, min(at_once, pixels - first))
        part, cost = render_rays(field, camera.position, directions, lookahead, layer, weight_min)
        rgbt[first : first + len(part)] = part
        counts += cost
        if progress is not None:
            progress(min(1.0, (first + at_once) / pixels))
    return rgbt.reshape(camera.height, camera.width, 4), counts


def check_weight(weight_min: float) -> None:
    """Refuse a least weight that is none.

    Raises
    ------
    SceneError
        It is not at least 0 and below 1.
    """
    demand_type(weight_min, (int, float), "the least weight", "give a number")
    if not 0 <= weight_min < 1:
        raise SceneError(
            f"a sample's weight cannot be wanted above {weight_min}",
            loc="--weight-min",
            hint="give a number from 0 to below 1",
        )


def render_rays(
    field: RadianceField,
    origin: Float32Array,
    directions: Float32Array,
    lookahead: bool = True,
    layer: Layer = linear,
    weight_min: float = 0.0,
) -> tuple[Float32Array, MarchCounts]:
    """Render rays from `origin` [3] along unit `directions` [n, 3]: r, g, b, T [n, 4], and counts.

    See `render_field`.
    """
    samples = occupied_samples(field.march, origin, directions)
    count = len(samples.ray)
    if count == 0:
        empty = np.zeros((len(directions), 4), dtype=np.float32)
        empty[:, 3] = 1
        return empty, MarchCounts(rays=len(directions))
    thickness, features = field.density(samples.points, layer)
    alpha = _ONE - np.exp(-thickness)
    before, left = _transmittance(samples.ray, alpha, len(directions))
    weight = before * alpha
    counted = (before >= np.float32(field.transmittance_min)) & (
        weight > np.float32(max(field.weight_min, weight_min))
    )
    ran = np.flatnonzero(counted) if lookahead else np.arange(count)
    colour = np.zeros((count, 3), dtype=np.float32)
    if len(ran):
        colour[ran] = field.colour(
            samples.points[ran], features[ran], directions[samples.ray[ran]], layer
        )
    weight = np.where(counted, weight, np.float32(0))
    rgb = _sum_by_ray(samples.ray, weight[:, None] * colour, len(directions))
    cost = MarchCounts(len(directions), count, len(ran), int(counted.sum()))
    return np.concatenate((rgb, left[:, None]), axis=1), cost


def _ranks(ray: Int64Array, rays: int) -> tuple[Int64Array, Int64Array]:
    """Return the first sample of each ray, and how many it has, [rays] each."""
    counts = np.bincount(ray, minlength=rays).astype(np.int64)
    return np.cumsum(counts) - counts, counts


def _transmittance(
    ray: Int64Array, alpha: Float32Array, rays: int
) -> tuple[Float32Array, Float32Array]:
    """Return the transmittance before each sample [n], and behind the last of each ray [rays].

    The products are taken in the order of the samples, all rays at once.
    """
    first, counts = _ranks(ray, rays)
    before = np.empty_like(alpha)
    left = np.ones(rays, dtype=np.float32)
    for rank in range(int(counts.max())):
        active: npt.NDArray[np.intp] = np.flatnonzero(counts > rank)
        sample = first[active] + rank
        before[sample] = left[active]
        left[active] = left[active] * (_ONE - alpha[sample])
    return before, left


def _sum_by_ray(ray: Int64Array, values: Float32Array, rays: int) -> Float32Array:
    """Return the sums [rays, 3] of `values` [n, 3], added in the order of the samples."""
    first, counts = _ranks(ray, rays)
    total = np.zeros((rays, values.shape[1]), dtype=np.float32)
    for rank in range(int(counts.max())):
        active = np.flatnonzero(counts > rank)
        total[active] += values[first[active] + rank]
    return total
