"""KiloNeRF's networks with float8 operands (kernels/render/kilonerf_fp8.py)."""

from __future__ import annotations

from typing import Final

import numpy as np

from vividc.render.array.device.device import Device
from vividc.render.array.models.kilonerf_half import Half, Networks
from vividc.render.array.models.kilonerf_words import CHUNK_WORDS, WIDTH, fp8_words
from vividc.render.array.records import UInt32Array
from vividc.render.arrays import Float32Array
from vividc.render.errors import SceneError
from vividc.render.radiance import KiloNeRF

_FILE: Final = "render/kilonerf_fp8"
_AT_ONCE: Final = 144
"""Samples of a launch: as many as fit twice beside the weights of two networks."""
_ROOM: Final = (_AT_ONCE * CHUNK_WORDS,)


def fp8_networks(model: KiloNeRF, device: Device) -> Networks:
    """Return networks that take inputs and weights as float8 (E4M3), and add in float32. Features
    are float8, too: a row of them is eight words.

    Raises
    ------
    SceneError
        Hidden layers are not 32 wide.
    """
    hidden = model.weights[1].shape[2]
    if hidden != WIDTH:
        raise SceneError(
            f"the networks' hidden layers are {hidden} wide, and float8 takes {WIDTH}",
            loc="--precision",
            hint="leave it out, or train with hidden layers of 32",
        )
    words = fp8_words(model)
    step = model.march.step
    return Networks(
        at_once=_AT_ONCE,
        together=2,
        extra=2.0,
        density=Half(
            kernel=f"{_FILE}:density_network",
            weights=words.density,
            takes=[("local", 0)],
            shapes=lambda count: {
                "local": (count, 3),
                "features": _ROOM,
                "thickness": (count,),
            },
            scalars=lambda network: {"step": float(step * words.density_units[network])},
            work={"low": _ROOM, "high": _ROOM},
        ),
        colour=Half(
            kernel=f"{_FILE}:colour_network",
            weights=words.colour,
            takes=[("features", 0), ("seen", 0)],
            shapes=lambda count: {"features": _ROOM, "seen": _ROOM, "colours": (count, 3)},
            scalars=lambda network: {"unit": float(words.colour_units[network])},
            work={"hidden": _ROOM},
        ),
        features=("features", CHUNK_WORDS),
        positions=lambda _, local: local,  # the kernel encodes them itself
        directions=_encoded,
    )


def _encoded(device: Device, directions: Float32Array) -> UInt32Array:
    """Return the words of encoded directions, [n, 8]."""
    seen = np.zeros((len(directions), CHUNK_WORDS), np.uint32)
    device.spread("direction encoding", f"{_FILE}:encode_direction", directions, seen)
    return seen
