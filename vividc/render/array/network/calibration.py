"""Scales of a network's layers whose operands have 16 or 8 bits: powers of two, from the largest
numbers that a layer meets.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from vividc.formats import Format
from vividc.render.arrays import Float32Array
from vividc.render.errors import SceneError
from vividc.render.radiance import March
from vividc.render.radiance.layers import linear
from vividc.render.radiance.volume import RadianceField

_SAMPLES: Final = 4096
_GOLDEN: Final = (math.sqrt(5) - 1) / 2
_STEPS: Final = (0.8191725134, 0.6710436067, 0.5497004779)
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
    inside = (number[:, None] * np.array(_STEPS) + 0.5) % 1
    place = ((chosen + inside) / march.occupied.shape).astype(np.float32)
    low, high = march.box
    z = 1 - (2 * number + 1) / max(count, 1)
    angle, radius = 2 * np.pi * _GOLDEN * number, np.sqrt(1 - z * z)
    directions = np.stack((radius * np.cos(angle), radius * np.sin(angle), z), axis=1)
    points: Float32Array = (low + place * (high - low)).astype(np.float32)
    return points, directions.astype(np.float32)
