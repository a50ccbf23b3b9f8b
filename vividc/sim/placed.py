"""Launches of a program whose arrays lie in the scratchpad already."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from vividc.errors import ArgumentError
from vividc.machine.params import MAX_ELEMENTS, DType, Param
from vividc.machine.words import INFINITY, WORD_BYTES, word_of
from vividc.program import Program, pitch_words, pitches_of
from vividc.sim.bind import refuse_other_sizes, scalar_words
from vividc.sim.footprint.footprint import whole_loop

_WHOLE: Final = (int, np.integer)
_PLAIN: Final = {int}


@dataclass(frozen=True, slots=True)
class At:
    """An array argument of a run: where it lies in the tile's scratchpad, and its shape."""

    address: int
    shape: tuple[int, ...]


Extents = dict[str, tuple[int, int]]
"""First byte and end of arrays."""


class Signature:
    """What a program takes, looked up once for many launches."""

    def __init__(self, program: Program) -> None:
        self._program = program
        self._scalars = {param.name: _Scalar(param) for param in program.params if not param.ndim}
        self._arrays = [_Array(param) for param in program.params if param.ndim]
        self._has_known = any(param.known for param in program.params)

    def bound(self, arguments: Mapping[str, object]) -> tuple[dict[str, int], Extents]:
        """Launch words, and places of the arrays that are arguments.

        Raises
        ------
        ArgumentError
            An argument is missing, surplus, of the wrong kind or out of range.
        """
        program = self._program
        scalars = {name: value for name, value in arguments.items() if not isinstance(value, At)}
        if scalars.keys() != self._scalars.keys():
            self._refuse_scalars(scalars)
        inputs: dict[str, int] = {}
        for name, value in scalars.items():
            self._scalars[name].put(value, inputs)
        extents: Extents = {}
        for array in self._arrays:
            extents[array.name] = array.put(arguments.get(array.name), inputs, program.name)
        if program.pitches:
            shapes = {name: place.shape for name, place in _places(arguments)}
            inputs |= pitch_words(pitches_of(program.pitches, shapes))
        if self._has_known:
            refuse_other_sizes(program, inputs)
        if program.parallel is not None:
            inputs |= whole_loop(program.parallel, inputs)
        return inputs, extents

    def _refuse_scalars(self, scalars: Mapping[str, object]) -> None:
        missing = [name for name in self._scalars if name not in scalars]
        surplus = sorted(scalars.keys() - self._scalars.keys())
        what = f"misses {', '.join(missing)}" if missing else f"has no scalar {surplus[0]!r}"
        raise ArgumentError(f"{self._program.name} {what}")


def _places(arguments: Mapping[str, object]) -> Iterator[tuple[str, At]]:
    for name, value in arguments.items():
        if isinstance(value, At):
            yield name, value


class _Scalar:
    """A scalar parameter."""

    __slots__ = ("_high", "_is_float", "_low", "_mask", "_name", "_param")

    def __init__(self, param: Param) -> None:
        self._param, self._name = param, param.name
        self._is_float = param.dtype is DType.F32
        self._mask = (1 << 8 * min(param.dtype.size_bytes, WORD_BYTES)) - 1
        self._low, self._high = 0, -1
        if not param.dtype.is_float and param.dtype is not DType.BOOL and param.words == 1:
            half = (self._mask + 1) // 2
            is_signed = param.dtype.is_signed
            self._low, self._high = (-half, half - 1) if is_signed else (0, self._mask)

    def put(self, value: object, inputs: dict[str, int]) -> None:
        """Add its launch words: at once those of an int or a float that fit a word."""
        if isinstance(value, np.generic):
            value = value.item()
        if type(value) is int and self._low <= value <= self._high:
            inputs[self._name] = value & self._mask
            return
        if self._is_float and type(value) is float:
            word = word_of(value)
            if word & INFINITY != INFINITY:
                inputs[self._name] = word
                return
        inputs.update(scalar_words(self._param, value))


class _Array:
    """An array parameter."""

    __slots__ = ("_address", "_bytes", "_ndim", "_sizes", "name")

    def __init__(self, param: Param) -> None:
        self.name, self._ndim, self._bytes = param.name, param.ndim, param.dtype.size_bytes
        self._address = f"&{param.name}"
        self._sizes = [f"{param.name}.shape{axis}" for axis in range(param.ndim)]

    def put(self, place: object, inputs: dict[str, int], program: str) -> tuple[int, int]:
        """Add its launch words; return its first byte and its end."""
        if not isinstance(place, At) or not _is_place(place, self._ndim):
            raise ArgumentError(
                f"array {self.name} of {program} is given as At(address, shape) with "
                f"{self._ndim} dimension(s)"
            )
        address, shape = place.address, place.shape
        elements = math.prod(shape)
        if (elements or math.prod([max(size, 1) for size in shape])) > MAX_ELEMENTS:
            raise ArgumentError(f"array {self.name} of {program} has shape {shape}")
        inputs[self._address] = address
        inputs.update(zip(self._sizes, shape, strict=True))
        return address, address + elements * self._bytes


def _is_place(place: At, ndim: int) -> bool:
    """Return whether address and shape are integers, with one size per axis."""
    if not isinstance(place.shape, (tuple, list)) or len(place.shape) != ndim:
        return False
    sizes = (place.address, *place.shape)
    is_whole = set(map(type, sizes)) == _PLAIN or all([isinstance(n, _WHOLE) for n in sizes])
    return is_whole and min(sizes) >= 0
