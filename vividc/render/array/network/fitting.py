"""Weights rounded for the inputs that they meet.

A layer of rounded operands is to give the sums of the layer in float32. Of all weights that a
format has, those are looked for whose sums are nearest in the squared mean over samples: first
without the format, by least squares that are drawn to the given weights (ridge regression), then
one input after the other, the last first, each weight rounded to what makes up best for the rounded
ones behind it (as GPTQ does, Frantar et al. 2023; Babai's nearest plane, 1986). Biases take up the
mean.

Nothing here depends on the order in which a library adds up: words are the same on all machines.
"""

from __future__ import annotations

from typing import Final

import numpy as np
import numpy.typing as npt

from vividc.formats import Format, nearest
from vividc.render.arrays import Float32Array
from vividc.render.radiance.layers import linear

Float64Array = npt.NDArray[np.float64]
Exponents = npt.NDArray[np.int64]

_RIDGE: Final = 0.1
"""How much a weight is drawn to what it was: as a share of the inputs' mean square."""
_LARGEST: Final = 60
"""Exponent of two by which inputs and sums are made smaller, or larger."""


def rounded(fmt: Format, values: npt.NDArray[np.floating], exponents: Exponents) -> Float32Array:
    """Return values times powers of two, rounded to a format, over the powers of two."""
    scaled = np.ldexp(values.astype(np.float32), exponents)
    return np.ldexp(nearest(fmt, scaled), -exponents)


def fitted(
    fmt: Format,
    inputs: Float32Array,
    sums: Float32Array,
    weights: Float32Array,
    exponents: Exponents,
) -> tuple[Float32Array, Float32Array]:
    """Return weights [K, i, o] of K layers, of a format, and their biases [K, o].

    Parameters
    ----------
    inputs
        [K, n, i] of samples, as they are rounded.
    sums
        [K, n, o] that the layers have in float32.
    weights
        [K, i, o] that they have there.
    exponents
        [K, i, o], of the powers of two that weights are multiplied by before they are rounded.
    """
    # Powers of two take both to 1 at most: squares of large ones would leave float32.
    given, made = _size(inputs), _size(sums)
    x, y, known = np.ldexp(inputs, -given), np.ldexp(sums, -made), np.ldexp(weights, given - made)
    middle, aim = _mean(x), _mean(y)
    centred, missing = x - middle, y - aim - linear("", x - middle, known, None)
    across = np.ascontiguousarray(centred.transpose(0, 2, 1))
    gram = linear("", across, centred, None).astype(np.float64)
    size = gram.shape[1]
    diagonal = gram[:, np.arange(size), np.arange(size)]
    ridge = np.maximum(_RIDGE * diagonal.sum(axis=1) / size, np.finfo(np.float32).tiny)
    gram[:, np.arange(size), np.arange(size)] += ridge[:, None]
    root = _root(gram)
    change = _solved(root, linear("", across, missing, None).astype(np.float64))
    found = _nearest(fmt, root, known + change, exponents + made - given)
    biases = aim - linear("", middle, found, None)
    return np.ldexp(found, made - given), np.ldexp(biases, made)[:, 0]


def _size(values: Float32Array) -> Exponents:
    """Return an exponent of two of each layer's largest magnitude, [K, 1, 1]."""
    largest = np.abs(values).max(axis=(1, 2), keepdims=True, initial=0)
    exponent: Exponents = np.clip(np.frexp(largest)[1].astype(np.int64), -_LARGEST, _LARGEST)
    return exponent


def _mean(values: Float32Array) -> Float32Array:
    """Return the mean over samples, [K, 1, ...]."""
    ones = np.ones((len(values), 1, values.shape[1]), dtype=np.float32)
    return linear("", ones, values, None) / np.float32(values.shape[1])


def _root(gram: Float64Array) -> Float64Array:
    """Return upper triangles R with R^T R = `gram` (Cholesky)."""
    left, root = gram.copy(), np.zeros_like(gram)
    for i in range(gram.shape[1]):
        root[:, i, i:] = left[:, i, i:] / np.sqrt(left[:, i, i])[:, None]
        row = root[:, i, i + 1 :]
        left[:, i + 1 :, i + 1 :] -= row[:, :, None] * row[:, None, :]
    return root


def _solved(root: Float64Array, right: Float64Array) -> Float64Array:
    """Return x [K, i, o] with R^T R x = `right`."""
    x = right.copy()
    for i in range(root.shape[1]):
        x[:, i] /= root[:, i, i, None]
        x[:, i + 1 :] -= root[:, i, i + 1 :, None] * x[:, i, None]
    for i in reversed(range(root.shape[1])):
        x[:, i] /= root[:, i, i, None]
        x[:, :i] -= root[:, :i, i, None] * x[:, i, None]
    return x


def _nearest(
    fmt: Format, root: Float64Array, weights: Float64Array, exponents: Exponents
) -> Float32Array:
    """Return weights of a format with which R (weights - them) is small."""
    found = np.zeros(weights.shape, dtype=np.float32)
    lost = np.zeros_like(weights)
    for i in reversed(range(root.shape[1])):
        # R times what is lost behind it, a row added after the other.
        made_up = lost[:, i] / root[:, i, i, None]
        found[:, i] = rounded(fmt, weights[:, i] + made_up, exponents[:, i])
        left = weights[:, i] - found[:, i]
        lost[:, :i] += root[:, :i, i, None] * left[:, None]
    return found
