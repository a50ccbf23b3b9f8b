"""KiloNeRF's networks on the array with float8 operands (kernels/render/kilonerf_fp8.py)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vividc import LoopOptions
from vividc.render.array.device.device import Device
from vividc.render.array.device.frame import Ledger
from vividc.render.array.device.launches import Launch, Move, run_launches
from vividc.render.array.models.kilonerf import KiloNeRFOnArray, Pieces
from vividc.render.array.models.kilonerf_words import CHUNK_WORDS, WIDTH, fp8_words
from vividc.render.arrays import Float32Array
from vividc.render.errors import SceneError
from vividc.render.radiance import KiloNeRF

_FILE = "render/kilonerf_fp8"
_MAPPING_S = 150.0
"""Their loops' IIs are the time of a frame."""
_AT_ONCE = 64
"""Samples of a launch: as many as fit twice beside the weights of two networks."""
_STRIDE = _AT_ONCE * CHUNK_WORDS


class Fp8KiloNeRF(KiloNeRFOnArray):
    """A `KiloNeRF` whose networks take inputs and weights as float8 (E4M3), and add in float32.

    Features are float8, too: a row of them is eight words.

    Raises
    ------
    SceneError
        Hidden layers are not 32 wide.
    """

    def __init__(self, model: KiloNeRF, device: Device) -> None:
        super().__init__(model, device)
        if self._hidden != WIDTH:
            raise SceneError(
                f"the networks' hidden layers are {self._hidden} wide, and float8 takes {WIDTH}",
                loc="--precision",
                hint="leave it out, or train with hidden layers of 32",
            )
        self._words = fp8_words(model)
        self._at_once = _AT_ONCE

    def _density_network(
        self, local: Float32Array, pieces: Pieces, ledger: Ledger
    ) -> tuple[Float32Array, Float32Array]:
        low, high, features = (np.zeros((len(local), CHUNK_WORDS), np.uint32) for _ in range(3))
        kernel = f"{_FILE}:encode_position"
        self._device.spread(ledger, "position encoding", kernel, local, low, high)
        thickness = np.zeros(len(local), dtype=np.float32)
        words, launches = self._words, []
        for network, part in self._parts(pieces):
            count = part.stop - part.start
            weights = words.density[network]
            launches.append(
                Launch(
                    shapes=_shapes("inputs", "hidden", "features"),
                    inputs={"inputs": (Move(low[part]), Move(high[part], _STRIDE))},
                    outputs={
                        "thickness": thickness[part],
                        "features": (Move(features[part]),),
                    },
                    shared={"weights": weights},
                    scalars={
                        "step": float(self._model.march.step * words.density_units[network]),
                        "stride": _STRIDE,
                    },
                    cost=_cost(count),
                )
            )
        self._run_fp8("density network", "density_network", launches, ledger)
        return thickness, features.view(np.float32)

    def _colour_network(
        self, features: Float32Array, directions: Float32Array, pieces: Pieces, ledger: Ledger
    ) -> Float32Array:
        seen = np.zeros((len(features), CHUNK_WORDS), np.uint32)
        kernel = f"{_FILE}:encode_direction"
        self._device.spread(ledger, "position encoding", kernel, directions, seen)
        colours = np.full((len(features), 3), 0.5, dtype=np.float32)
        words, launches = self._words, []
        for network, part in self._parts(pieces):
            count = part.stop - part.start
            weights = words.colour[network]
            launches.append(
                Launch(
                    shapes=_shapes("inputs", "hidden"),
                    inputs={"inputs": (Move(features[part]), Move(seen[part], _STRIDE))},
                    outputs={"colours": colours[part]},
                    shared={"weights": weights},
                    scalars={"unit": float(words.colour_units[network]), "stride": _STRIDE},
                    cost=_cost(count),
                )
            )
        self._run_fp8("colour network", "colour_network", launches, ledger)
        return colours

    def _run_fp8(self, stage: str, kernel: str, launches: Sequence[Launch], ledger: Ledger) -> None:
        run_launches(
            self._device,
            ledger,
            stage,
            f"{_FILE}:{kernel}",
            launches,
            loops=LoopOptions(auto=False),
            time_limit_s=_MAPPING_S,
        )


def _shapes(first: str, *others: str) -> dict[str, tuple[int, ...]]:
    """Return the sizes of the inputs, two chunks, and of arrays of one chunk."""
    sizes: dict[str, tuple[int, ...]] = {first: (2 * _STRIDE,)}
    return sizes | dict.fromkeys(others, (_STRIDE,))


def _cost(samples: int) -> float:
    """Return about how long a launch takes, in pairs of samples: the loops have to fill, too."""
    return -(-samples // 2) + 2.0
