"""TensoRF: a radiance field as sums of plane and line factors (Chen et al. 2022, VM-192)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vividc.render.archive import Archive
from vividc.render.arrays import Float32Array, frozen_float32
from vividc.render.radiance.layers import Layer, in_blocks, relu, sigmoid
from vividc.render.radiance.occupancy import March, in_box, read_march

PLANE_AXES = ((0, 1), (0, 2), (1, 2))
"""Axes along the columns and the rows of plane k."""
LINE_AXES = (2, 1, 0)
_FEATURES = 27
_FREQUENCIES = np.array([1.0, 2.0], dtype=np.float32)
_INPUTS = 150
"""27 features and a direction, and sine and cosine of both at two frequencies."""


@dataclass(frozen=True, slots=True, eq=False)
class Factors:
    """One plane and one line: [rows, columns, C] and [nodes, C] float32, channels last."""

    plane: Float32Array
    line: Float32Array


@dataclass(frozen=True, slots=True, eq=False)
class TensoRF:
    """A VM-decomposed field; weights are input-major, [inputs, outputs].

    Attributes
    ----------
    march
        How rays are sampled.
    density_factors, appearance_factors
        Three plane-line pairs each.
    basis
        [144, 27]: products of appearance factors to features.
    weights, biases
        Of the colour network's three layers.
    density_shift
        Added before the softplus.
    distance_scale
        Density times step times this is the optical thickness.
    weight_min
        Colour is computed for samples of greater weight only.
    """

    march: March
    density_factors: tuple[Factors, ...]
    appearance_factors: tuple[Factors, ...]
    basis: Float32Array
    weights: tuple[Float32Array, ...]
    biases: tuple[Float32Array, ...]
    density_shift: float
    distance_scale: float
    weight_min: float
    transmittance_min: float = 0.0

    def density(self, points: Float32Array, layer: Layer) -> tuple[Float32Array, Float32Array]:
        """Return optical thickness [n] of one step, and no features, [n, 0]."""
        (thickness,) = in_blocks(self._thickness, points)
        return thickness, np.zeros((len(points), 0), dtype=np.float32)

    def colour(
        self, points: Float32Array, features: Float32Array, directions: Float32Array, layer: Layer
    ) -> Float32Array:
        """Return r, g, b [n, 3] of points seen along unit `directions` [n, 3]."""

        def of_block(points: Float32Array, directions: Float32Array) -> tuple[Float32Array]:
            return (self._colour(points, directions, layer),)

        return in_blocks(of_block, points, directions)[0]

    def _thickness(self, points: Float32Array) -> tuple[Float32Array]:
        place = in_box(self.march.box, points)
        total = np.zeros(len(points), dtype=np.float32)
        for product in _products(self.density_factors, place):
            total += product.sum(axis=1)
        sigma = np.logaddexp(np.float32(0), total + np.float32(self.density_shift))
        return (sigma * np.float32(self.march.step * self.distance_scale),)

    def _colour(self, points: Float32Array, directions: Float32Array, layer: Layer) -> Float32Array:
        place = in_box(self.march.box, points)
        products = np.concatenate(_products(self.appearance_factors, place), axis=1)
        features = layer("basis", products, self.basis, None)
        values = np.concatenate(
            (features, directions, *_waves(features), *_waves(directions)), axis=1
        )
        for index in (0, 1):
            name = f"mlp{index}"
            values = relu(layer(name, values, self.weights[index], self.biases[index]))
        return sigmoid(layer("mlp2", values, self.weights[2], self.biases[2]))


def read_tensorf(archive: Archive) -> TensoRF:
    """Read the layout `density_plane_0`, ..., `mlp_b2` (see docs/rendering.md).

    Raises
    ------
    SceneError
        An array is missing, of another shape, or not finite.
    """
    resolution = [int(nodes) for nodes in archive.integers("grid_res", (3,))]
    if min(resolution) <= 1:
        raise archive.error(f"grid_res {resolution} has fewer than two nodes along an axis")
    hidden = archive.floats("mlp_w1", (None, None)).shape[0]
    shapes = ((hidden, _INPUTS), (hidden, hidden), (3, hidden))
    weights = [archive.floats(f"mlp_w{i}", shape) for i, shape in enumerate(shapes)]
    biases = [archive.floats(f"mlp_b{i}", (shape[0],)) for i, shape in enumerate(shapes)]
    appearance = _factors(archive, "app", resolution)
    channels = sum(pair.line.shape[1] for pair in appearance)
    return TensoRF(
        march=read_march(archive),
        density_factors=_factors(archive, "density", resolution),
        appearance_factors=appearance,
        basis=frozen_float32(archive.floats("basis_w", (_FEATURES, channels)).T),
        weights=tuple(frozen_float32(weight.T) for weight in weights),
        biases=tuple(biases),
        density_shift=archive.number("density_shift"),
        distance_scale=archive.number("distance_scale", above=0),
        weight_min=archive.number("weight_thres"),
    )


def _factors(archive: Archive, kind: str, resolution: Sequence[int]) -> tuple[Factors, ...]:
    pairs = []
    for k, ((column_axis, row_axis), line_axis) in enumerate(
        zip(PLANE_AXES, LINE_AXES, strict=True)
    ):
        shape = (None, resolution[row_axis], resolution[column_axis])
        plane = archive.floats(f"{kind}_plane_{k}", shape)
        line = archive.floats(f"{kind}_line_{k}", (len(plane), resolution[line_axis]))
        pairs.append(Factors(frozen_float32(plane.transpose(1, 2, 0)), frozen_float32(line.T)))
    return tuple(pairs)


def _products(factors: tuple[Factors, ...], place: Float32Array) -> list[Float32Array]:
    """Return plane times line at `place` [n, 3] in 0..1, [n, C] for each pair."""
    products = []
    for pair, (column_axis, row_axis), line_axis in zip(
        factors, PLANE_AXES, LINE_AXES, strict=True
    ):
        row, down = _node(place[:, row_axis], pair.plane.shape[0])
        column, right = _node(place[:, column_axis], pair.plane.shape[1])
        above = _mix(pair.plane[row, column], pair.plane[row, column + 1], right)
        below = _mix(pair.plane[row + 1, column], pair.plane[row + 1, column + 1], right)
        node, along = _node(place[:, line_axis], len(pair.line))
        products.append(
            _mix(above, below, down) * _mix(pair.line[node], pair.line[node + 1], along)
        )
    return products


def _node(
    coordinate: Float32Array, nodes: int
) -> tuple[np.ndarray[tuple[int], np.dtype[np.intp]], Float32Array]:
    """Return the node below each coordinate (0 to 1 over all nodes), and the way to the next."""
    scaled = coordinate * np.float32(nodes - 1)
    node = np.clip(np.floor(scaled).astype(np.intp), 0, nodes - 2)
    return node, scaled - node.astype(np.float32)


def _mix(low: Float32Array, high: Float32Array, share: Float32Array) -> Float32Array:
    return low + (high - low) * share[:, None]


def _waves(values: Float32Array) -> tuple[Float32Array, Float32Array]:
    """Return sine and cosine [n, 2 C]: both frequencies of channel 0, then of channel 1, ..."""
    scaled = (values[:, :, None] * _FREQUENCIES).reshape(len(values), -1)
    return np.sin(scaled), np.cos(scaled)
