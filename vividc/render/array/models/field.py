"""What the marching pipeline needs from a model: density and colour of points, computed by jobs."""

from __future__ import annotations

from abc import ABC, abstractmethod

from vividc.render.array.device.device import Device
from vividc.render.array.records import Kept, Listed, Results
from vividc.render.radiance.volume import Sampled


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
    sample_words = 6
    """Of each sample in a launch of the kernels that make points, light and the picture."""

    def __init__(self, model: Sampled, device: Device) -> None:
        self.march = model.march
        self.weight_min = model.weight_min
        self.transmittance_min = model.transmittance_min
        self._device = device

    @abstractmethod
    def densities(self, listed: Listed) -> Results:
        """Return what samples have, for a kernel that makes light of it."""

    @abstractmethod
    def colours(self, kept: Kept) -> Results:
        """Return the colours of samples, `densities` of which it returned before."""
