"""KiloNeRF on the array: samples sorted by network, each network's weights in one scratchpad."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from vividc import LoopOptions
from vividc.machine.words import WORD_BYTES
from vividc.render.array.device.device import Device
from vividc.render.array.device.frame import Ledger
from vividc.render.array.device.gather import gather_rows
from vividc.render.array.device.launches import Launch, Move, run_launches
from vividc.render.array.models.field import Features, ModelField
from vividc.render.arrays import Float32Array, Int32Array
from vividc.render.errors import SceneError
from vividc.render.radiance import KiloNeRF

_KERNELS = "render/kilonerf"
_POSITION_TERMS = 63
_AXES = 3
_DIRECTION_TERMS = 27
CHUNK = 1024
"""Samples that one launch sorts."""
_AT_ONCE = 12
"""Samples of a launch of a network: as many as fit twice beside its weights."""
_QUAD = 4
_OCTET = 8
_SPARE_BYTES = 1024
_SORT_ARRAYS = 5


Pieces = Sequence[tuple[int, int, int]]
"""Network, first place and number of samples of one network in one chunk."""


@dataclass(frozen=True, slots=True, eq=False)
class _Sorted:
    """Samples by chunk and, within each, by network.

    Attributes
    ----------
    order
        [n] int32 samples in that order.
    places
        [n] int32 where each sample is in it.
    pieces
        The samples of one network in one chunk.
    """

    order: Int32Array
    places: Int32Array
    pieces: Pieces


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

    The features of a call of `density` stay where the networks wrote them, sorted; those that it
    returns, [n, 1], are the numbers of their rows, as bits of a float32. They hold until its next
    call.

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
        self._box = np.concatenate((model.march.box[0], model.march.box[1] - model.march.box[0]))
        self._networks = np.ascontiguousarray(model.network, dtype=np.int32)
        self._features = np.zeros((0, hidden), dtype=np.float32)

    def density(self, points: Float32Array, ledger: Ledger) -> tuple[Float32Array, Float32Array]:
        """Return optical thickness [n] of one step, and where the features are [n, 1]."""
        device = self._device
        networks, local = self.cells_of(points, ledger)
        grouped = self._sorted(networks, ledger)
        local = gather_rows(device, ledger, "grouping", local, [grouped.order])
        thickness, features = self._density_network(local, grouped.pieces, ledger)
        self._features = features
        thickness = gather_rows(device, ledger, "grouping", thickness, [grouped.places])
        return thickness, grouped.places.view(np.float32)[:, None]

    def colour(
        self,
        points: Float32Array,
        features: Features,
        rays: Int32Array,
        directions: Float32Array,
        ledger: Ledger,
    ) -> Float32Array:
        """Return r, g, b [n, 3] of points seen along their rays' unit `directions` [R, 3]."""
        device = self._device
        directions = gather_rows(device, ledger, "compaction", directions, [rays])
        networks, _ = self.cells_of(points, ledger)
        grouped = self._sorted(networks, ledger)
        directions = gather_rows(device, ledger, "grouping", directions, [grouped.order])
        rows = gather_rows(device, ledger, "grouping", features, [grouped.order])
        inputs = gather_rows(
            device, ledger, "grouping", self._features, [rows[:, 0].view(np.int32)]
        )
        colours = self._colour_network(inputs, directions, grouped.pieces, ledger)
        return gather_rows(device, ledger, "grouping", colours, [grouped.places])

    def _density_network(
        self, local: Float32Array, pieces: Pieces, ledger: Ledger
    ) -> tuple[Float32Array, Float32Array]:
        """Return thickness [n] and features [n, words] of sorted places in cells."""
        encoded = self._encoded(local, "position", _POSITION_TERMS, ledger)
        thickness = np.zeros(len(local), dtype=np.float32)
        features = np.zeros((len(local), self._hidden), dtype=np.float32)
        half, launches = self._density, []
        for network, part in self._parts(pieces):
            count = part.stop - part.start
            launches.append(
                Launch(
                    shapes=self._shapes(half),
                    inputs={"values": (Move(encoded[part]),)},
                    outputs={
                        "thickness": thickness[part],
                        "values": (Move(features[part]),),
                    },
                    shared={"weights": half.weights[network], "layers": half.layers},
                    scalars={
                        "first": half.first,
                        "pitch": half.pitch,
                        "step": float(self._model.march.step),
                    },
                    cost=-(-count // _QUAD),
                )
            )
        self._run("density network", "density_network", launches, ledger)
        return thickness, features

    def _colour_network(
        self, features: Float32Array, directions: Float32Array, pieces: Pieces, ledger: Ledger
    ) -> Float32Array:
        """Return colours [n, 3] of sorted features and directions."""
        seen = self._encoded(directions, "direction", _DIRECTION_TERMS, ledger)
        colours = np.full((len(features), 3), 0.5, dtype=np.float32)
        half, launches = self._colour, []
        for network, part in self._parts(pieces):
            count = part.stop - part.start
            second = self._at_once * self._hidden
            launches.append(
                Launch(
                    shapes=self._shapes(half),
                    inputs={"values": (Move(features[part]), Move(seen[part], second))},
                    outputs={"colours": colours[part]},
                    shared={"weights": half.weights[network], "layers": half.layers},
                    scalars={"first": half.first, "pitch": half.pitch},
                    cost=-(-count // _QUAD),
                )
            )
        self._run("colour network", "colour_network", launches, ledger)
        return colours

    def cells_of(self, points: Float32Array, ledger: Ledger) -> tuple[Int32Array, Float32Array]:
        """Return the network of each point (-1: none), and its place in that network's cell."""
        local = np.zeros((len(points), 3), dtype=np.float32)
        grid = self._networks
        if grid.nbytes <= self._device.scratchpad_bytes // 2:
            networks = np.zeros(len(points), dtype=np.int32)
            arguments = (points, self._box, grid, networks, local)
            self._device.spread(ledger, "grouping", f"{_KERNELS}:cells", *arguments)
            return networks, local
        numbers = np.zeros(len(points), dtype=np.int32)
        shape = np.array(grid.shape, dtype=np.int32)
        arguments = (points, self._box, shape, numbers, local)
        self._device.spread(ledger, "grouping", f"{_KERNELS}:cell_numbers", *arguments)
        table = grid.reshape(-1).view(np.float32)
        rows = gather_rows(self._device, ledger, "grouping", table, [numbers])
        return rows.view(np.int32), local

    def _encoded(
        self, vectors: Float32Array, kind: str, terms: int, ledger: Ledger
    ) -> Float32Array:
        """Return the terms of each vector, [n, terms], one coordinate after the other."""
        out = np.zeros((vectors.size, terms // _AXES), dtype=np.float32)
        kernel = f"{_KERNELS}:encode_{kind}"
        self._device.spread(ledger, "position encoding", kernel, vectors.ravel(), out)
        return out.reshape(len(vectors), terms)

    def _sorted(self, networks: Int32Array, ledger: Ledger) -> _Sorted:
        """Sort chunks; of more networks than a scratchpad counts, a range after the other."""
        order, places = np.zeros_like(networks), np.zeros_like(networks)
        chunks = range(0, len(networks), CHUNK)
        pieces: list[tuple[int, int, int]] = []
        for low, count in self._ranges():
            starts = np.zeros((len(chunks), count + 2), dtype=np.int32)
            launches = [
                self._sort_launch(networks, low, first, starts[number], order, places)
                for number, first in enumerate(chunks)
            ]
            self._run("grouping", "sort_by_network", launches, ledger)
            ledger.count(words_read_by_host=starts.size)
            pieces += pieces_of(starts, low)
        return _Sorted(order, places, tuple(pieces))

    def _ranges(self) -> list[tuple[int, int]]:
        """First network and number of networks (-1 is one) that a scratchpad counts at once."""
        networks = len(self._model.weights[0]) + 1
        lines = _SORT_ARRAYS * self._device.line_bytes
        words = (self._device.scratchpad_bytes - lines) // WORD_BYTES
        most = (words - 3 * CHUNK) // 2 - 2
        parts = -(-networks // most)
        bounds = [networks * part // parts - 1 for part in range(parts + 1)]
        return [(low, high - low) for low, high in pairwise(bounds)]

    def _sort_launch(
        self,
        networks: Int32Array,
        low: int,
        first: int,
        starts: Int32Array,
        order: Int32Array,
        places: Int32Array,
    ) -> Launch:
        """Sort a chunk's samples of some networks, in what the ranges before left."""
        part = slice(first, first + CHUNK)
        before = {"order": order[part], "places": places[part]}
        return Launch(
            shapes={"cursors": starts.shape},
            inputs={"networks": networks[part], **(before if low >= 0 else {})},
            outputs={"starts": starts, **before},
            scalars={"low": low, "first": first},
        )

    def _parts(self, pieces: Pieces) -> Iterator[tuple[int, slice]]:
        """Yield network and places of each launch, by network, so that weights are loaded once."""
        for network, first, count in sorted(pieces):
            for start in range(first, first + count, self._at_once):
                yield network, slice(start, min(start + self._at_once, first + count))

    def _shapes(self, half: _Half) -> dict[str, tuple[int, ...]]:
        return {"values": (half.words * self._at_once,)}

    def _run(self, stage: str, kernel: str, launches: Sequence[Launch], ledger: Ledger) -> None:
        run_launches(
            self._device,
            ledger,
            stage,
            f"{_KERNELS}:{kernel}",
            launches,
            loops=LoopOptions(auto=False),
        )

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


def pieces_of(starts: Int32Array, low: int) -> Iterator[tuple[int, int, int]]:
    """Yield network, first place and number of samples, of networks from `low` on; those without
    a network are left out.
    """
    for chunk, row in enumerate(starts):
        begins, ends = row[:-2], row[1:-1]
        for slot in np.flatnonzero(ends > begins).tolist():
            if low + slot >= 0:
                begin = int(begins[slot])
                yield low + slot, chunk * CHUNK + begin, int(ends[slot]) - begin


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
