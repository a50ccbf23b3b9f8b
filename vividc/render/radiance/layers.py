"""What the networks of the radiance fields share: layers, encodings, blocks of samples."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, Final, Protocol, TypeAlias

import numpy as np

from vividc.host.machine_code import Compiler
from vividc.render.arrays import Float32Array

_compiled: Final = Compiler(in_vectors=True)
_Matrices: TypeAlias = Annotated[Float32Array, 3]

BLOCK = 2048
"""Samples a network sees at once. Every block has this length, the last one padded, so that a
sample's result does not depend on how many others are computed with it."""
_ONE = np.float32(1.0)
_LARGEST_EXPONENT = np.float32(80.0)


class Layer(Protocol):
    """A linear layer: the place where a quantised one is put instead of `linear`."""

    def __call__(
        self, name: str, inputs: Float32Array, weights: Float32Array, bias: Float32Array | None
    ) -> Float32Array:
        """Return inputs [..., n, i] times weights [..., i, o] plus bias [..., o], [..., n, o].

        `name` is the layer's: per-layer scales are looked up with it.
        """
        ...


def linear(
    name: str, inputs: Float32Array, weights: Float32Array, bias: Float32Array | None
) -> Float32Array:
    """Return inputs times weights plus bias in float32, summed in the order of the inputs.

    The same on every machine and for every number of rows, which products of linear algebra
    libraries are not: their kernels differ by processor, and sum a matrix's last rows otherwise.
    """
    inputs, weights = (np.require(array, np.float32, ("C", "W")) for array in (inputs, weights))
    product = np.zeros((*inputs.shape[:-1], weights.shape[-1]), dtype=np.float32)
    matrices = math.prod(inputs.shape[:-2])
    _add_products(*(m.reshape(matrices, *m.shape[-2:]) for m in (inputs, weights, product)))
    return product if bias is None else product + bias


@_compiled
def _add_products(inputs: _Matrices, weights: _Matrices, sums: _Matrices) -> None:
    """Add inputs [k, n, i] times weights [k, i, o] to `sums` [k, n, o]."""
    for matrix in range(inputs.shape[0]):
        for row in range(inputs.shape[1]):
            for column in range(inputs.shape[2]):
                factor = inputs[matrix, row, column]
                for output in range(weights.shape[2]):
                    sums[matrix, row, output] += factor * weights[matrix, column, output]


def relu(values: Float32Array) -> Float32Array:
    """Return max(0, values)."""
    result: Float32Array = np.maximum(values, np.float32(0))
    return result


def sigmoid(values: Float32Array) -> Float32Array:
    """Return 1 / (1 + exp(-values)), without overflow."""
    exponent = np.clip(-values, -_LARGEST_EXPONENT, _LARGEST_EXPONENT)
    result: Float32Array = _ONE / (_ONE + np.exp(exponent))
    return result


def in_blocks(
    function: Callable[..., tuple[Float32Array, ...]], *arrays: Float32Array
) -> tuple[Float32Array, ...]:
    """Apply `function` to blocks of BLOCK rows of `arrays` [n, ...], and join what it returns.

    The last block is padded with its own first row; no block at all is made of n = 0 rows, but one
    padded with zeros, so that the results have their shapes.
    """
    count = len(arrays[0])
    parts = []
    for start in range(0, max(count, 1), BLOCK):
        block = [_padded(array[start : start + BLOCK]) for array in arrays]
        length = min(BLOCK, count - start)
        parts.append(tuple(result[:length] for result in function(*block)))
    return tuple(np.concatenate(results) for results in zip(*parts, strict=True))


def _padded(rows: Float32Array) -> Float32Array:
    if len(rows) == BLOCK:
        return np.ascontiguousarray(rows)
    filled = np.zeros((BLOCK, *rows.shape[1:]), dtype=rows.dtype)
    filled[: len(rows)] = rows
    if len(rows):
        filled[len(rows) :] = rows[0]
    return filled
