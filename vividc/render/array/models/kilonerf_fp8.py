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
_PLACE_WORDS: Final = 4
"""A sample's place in its cell, and its thickness."""
_ARRAYS: Final = 6
"""Of the kernel of densities."""
_TOGETHER: Final = 2
"""Samples that the kernels compute together."""


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
    # Beside the weights of two networks lie what two launches move, and hidden layers once.
    record = 2 * (_PLACE_WORDS + CHUNK_WORDS) + 2 * CHUNK_WORDS
    most = device.fitting(record, 2 * words.density[0].size, 2 * _ARRAYS, copies=1)
    samples = most // _TOGETHER * _TOGETHER
    room = (samples * CHUNK_WORDS,)
    return Networks(
        at_once=samples,
        together=_TOGETHER,
        extra=2.0,
        density=Half(
            kernel=f"{_FILE}:density_network",
            weights=words.density,
            takes=[("local", 0)],
            shapes=lambda count: {
                "local": (count, 3),
                "features": room,
                "thickness": (count,),
            },
            scalars=lambda network: {"step": float(step * words.density_units[network])},
            work={"low": room, "high": room},
        ),
        colour=Half(
            kernel=f"{_FILE}:colour_network",
            weights=words.colour,
            takes=[("features", 0), ("seen", 0)],
            shapes=lambda count: {"features": room, "seen": room, "colours": (count, 3)},
            scalars=lambda network: {"unit": float(words.colour_units[network])},
            work={"hidden": room},
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
