"""What the marching pipeline needs from a model: density and colour of points, computed by jobs."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from vividc.render.array.device.frame import Ledger
from vividc.render.array.pieces import Piece, Rays, Survivors
from vividc.render.arrays import Float32Array, Int32Array
from vividc.render.radiance.volume import Sampled

Features: TypeAlias = npt.NDArray[np.float32 | np.uint32]
"""Words of four bytes: numbers, or what the field packs into them."""
UInt32Array: TypeAlias = npt.NDArray[np.uint32]


class Listed(Protocol):
    """The samples whose density is wanted, in pieces; jobs make what is asked for of them."""

    @property
    def geometry(self) -> Float32Array:
        """The table that kernels/render/marching.py calls so."""
        ...

    @property
    def rays(self) -> Rays:
        """Of the batch."""
        ...

    @property
    def pieces(self) -> Sequence[Piece]:
        """Which they are."""
        ...

    def points(self) -> Float32Array:
        """Return their places [n, 3]."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Densities:
    """What samples have.

    Attributes
    ----------
    thickness, features
        [n] optical thickness of one step, and [n, F]; both are C-contiguous. What features mean is
        the field's own affair, `Kept.features` gives rows of them.
    places
        [n] where each sample's are, counted from its piece's first; None: in the samples' order.
    """

    thickness: Float32Array
    features: Features
    places: Int32Array | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Colours:
    """r, g, b [n, 3] of each piece's samples, and `places` as of `Densities`."""

    of_pieces: Sequence[Float32Array]
    places: Int32Array | None = None


class Kept(Protocol):
    """The samples whose colour is wanted, in pieces; jobs make what is asked for of them."""

    @property
    def pieces(self) -> Sequence[Survivors]:
        """Which they are."""
        ...

    @property
    def directions(self) -> Float32Array:
        """Unit directions [R, 3] of all rays, (0, 0, 0) outside the picture."""
        ...

    @property
    def lengths(self) -> list[int]:
        """How many samples each piece has."""
        ...

    def points(self) -> tuple[Float32Array, Int32Array]:
        """Return their places [n, 3] and rays [n]; those in a row lie near each other."""
        ...

    def features(self) -> Features:
        """Return their features [n, F], as `densities` returned them."""
        ...

    def in_blocks(self, kernel: str, of_rays: UInt32Array, words: int) -> UInt32Array:
        """Return what a kernel makes of words [R, 4] of their rays and of their features,
        [B, words, 16] uint32: of each piece as many blocks as it takes, and the last one filled up
        with its last sample.

        Parameters
        ----------
        kernel
            Gets `rows`, [m, F] features as words of all samples of a piece, `of_rays`, [64, 4] of
            its rays, `items`, as in kernels/render/marching.py, and `out`.
        """
        ...


class ArrayField(Sampled, Protocol):
    """A `RadianceField` whose density and colour the array computes.

    What a sample gives does not depend on the other samples of the call: a picture is then the
    same to the last bit with and without lookahead.
    """

    most_samples: int
    """Of a piece: its launches hold what they have by sample in a scratchpad."""

    def densities(self, listed: Listed, ledger: Ledger) -> Densities:
        """Return what samples have.

        Jobs are booked in `ledger` under the names of their stages.
        """
        ...

    def colours(self, kept: Kept, ledger: Ledger) -> Colours:
        """Return the colours of samples, `densities` of which it returned before."""
        ...


class ModelField:
    """What an `ArrayField` takes from its model as it is."""

    most_samples = 1 << 10

    def __init__(self, model: Sampled) -> None:
        self.march = model.march
        self.weight_min = model.weight_min
        self.transmittance_min = model.transmittance_min


class PointField(ModelField):
    """A field that asks for points and their rays, and gives back what they have in their order."""

    def densities(self, listed: Listed, ledger: Ledger) -> Densities:
        """Return what samples have, in their order."""
        return Densities(*self.density(listed.points(), ledger))

    def colours(self, kept: Kept, ledger: Ledger) -> Colours:
        """Return the colours of samples, in their order."""
        features = kept.features()
        points, rays = kept.points()
        rgb = self.colour(points, features, rays, kept.directions, ledger)
        bounds = accumulate(kept.lengths, initial=0)
        return Colours([rgb[first:last] for first, last in pairwise(bounds)])

    @abstractmethod
    def density(self, points: Float32Array, ledger: Ledger) -> tuple[Float32Array, Features]:
        """Return optical thickness [n] of one step at `points` [n, 3], and features [n, F]."""

    @abstractmethod
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
