"""KiloNeRF's networks in float32 (kernels/render/kilonerf.py)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Final

import numpy as np
import numpy.typing as npt

from vividc.render.array.device.device import Device
from vividc.render.array.models.kilonerf_half import Half, Networks
from vividc.render.arrays import Float32Array
from vividc.render.errors import SceneError
from vividc.render.radiance import KiloNeRF

_FILE: Final = "render/kilonerf"
_POSITION_TERMS: Final = 63
_AXES: Final = 3
_DIRECTION_TERMS: Final = 27
_AT_ONCE: Final = 12
"""Samples of a launch, at most."""
_QUAD: Final = 4
_OCTET: Final = 8
_SPARE_WORDS: Final = 256


def fp32_networks(model: KiloNeRF, device: Device) -> Networks:
    """Return networks of float32.

    Raises
    ------
    SceneError
        A network fits no scratchpad, or its hidden layers are no multiple of 8 wide.
    """
    hidden = model.weights[1].shape[2]
    if hidden % _OCTET:
        raise SceneError(
            f"the networks' hidden layers are {hidden} wide, not a multiple of {_OCTET}",
            hint="train with hidden layers of 32",
        )
    samples = _samples_at_once(hidden, device)
    return Networks(
        at_once=samples,
        together=_QUAD,
        extra=0.0,
        density=_density_half(model, samples),
        colour=_colour_half(model, samples),
        features=("values", hidden),
        positions=partial(_encoded, kind="position", terms=_POSITION_TERMS),
        directions=partial(_encoded, kind="direction", terms=_DIRECTION_TERMS),
    )


def _encoded(device: Device, vectors: Float32Array, kind: str, terms: int) -> Float32Array:
    """Return the terms of each vector, [n, terms], one coordinate after the other."""
    out = np.zeros((vectors.size, terms // _AXES), dtype=np.float32)
    device.spread("position encoding", f"{_FILE}:encode_{kind}", vectors.ravel(), out)
    return out.reshape(len(vectors), terms)


def _samples_at_once(hidden: int, device: Device) -> int:
    """Return how many samples fit beside a network's weights, in fours."""
    weights = (_POSITION_TERMS + hidden + hidden + _OCTET) * hidden + 4 * hidden
    row = _POSITION_TERMS + 2 * hidden + _OCTET
    for copies in (2, 1):
        room = device.fitting(row, weights + _SPARE_WORDS, copies=copies)
        count = min(_AT_ONCE, room) // _QUAD * _QUAD
        if count:
            return count
    raise SceneError(
        f"a network of {weights} weights does not fit a scratchpad of "
        f"{device.scratchpad_bytes} bytes",
        hint="train smaller networks, or use a fabric with larger scratchpads",
    )


def _density_half(model: KiloNeRF, samples: int) -> Half:
    """Three layers; the last one's first neuron is the density, the others are the features.

    In `values` lie the encoded positions, which the features overwrite, then two hidden layers; the
    density overwrites the first.
    """
    hidden = model.weights[1].shape[2]
    pitch = hidden + 1
    one = samples * _POSITION_TERMS
    two = one + samples * pitch
    w1, w2, w3 = (np.asarray(weights) for weights in model.weights[:3])
    w1 = w1[:, by_coordinate(_POSITION_TERMS)]
    b1, b2, b3 = (np.asarray(bias) for bias in model.biases[:3])
    parts = (w1, w2, w3[:, :, 1:], _octet(w3[:, :, :1]), b1, b2, b3[:, 1:], _octet(b3[:, :1]))
    at = _offsets(parts)
    layers = (
        (0, _POSITION_TERMS, _POSITION_TERMS, at[0], hidden, one, pitch, 1, at[4]),
        (one, pitch, hidden, at[1], hidden, two, pitch, 1, at[5]),
        (two, pitch, hidden, at[2], hidden, 0, hidden, 0, at[6]),
        (two, pitch, hidden, at[3], _OCTET, one, _OCTET + 1, 0, at[7]),
    )
    words = samples * (_POSITION_TERMS + 2 * pitch)
    step = float(model.march.step)
    return Half(
        kernel=f"{_FILE}:density_network",
        weights=_packed(parts),
        takes=[("values", 0)],
        shapes=lambda count: {"values": (words,), "thickness": (count,)},
        scalars=lambda _: {"first": one, "pitch": _OCTET + 1, "step": step},
        shared={"layers": np.array(layers, dtype=np.int32)},
    )


def _colour_half(model: KiloNeRF, samples: int) -> Half:
    """Two layers; in `values` lie the features, the encoded directions, the hidden layer and the
    result.
    """
    hidden = model.weights[1].shape[2]
    pitch = hidden + 1
    seen = samples * hidden
    one = seen + samples * _DIRECTION_TERMS
    two = one + samples * pitch
    w4, w5 = (np.asarray(weights) for weights in model.weights[3:])
    b4, b5 = (np.asarray(bias) for bias in model.biases[3:])
    seen_weights = w4[:, hidden:][:, by_coordinate(_DIRECTION_TERMS)]
    parts = (w4[:, :hidden], seen_weights, _octet(w5), b4, _octet(b5))
    at = _offsets(parts)
    layers = (
        (0, hidden, hidden, at[0], hidden, one, pitch, 0, at[3]),
        (seen, _DIRECTION_TERMS, _DIRECTION_TERMS, at[1], hidden, one, pitch, 1, -1),
        (one, pitch, hidden, at[2], _OCTET, two, _OCTET + 1, 0, at[4]),
    )
    words = samples * (hidden + _DIRECTION_TERMS + pitch + _OCTET + 1)
    return Half(
        kernel=f"{_FILE}:colour_network",
        weights=_packed(parts),
        takes=[("values", 0), ("values", seen)],
        shapes=lambda count: {"values": (words,), "colours": (count, 3)},
        scalars=lambda _: {"first": two, "pitch": _OCTET + 1},
        shared={"layers": np.array(layers, dtype=np.int32)},
    )


def by_coordinate(terms: int) -> npt.NDArray[np.int64]:
    """Return the models' place of each term of an encoding, one coordinate after the other."""
    return np.arange(terms).reshape(-1, _AXES).T.ravel()


def _octet(array: Float32Array) -> Float32Array:
    """Return an array whose last axis is filled up to 8 with zeros."""
    filled = np.zeros((*array.shape[:-1], _OCTET), dtype=np.float32)
    filled[..., : array.shape[-1]] = array
    return filled


def _offsets(parts: Sequence[Float32Array]) -> list[int]:
    sizes = [part[0].size for part in parts]
    return [sum(sizes[:index]) for index in range(len(parts))]


def _packed(parts: Sequence[Float32Array]) -> tuple[Float32Array, ...]:
    """Return the words of each network, one after the other."""
    rows = [part.reshape(len(part), -1) for part in parts]
    whole = np.concatenate(rows, axis=1, dtype=np.float32)
    return tuple(whole)
