"""KiloNeRF on the array: samples sorted by network, each network's weights in one scratchpad."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise

import numpy as np
import numpy.typing as npt

from vividc import LoopOptions
from vividc.machine.words import WORD_BYTES
from vividc.render.array.device.device import Device
from vividc.render.array.device.frame import Ledger
from vividc.render.array.device.gather import gather_rows
from vividc.render.array.device.launches import Gathered, Launch, Move, Words, run_launches
from vividc.render.array.models.field import Features, ModelField
from vividc.render.arrays import Float32Array, Int32Array
from vividc.render.errors import SceneError
from vividc.render.radiance import KiloNeRF

_KERNELS = "render/kilonerf"
_POSITION_TERMS = 63
_AXES = 3
_DIRECTION_TERMS = 27
CHUNK = 352
"""Samples that one launch sorts: as many as fit twice beside 274 networks in 12^3 cells."""
_AT_ONCE = 12
"""Samples of a launch of a network: as many as fit twice beside its weights."""
_QUAD = 4
_OCTET = 8
_SPARE_BYTES = 1024
_SORT_WORDS = 15
"""Of a sample in launches that sort, with those of the next one."""
_SORT_LINES = 16
"""Of arrays that begin in a certain bank there."""


Pieces = Sequence[tuple[int, int, int]]
"""Network, first place and number of samples of one network in one chunk."""


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Samples of one network that go through it together.

    Attributes
    ----------
    network
        Its number.
    places
        Where they are among all that are sorted.
    """

    network: int
    places: tuple[slice, ...]

    @property
    def count(self) -> int:
        """How many they are."""
        return sum(some.stop - some.start for some in self.places)

    def moves(
        self, table: Words, first: int = 0, rows: Int32Array | None = None
    ) -> tuple[Move, ...]:
        """Return their rows of a table, or those that sorted numbers of rows choose, one after the
        other from word `first` of an array on.
        """
        width = table[:1].nbytes // WORD_BYTES
        moves = []
        for some in self.places:
            chosen = table[some] if rows is None else Gathered(table, rows[some])
            moves.append(Move(chosen, first))
            first += width * (some.stop - some.start)
        return tuple(moves)


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
        self._grid = np.array(model.network.shape, dtype=np.int32)
        self._features = np.zeros((0, hidden), dtype=np.float32)

    def density(self, points: Float32Array, ledger: Ledger) -> tuple[Float32Array, Float32Array]:
        """Return optical thickness [n] of one step, and where the features are [n, 1]."""
        local, places = np.zeros_like(points), np.zeros(len(points), dtype=np.int32)
        made = {"places": places, "local": local}
        pieces = self._sorted("group_places", points, {}, made, ledger)
        parts = list(parts_of(pieces, self._at_once))
        thickness, self._features = self._density_network(local, parts, ledger)
        thickness = self._ungrouped(thickness[:, None], places, ledger)
        return thickness[:, 0], places.view(np.float32)[:, None]

    def colour(
        self,
        points: Float32Array,
        features: Features,
        rays: Int32Array,
        directions: Float32Array,
        ledger: Ledger,
    ) -> Float32Array:
        """Return r, g, b [n, 3] of points seen along their rays' unit `directions` [R, 3]."""
        places, rows, sorted_rays = (np.zeros(len(points), dtype=np.int32) for _ in range(3))
        given = {"rows": np.ascontiguousarray(features[:, 0]).view(np.int32), "rays": rays}
        made = {"places": places, "sorted_rows": rows, "sorted_rays": sorted_rays}
        pieces = self._sorted("group_numbers", points, given, made, ledger)
        parts = list(parts_of(pieces, self._at_once))
        colours = self._colour_network(rows, sorted_rays, directions, parts, ledger)
        return self._ungrouped(colours, places, ledger)

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

    def _sorted(
        self,
        kernel: str,
        points: Float32Array,
        given: Mapping[str, Int32Array],
        made: Mapping[str, Words],
        ledger: Ledger,
    ) -> Pieces:
        """Sort chunks of points by network, those without one first; of more networks than a
        scratchpad counts, a range after the other, in what the ranges before left.

        Parameters
        ----------
        given, made
            By sample: other inputs and the outputs of a kernel that sorts.
        """
        known = self._numbers(points, ledger)
        shared = self._cells(known is not None)
        whole: dict[str, Words] = {"points": points, **given}
        if known is not None:
            whole["chosen"] = known
        pieces: list[tuple[int, int, int]] = []
        for low, count in self._ranges(shared):
            starts = np.zeros((-(-len(points) // CHUNK), count + 2), dtype=np.int32)
            before = whole if low < 0 else {**whole, **made}
            scalars = {"known": int(known is not None), "low": low}
            launches = [
                Launch(
                    inputs=_chunk(before, first),
                    outputs={"starts": one, **_chunk(made, first)},
                    shared=shared,
                    work={
                        "cursors": one.shape,
                        **({} if "chosen" in whole else {"chosen": (CHUNK,)}),
                    },
                    scalars={**scalars, "first": first},
                )
                for first, one in zip(range(0, len(points), CHUNK), starts, strict=True)
            ]
            self._run("grouping", f"{_KERNELS}:{kernel}", launches, ledger)
            ledger.count(words_read_by_host=starts.size)
            pieces += pieces_of(starts, low)
        return pieces

    def _ungrouped(self, rows: Float32Array, places: Int32Array, ledger: Ledger) -> Float32Array:
        """Return rows where their samples were before they were sorted."""
        out = np.empty_like(rows)
        launches = [
            Launch(
                inputs=_chunk({"grouped": rows, "places": places}, first),
                outputs=_chunk({"out": out}, first),
                scalars={"first": first},
            )
            for first in range(0, len(rows), CHUNK)
        ]
        self._run("grouping", f"{_KERNELS}:ungroup", launches, ledger)
        return out

    def _cells(self, known: bool) -> dict[str, Words]:
        """Return what kernels that sort know of the grid."""
        table = self._networks.reshape(-1)[: 1 if known else None]
        return {"box": self._box, "grid": self._grid, "networks": table}

    def _numbers(self, points: Float32Array, ledger: Ledger) -> Int32Array | None:
        """Return the network of each point, -1: none, if the grid fits no scratchpad."""
        if 2 * self._networks.nbytes <= self._device.scratchpad_bytes:
            return None
        numbers = np.zeros(len(points), dtype=np.int32)
        arguments = (points, self._box, self._grid, numbers)
        self._device.spread(ledger, "grouping", f"{_KERNELS}:cell_numbers", *arguments)
        table = self._networks.reshape(-1)
        return gather_rows(self._device, ledger, "grouping", table, [numbers])

    def _ranges(self, shared: Mapping[str, Words]) -> list[tuple[int, int]]:
        """First network and number of networks (-1 is one) that a scratchpad counts at once."""
        networks = len(self._model.weights[0]) + 1
        held = sum(array.nbytes for array in shared.values())
        free = self._device.scratchpad_bytes - held - _SORT_LINES * self._device.line_bytes
        most = (free // WORD_BYTES - _SORT_WORDS * CHUNK) // 3 - 2
        parts = -(-networks // most)
        bounds = [networks * part // parts - 1 for part in range(parts + 1)]
        return [(low, high - low) for low, high in pairwise(bounds)]

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


def _chunk(arrays: Mapping[str, Words], first: int) -> dict[str, Words]:
    """Return the rows of a chunk."""
    return {name: array[first : first + CHUNK] for name, array in arrays.items()}


def parts_of(pieces: Pieces, most: int) -> Iterator[Part]:
    """Yield at most so many samples each of one network, by network, so that weights are loaded
    once.
    """
    for network, some in groupby(sorted(pieces), lambda piece: piece[0]):
        places: list[slice] = []
        room = most
        for _, begin, count in some:
            at, end = begin, begin + count
            while at < end:
                places.append(slice(at, min(at + room, end)))
                room -= places[-1].stop - at
                at = places[-1].stop
                if not room:
                    yield Part(network, tuple(places))
                    places, room = [], most
        if places:
            yield Part(network, tuple(places))


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
