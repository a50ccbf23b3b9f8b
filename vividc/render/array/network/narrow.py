"""Networks on operands of 16 and 8 bits: the tiles round the inputs, the arrays do the rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from vividc.formats import FORMATS
from vividc.gemm import Layer, Precision
from vividc.render.array.device.block_map import BlockMap
from vividc.render.array.device.device import Device
from vividc.render.array.device.frame import Ledger
from vividc.render.array.device.launch import Words
from vividc.render.array.network.calibration import exponents
from vividc.render.array.network.networks import SAMPLES, DenseLayer, run_network
from vividc.render.array.network.systolic import run_systolic, tpu_choice
from vividc.render.array.options import RenderPrecision
from vividc.render.arrays import Float32Array
from vividc.render.errors import SceneError

_FORMATS: Final[dict[RenderPrecision, Precision]] = {"fp32": "f32", "fp16": "f16", "fp8": "e4m3"}


@dataclass(frozen=True, slots=True, eq=False)
class Network:
    """Layers with the format of their operands.

    Attributes
    ----------
    layers
        In float32, as they are.
    precision
        Of all layers' operands; sums are float32, and so are outputs, but with fp8, which leaves
        float16, two to a word.
    narrow
        The layers with weights and biases scaled for the format; none for fp32.
    scale
        What the inputs are multiplied by before they are rounded: a power of two. Outputs have
        scale 1.
    """

    layers: tuple[DenseLayer, ...]
    precision: RenderPrecision
    narrow: tuple[Layer, ...]
    scale: np.float32

    @property
    def inputs(self) -> int:
        """Rows of an array of blocks of inputs: features, or words of them."""
        first = self.layers[0]
        return self.narrow[0].shape.words if self.narrow else first.inputs

    @property
    def features(self) -> int:
        """Features that the words hold; those behind the network's are 0."""
        return self.inputs * FORMATS[_FORMATS[self.precision]].lanes if self.narrow else self.inputs

    def room(self, blocks: int) -> Float32Array:
        """Return zeros [blocks, features, 16], for inputs that are to be rounded."""
        return np.zeros((blocks, self.features, SAMPLES), dtype=np.float32)

    def words(self, blocks: int) -> Float32Array:
        """Return room [blocks, inputs, 16] for inputs that a kernel makes as they are taken."""
        return np.empty((blocks, self.inputs, SAMPLES), dtype=np.float32)

    def rounded(
        self, device: Device, ledger: Ledger, stage: str, blocks: Float32Array
    ) -> Float32Array:
        """Return the inputs as the network takes them.

        Parameters
        ----------
        blocks
            [B, features, 16] float32, those behind the network's own 0.
        """
        if not self.narrow:
            return blocks
        words = self.words(len(blocks))
        BlockMap(
            kernel=f"render/quantise:to_{self.precision}",
            inputs={"x": blocks},
            outputs={"out": words.view(np.uint32)},
            scalars={"scale": self.scale},
        ).run(device, ledger, stage)
        return words

    def made(
        self,
        device: Device,
        ledger: Ledger,
        stage: str,
        kernel: str,
        given: Mapping[str, Words],
    ) -> Float32Array:
        """Return the inputs that a kernel makes of blocks of samples, as the network takes them.

        For fp8 it is the kernel whose name ends in `_fp8`, which rounds them itself.

        Parameters
        ----------
        given
            Inputs of the kernel, [B, ...].
        """
        blocks = len(next(iter(given.values())))
        if self.precision == "fp8":
            words = self.words(blocks)
            made: dict[str, Words] = {"out": words.view(np.uint32)}
            scalars = {"scale": self.scale}
            BlockMap(f"{kernel}_fp8", given, made, scalars=scalars).run(device, ledger, stage)
            return words
        features = self.room(blocks)
        made = {"out": features[:, : self.layers[0].inputs]}
        BlockMap(kernel, given, made).run(device, ledger, stage)
        return self.rounded(device, ledger, "rounding", features)

    def run(self, device: Device, ledger: Ledger, stage: str, inputs: Float32Array) -> Float32Array:
        """Return the last layer's outputs, float32 [B, outputs, 16]; of fp8 words of two float16.

        Raises
        ------
        SceneError
            Operands are narrow, and the accelerator has no TPU-like modes, or a layer fits none:
            the tiles have no kernel for them.

        Parameters
        ----------
        inputs
            [B, inputs, 16], as `rounded` makes them.
        """
        if not self.narrow:
            return run_network(device, ledger, stage, self.layers, inputs)
        if not len(inputs):
            words = FORMATS[self.narrow[-1].results].lanes if self.precision == "fp8" else 1
            outputs = -(-self.layers[-1].outputs // words)
            return np.zeros((0, outputs, SAMPLES), dtype=np.float32)
        mode = self._mode(device, len(inputs) * SAMPLES)
        return run_systolic(device, ledger, stage, self.narrow, inputs, mode, words=True)

    def colours(self, device: Device, ledger: Ledger, inputs: Float32Array, rgb: Words) -> None:
        """Put sigmoids of the first three outputs into `rgb`, [B, 16, 3]."""
        x: Words = self.run(device, ledger, "colour network", inputs)
        kernel = "render/instant_ngp:colour"
        if self.precision == "fp8":
            kernel, x = f"{kernel}_fp8", x.view(np.uint32)
        BlockMap(kernel, {"x": x}, {"out": rgb}).run(device, ledger, "colour")

    def check(self, device: Device) -> None:
        """Refuse a device that cannot run the network, before there are inputs.

        Raises
        ------
        SceneError
            As of `run`.
        """
        if self.narrow:
            self._mode(device, SAMPLES)

    def _mode(self, device: Device, samples: int) -> str:
        choice = tpu_choice(device, self.narrow, samples)
        if choice is None:
            raise SceneError(
                f"{device.programs.machine.name} cannot run layers of {self.precision} numbers of "
                "this size: it has no TPU-like mode for them",
                loc="--precision",
                hint="choose fp32, or the fabric vivid",
            )
        return choice.mode


def network(
    layers: Sequence[DenseLayer], precision: RenderPrecision, largest: Sequence[float]
) -> Network:
    """Return a network whose operands have a format.

    Parameters
    ----------
    layers
        Of one group each.
    largest
        Magnitude of each layer's inputs; of no account for fp32.
    """
    if precision == "fp32":
        return Network(tuple(layers), precision, (), np.float32(1))
    fmt = _FORMATS[precision]
    inputs, factors = exponents(largest, [layer.matrix for layer in layers], FORMATS[fmt])
    narrow = tuple(
        Layer(
            np.ldexp(layer.matrix[0], factor),
            np.ldexp(layer.bias[0], before + factor),
            "relu" if layer.relu else "none",
            fmt,
            "f16" if precision == "fp8" and layer is layers[-1] else "f32",
        )
        for layer, before, factor in zip(layers, inputs, factors, strict=True)
    )
    return Network(tuple(layers), precision, narrow, np.float32(2.0 ** inputs[0]))
