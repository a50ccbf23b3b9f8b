"""KiloNeRF on the array: samples sorted by network, each network's weights in one scratchpad."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vividc import LoopOptions
from vividc.machine.words import WORD_BYTES
from vividc.render.array.device.device import Device
from vividc.render.array.device.frame import Ledger
from vividc.render.array.device.launch import Launch
from vividc.render.array.device.launches import run_launches
from vividc.render.array.models.field import Colours, Densities, Kept, Listed, ModelField
from vividc.render.array.models.grouping import Grouping, Part, Samples, parts_of
from vividc.render.arrays import Float32Array, Int32Array
from vividc.render.errors import SceneError
from vividc.render.radiance import KiloNeRF

_KERNELS = "render/kilonerf"
_POSITION_TERMS = 63
_AXES = 3
_DIRECTION_TERMS = 27
_AT_ONCE = 12
"""Samples of a launch of a network: as many as fit twice beside its weights."""
_QUAD = 4
_OCTET = 8
_SPARE_BYTES = 1024


@dataclass(frozen=True, slots=True, eq=False)
class _Half:
    """One half of all networks as the kernels read it: weights of each, and the layers' table.

    `first` and `pitch` say where the results are that the kernel finishes, `words` how much room
    a sample takes.
    """

    weights: tuple[Float32Array, ...]
    layers: Int32Array
    first: int
    pitch: int
    words: int


class KiloNeRFOnArray(ModelField):
    """A `KiloNeRF` as an `ArrayField`.

    The features of a call of `densities` stay where the networks wrote them, in the order of
    networks, until its next call; it returns none.

    Raises
    ------
    SceneError
        A network fits no scratchpad, or its hidden layers are no multiple of 8 wide.
    """

    def __init__(self, model: KiloNeRF, device: Device) -> None:
        super().__init__(model)
        self._model = model
        self._device = device
        hidden = model.weights[1].shape[2]
        if hidden % _OCTET:
            raise SceneError(
                f"the networks' hidden layers are {hidden} wide, not a multiple of {_OCTET}",
                hint="train with hidden layers of 32",
            )
        self._hidden = hidden
        self._at_once = self._samples_at_once()
        self._density = _density_half(model, self._at_once)
        self._colour = _colour_half(model, self._at_once)
        self._grouping = Grouping(model, device)
        self.most_samples = self._grouping.most_samples
        self._samples: Samples | None = None
        self._features = np.zeros((0, hidden), dtype=np.float32)

    def densities(self, listed: Listed, ledger: Ledger) -> Densities:
        """Return what samples have, in the order of networks; their features stay here."""
        self._samples = samples = self._grouping.samples(listed, ledger)
        parts = list(parts_of(samples.runs, self._at_once))
        thickness, self._features = self._density_network(samples.local, parts, ledger)
        return Densities(thickness, np.zeros((len(thickness), 0), np.float32), samples.places)

    def colours(self, kept: Kept, ledger: Ledger) -> Colours:
        """Return r, g, b of each piece's samples, in the order of networks."""
        assert self._samples is not None
        some = self._grouping.survivors(self._samples, kept, ledger)
        parts = list(parts_of(some.runs, self._at_once))
        rgb = self._colour_network(some.rows, some.rays, kept.directions, parts, ledger)
        return Colours([rgb[piece.samples] for piece in kept.pieces], some.places)

    def _density_network(
        self, local: Float32Array, parts: Sequence[Part], ledger: Ledger
    ) -> tuple[Float32Array, Float32Array]:
        """Return thickness [n] and features [n, words] of sorted places in cells."""
        encoded = self._encoded(local, "position", _POSITION_TERMS, ledger)
        thickness = np.zeros(len(local), dtype=np.float32)
        features = np.zeros((len(local), self._hidden), dtype=np.float32)
        half = self._density
        launches = [
            Launch(
                shapes={**self._shapes(half), "thickness": (part.count,)},
                inputs={"values": part.moves(encoded)},
                outputs={
                    "thickness": part.moves(thickness),
                    "values": part.moves(features),
                },
                shared={"weights": half.weights[part.network], "layers": half.layers},
                scalars={
                    "first": half.first,
                    "pitch": half.pitch,
                    "step": float(self._model.march.step),
                },
                cost=-(-part.count // _QUAD),
            )
            for part in parts
        ]
        self._run("density network", f"{_KERNELS}:density_network", launches, ledger)
        return thickness, features

    def _colour_network(
        self,
        rows: Int32Array,
        rays: Int32Array,
        directions: Float32Array,
        parts: Sequence[Part],
        ledger: Ledger,
    ) -> Float32Array:
        """Return colours [n, 3] of sorted numbers of features and of rays."""
        seen = self._encoded(directions, "direction", _DIRECTION_TERMS, ledger)
        colours = np.full((len(rows), 3), 0.5, dtype=np.float32)
        half, second = self._colour, self._at_once * self._hidden
        launches = [
            Launch(
                shapes={**self._shapes(half), "colours": (part.count, 3)},
                inputs={
                    "values": (
                        *part.moves(self._features, rows=rows),
                        *part.moves(seen, second, rays),
                    )
                },
                outputs={"colours": part.moves(colours)},
                shared={"weights": half.weights[part.network], "layers": half.layers},
                scalars={"first": half.first, "pitch": half.pitch},
                cost=-(-part.count // _QUAD),
            )
            for part in parts
        ]
        self._run("colour network", f"{_KERNELS}:colour_network", launches, ledger)
        return colours

    def _encoded(
        self, vectors: Float32Array, kind: str, terms: int, ledger: Ledger
    ) -> Float32Array:
        """Return the terms of each vector, [n, terms], one coordinate after the other."""
        out = np.zeros((vectors.size, terms // _AXES), dtype=np.float32)
        kernel = f"{_KERNELS}:encode_{kind}"
        self._device.spread(ledger, "position encoding", kernel, vectors.ravel(), out)
        return out.reshape(len(vectors), terms)

    def _shapes(self, half: _Half) -> dict[str, tuple[int, ...]]:
        return {"values": (half.words * self._at_once,)}

    def _run(
        self,
        stage: str,
        kernel: str,
        launches: Sequence[Launch],
        ledger: Ledger,
        **options: object,
    ) -> None:
        loops = LoopOptions(auto=False)
        run_launches(self._device, ledger, stage, kernel, launches, loops=loops, **options)

    def _samples_at_once(self) -> int:
        """Return how many samples fit beside a network's weights, in fours."""
        hidden = self._hidden
        weights = (_POSITION_TERMS + hidden + hidden + _OCTET) * hidden + 4 * hidden
        free = self._device.scratchpad_bytes - WORD_BYTES * weights - _SPARE_BYTES
        row = WORD_BYTES * (_POSITION_TERMS + 2 * hidden + _OCTET)
        for copies in (2, 1):
            count: int = min(_AT_ONCE, free // (copies * row)) // _QUAD * _QUAD
            if count:
                return count
        raise SceneError(
            f"a network of {weights} weights does not fit a scratchpad of "
            f"{self._device.scratchpad_bytes} bytes",
            hint="train smaller networks, or use a fabric with larger scratchpads",
        )


def _density_half(model: KiloNeRF, samples: int) -> _Half:
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
    words = _POSITION_TERMS + 2 * pitch
    return _Half(_packed(parts), np.array(layers, dtype=np.int32), one, _OCTET + 1, words)


def _colour_half(model: KiloNeRF, samples: int) -> _Half:
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
    words = hidden + _DIRECTION_TERMS + pitch + _OCTET + 1
    return _Half(_packed(parts), np.array(layers, dtype=np.int32), two, _OCTET + 1, words)


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
