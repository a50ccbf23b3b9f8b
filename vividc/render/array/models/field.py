"""What the marching pipeline needs from a model: density and colour of points, computed by jobs."""

from __future__ import annotations

from typing import Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from vividc.render.array.device.frame import Ledger
from vividc.render.arrays import Float32Array, Int32Array
from vividc.render.radiance.volume import Sampled

Features: TypeAlias = npt.NDArray[np.float32 | np.uint32]
"""Words of four bytes: numbers, or what the field packs into them."""


class ArrayField(Sampled, Protocol):
    """A `RadianceField` whose density and colour the array computes.

    What a sample gives does not depend on the other samples of the call: a picture is then the
    same to the last bit with and without lookahead.
    """

    def density(self, points: Float32Array, ledger: Ledger) -> tuple[Float32Array, Features]:
        """Return optical thickness [n] of one step at `points` [n, 3], and features [n, F].

        Both are C-contiguous; what features mean is the field's own affair, `colour` gets rows of
        them.

        Jobs are booked in `ledger` under the names of their stages.
        """
        ...

    def colour(
        self,
        points: Float32Array,
        features: Features,
        rays: Int32Array,
        directions: Float32Array,
        ledger: Ledger,
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
        ...


class ModelField:
    """What an `ArrayField` takes from its model as it is."""

    def __init__(self, model: Sampled) -> None:
        self.march = model.march
        self.weight_min = model.weight_min
        self.transmittance_min = model.transmittance_min
