"""TensoRF as a field that the array computes."""

from __future__ import annotations

from typing import Final

import numpy as np
import numpy.typing as npt

from vividc.render.array.device.blocks import BLOCK, batches
from vividc.render.array.device.device import Device
from vividc.render.array.models.factors import CHANNELS, KERNELS, channel_pairs, factor_grid
from vividc.render.array.models.field import ArrayField
from vividc.render.array.network.calibration import Calibrated, calibrated
from vividc.render.array.network.networks import dense_layers, network
from vividc.render.array.options import RenderPrecision
from vividc.render.array.records import (
    Columns,
    Kept,
    Listed,
    Results,
    blocks_of_samples,
    place_in_block,
)
from vividc.render.array.steering import TENSORF_BATCH
from vividc.render.arrays import Float32Array
from vividc.render.radiance import TensoRF
from vividc.render.radiance.tensorf import LINE_AXES

_CHANNELS: Final = 3
_FEATURES: Final = 27


class TensoRFField(ArrayField):
    """`ArrayField` of a TensoRF model: factors, and the colour network.

    Raises
    ------
    SceneError
        Its networks run on no array in this format.
    """

    def __init__(self, model: TensoRF, device: Device, precision: RenderPrecision = "fp32") -> None:
        super().__init__(model, device)
        self._model = model
        lines = dict(zip(LINE_AXES, model.density_factors, strict=True))
        self._grid = factor_grid(model.march, [len(lines[axis].line) for axis in range(3)], device)
        basis, mlp = calibrated(
            model,
            precision,
            {"basis": Calibrated([model.basis]), "mlp": Calibrated(model.weights, model.biases)},
        )
        layers = dense_layers([_spread(model, basis.weights[0])], basis.biases)
        self._basis = network(layers, precision, basis.largest)
        one, is_fp8 = np.float32(1), self._basis.is_fp8
        scale = self._basis.scale if is_fp8 else one
        self._density_pairs = channel_pairs(model.density_factors, is_fp8, one)
        self.sample_words = max(self.sample_words, 3 + len(self._density_pairs))
        self._appearance_pairs = channel_pairs(model.appearance_factors, is_fp8, scale)
        first, *others = mlp.weights
        if is_fp8:
            first = first[_by_words()]  # the order in which the kernel makes words of them
        layers = dense_layers([first, *others], mlp.biases)
        self._colour_network = network(layers, precision, mlp.largest)
        for net in (self._basis, self._colour_network):
            net.mode(device)

    def densities(self, listed: Listed) -> Results:
        """Return what pairs of factors give of samples, whose sums make densities."""
        model, points = self._model, listed.points()
        pairs = self._density_pairs
        sums = np.empty((len(pairs), -(-len(points) // BLOCK), BLOCK), np.float32)
        for place, (blocks,) in batches(TENSORF_BATCH, points):
            self._grid.sums("density factors", blocks.reshape(-1, 3), pairs, sums[:, place])
        rows = sums.reshape(len(pairs), -1)
        scalars = {
            "shift": np.float32(model.density_shift),
            "step": np.float32(model.march.step * model.distance_scale),
        }
        reads: Columns = {"sums": lambda piece: rows[:, piece.samples]}
        return Results("transmittance_of_sums", reads, lambda _: scalars)

    def colours(self, kept: Kept) -> Results:
        """Return what sigmoids make colours of."""
        net, located = self._colour_network, kept.located()
        outputs = net.room(len(located[0]))
        for place, blocks in batches(TENSORF_BATCH, *located):
            outputs[place] = self._colour(*blocks)
        x = blocks_of_samples(net.bits(outputs))
        return Results(net.named("accumulate_sigmoids"), {"x": x}, place_in_block)

    def _colour(self, points: Float32Array, directions: Float32Array) -> Float32Array:
        """Return the colour network's outputs of blocks of points."""
        device, basis, net = self._device, self._basis, self._colour_network
        pairs = self._appearance_pairs
        products = self._grid.products("appearance factors", points.reshape(-1, 3), pairs)
        appearance = basis.run(device, "basis", basis.rounded(device, products))
        given = {"features": basis.bits(appearance), "directions": directions}
        kernel = f"{KERNELS}:colour_inputs"
        return net.run(
            device, "colour network", net.made(device, "position encoding", kernel, given)
        )


def _by_words() -> npt.NDArray[np.int64]:
    """Return which of the network's inputs `colour_inputs_fp8` makes after one another."""
    features, directions = np.arange(_FEATURES), np.arange(_CHANNELS)
    waves = [(30 + 2 * features, 84 + 2 * features), (138 + 2 * directions, 144 + 2 * directions)]
    parts = [
        np.stack((sines, sines + 1, cosines, cosines + 1), axis=1).ravel()
        for sines, cosines in waves
    ]
    return np.concatenate((*parts, features, _FEATURES + directions))


def _spread(model: TensoRF, basis: Float32Array) -> Float32Array:
    """Return the basis with rows of 0 for the channels that fill up a group of 16."""
    rows = []
    start = 0
    for factors in model.appearance_factors:
        channels = factors.line.shape[1]
        rows.append(np.pad(basis[start : start + channels], ((0, -channels % CHANNELS), (0, 0))))
        start += channels
    return np.concatenate(rows)
