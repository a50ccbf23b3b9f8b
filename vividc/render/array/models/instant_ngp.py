"""Instant-NGP as a field that the array computes."""

from __future__ import annotations

from typing import Final

import numpy as np

from vividc.render.array.device.blocks import BLOCK, batches, in_blocks, run_blocks
from vividc.render.array.device.device import Device
from vividc.render.array.device.launch import Words
from vividc.render.array.models.field import ArrayField
from vividc.render.array.models.hash_encoding import hash_encoding
from vividc.render.array.network.calibration import Calibrated, calibrated
from vividc.render.array.network.networks import dense_layers, network
from vividc.render.array.options import RenderPrecision
from vividc.render.array.pieces import RAYS
from vividc.render.array.records import (
    Kept,
    Listed,
    Results,
    blocks_of_samples,
    of_pieces,
    place_in_block,
)
from vividc.render.array.steering import NGP_BATCH
from vividc.render.arrays import Float32Array
from vividc.render.radiance import InstantNGP
from vividc.render.radiance.instant_ngp import DIRECTION_TERMS

_LANES: Final = 4
"""Numbers of float8 in a word."""
_BLOCKS: Final = 2
"""That a launch makes inputs of, at least, if a piece has as many samples as fit."""
_ARRAYS: Final = 6
"""Of such a launch, and of the next one."""
_KERNELS: Final = "render/instant_ngp"


class InstantNGPField(ArrayField):
    """`ArrayField` of an Instant-NGP model: hash encoding, density and colour networks.

    Raises
    ------
    SceneError
        The model has a form that the kernels have not (see `hash_encoding`), or its networks run on
        no array in this format.
    """

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
        self._terms = DIRECTION_TERMS // (_LANES if is_fp8 else 1)
        self.most_samples = min(self.most_samples, self._samples_that_fit(device))
        self._outputs = self._density_network.room(0)
        for net in (self._density_network, self._colour_network):
            net.mode(device)

    def _samples_that_fit(self, device: Device) -> int:
        """Return how many samples of a piece fit, by their outputs, beside what launches make of
        some blocks of them.
        """
        width, made = self._density_network.outputs, self._colour_network.empty(2 * _BLOCKS)
        held = 2 * BLOCK * width + RAYS * self._terms + made.size + 2 * _BLOCKS * BLOCK
        return max(BLOCK, device.fitting(width, held, _ARRAYS, copies=1))

    def densities(self, listed: Listed) -> Results:
        """Return the exponents of densities, the first outputs of their network; all stay here."""
        device, net, points = self._device, self._density_network, listed.points()
        self._outputs = net.room(len(points))
        for place, (blocks,) in batches(NGP_BATCH, points):
            inputs = net.empty(len(blocks))
            self._encoding.encode(device, "hash encoding", blocks.reshape(-1, 3), inputs)
            self._outputs[place] = net.run(device, "density network", net.rounded(device, inputs))
        scalars = {
            "most": np.float32(self._model.exponent_max),
            "step": np.float32(self._model.march.step),
        }
        return Results(
            net.named("transmittance_of_exponents"),
            {"x": blocks_of_samples(net.bits(self._outputs)[:, 0])},
            lambda piece: {**place_in_block(piece), **scalars},
        )

    def colours(self, kept: Kept) -> Results:
        """Return what sigmoids make colours of; pieces begin with a block."""
        device, net, blocks = self._device, self._colour_network, kept.blocks
        inputs = net.empty(blocks[-1].stop)
        given = (net.bits(self._outputs), self._encoded(kept.directions))
        kernel = net.named(f"{_KERNELS}:colour_inputs")
        kept.fill_blocks(kernel, *given, net.own(inputs), net.scaling)
        outputs = net.room(BLOCK * len(inputs))
        for first in range(0, len(inputs), NGP_BATCH // BLOCK):
            place = slice(first, first + NGP_BATCH // BLOCK)
            some = net.rounded(device, inputs[place])
            outputs[place] = net.run(device, "colour network", some)
        x = of_pieces([net.bits(outputs)[some] for some in blocks])
        return Results(net.named("accumulate_sigmoids"), {"x": x}, lambda _: {"first": 0})

    def _encoded(self, directions: Float32Array) -> Words:
        """Return the directions' terms [R, 16], or words of four of them [R, 4]."""
        net, blocks = self._colour_network, in_blocks(directions)
        kernel = net.named(f"{_KERNELS}:directions")
        out = net.bits(np.empty((*blocks.shape[:2], self._terms), np.float32))
        given, made = {"directions": blocks}, {"out": out}
        run_blocks(self._device, "direction encoding", kernel, given, made, net.scaling)
        return out.reshape(-1, self._terms)
