"""KiloNeRF's weights as float8 words for kernels/render/kilonerf_fp8.py, and their scales.

Every scale is a power of two, of a layer of one network. A layer's results are e4m3(x 2**s): as its
inputs come with the scale of the layer before, its weights are stored with the ratio of both, and
the array has nothing to scale. s is the largest with which the largest result of a calibration is
at most 64 and the largest weight at most 448. The calibration is deterministic: each network's
results in float32 at the 512 points of a grid in its cell, seen along as many directions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vividc.formats import E4M3, round_array
from vividc.render.array.models.kilonerf_fit import Scales, directions, fitted_networks
from vividc.render.arrays import Float32Array
from vividc.render.errors import SceneError
from vividc.render.radiance import KiloNeRF
from vividc.render.radiance.kilonerf import (
    DIRECTION_FREQUENCIES,
    POSITION_FREQUENCIES,
    positional_encoding,
)
from vividc.render.radiance.layers import relu

Words = npt.NDArray[np.uint32]
Exponents = npt.NDArray[np.int64]

CHUNK_WORDS = 8
"""Words of a sample that a layer takes at once."""
_LANES = 4
WIDTH = CHUNK_WORDS * _LANES
"""Of a hidden layer: one chunk."""
_AXES = 3
_LARGEST_RESULT = 64.0
"""Of the calibration, scaled; what it did not see may be seven times as large."""
_LEAST_SCALE, _LARGEST_SCALE = -40, 40
_GRID = 8
"""Points of the calibration along each axis of a cell."""


@dataclass(frozen=True, slots=True, eq=False)
class Fp8Words:
    """The networks as the kernels read them.

    Attributes
    ----------
    density, colour
        Words of each network's layers.
    density_units, colour_units
        What the sums of each network's last layer are to be multiplied by, [K] float32.
    """

    density: tuple[Words, ...]
    colour: tuple[Words, ...]
    density_units: Float32Array
    colour_units: Float32Array


def fp8_words(model: KiloNeRF) -> Fp8Words:
    """Return the words of all networks, whose hidden layers are 32 wide.

    Raises
    ------
    SceneError
        Results of the calibration are not finite.
    """
    w1, w2, w3, w4, w5 = (np.asarray(weights) for weights in model.weights)
    with np.errstate(over="ignore", invalid="ignore"):
        largest = _largest_results(model)
    if not np.isfinite(largest).all():
        network = np.argwhere(~np.isfinite(largest))[0, 1]
        raise SceneError(
            f"results of network {network} leave float32: there is no scale for them",
            loc="--precision",
            hint="render in fp32, or train with smaller weights",
        )
    by_feature, by_direction = w4[:, :WIDTH], w4[:, WIDTH:]
    s1 = scales(largest[0], (w1, 0))
    s2 = scales(largest[1], (w2, s1))
    s3 = scales(largest[2], (w3[:, :, 1:], s2))
    s4 = scales(largest[3], (by_feature, s3), (by_direction, 0))
    # Sums that nothing rounds may be as large as they like.
    density = scales(np.zeros(len(w3)), (w3[:, :, :1], s2))
    colour = scales(np.zeros(len(w5)), (w5, s4))
    (w1, w2, w3, w4, w5), (b1, b2, b3, b4, b5) = fitted_networks(
        model, Scales(s1, s2, s3, s4, density, colour)
    )
    position = in_words(w1, POSITION_FREQUENCIES)
    direction = in_words(w4[:, WIDTH:], DIRECTION_FREQUENCIES)
    return Fp8Words(
        _joined(
            _layer(_scaled(position, s1), _scaled(b1[:, None], s1), 8),
            _layer(_scaled(w2, s2 - s1), _scaled(b2[:, None], s2), 8),
            _layer(_scaled(w3[:, :, 1:], s3 - s2), _scaled(b3[:, None, 1:], s3), 8),
            _layer(_scaled(w3[:, :, :1], density - s2), _scaled(b3[:, None, :1], density), 1),
        ),
        _joined(
            _layer(
                np.concatenate((_scaled(w4[:, :WIDTH], s4 - s3), _scaled(direction, s4)), axis=1),
                _scaled(b4[:, None], s4),
                8,
            ),
            _layer(_scaled(w5, colour - s4), _scaled(b5[:, None], colour), 1),
        ),
        np.ldexp(np.float32(1), -density).astype(np.float32),
        np.ldexp(np.float32(1), -colour).astype(np.float32),
    )


def _largest_results(model: KiloNeRF) -> list[Float32Array]:
    """Return the largest magnitudes of results of layers 1 to 4, without the density, [K] each."""
    axis = (np.arange(_GRID, dtype=np.float32) + np.float32(0.5)) * np.float32(2 / _GRID) - 1
    points = np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, _AXES)
    encoded = positional_encoding(points.astype(np.float32), POSITION_FREQUENCIES)
    seen = positional_encoding(directions(len(points)), DIRECTION_FREQUENCIES)
    largest = []
    for network in range(len(model.weights[0])):
        w1, w2, w3, w4, _ = (weights[network] for weights in model.weights)
        b1, b2, b3, b4, _ = (biases[network] for biases in model.biases)
        one = relu(encoded @ w1 + b1)
        two = relu(one @ w2 + b2)
        features = (two @ w3 + b3)[:, 1:]
        four = relu(np.concatenate((features, seen), axis=1) @ w4 + b4)
        largest.append([np.abs(results).max() for results in (one, two, features, four)])
    return list(np.array(largest, dtype=np.float32).T)


def scales(
    largest: npt.NDArray[np.floating], *weights: tuple[Float32Array, Exponents | int]
) -> Exponents:
    """Return s of each network for its largest results, and weights with the scale of their
    inputs.
    """
    scale = _exponent(_LARGEST_RESULT, largest)
    for array, before in weights:
        most = np.abs(array).max(axis=(1, 2))
        scale = np.minimum(scale, _exponent(E4M3.max_finite, most) + before)
    return np.clip(scale, _LEAST_SCALE, _LARGEST_SCALE)


def _exponent(limit: float, largest: npt.NDArray[np.floating]) -> Exponents:
    """Return the largest e with `largest` 2**e at most `limit`."""
    tiny = np.ldexp(limit, -2 * _LARGEST_SCALE)
    ratio = limit / np.maximum(largest.astype(np.float64), tiny)
    exponent: Exponents = np.frexp(ratio)[1].astype(np.int64) - 1
    return exponent


def _scaled(array: Float32Array, exponents: Exponents) -> Float32Array:
    """Return an array [K, inputs, neurons] times powers of two."""
    scaled: Float32Array = np.ldexp(array, exponents[:, None, None]).astype(np.float32)
    return scaled


def in_words(weights: Float32Array, frequencies: int) -> Float32Array:
    """Return weights [K, terms, n] in the order of the words of an encoding, filled up to chunks.

    First the sines and cosines of x, two by two, then of y and z; then x, y, z.
    """
    octaves = np.arange(2 * frequencies)
    order = [_AXES + _AXES * octaves + axis for axis in range(_AXES)]
    terms = np.concatenate([*order, np.arange(_AXES)])
    room = -(-len(terms) // WIDTH) * WIDTH
    filled = np.zeros((len(weights), room, weights.shape[2]), dtype=np.float32)
    filled[:, : len(terms)] = weights[:, terms]
    return filled


def _layer(weights: Float32Array, biases: Float32Array, at_once: int) -> Words:
    """Return the words [K, n] of a layer [K, inputs, neurons]: those of each neuron, and after some
    neurons at once their biases [K, 1, neurons].
    """
    codes = round_array(E4M3, np.ascontiguousarray(weights.transpose(0, 2, 1))).astype(np.uint8)
    blocks = (len(weights), -1)
    words = codes.view(np.uint32).reshape(*blocks, at_once * (weights.shape[1] // _LANES))
    starts = np.ascontiguousarray(biases, dtype=np.float32).view(np.uint32)
    joined = np.concatenate((words, starts.reshape(*blocks, at_once)), axis=2)
    return joined.reshape(blocks)


def _joined(*layers: Words) -> tuple[Words, ...]:
    """Return the words of each network's layers, one after the other."""
    return tuple(np.concatenate(layers, axis=1))
