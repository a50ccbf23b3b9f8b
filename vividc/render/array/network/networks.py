"""Networks on blocks of 16 samples, with operands of a format: the arrays of a TPU-like mode, or a
kernel of layers on the tiles, with the weights in the scratchpads.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import numpy.typing as npt

from vividc.formats import FORMATS
from vividc.gemm import Layer, Precision
from vividc.render.array.device.blocks import BLOCK, run_blocks
from vividc.render.array.device.device import Device
from vividc.render.array.device.launch import Words
from vividc.render.array.network.calibration import exponents
from vividc.render.array.network.systolic import run_systolic, tile_cycles, tpu_choice
from vividc.render.array.options import RenderPrecision
from vividc.render.array.steering import TPU_SAMPLES
from vividc.render.arrays import Float32Array
from vividc.render.errors import SceneError

_FORMATS: Final[dict[RenderPrecision, Precision]] = {"fp32": "f32", "fp16": "f16", "fp8": "e4m3"}
_NEURONS: Final = 8
"""Of a block of weights."""
_KERNEL: Final = "render/layers:layer"
_PLACES: Final = 2
"""Launches that fit a scratchpad beside the weights."""
_ARRAYS: Final = 3
"""Of the kernel of layers."""
_NO_LIMIT: Final = np.float32(-np.inf)


@dataclass(frozen=True, slots=True, eq=False)
class Network:
    """Layers with the format of their operands.

    Attributes
    ----------
    layers
        With weights and biases scaled for the format.
    precision
        Of all layers' operands; sums are float32, and so are outputs, but with fp8, which leaves
        float16, two to a word.
    scale
        What the inputs are multiplied by before they are rounded: a power of two. Outputs have
        scale 1.
    """

    layers: tuple[Layer, ...]
    precision: RenderPrecision
    scale: np.float32

    @property
    def inputs(self) -> int:
        """Rows of an array of blocks of inputs: features, or words of them."""
        return self.layers[0].shape.words

    @property
    def features(self) -> int:
        """Features that the words hold; those behind the network's are 0."""
        return self.inputs * _lanes(_FORMATS[self.precision])

    @property
    def outputs(self) -> int:
        """Rows of an array of blocks of outputs."""
        last = self.layers[-1].shape
        return -(-last.cols // _lanes(last.results))

    @property
    def scaling(self) -> dict[str, object]:
        """The scalar of kernels that make words for it."""
        return {"scale": self.scale} if self.is_fp8 else {}

    @property
    def is_fp8(self) -> bool:
        """Whether kernels read and write words for it: those whose names end in `_fp8`."""
        return self.precision == "fp8"

    def named(self, kernel: str) -> str:
        """Return the name of a kernel that works on what the network takes or leaves."""
        return f"{kernel}_fp8" if self.is_fp8 else kernel

    def bits(self, array: Float32Array) -> Words:
        """Return the numbers, or words, of what the network takes or leaves."""
        return array.view(np.uint32) if self.is_fp8 else array

    def empty(self, blocks: int) -> Float32Array:
        """Return room for inputs that a kernel makes: for words [blocks, inputs, 16], or zeros
        [blocks, features, 16] that are rounded afterwards.
        """
        if self.is_fp8:
            return np.empty((blocks, self.inputs, BLOCK), dtype=np.float32)
        return np.zeros((blocks, self.features, BLOCK), dtype=np.float32)

    def room(self, samples: int) -> Float32Array:
        """Return room for the outputs of blocks of so many samples, [B, outputs, 16]."""
        return np.empty((-(-samples // BLOCK), self.outputs, BLOCK), dtype=np.float32)

    def own(self, inputs: Float32Array) -> Words:
        """Return what a kernel fills of `empty` room."""
        return self.bits(inputs if self.is_fp8 else inputs[:, : self.layers[0].shape.depth])

    def rounded(self, device: Device, blocks: Float32Array) -> Float32Array:
        """Return what a kernel put into `empty` room as the network takes it."""
        if self.precision != "fp16":
            return blocks
        words = np.empty((len(blocks), self.inputs, BLOCK), dtype=np.float32)
        out, scalars = {"out": words.view(np.uint32)}, {"scale": self.scale}
        run_blocks(device, "rounding", "render/quantise:to_fp16", {"x": blocks}, out, scalars)
        return words

    def made(
        self, device: Device, stage: str, kernel: str, given: Mapping[str, Words]
    ) -> Float32Array:
        """Return the inputs that a kernel (`named`) makes of [B, ...] `given` it, as the network
        takes them.
        """
        inputs = self.empty(len(next(iter(given.values()))))
        out = {"out": self.own(inputs)}
        run_blocks(device, stage, self.named(kernel), given, out, self.scaling)
        return self.rounded(device, inputs)

    def run(self, device: Device, stage: str, inputs: Float32Array) -> Float32Array:
        """Return the last layer's outputs [B, outputs, 16] of inputs [B, inputs, 16] as `rounded`
        makes them; of fp8 words of two float16.

        In float32 a sum is one chain of fused multiply-adds in the order of the inputs, from the
        bias, whatever computes it.

        Raises
        ------
        SceneError
            Operands are narrow, and the accelerator has no TPU-like modes, or a layer fits none:
            the tiles have no kernel for them.
        """
        if not len(inputs):
            return self.room(0)
        mode = self.mode(device, len(inputs) * BLOCK)
        if mode is not None:
            words = self.precision != "fp32"
            return run_systolic(device, stage, self.layers, inputs, mode, words=words)
        for layer in self.layers:
            inputs = _run_layer(device, stage, layer, inputs)
        return inputs

    def mode(self, device: Device, samples: int = BLOCK) -> str | None:
        """Return the TPU-like mode in which the network takes fewest cycles; None: it takes fewer
        as a kernel on the tiles, or the samples are too few to make a program for them.

        Raises
        ------
        SceneError
            As of `run`.
        """
        is_narrow = self.precision != "fp32"
        if samples < TPU_SAMPLES and not is_narrow:
            return None
        choice = tpu_choice(device, self.layers, samples)
        if choice is not None:
            mode, cycles = choice
            return mode if is_narrow or cycles < self._tile_cycles(device, samples) else None
        if is_narrow:
            raise SceneError(
                f"{device.programs.machine.name} cannot run layers of {self.precision} numbers of "
                "this size: it has no TPU-like mode for them",
                loc="--precision",
                hint="choose fp32, or the fabric vivid",
            )
        return None

    def _tile_cycles(self, device: Device, samples: int) -> int:
        shapes = [
            (layer.shape.depth, layer.shape.cols, len(_parts(layer, device)))
            for layer in self.layers
        ]
        return tile_cycles(shapes, samples, device.tiles)


def dense_layer(
    weights: npt.ArrayLike, bias: npt.ArrayLike | None = None, relu: bool = False
) -> Layer:
    """Return a layer of float32: weights [inputs, outputs] and bias [outputs], or zeros."""
    matrix = np.asarray(weights, dtype=np.float32)
    shift = np.zeros(matrix.shape[1], dtype=np.float32)
    if bias is not None:
        shift[:] = bias
    return Layer(matrix, shift, "relu" if relu else "none")


def dense_layers(
    weights: Sequence[npt.ArrayLike], biases: Sequence[npt.ArrayLike] = ()
) -> list[Layer]:
    """Return layers of which all but the last have a ReLU."""
    last = len(weights) - 1
    shifts: Sequence[npt.ArrayLike | None] = biases or [None] * len(weights)
    return [
        dense_layer(matrix, bias, relu=number < last)
        for number, (matrix, bias) in enumerate(zip(weights, shifts, strict=True))
    ]


def network(
    layers: Sequence[Layer], precision: RenderPrecision, largest: Sequence[float] = ()
) -> Network:
    """Return a network whose operands have a format.

    Parameters
    ----------
    layers
        Of float32.
    largest
        Magnitude of each layer's inputs; of no account for fp32.
    """
    if precision == "fp32":
        return Network(tuple(layers), precision, np.float32(1))
    fmt = _FORMATS[precision]
    inputs, factors = exponents(largest, [layer.weights for layer in layers], FORMATS[fmt])
    narrow = tuple(
        replace(
            layer,
            weights=np.ldexp(layer.weights, factor),
            bias=None if layer.bias is None else np.ldexp(layer.bias, before + factor),
            precision=fmt,
            results="f16" if precision == "fp8" and layer is layers[-1] else "f32",
        )
        for layer, before, factor in zip(layers, inputs, factors, strict=True)
    )
    return Network(narrow, precision, np.float32(2.0 ** inputs[0]))


def _lanes(fmt: Precision) -> int:
    """Return how many numbers a word has."""
    return FORMATS[fmt].lanes if fmt in FORMATS else 1


def _run_layer(device: Device, stage: str, layer: Layer, values: Float32Array) -> Float32Array:
    """Run a layer on the tiles, a part of its neurons after the other if its weights are many."""
    shape, parts = layer.shape, []
    for packed in _parts(layer, device):
        out = np.empty((len(values), len(packed) * _NEURONS, BLOCK), dtype=np.float32)
        scalars = {
            "inputs": shape.depth,
            "neurons": len(packed),
            "least": np.float32(0) if shape.relu else _NO_LIMIT,
        }
        run_blocks(
            device, stage, _KERNEL, {"x": values}, {"out": out}, scalars, {"weights": packed}
        )
        parts.append(out)
    whole = parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)
    return whole[:, : shape.cols]


def _parts(layer: Layer, device: Device) -> list[Float32Array]:
    """Cut the neurons so that weights and two blocks of samples fit a scratchpad, into parts as
    equal as possible, [blocks of 8 neurons, 1 + inputs, 8]: biases, then weights; 0 for neurons
    that fill the last block.
    """
    inputs, outputs = layer.weights.shape
    blocks = -(-outputs // _NEURONS)
    rows = np.zeros((1 + inputs, blocks * _NEURONS), dtype=np.float32)
    rows[1:, :outputs] = layer.weights
    rows[0, :outputs] = 0 if layer.bias is None else layer.bias
    packed = rows.reshape(1 + inputs, blocks, _NEURONS).transpose(1, 0, 2)
    samples = _PLACES * BLOCK
    record = packed[0].size + samples * _NEURONS
    most = max(1, device.fitting(record, samples * inputs, _PLACES * _ARRAYS, copies=1))
    return np.array_split(np.ascontiguousarray(packed), -(-blocks // most))
