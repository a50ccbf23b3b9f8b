"""Instant-NGP as a field that the array computes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from vividc.render.array.device.block_map import BlockMap
from vividc.render.array.device.device import Device
from vividc.render.array.device.frame import Ledger
from vividc.render.array.device.gather import gather_rows
from vividc.render.array.models.field import Features, ModelField
from vividc.render.array.models.hash_encoding import hash_encoding
from vividc.render.array.network.calibration import largest_inputs
from vividc.render.array.network.narrow import network
from vividc.render.array.network.networks import batches, dense_layer, room_for
from vividc.render.array.options import RenderPrecision
from vividc.render.arrays import Float32Array, Int32Array
from vividc.render.radiance import InstantNGP
from vividc.render.radiance.instant_ngp import DIRECTION_TERMS

_BATCH: Final = 32_768
"""Samples that go through the stages together; a multiple of a block's."""
_CHANNELS: Final = 3
_LANES: Final = 4
"""Numbers of float8 in a word."""


class InstantNGPField(ModelField):
    """`ArrayField` of an Instant-NGP model: hash encoding, density and colour networks.

    Parameters
    ----------
    model
        As read from a scene.
    device
        Where it is computed.
    precision
        Of the networks' operands.

    Raises
    ------
    SceneError
        The model has a form that the kernels have not (see `hash_encoding`), or its networks run on
        no array in this format.
    """

    def __init__(
        self, model: InstantNGP, device: Device, precision: RenderPrecision = "fp32"
    ) -> None:
        super().__init__(model)
        self._model, self._device = model, device
        self._encoding = hash_encoding(model)
        largest = {} if precision == "fp32" else largest_inputs(model)
        density_layers = [
            dense_layer(weights, relu=hidden)
            for weights, hidden in zip(model.density_weights, (True, False), strict=True)
        ]
        self._density_network = network(density_layers, precision, _of(largest, "sigma"))
        first, *others = model.colour_weights
        # The kernel puts the direction's terms before the features.
        swapped = np.concatenate((first[-DIRECTION_TERMS:], first[:-DIRECTION_TERMS]))
        colour_layers = [
            dense_layer(weights, relu=hidden)
            for weights, hidden in zip((swapped, *others), (True, True, False), strict=True)
        ]
        self._colour_network = network(colour_layers, precision, _of(largest, "rgb"))
        self._features = model.density_weights[-1].shape[1]
        for net in (self._density_network, self._colour_network):
            net.check(device)

    def density(self, points: Float32Array, ledger: Ledger) -> tuple[Float32Array, Float32Array]:
        """Return optical thickness [n] of one step, and the density network's outputs [n, F]."""
        count = len(points)
        thickness, features = room_for(count), room_for(count, self._features)
        for place, (blocks,) in batches(_BATCH, points):
            self._density(blocks, thickness[place], features[place], ledger)
        return thickness.reshape(-1)[:count], features.reshape(-1, self._features)[:count]

    def colour(
        self,
        points: Float32Array,
        features: Features,
        rays: Int32Array,
        directions: Float32Array,
        ledger: Ledger,
    ) -> Float32Array:
        """Return r, g, b [n, 3] of features seen along their rays' unit `directions` [R, 3]."""
        count = len(features)
        directions = gather_rows(self._device, ledger, "compaction", directions, [rays])
        rgb = room_for(count, _CHANNELS)
        for place, (blocks, seen) in batches(_BATCH, features.view(np.float32), directions):
            self._colour(blocks, seen, rgb[place], ledger)
        return rgb.reshape(-1, _CHANNELS)[:count]

    def _density(
        self,
        points: Float32Array,
        thickness: Float32Array,
        features: Float32Array,
        ledger: Ledger,
    ) -> None:
        device, net = self._device, self._density_network
        encoded = net.room(len(points))
        self._encoding.encode(device, ledger, "hash encoding", points, encoded)
        inputs = net.rounded(device, ledger, "rounding", encoded)
        outputs = net.run(device, ledger, "density network", inputs)
        BlockMap(
            kernel="render/instant_ngp:density",
            inputs={"x": outputs},
            outputs={"thickness": thickness, "features": features},
            scalars={
                "limit": np.float32(self._model.exponent_max),
                "step": np.float32(self._model.march.step),
            },
        ).run(device, ledger, "density")

    def _colour(
        self, features: Float32Array, directions: Float32Array, rgb: Float32Array, ledger: Ledger
    ) -> None:
        device = self._device
        inputs = self._colour_network.made(
            device,
            ledger,
            "direction encoding",
            "render/instant_ngp:colour_inputs",
            {"features": features, "directions": directions},
            rounds=self._features % _LANES == 0,
        )
        outputs = self._colour_network.run(device, ledger, "colour network", inputs)
        BlockMap(
            kernel="render/instant_ngp:colour", inputs={"x": outputs}, outputs={"out": rgb}
        ).run(device, ledger, "colour")


def _of(largest: Mapping[str, float], name: str) -> list[float]:
    """Return the figures of the layers of a network, in order."""
    return [value for layer, value in sorted(largest.items()) if layer.startswith(name)]
