"""What the marching pipeline asks of a model: density and colour of points, computed by jobs."""

from __future__ import annotations

from typing import Protocol

from vividc.render.array.device.frame import Ledger
from vividc.render.arrays import Float32Array
from vividc.render.radiance import March


class ArrayField(Protocol):
    """A `RadianceField` whose density and colour the array computes.

    What a sample gives does not depend on the other samples of the call: a picture is then the
    same to the last bit with and without lookahead.
    """

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

    def density(self, points: Float32Array, ledger: Ledger) -> tuple[Float32Array, Float32Array]:
        """Return optical thickness [n] of one step at `points` [n, 3], and features [n, F].

        Both are C-contiguous; what features mean is the field's own affair, `colour` gets rows of
        them.

        Jobs are booked in `ledger` under the names of their stages.
        """
        ...

    def colour(
        self, points: Float32Array, features: Float32Array, directions: Float32Array, ledger: Ledger
    ) -> Float32Array:
        """Return r, g, b [n, 3] of points seen along unit `directions` [n, 3]."""
        ...
