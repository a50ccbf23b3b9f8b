"""Networks on the array: dense layers on blocks of 32 samples, weights in the scratchpads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vividc.render.array.block_map import BlockMap
from vividc.render.array.device import Device
from vividc.render.array.frame import Ledger
from vividc.render.arrays import Float32Array

SAMPLES = 32
"""Samples of a block of activations."""
NEURONS = 8
"""Neurons of a block of weights."""
_KERNEL = "render/layers:layer"
_NO_LIMIT = np.float32(-np.inf)
_SHARED_BYTES = 17_408
"""Of weights that lie in a scratchpad at a time, at most: a little more than a layer of 64 by 64."""


@dataclass(frozen=True, slots=True, eq=False)
class DenseLayer:
    """A layer's weights as the kernel takes them.

    Attributes
    ----------
    packed
        [groups, ceil(outputs / 8), 1 + inputs, 8] float32: the bias, then the weights; neurons
        that fill the last block are 0.
    inputs, outputs
        Features in and out.
    relu
        Whether what is below 0 becomes 0.
    """

    packed: Float32Array
    inputs: int
    outputs: int
    relu: bool


def dense_layer(
    weights: npt.ArrayLike, bias: npt.ArrayLike | None = None, relu: bool = False
) -> DenseLayer:
    """Pack a layer: weights [inputs, outputs] and bias [outputs], or both with a leading axis of
    groups; no bias is one of zeros.
    """
    matrices = np.asarray(weights, dtype=np.float32)
    matrices = matrices.reshape(-1, *matrices.shape[-2:])
    groups, inputs, outputs = matrices.shape
    blocks = -(-outputs // NEURONS)
    rows = np.zeros((groups, 1 + inputs, blocks * NEURONS), dtype=np.float32)
    rows[:, 1:, :outputs] = matrices
    if bias is not None:
        rows[:, 0, :outputs] = np.asarray(bias, dtype=np.float32).reshape(groups, outputs)
    packed = rows.reshape(groups, 1 + inputs, blocks, NEURONS).transpose(0, 2, 1, 3)
    return DenseLayer(np.ascontiguousarray(packed), inputs, outputs, relu)


def run_network(
    device: Device,
    ledger: Ledger,
    stage: str,
    layers: Sequence[DenseLayer],
    blocks: Float32Array,
    groups: npt.NDArray[np.int32] | None = None,
) -> Float32Array:
    """Return the last layer's outputs of blocks of samples.

    Parameters
    ----------
    blocks
        [B, inputs, 32] float32: 32 samples a block, feature by feature.
    groups
        [B] which of the layers' groups of weights each block takes, ascending.

    Returns
    -------
    float32 [B, outputs rounded up to 8, 32]. A sum is one chain of fused multiply-adds in the order
    of the inputs, from the bias.
    """
    values = blocks
    for layer in layers:
        values = _run_layer(device, ledger, stage, layer, values, groups)
    return values


def _run_layer(
    device: Device,
    ledger: Ledger,
    stage: str,
    layer: DenseLayer,
    values: Float32Array,
    groups: npt.NDArray[np.int32] | None,
) -> Float32Array:
    """Run a layer, a part of its neurons after the other if its weights are many."""
    row_bytes = layer.packed[0, :1].nbytes
    limit = _SHARED_BYTES // (1 if groups is None else 2)
    neurons = layer.packed.shape[1]
    at_once = max(1, min(neurons, limit // row_bytes))
    parts = []
    for first in range(0, neurons, at_once):
        packed = np.ascontiguousarray(layer.packed[:, first : first + at_once])
        out = np.empty((len(values), packed.shape[1] * NEURONS, SAMPLES), dtype=np.float32)
        flat = packed.reshape(len(packed), -1)
        BlockMap(
            kernel=_KERNEL,
            inputs={"x": values[:, : layer.inputs]},
            outputs={"out": out},
            shared={"weights": flat[0] if groups is None else flat},
            scalars={
                "inputs": layer.inputs,
                "neurons": packed.shape[1],
                "least": np.float32(0) if layer.relu else _NO_LIMIT,
            },
            groups=groups,
        ).run(device, ledger, stage)
        parts.append(out)
    return parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)
