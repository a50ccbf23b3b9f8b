"""Instant-NGP: a multiresolution hash encoding and two small networks (Müller et al. 2022)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vividc.render.archive import Archive
from vividc.render.arrays import Float32Array, Int64Array, frozen_float32
from vividc.render.radiance.layers import Layer, in_blocks, relu, sigmoid
from vividc.render.radiance.occupancy import March, read_march
from vividc.render.splat.spherical_harmonics import sh_basis

_PRIMES = np.array([1, 2654435761, 805459861], dtype=np.uint32)
_CORNERS = np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)], dtype=np.int64)
_HALF = np.float32(0.5)
_ONE = np.float32(1.0)
DIRECTION_TERMS = 16
"""Spherical harmonics of degree 0 to 3 of the direction."""


@dataclass(frozen=True, slots=True, eq=False)
class Level:
    """One grid of the encoding: `table` [entries, F], nodes a `scale`, `dense` or hashed."""

    table: Float32Array
    scale: np.float32
    resolution: int
    dense: bool


@dataclass(frozen=True, slots=True, eq=False)
class InstantNGP:
    """A hash-encoded field; weights are input-major, [inputs, outputs].

    Attributes
    ----------
    march
        How rays are sampled.
    levels
        The grids of the encoding, coarse to fine.
    cube_low, cube_side
        The cube the grids cover: its lowest corner [3] and its side, world units.
    density_weights, colour_weights
        Of the layers of the two networks.
    exponent_max
        The density is exp of the first feature, clamped to this.
    transmittance_min
        A sample's colour counts while the light before it is at least this.
    """

    march: March
    levels: tuple[Level, ...]
    cube_low: Float32Array
    cube_side: float
    density_weights: tuple[Float32Array, ...]
    colour_weights: tuple[Float32Array, ...]
    exponent_max: float
    transmittance_min: float
    weight_min: float = 0.0

    def density(self, points: Float32Array, layer: Layer) -> tuple[Float32Array, Float32Array]:
        """Return optical thickness [n] of one step, and the density network's outputs."""

        def of_block(points: Float32Array) -> tuple[Float32Array, Float32Array]:
            values = relu(layer("sigma0", self.encode(points), self.density_weights[0], None))
            features = layer("sigma1", values, self.density_weights[1], None)
            sigma = np.exp(np.minimum(features[:, 0], np.float32(self.exponent_max)))
            return sigma * np.float32(self.march.step), features

        thickness, features = in_blocks(of_block, points)
        return thickness, features

    def colour(
        self, points: Float32Array, features: Float32Array, directions: Float32Array, layer: Layer
    ) -> Float32Array:
        """Return r, g, b [n, 3] of features seen along unit `directions` [n, 3]."""

        def of_block(features: Float32Array, directions: Float32Array) -> tuple[Float32Array]:
            values = np.concatenate((features, sh_basis(directions, DIRECTION_TERMS)), axis=1)
            for index in (0, 1):
                values = relu(layer(f"rgb{index}", values, self.colour_weights[index], None))
            return (sigmoid(layer("rgb2", values, self.colour_weights[2], None)),)

        return in_blocks(of_block, features, directions)[0]

    def encode(self, points: Float32Array) -> Float32Array:
        """Return the encoding [n, levels * F] of points [n, 3], level by level."""
        place = (points - self.cube_low) / np.float32(self.cube_side)
        return np.concatenate([_interpolate(level, place) for level in self.levels], axis=1)


def read_instant_ngp(archive: Archive) -> InstantNGP:
    """Read the layout `table`, `level_*`, `sigma0`, ..., `rgb2` (see docs/rendering.md).

    Raises
    ------
    SceneError
        An array is missing, of another shape, or not finite.
    """
    levels = _levels(archive)
    encoded = sum(level.table.shape[1] for level in levels)
    hidden = archive.floats("sigma0", (None, encoded)).shape[0]
    features = archive.floats("sigma1", (None, hidden)).shape[0]
    inputs = features + DIRECTION_TERMS
    width = archive.floats("rgb0", (None, inputs)).shape[0]
    shapes = {"rgb0": (width, inputs), "rgb1": (width, width), "rgb2": (3, width)}
    return InstantNGP(
        march=read_march(archive),
        levels=levels,
        cube_low=archive.floats("cube_lo", (3,)),
        cube_side=archive.number("cube_side", above=0),
        density_weights=tuple(
            frozen_float32(archive.floats(name, (None, None)).T) for name in ("sigma0", "sigma1")
        ),
        colour_weights=tuple(
            frozen_float32(archive.floats(name, shape).T) for name, shape in shapes.items()
        ),
        exponent_max=archive.number("sigma_clamp"),
        transmittance_min=archive.number("t_stop"),
    )


def _levels(archive: Archive) -> tuple[Level, ...]:
    table = archive.floats("table", (None, None))
    scales = archive.floats("level_scale", (None,))
    count = (len(scales),)
    offsets = archive.integers("level_offset", count)
    entries = archive.integers("level_entries", count)
    resolutions = archive.integers("level_res", count)
    dense = archive.integers("level_dense", count)
    if (offsets < 0).any() or (entries < 1).any() or (offsets + entries > len(table)).any():
        raise archive.error(f"level_offset and level_entries leave the {len(table)} table rows")
    hashed = entries[dense == 0]
    if (hashed & (hashed - 1)).any():
        raise archive.error("level_entries of a hashed level is no power of two")
    return tuple(
        Level(table[start : start + size], np.float32(scale), int(resolution), bool(is_dense))
        for start, size, scale, resolution, is_dense in zip(
            offsets, entries, scales, resolutions, dense, strict=True
        )
    )


def _interpolate(level: Level, place: Float32Array) -> Float32Array:
    """Return the trilinear interpolation [n, F] of a level at `place` [n, 3] in the cube."""
    scaled = place * level.scale + _HALF
    low = np.floor(scaled)
    share = scaled - low
    total = np.zeros((len(place), level.table.shape[1]), dtype=np.float32)
    for corner in _CORNERS:
        weights = np.where(corner == 1, share, _ONE - share)
        weight = weights[:, 0] * weights[:, 1] * weights[:, 2]
        index = _index(level, low.astype(np.int64) + corner)
        total += weight[:, None] * level.table[index]
    return total


def _index(level: Level, node: Int64Array) -> Int64Array:
    """Return the table row of each node [n, 3]."""
    rows: Int64Array
    entries = len(level.table)
    if level.dense:
        rows = node @ np.array([1, level.resolution, level.resolution**2]) % entries
        return rows
    mixed = node.astype(np.uint32) * _PRIMES
    hashed = mixed[:, 0] ^ mixed[:, 1] ^ mixed[:, 2]
    rows = (hashed & np.uint32(entries - 1)).astype(np.int64)
    return rows
