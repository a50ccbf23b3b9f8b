"""Scales of a network's layers whose operands have 16 or 8 bits: powers of two, from the largest
numbers that a layer meets.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from vividc.formats import E4M3, Format
from vividc.render.array.network.fitting import fitted, rounded
from vividc.render.array.options import RenderPrecision
from vividc.render.arrays import Float32Array
from vividc.render.errors import SceneError
from vividc.render.radiance import March
from vividc.render.radiance.layers import BLOCK, Layer, linear
from vividc.render.radiance.volume import RadianceField

_SAMPLES: Final = 4096
_GOLDEN: Final = (math.sqrt(5) - 1) / 2
STEPS: Final = (0.8191725134, 0.6710436067, 0.5497004779)
"""Of a sequence that fills a cube evenly: powers of the root of x^4 = x + 1 (Roberts 2018)."""


def largest_inputs(scene: RadianceField) -> dict[str, float]:
    """Return the largest magnitude of each layer's inputs, by the layer's name.

    It is that of the float32 reference at 4,096 points, the same ones each time: in occupied cells
    that are evenly spread over the list of all, and along directions that are over the sphere. A
    layer that meets zeros only has 1.

    Raises
    ------
    SceneError
        An input is not finite.
    """
    largest: dict[str, float] = {}

    def recorded(
        name: str, inputs: Float32Array, weights: Float32Array, bias: Float32Array | None
    ) -> Float32Array:
        if not np.isfinite(inputs).all():
            raise SceneError(
                f"inputs of the layer {name} leave float32: there is no scale for them",
                loc="--precision",
                hint="render in fp32, or train with smaller weights",
            )
        largest[name] = max(largest.get(name, 0.0), float(np.abs(inputs).max(initial=0)))
        return linear(name, inputs, weights, bias)

    points, directions = _samples(scene.march)
    with np.errstate(over="ignore", invalid="ignore"):  # `recorded` refuses what comes of it
        _, features = scene.density(points, recorded)
        scene.colour(points, features, directions, recorded)
    return {name: value or 1.0 for name, value in largest.items()}


@dataclass(frozen=True, slots=True, eq=False)
class Calibrated:
    """A network's layers: weights [inputs, outputs], biases [outputs], and the largest magnitude of
    the inputs of each, where operands are narrow.
    """

    weights: Sequence[Float32Array]
    biases: Sequence[Float32Array] = ()
    largest: Sequence[float] = ()


def calibrated(
    scene: RadianceField, precision: RenderPrecision, networks: Mapping[str, Calibrated]
) -> list[Calibrated]:
    """Return networks as operands of a format want them: for fp8, their weights are E4M3's and
    fitted to what the layers meet at 2,048 points of `largest_inputs`, and their biases, too.

    Parameters
    ----------
    networks
        In float32, by what the names of their layers begin with.

    Raises
    ------
    SceneError
        As of `largest_inputs` and `exponents`.
    """
    if precision == "fp32":
        return [*networks.values()]
    largest = largest_inputs(scene)
    known = {name: replace(net, largest=of_layers(largest, name)) for name, net in networks.items()}
    if precision == "fp8":
        known = _fitted(scene, E4M3, known)
    return [*known.values()]


def _fitted(
    scene: RadianceField, fmt: Format, networks: Mapping[str, Calibrated]
) -> dict[str, Calibrated]:
    scales = {
        f"{name}{index}": pair
        for name, net in networks.items()
        for index, pair in enumerate(zip(*exponents(net.largest, net.weights, fmt), strict=True))
    }
    exact: dict[str, Float32Array] = {}
    found: dict[str, tuple[Float32Array, Float32Array]] = {}

    def recorded(
        name: str, inputs: Float32Array, weights: Float32Array, bias: Float32Array | None
    ) -> Float32Array:
        exact[name] = linear(name, inputs, weights, bias)
        return exact[name]

    def fit(
        name: str, inputs: Float32Array, weights: Float32Array, bias: Float32Array | None
    ) -> Float32Array:
        before, factor = scales[name] if name in scales else scales[f"{name}0"]
        given = rounded(fmt, inputs, np.full(inputs.shape, before))
        grid = np.full((1, *weights.shape), factor)
        layer = fitted(fmt, given[None], exact[name][None], weights[None], grid)
        found[name] = layer[0][0], layer[1][0]
        return linear(name, given, *found[name])

    points, directions = (rows[:: _SAMPLES // BLOCK] for rows in _samples(scene.march))
    passes: list[Layer] = [recorded, fit]
    for layer in passes:
        _, features = scene.density(points, layer)
        scene.colour(points, features, directions, layer)
    made = {}
    for name, net in networks.items():
        layers = [found[layer] for layer in sorted(found) if layer.startswith(name)]
        made[name] = Calibrated([w for w, _ in layers], [b for _, b in layers], net.largest)
    return made


def of_layers(largest: Mapping[str, float], name: str) -> list[float]:
    """Return the figures of the layers of a network, in order: those whose names begin so."""
    return [value for layer, value in sorted(largest.items()) if layer.startswith(name)]


def exponents(
    largest: Sequence[float], weights: Sequence[Float32Array], fmt: Format
) -> tuple[list[int], list[int]]:
    """Return the scales of each layer's inputs and weights, as exponents of two.

    A layer's sums have the scale of both together, and are the next layer's inputs: no number has
    to be scaled anywhere but the first layer's inputs. The last sums have scale 1. What room a
    format has above the largest inputs and the largest weight, the two share evenly: both lose as
    little as possible to what the format rounds to 0.

    Parameters
    ----------
    largest
        Magnitude of each layer's inputs; what is larger becomes the format's largest number.

    Raises
    ------
    SceneError
        With the scale that a layer's sums have to have, its inputs or its weights are too large
        for the format.
    """
    inputs, factors = [], []
    after = 0
    for inputs_max, matrix in zip(reversed(largest), reversed(weights), strict=True):
        weights_max = float(np.abs(matrix).max(initial=0)) or 1.0
        most = _most(inputs_max, fmt)
        room = most + _most(weights_max, fmt) - after
        if room < 0:
            raise SceneError(
                f"a layer with inputs of up to {inputs_max:.3g} and weights of up to "
                f"{weights_max:.3g} does not fit {fmt.name}",
                loc="--precision",
                hint="render in fp16 or fp32, or train with smaller weights",
            )
        before = most - room // 2
        inputs.append(before)
        factors.append(after - before)
        after = before
    return inputs[::-1], factors[::-1]


def _most(value: float, fmt: Format) -> int:
    """Return the largest exponent with which a number stays within a format."""
    return math.floor(math.log2(fmt.max_finite / value))


def _samples(march: March) -> tuple[Float32Array, Float32Array]:
    """Return points [n, 3] in occupied cells and directions [n, 3]."""
    cells = np.argwhere(march.occupied)
    count = min(_SAMPLES, _SAMPLES * len(cells))
    number = np.arange(count)
    chosen = cells[number * len(cells) // max(count, 1)]
    inside = (number[:, None] * np.array(STEPS) + 0.5) % 1
    place = ((chosen + inside) / march.occupied.shape).astype(np.float32)
    low, high = march.box
    z = 1 - (2 * number + 1) / max(count, 1)
    angle, radius = 2 * np.pi * _GOLDEN * number, np.sqrt(1 - z * z)
    directions = np.stack((radius * np.cos(angle), radius * np.sin(angle), z), axis=1)
    points: Float32Array = (low + place * (high - low)).astype(np.float32)
    return points, directions.astype(np.float32)
