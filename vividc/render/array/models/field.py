"""What the marching pipeline needs from a model: density and colour of points, computed by jobs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from itertools import accumulate, pairwise

from vividc.render.array.device.device import Device
from vividc.render.array.records import Colours, Densities, Features, Kept, Listed
from vividc.render.arrays import Float32Array, Int32Array
from vividc.render.radiance.volume import Sampled


class ArrayField(ABC):
    """A `RadianceField` whose density and colour the array computes.

    What a sample gives does not depend on the other samples of the call: a picture is then the
    same to the last bit with and without lookahead.
    """

    most_samples = 1 << 10
    """Of a piece: its launches hold what they have by sample in a scratchpad."""

    def __init__(self, model: Sampled, device: Device) -> None:
        self.march = model.march
        self.weight_min = model.weight_min
        self.transmittance_min = model.transmittance_min
        self._device = device

    @abstractmethod
    def densities(self, listed: Listed) -> Densities:
        """Return what samples have."""

    @abstractmethod
    def colours(self, kept: Kept) -> Colours:
        """Return the colours of samples, `densities` of which it returned before."""


class PointField(ArrayField):
    """A field that asks for points and their rays, and gives back what they have in their order."""

    def densities(self, listed: Listed) -> Densities:
        """Return what samples have, in their order."""
        return Densities(*self.density(listed.points()))

    def colours(self, kept: Kept) -> Colours:
        """Return the colours of samples, in their order."""
        features = kept.features()
        rgb = self.colour(features, *kept.located(), kept.directions)
        bounds = accumulate(kept.lengths, initial=0)
        return Colours([rgb[first:last] for first, last in pairwise(bounds)])

    @abstractmethod
    def density(self, points: Float32Array) -> tuple[Float32Array, Features]:
        """Return optical thickness [n] of one step at `points` [n, 3], and features [n, F]."""

    @abstractmethod
    def colour(
        self, features: Features, points: Float32Array, rays: Int32Array, directions: Float32Array
    ) -> Float32Array:
        """Return r, g, b [n, 3] of points [n, 3], seen along the unit direction of their rays.

        Parameters
        ----------
        features
            [n, F] rows of what `density` returned.
        rays
            [n] rows of `directions`; those of points in a row lie near each other.
        directions
            [R, 3] of rays, (0, 0, 0) outside the picture.
        """
