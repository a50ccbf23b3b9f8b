"""KiloNeRF's networks on the array with float8 operands (kernels/render/kilonerf_fp8.py)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vividc.render.array.device.device import Device
from vividc.render.array.device.frame import Ledger
from vividc.render.array.device.launch import Launch
from vividc.render.array.models.grouping import Part
from vividc.render.array.models.kilonerf import KiloNeRFOnArray
from vividc.render.array.models.kilonerf_words import CHUNK_WORDS, WIDTH, fp8_words
from vividc.render.arrays import Float32Array, Int32Array
from vividc.render.errors import SceneError
from vividc.render.radiance import KiloNeRF

_FILE = "render/kilonerf_fp8"
_MAPPING_S = 150.0
"""Their loops' IIs are the time of a frame."""
_AT_ONCE = 144
"""Samples of a launch: as many as fit twice beside the weights of two networks."""
_ROOM = (_AT_ONCE * CHUNK_WORDS,)


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
        self, local: Float32Array, parts: Sequence[Part], ledger: Ledger
    ) -> tuple[Float32Array, Float32Array]:
        features = np.zeros((len(local), CHUNK_WORDS), dtype=np.float32)
        thickness = np.zeros(len(local), dtype=np.float32)
        words = self._words
        launches = [
            Launch(
                shapes={
                    "local": (part.count, 3),
                    "features": _ROOM,
                    "thickness": (part.count,),
                },
                inputs={"local": part.moves(local)},
                outputs={"thickness": part.moves(thickness), "features": part.moves(features)},
                shared={"weights": words.density[part.network]},
                work={"low": _ROOM, "high": _ROOM},
                scalars={"step": float(self._model.march.step * words.density_units[part.network])},
                cost=_cost(part.count),
            )
            for part in parts
        ]
        kernel = f"{_FILE}:density_network"
        self._run("density network", kernel, launches, ledger, time_limit_s=_MAPPING_S)
        return thickness, features

    def _colour_network(
        self,
        rows: Int32Array,
        rays: Int32Array,
        directions: Float32Array,
        parts: Sequence[Part],
        ledger: Ledger,
    ) -> Float32Array:
        seen = np.zeros((len(directions), CHUNK_WORDS), np.uint32)
        kernel = f"{_FILE}:encode_direction"
        self._device.spread(ledger, "direction encoding", kernel, directions, seen)
        colours = np.full((len(rows), 3), 0.5, dtype=np.float32)
        words = self._words
        launches = [
            Launch(
                shapes={"features": _ROOM, "seen": _ROOM, "colours": (part.count, 3)},
                inputs={
                    "features": part.moves(self._features, rows=rows),
                    "seen": part.moves(seen, rows=rays),
                },
                outputs={"colours": part.moves(colours)},
                shared={"weights": words.colour[part.network]},
                work={"hidden": _ROOM},
                scalars={"unit": float(words.colour_units[part.network])},
                cost=_cost(part.count),
            )
            for part in parts
        ]
        kernel = f"{_FILE}:colour_network"
        self._run("colour network", kernel, launches, ledger, time_limit_s=_MAPPING_S)
        return colours


def _cost(samples: int) -> float:
    """Return about how long a launch takes, in pairs of samples: the loops have to fill, too."""
    return -(-samples // 2) + 2.0
