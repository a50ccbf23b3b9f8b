"""KiloNeRF's networks with weights that are rounded for the samples of each network's own cells."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Final

import numpy as np

from vividc.formats import E4M3
from vividc.render.array.network.calibration import STEPS
from vividc.render.array.network.fitting import Exponents, fitted, rounded
from vividc.render.arrays import Float32Array
from vividc.render.radiance import KiloNeRF
from vividc.render.radiance.kilonerf import (
    DIRECTION_FREQUENCIES,
    POSITION_FREQUENCIES,
    positional_encoding,
)
from vividc.render.radiance.layers import linear, relu

_SAMPLES: Final = 1024
"""Of a network."""
AT_ONCE: Final = 64
"""Networks: what is made of their samples takes 100 MB."""
_TURN: Final = 619
"""From a sample's direction to the next one's, along all."""
_ZERO: Final = np.int64(0)


@dataclass(frozen=True, slots=True, eq=False)
class Scales:
    """Exponents [K] of the powers of two that results are multiplied by: of layers 1 and 2, of the
    features, of layer 4, of the density and of the colour.
    """

    one: Exponents
    two: Exponents
    features: Exponents
    four: Exponents
    density: Exponents
    colour: Exponents


def fitted_networks(
    model: KiloNeRF, scales: Scales
) -> tuple[list[Float32Array], list[Float32Array]]:
    """Return weights [K, inputs, outputs] and biases [K, outputs] of the five layers: weights are
    numbers that E4M3 has when they are multiplied by the power of two between their inputs' scale
    and their results'.

    A network is fitted to 1,024 samples in those cells of the occupancy that are its own, spread
    evenly, and seen from all sides; one without any keeps to all of its cell.
    """
    parts = []
    for first in range(0, len(model.weights[0]), AT_ONCE):
        part = slice(first, first + AT_ONCE)
        own = Scales(*(getattr(scales, field.name)[part] for field in fields(scales)))
        parts.append(_Fit(model, part, own).layers())
    layers = [
        [np.concatenate(arrays) for arrays in zip(*same, strict=True)]
        for same in zip(*parts, strict=True)
    ]
    return [weights for weights, _ in layers], [biases for _, biases in layers]


class _Fit:
    """Some networks, layer by layer: each sees what the fitted ones before it make."""

    def __init__(self, model: KiloNeRF, part: slice, scales: Scales) -> None:
        self._weights = [weights[part] for weights in model.weights]
        self._biases = [biases[part, None] for biases in model.biases]
        self._scales = scales
        self._width = model.weights[1].shape[1]
        places = _places(model, part)
        encoded = positional_encoding(places.reshape(-1, 3), POSITION_FREQUENCIES)
        self._position = encoded.reshape(*places.shape[:2], -1)
        order = np.arange(_SAMPLES) * _TURN % _SAMPLES
        seen = positional_encoding(directions(_SAMPLES)[order], DIRECTION_FREQUENCIES)
        self._seen = np.broadcast_to(seen, (len(places), *seen.shape))

    def layers(self) -> list[tuple[Float32Array, Float32Array]]:
        """Return weights and biases of each layer."""
        exact = made = self._position
        done = []
        for index in range(len(self._weights)):
            if index == 3:  # noqa: PLR2004 - the colour's half: features, which come behind density
                exact = np.concatenate((exact[..., 1:], self._seen), axis=2)
                made = np.concatenate((made[..., 1:], self._seen), axis=2)
            elif index:
                exact, made = relu(exact), relu(made)
            given = self._rounded(index, made)
            exact = linear("", exact, self._weights[index], self._biases[index])
            weights = self._weights[index]
            layer = fitted(E4M3, given, exact, weights, self._exponents(index, weights))
            made = linear("", given, layer[0], layer[1][:, None])
            done.append(layer)
        return done

    def _rounded(self, index: int, inputs: Float32Array) -> Float32Array:
        return rounded(E4M3, inputs, np.broadcast_to(self._before(index), inputs.shape))

    def _before(self, index: int) -> Exponents:
        """Return the exponents of a layer's inputs, [K, 1, inputs] or such that they fit it."""
        of = self._scales
        if index == 3:  # noqa: PLR2004
            parts = (of.features, self._width), (_ZERO, self._seen.shape[2])
            return self._side_by_side(*parts)
        return _columns((_ZERO, of.one, of.two, _ZERO, of.four)[index])

    def _exponents(self, index: int, weights: Float32Array) -> Exponents:
        """Return the exponents of a layer's weights."""
        of = self._scales
        after = _columns((of.one, of.two, of.features, of.four, of.colour)[index])
        if index == 2:  # noqa: PLR2004
            after = self._side_by_side((of.density, 1), (of.features, self._width))
        before = np.swapaxes(self._before(index), 1, 2)
        exponents: Exponents = np.broadcast_to(after - before, weights.shape)
        return exponents

    def _side_by_side(self, *parts: tuple[Exponents | np.int64, int]) -> Exponents:
        shape = len(self._seen), 1
        wide = [np.broadcast_to(_columns(one), (*shape, width)) for one, width in parts]
        return np.concatenate(wide, axis=2)


def _columns(exponents: Exponents | np.int64) -> Exponents:
    return np.reshape(exponents, (-1, 1, 1))


def _places(model: KiloNeRF, part: slice) -> Float32Array:
    """Return samples of networks in their cells, each coordinate from -1 to 1, [k, n, 3]."""
    march = model.march
    cells = np.argwhere(march.occupied)
    low, high = march.box
    middles = low + (cells + 0.5) / march.occupied.shape * (high - low)
    owners, _ = model.cells_of(middles.astype(np.float32))
    number = np.arange(_SAMPLES)
    inside = (number[:, None] * np.array(STEPS) + 0.5) % 1
    places = np.empty((len(model.weights[0][part]), _SAMPLES, 3), dtype=np.float32)
    for index, network in enumerate(range(part.start, part.start + len(places))):
        own = cells[owners == network]
        if len(own) == 0:
            places[index] = 2 * inside - 1
            continue
        chosen = own[number * len(own) // _SAMPLES]
        points = low + (chosen + inside) / march.occupied.shape * (high - low)
        places[index] = model.cells_of(points.astype(np.float32))[1]
    return places


def directions(count: int) -> Float32Array:
    """Return unit vectors [count, 3], evenly spread along a spiral."""
    index = np.arange(count) + 0.5
    height = 1 - 2 * index / count
    angle = np.pi * (1 + np.sqrt(5)) * index
    radius = np.sqrt(1 - height**2)
    spiral = (radius * np.cos(angle), radius * np.sin(angle), height)
    return np.stack(spiral, axis=-1).astype(np.float32)
