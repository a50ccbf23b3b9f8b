"""Networks on the array: dense layers on blocks of 16 samples, weights in the scratchpads."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from vividc.gemm import Layer
from vividc.machine.words import WORD_BYTES
from vividc.render.array.device.block_map import BlockMap
from vividc.render.array.device.device import Device
from vividc.render.array.device.frame import Ledger
from vividc.render.array.network.systolic import run_systolic, tile_cycles, tpu_choice
from vividc.render.arrays import Float32Array

Word = TypeVar("Word", bound=np.generic)

SAMPLES = 16
"""Samples of a block of activations."""
NEURONS = 8
"""Neurons of a block of weights."""
_KERNEL = "render/layers:layer"
_FEWEST = 2048
"""Samples for which a TPU-like mode is considered: its programs take the host seconds to make."""
_NO_LIMIT = np.float32(-np.inf)
_PLACES = 2
_ARRAYS = 3
"""Of the kernel of layers."""


@dataclass(frozen=True, slots=True, eq=False)
class DenseLayer:
    """A layer's weights as the kernel takes them.

    Attributes
    ----------
    matrix, bias
        [groups, inputs, outputs] and [groups, outputs] float32.
    packed
        [groups, ceil(outputs / 8), 1 + inputs, 8] float32: the bias, then the weights; neurons
        that fill the last block are 0.
    inputs, outputs
        Features in and out.
    relu
        Whether what is below 0 becomes 0.
    """

    matrix: Float32Array
    bias: Float32Array
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
    shift = np.zeros((groups, outputs), dtype=np.float32)
    if bias is not None:
        shift[:] = np.asarray(bias, dtype=np.float32).reshape(groups, outputs)
    rows = np.zeros((groups, 1 + inputs, blocks * NEURONS), dtype=np.float32)
    rows[:, 1:, :outputs] = matrices
    rows[:, 0, :outputs] = shift
    packed = rows.reshape(groups, 1 + inputs, blocks, NEURONS).transpose(0, 2, 1, 3)
    return DenseLayer(matrices, shift, np.ascontiguousarray(packed), inputs, outputs, relu)


def in_blocks(rows: npt.NDArray[Word]) -> npt.NDArray[Word]:
    """Return rows [n, F] as blocks [B, 16, F], the last one filled up with its last row."""
    missing = -len(rows) % SAMPLES
    if missing:
        rows = np.concatenate((rows, np.repeat(rows[-1:], missing, axis=0)))
    return np.ascontiguousarray(rows).reshape(-1, SAMPLES, rows.shape[1])


def room_for(rows: int, *shape: int) -> Float32Array:
    """Return room [B, 16, ...] for what becomes of rows."""
    return np.empty((-(-rows // SAMPLES), SAMPLES, *shape), dtype=np.float32)


def batches(most: int, *arrays: npt.NDArray[Any]) -> Iterator[tuple[slice, list[npt.NDArray[Any]]]]:
    """Yield where the blocks of at most `most` rows lie among all blocks, and those of each array.

    Parameters
    ----------
    most
        A multiple of 16.
    """
    for first in range(0, len(arrays[0]), most):
        blocks = [in_blocks(rows[first : first + most]) for rows in arrays]
        yield slice(first // SAMPLES, first // SAMPLES + len(blocks[0])), blocks


def run_network(
    device: Device,
    ledger: Ledger,
    stage: str,
    layers: Sequence[DenseLayer],
    blocks: Float32Array,
    groups: npt.NDArray[np.int32] | None = None,
) -> Float32Array:
    """Return the last layer's outputs of blocks of samples.

    Without groups the network runs in a TPU-like mode if that is expected to take fewer cycles than
    the kernel of layers on the tiles; the results are the same to the last bit.

    Parameters
    ----------
    blocks
        [B, inputs, 16] float32: 16 samples a block, feature by feature.
    groups
        [B] which of the layers' groups of weights each block takes, ascending.

    Returns
    -------
    float32 [B, outputs, 16]. A sum is one chain of fused multiply-adds in the order
    of the inputs, from the bias.
    """
    if groups is None and len(blocks):
        products = [
            Layer(layer.matrix[0], layer.bias[0], "relu" if layer.relu else "none")
            for layer in layers
        ]
        mode = tpu_mode(device, layers, products, len(blocks) * SAMPLES)
        if mode is not None:
            return run_systolic(device, ledger, stage, products, blocks, mode)
    values = blocks
    for layer in layers:
        values = _run_layer(device, ledger, stage, layer, values, groups)
    return values


def tpu_mode(
    device: Device, layers: Sequence[DenseLayer], products: Sequence[Layer], samples: int
) -> str | None:
    """Return the TPU-like mode in which a network takes fewest cycles; None: it takes fewer as a
    kernel on the tiles, or the samples are too few to make a program for them.
    """
    if samples < _FEWEST:
        return None
    shapes = [(layer.inputs, layer.outputs, len(_parts(layer, device, 1))) for layer in layers]
    choice = tpu_choice(device, products, samples)
    better = choice is not None and choice.cycles < tile_cycles(shapes, samples, device.tiles)
    return choice.mode if choice is not None and better else None


def _run_layer(
    device: Device,
    ledger: Ledger,
    stage: str,
    layer: DenseLayer,
    values: Float32Array,
    groups: npt.NDArray[np.int32] | None,
) -> Float32Array:
    """Run a layer, a part of its neurons after the other if its weights are many."""
    parts = []
    for packed in _parts(layer, device, 1 if groups is None else 2):
        out = np.empty((len(values), packed.shape[1] * NEURONS, SAMPLES), dtype=np.float32)
        BlockMap(
            kernel=_KERNEL,
            inputs={"x": values},
            outputs={"out": out},
            shared=[{"weights": group} for group in packed],
            scalars={
                "inputs": layer.inputs,
                "neurons": packed.shape[1],
                "least": np.float32(0) if layer.relu else _NO_LIMIT,
            },
            groups=groups,
        ).run(device, ledger, stage)
        parts.append(out)
    whole = parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)
    return whole[:, : layer.outputs]


def _parts(layer: DenseLayer, device: Device, copies: int) -> list[Float32Array]:
    """Cut the neurons so that weights and two blocks of samples fit a scratchpad, into parts as
    equal as possible.
    """
    neurons = layer.packed.shape[1]
    weights = copies * layer.packed[0, :1].nbytes
    samples = _PLACES * SAMPLES * WORD_BYTES
    aligned = device.scratchpad_bytes - _PLACES * _ARRAYS * device.line_bytes
    room = aligned - samples * layer.inputs
    most = max(1, room // (weights + samples * NEURONS))
    return np.array_split(layer.packed, -(-neurons // most), axis=1)
