"""What the marching pipeline needs from a model: density and colour of points, computed by jobs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from itertools import accumulate, pairwise
from typing import Final

from vividc.render.array.device.blocks import BLOCK, batches, room_for
from vividc.render.array.device.device import Device
from vividc.render.array.device.gather import gather_rows
from vividc.render.array.records import Colours, Densities, Features, Kept, Listed
from vividc.render.arrays import Float32Array
from vividc.render.radiance.volume import Sampled

_CHANNELS: Final = 3


class ArrayField(ABC):
    """A `RadianceField` whose density and colour the array computes.

    What a sample gives does not depend on the other samples of the call: a picture is then the
    same to the last bit with and without lookahead. Fields are made of a model as read from a
    scene, for a device, with a format of the networks' operands.
    """

    most_samples = 1 << 10
    """Of a piece, at most: its launches hold what they have by sample in a scratchpad, and ten bits
    of an item say which of them it is (kernels/render/marching.py).
    """

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
    """A field that asks for points, and gives back what they have in their order, a batch after the
    other.
    """

    batch: int
    """Samples that go through the stages together; a multiple of a block's."""
    words = 0
    """Of a point's features."""
    are_in_blocks = False
    """Whether features are blocks [B, words, 16] of samples, and not rows."""

    def densities(self, listed: Listed) -> Densities:
        """Return what samples have, in their order."""
        return Densities(*self.density(listed.points()))

    def colours(self, kept: Kept) -> Colours:
        """Return the colours of samples, in their order."""
        features = kept.features()
        points, rays = kept.located()
        directions = gather_rows(self._device, "compaction", kept.directions, [rays])
        rgb = self.colour(features, points, directions)
        bounds = accumulate(kept.lengths, initial=0)
        return Colours([rgb[first:last] for first, last in pairwise(bounds)])

    def density(self, points: Float32Array) -> tuple[Float32Array, Features]:
        """Return optical thickness [n] of one step at `points` [n, 3], and features [n, words], or
        in blocks.
        """
        count = len(points)
        thickness, features = room_for(count), room_for(count, self.words)
        if self.are_in_blocks:
            features = features.reshape(len(features), self.words, BLOCK)
        for place, (blocks,) in batches(self.batch, points):
            self._density(blocks, thickness[place], features[place])
        if not self.are_in_blocks:
            features = features.reshape(len(features) * BLOCK, self.words)[:count]
        return thickness.reshape(-1)[:count], features

    def colour(
        self, features: Features, points: Float32Array, directions: Float32Array
    ) -> Float32Array:
        """Return r, g, b [n, 3] of points [n, 3], seen along unit directions [n, 3]; features are
        rows of what `density` returned.
        """
        rgb = room_for(len(points), _CHANNELS)
        for place, (rows, where, seen) in batches(self.batch, features, points, directions):
            self._colour(rows, where, seen, rgb[place])
        return rgb.reshape(-1, _CHANNELS)[: len(points)]

    @abstractmethod
    def _density(
        self, points: Float32Array, thickness: Float32Array, features: Float32Array
    ) -> None:
        """Put into [B, 16] and [B, 16, words], or [B, words, 16], what blocks of points [B, 16, 3]
        have.
        """

    @abstractmethod
    def _colour(
        self,
        features: Float32Array,
        points: Float32Array,
        directions: Float32Array,
        rgb: Float32Array,
    ) -> None:
        """Put the colours of blocks of points into [B, 16, 3]."""
