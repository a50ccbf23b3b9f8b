"""KiloNeRF: a grid of tiny networks (Reiser et al. 2021)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vividc.render.archive import Archive
from vividc.render.arrays import Float32Array, Int64Array
from vividc.render.radiance.layers import Layer, relu, sigmoid
from vividc.render.radiance.occupancy import March, in_box, read_march

POSITION_FREQUENCIES = 10
DIRECTION_FREQUENCIES = 4
_POSITION_TERMS = 3 + 6 * POSITION_FREQUENCIES
_DIRECTION_TERMS = 3 + 6 * DIRECTION_FREQUENCIES
_GROUP = 32
"""Samples of one network that are multiplied at once; groups are padded to this length."""
_GROUPS_AT_ONCE = 128
_Network = Callable[[Int64Array, Float32Array, Layer], Float32Array]
"""One half of a network: (network of each group [G], inputs [G, n, i], layer) to [G, n, o]."""


@dataclass(frozen=True, slots=True, eq=False)
class KiloNeRF:
    """K networks of 6,212 parameters each, in the cells of a grid.

    Attributes
    ----------
    march
        How rays are sampled.
    network
        [X, Y, Z] int64 network of each cell of the box, or -1 where it is empty.
    weights, biases
        Of the five layers of all networks: [K, inputs, outputs] and [K, outputs].
    transmittance_min
        A sample's colour counts while the light before it is at least this.
    """

    march: March
    network: Int64Array
    weights: tuple[Float32Array, ...]
    biases: tuple[Float32Array, ...]
    transmittance_min: float
    weight_min: float = 0.0

    def density(self, points: Float32Array, layer: Layer) -> tuple[Float32Array, Float32Array]:
        """Return optical thickness [n] of one step, and the features [n, 32] of the colour."""
        network, local = self.cells_of(points)
        encoded = positional_encoding(local, POSITION_FREQUENCIES)
        outputs = _by_network(network, encoded, self._density_network, layer)
        sigma = relu(outputs[:, 0])
        return sigma * np.float32(self.march.step), outputs[:, 1:]

    def colour(
        self, points: Float32Array, features: Float32Array, directions: Float32Array, layer: Layer
    ) -> Float32Array:
        """Return r, g, b [n, 3] of points seen along unit `directions` [n, 3]."""
        network, _ = self.cells_of(points)
        seen = positional_encoding(directions, DIRECTION_FREQUENCIES)
        inputs = np.concatenate((features, seen), axis=1)
        return sigmoid(_by_network(network, inputs, self._colour_network, layer))

    def cells_of(self, points: Float32Array) -> tuple[Int64Array, Float32Array]:
        """Return the network of each point, and its place in that network's cell, -1 to 1."""
        shape = np.array(self.network.shape)
        scaled = in_box(self.march.box, points) * shape.astype(np.float32)
        cell = np.clip(np.floor(scaled).astype(np.int64), 0, shape - 1)
        local = (scaled - cell.astype(np.float32)) * np.float32(2) - np.float32(1)
        return self.network[tuple(cell.T)], local

    def _density_network(
        self, networks: Int64Array, inputs: Float32Array, layer: Layer
    ) -> Float32Array:
        values = inputs
        for index in (0, 1):
            values = relu(self._layer(index, networks, values, layer))
        return self._layer(2, networks, values, layer)

    def _colour_network(
        self, networks: Int64Array, inputs: Float32Array, layer: Layer
    ) -> Float32Array:
        return self._layer(4, networks, relu(self._layer(3, networks, inputs, layer)), layer)

    def _layer(
        self, index: int, networks: Int64Array, inputs: Float32Array, layer: Layer
    ) -> Float32Array:
        weights, bias = self.weights[index][networks], self.biases[index][networks]
        return layer(f"w{index + 1}", inputs, weights, bias[:, None, :])


def read_kilonerf(archive: Archive) -> KiloNeRF:
    """Read the layout `net_index`, `w1`, `b1`, ..., `b5` (see docs/rendering.md).

    Raises
    ------
    SceneError
        An array is missing, of another shape, or not finite.
    """
    network = archive.integers("net_index", (None, None, None))
    weights, biases = [], []
    hidden = archive.floats("w2", (None, None, None)).shape[2]
    shapes = (
        (_POSITION_TERMS, hidden),
        (hidden, hidden),
        (hidden, hidden + 1),
        (hidden + _DIRECTION_TERMS, hidden),
        (hidden, 3),
    )
    count = len(archive.floats("w1", (None, None, None)))
    for index, (inputs, outputs) in enumerate(shapes, start=1):
        weights.append(archive.floats(f"w{index}", (count, inputs, outputs)))
        biases.append(archive.floats(f"b{index}", (count, outputs)))
    if network.size == 0 or network.min() < -1 or network.max() >= count:
        raise archive.error(f"net_index names networks outside the {count} there are")
    return KiloNeRF(
        march=read_march(archive),
        network=network,
        weights=tuple(weights),
        biases=tuple(biases),
        transmittance_min=archive.number("t_stop"),
    )


def positional_encoding(values: Float32Array, frequencies: int) -> Float32Array:
    """Return [x, sin x, cos x, sin 2x, cos 2x, ...] of [n, 3], [n, 3 + 6 frequencies]."""
    parts = [values]
    for power in range(frequencies):
        scaled = values * np.float32(2**power)
        parts += [np.sin(scaled), np.cos(scaled)]
    return np.concatenate(parts, axis=1)


def _by_network(
    network: Int64Array, inputs: Float32Array, apply: _Network, layer: Layer
) -> Float32Array:
    """Run each row of `inputs` [n, i] through its network; rows without one (-1) give 0.

    Rows of one network are put into groups of equal, padded length, so that a row's result does
    not depend on how many there are.
    """
    order = np.argsort(network, kind="stable")
    order = order[network[order] >= 0]
    used, counts = np.unique(network[order], return_counts=True)
    groups = -(-counts // _GROUP)
    first_slot = np.cumsum(groups * _GROUP) - groups * _GROUP
    rank = np.arange(len(order)) - np.repeat(np.cumsum(counts) - counts, counts)
    slot = np.repeat(first_slot, counts) + rank
    padded = np.zeros((int(groups.sum()) * _GROUP, inputs.shape[1]), dtype=np.float32)
    padded[slot] = inputs[order]
    outputs = _in_groups(
        np.repeat(used, groups), padded.reshape(-1, _GROUP, inputs.shape[1]), apply, layer
    )
    result = np.zeros((len(inputs), outputs.shape[2]), dtype=np.float32)
    result[order] = outputs.reshape(-1, outputs.shape[2])[slot]
    return result


def _in_groups(
    network: npt.NDArray[np.int64], grouped: Float32Array, apply: _Network, layer: Layer
) -> Float32Array:
    parts = [
        apply(
            network[start : start + _GROUPS_AT_ONCE],
            grouped[start : start + _GROUPS_AT_ONCE],
            layer,
        )
        for start in range(0, max(len(grouped), 1), _GROUPS_AT_ONCE)
    ]
    return np.concatenate(parts)
