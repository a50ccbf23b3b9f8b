"""Instant-NGP as a field that the array computes."""

from __future__ import annotations

from itertools import accumulate
from typing import Final

import numpy as np

from vividc.machine.words import WORD_BYTES
from vividc.render.array.device.blocks import BLOCK, in_blocks, run_blocks
from vividc.render.array.device.device import Device
from vividc.render.array.models.field import PointField
from vividc.render.array.models.hash_encoding import hash_encoding
from vividc.render.array.network.calibration import Calibrated, calibrated
from vividc.render.array.network.networks import dense_layers, network
from vividc.render.array.options import RenderPrecision
from vividc.render.array.records import Colours, Kept, UInt32Array
from vividc.render.array.steering import NGP_BATCH, NGP_ROWS
from vividc.render.arrays import Float32Array
from vividc.render.radiance import InstantNGP
from vividc.render.radiance.instant_ngp import DIRECTION_TERMS

_LANES: Final = 4
"""Numbers of float8 in a word."""
_HALVES: Final = 2
"""The same of float16."""
_KERNELS: Final = "render/instant_ngp"


class InstantNGPField(PointField):
    """`ArrayField` of an Instant-NGP model: hash encoding, density and colour networks.

    Raises
    ------
    SceneError
        The model has a form that the kernels have not (see `hash_encoding`), or its networks run on
        no array in this format.
    """

    batch = NGP_BATCH

    def __init__(
        self, model: InstantNGP, device: Device, precision: RenderPrecision = "fp32"
    ) -> None:
        super().__init__(model, device)
        self._model = model
        sigma, rgb = calibrated(
            model,
            precision,
            {"sigma": Calibrated(model.density_weights), "rgb": Calibrated(model.colour_weights)},
        )
        first, last = sigma.weights
        # The encoding has features in fours, and so have float8 words; weights of the others are 0.
        first = np.pad(first, ((0, -len(first) % _LANES), (0, 0)))
        missing = -last.shape[1] % _LANES if precision == "fp8" else 0
        last = np.pad(last, ((0, 0), (0, missing)))
        biases = [np.pad(bias, (0, -len(bias) % _LANES)) for bias in sigma.biases]
        layers = dense_layers([first, last], biases)
        self._density_network = network(layers, precision, sigma.largest)
        is_fp8 = self._density_network.is_fp8
        self._encoding = hash_encoding(model, self._density_network.scale if is_fp8 else None)
        first, *others = rgb.weights
        # The kernel puts the direction's terms before the features.
        swapped = np.concatenate((first[-DIRECTION_TERMS:], first[:-DIRECTION_TERMS]))
        swapped = np.pad(swapped, ((0, missing), (0, 0)))
        layers = dense_layers([swapped, *others], rgb.biases)
        self._colour_network = network(layers, precision, rgb.largest)
        self.words = last.shape[1] // (_HALVES if is_fp8 else 1)
        self.are_in_blocks = is_fp8
        if is_fp8:
            words = device.scratchpad_bytes // WORD_BYTES
            self.most_samples = min(self.most_samples, int(NGP_ROWS * words) // self.words)
        for net in (self._density_network, self._colour_network):
            net.mode(device)

    def colours(self, kept: Kept) -> Colours:
        """Return r, g, b [n, 3] of each piece's samples."""
        net = self._colour_network
        if not net.is_fp8:
            return super().colours(kept)
        # A direction is encoded once for all samples of its ray.
        kernel = f"{_KERNELS}:colour_inputs_fp8"
        scalars = {"scale": net.scale}
        inputs = kept.in_blocks(kernel, self._encoded(kept.directions), net.inputs, scalars)
        rgb = np.empty((len(inputs), BLOCK, 3), dtype=np.float32)
        for first in range(0, len(inputs), self.batch // BLOCK):
            place = slice(first, first + self.batch // BLOCK)
            net.colours(self._device, inputs[place].view(np.float32), rgb[place])
        rows = rgb.reshape(-1, 3)
        firsts = accumulate((-(-n // BLOCK) * BLOCK for n in kept.lengths), initial=0)
        of_pieces = zip(firsts, kept.lengths, strict=False)
        return Colours([rows[first : first + n] for first, n in of_pieces])

    def _density(
        self, points: Float32Array, thickness: Float32Array, features: Float32Array
    ) -> None:
        device, net = self._device, self._density_network
        inputs = net.empty(len(points))
        self._encoding.encode(device, "hash encoding", points.reshape(-1, 3), inputs)
        outputs = net.run(device, "density network", net.rounded(device, inputs))
        scalars = {
            "limit": np.float32(self._model.exponent_max),
            "step": np.float32(self._model.march.step),
        }
        kernel, given = net.named(f"{_KERNELS}:density"), net.bits(outputs)
        made = {"thickness": thickness}
        if net.is_fp8:  # the outputs are the features
            features[...], given = outputs, given[:, 0]
        else:
            made["features"] = features
        run_blocks(device, "density", kernel, {"x": given}, made, scalars)

    def _colour(
        self,
        features: Float32Array,
        points: Float32Array,
        directions: Float32Array,
        rgb: Float32Array,
    ) -> None:
        """Of features that are not float8."""
        device, net = self._device, self._colour_network
        given = {"features": features, "directions": directions}
        kernel = f"{_KERNELS}:colour_inputs"
        net.colours(device, net.made(device, "direction encoding", kernel, given), rgb)

    def _encoded(self, directions: Float32Array) -> UInt32Array:
        """Return the directions' terms as float8 words, [R, 4] uint32."""
        blocks = in_blocks(directions)
        out = np.empty((*blocks.shape[:2], DIRECTION_TERMS // _LANES), np.uint32)
        kernel, scalars = f"{_KERNELS}:directions_fp8", {"scale": self._colour_network.scale}
        given = {"directions": blocks}
        run_blocks(self._device, "direction encoding", kernel, given, {"out": out}, scalars)
        return out.reshape(-1, out.shape[2])
