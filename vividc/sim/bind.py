"""numpy arguments to scratchpad words and launch inputs, and back; every mismatch is refused."""

from __future__ import annotations

import math
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from struct import Struct
from typing import Final

import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

from vividc.errors import ArgumentError
from vividc.machine.params import MAX_ELEMENTS, given, sizes_text
from vividc.machine.words import WORD_BITS
from vividc.program import (
    WORD_BYTES,
    DType,
    LocalArray,
    Param,
    Program,
    pitch_words,
    pitches_of,
    place_arrays,
)
from vividc.sim.footprint.footprint import whole_loop

Array = NDArray[np.generic]

_INT_RANGE: Final = {
    DType.I32: (-(1 << 31), (1 << 31) - 1),
    DType.U32: (0, (1 << 32) - 1),
    DType.I16: (-(1 << 15), (1 << 15) - 1),
    DType.U16: (0, (1 << 16) - 1),
    DType.I8: (-(1 << 7), (1 << 7) - 1),
    DType.U8: (0, (1 << 8) - 1),
    DType.I64: (-(1 << 63), (1 << 63) - 1),
    DType.U64: (0, (1 << 64) - 1),
    DType.BOOL: (0, 1),
}
_ONE_WORD: Final = {DType.I64: DType.I32, DType.U64: DType.U32}
_FLOAT: Final = Struct("@f")
_PACKED_WORD: Final = Struct("@I")


@dataclass(frozen=True)
class Bound:
    """Arguments as the machine takes them.

    Attributes
    ----------
    memory
        Scratchpad contents: uint32 words.
    inputs
        Word of each launch key.
    arrays, addresses
        The caller's arrays by parameter name; byte addresses of these and of the kernel's own.
    locals
        The kernel's own arrays.
    pitches
        Elements from one row to the next, of matrices whose rows may lie further apart than they
        are long.
    """

    memory: NDArray[np.uint32]
    inputs: Mapping[str, int]
    arrays: Mapping[str, Array]
    addresses: Mapping[str, int]
    locals: tuple[LocalArray, ...] = ()
    pitches: Mapping[str, int] = field(default_factory=dict)

    @property
    def extents(self) -> dict[str, tuple[int, int]]:
        """First byte and end of each array in the scratchpad."""
        sizes = {name: _size_bytes(array) for name, array in self.arrays.items()}
        for name, pitch in self.pitches.items():
            sizes[name] = WORD_BYTES * _words(self.arrays[name], pitch)
        sizes |= {local.name: WORD_BYTES * local.words for local in self.locals}
        return {
            name: (self.addresses[name], self.addresses[name] + size)
            for name, size in sizes.items()
        }

    def copy_back(self, memory: NDArray[np.uint32], stored: frozenset[str]) -> None:
        """Write the arrays named in `stored` from the scratchpad into the caller's arrays."""
        for name, array in self.arrays.items():
            if name in stored:
                start = self.addresses[name]
                rows = _rows(memory, start, array, self.pitches.get(name))
                array[...] = _elements(rows.reshape(-1), array)


def bind(program: Program, args: Sequence[object], kwargs: Mapping[str, object]) -> Bound:
    """Bind arguments to the program's parameters.

    Raises
    ------
    ArgumentError
        Missing or surplus arguments, a wrong dtype or number of dimensions, an array that is not
        C-contiguous, that overlaps one that is written, or is read-only but written; a scalar out
        of range; arrays that do not fit the scratchpad.
    """
    arrays, inputs = arguments(program, args, kwargs)
    locals_ = tuple(local.at_launch(inputs) for local in program.locals)
    addresses, pitches = _layout(program, arrays, locals_)
    inputs |= pitch_words(pitches)
    memory = np.zeros(program.fabric.scratchpad.words, np.uint32)
    for name, array in arrays.items():
        rows = _rows(memory, addresses[name], array, pitches.get(name))
        rows[...] = _bytes(name, array).reshape(rows.shape)
        inputs[f"&{name}"] = addresses[name]
    for local in locals_:
        _place_local(local, addresses[local.name], memory, inputs)
    return Bound(memory, inputs, arrays, addresses, locals_, pitches)


def _layout(
    program: Program, arrays: Mapping[str, Array], locals_: Sequence[LocalArray]
) -> tuple[dict[str, int], dict[str, int]]:
    """First byte of each array, and the pitches of matrices: as wished if they fit so."""
    pad = program.fabric.scratchpad
    shapes = {name: array.shape for name, array in arrays.items()}
    around = {param.name: param.per_word * pad.banks for param in program.params}
    for spaced in (around, None):
        pitches = pitches_of(program.pitches, shapes, spaced)
        sizes = [(name, _words(array, pitches.get(name))) for name, array in arrays.items()]
        sizes += [(local.name, local.words) for local in locals_]
        if sum(words for _, words in sizes) <= pad.words:
            break
    return place_arrays(sizes, pad, program.banks), pitches


def arguments(
    program: Program, args: Sequence[object], kwargs: Mapping[str, object]
) -> tuple[dict[str, Array], dict[str, int]]:
    """The arrays by parameter name, and the launch words that do not depend on where they lie.

    Raises
    ------
    ArgumentError
        As for `bind`, without regard to the scratchpad.
    """
    values = named(program, args, kwargs)
    arrays: dict[str, Array] = {}
    inputs: dict[str, int] = {}
    for param in given(program.params):
        if param.ndim:
            array = _array(program, param, values[param.name])
            arrays[param.name] = array
            if not param.flat:
                inputs.update({f"{param.name}.shape{k}": n for k, n in enumerate(array.shape)})
        else:
            inputs.update(scalar_words(param, values[param.name]))
    for param in program.params:
        if param.made:
            arrays[param.name] = _made(param, inputs, values)
    _refuse_overlap(arrays, program.stored_arrays)
    refuse_other_sizes(program, inputs)
    if program.parallel is not None:
        inputs |= whole_loop(program.parallel, inputs)
    return arrays, inputs


def _made(param: Param, inputs: Mapping[str, int], values: Mapping[str, object]) -> Array:
    """An array that the kernel returns; one of a launch before, if it is among the values."""
    words = param.words_at(inputs)
    before = values.get(param.name)
    if before is None:
        if words > MAX_ELEMENTS:
            raise ArgumentError(f"the kernel would return an array of {words:,} words")
        return np.zeros(words, np.dtype(param.dtype.value))
    if not isinstance(before, np.ndarray) or before.shape != (words,):
        raise ArgumentError(f"{param.name} is no argument: the launch makes it")
    return before


def refuse_other_sizes(program: Program, inputs: Mapping[str, int]) -> None:
    """Refuse a launch of other sizes than those that the program was compiled for.

    Raises
    ------
    ArgumentError
        It names all that differ.
    """
    got = {
        param.name: _launched(param, inputs)
        for param in program.params
        if param.known and any(inputs[key] != word for key, word in param.known_words.items())
    }
    if got:
        wanted = {name: program.sizes[name] for name in got}
        raise ArgumentError(
            f"{program.name} was compiled for {sizes_text(wanted)} only, and got {sizes_text(got)}",
            hint="compile it for these sizes, or for any: without like (--sizes)",
        )


def _launched(param: Param, inputs: Mapping[str, int]) -> tuple[int, ...] | int:
    words = [inputs[key] for key in param.known_words]
    if param.ndim:
        return tuple(words)
    return int(returned(param.dtype, sum(w << WORD_BITS * n for n, w in enumerate(words))))


def scalar_words(param: Param, value: object) -> dict[str, int]:
    """The launch words of a scalar parameter.

    Raises
    ------
    ArgumentError
        The value is of the wrong kind or out of range.
    """
    return param.words_of(_scalar(param, value))


def _place_local(
    local: LocalArray, address: int, memory: NDArray[np.uint32], inputs: dict[str, int]
) -> None:
    inputs[f"&{local.name}"] = address
    local.fill(memory, address)


def returned(dtype: DType, word: int) -> int | float | bool:
    """A word (for integers of 64 bits: both) as the Python scalar that numba would return."""
    if dtype is DType.F32:
        value: float = _FLOAT.unpack(_PACKED_WORD.pack(word))[0]
        return value
    if dtype is DType.BOOL:
        return word != 0
    # Of what is less than a word only the low bits count.
    bits = 64 if dtype in _ONE_WORD else 8 * dtype.size_bytes
    value = word & (1 << bits) - 1
    return value - ((value >> bits - 1) << bits) if dtype.is_signed else value


def named(
    program: Program, args: Sequence[object], kwargs: Mapping[str, object]
) -> dict[str, object]:
    """The arguments of a launch by parameter name.

    Raises
    ------
    ArgumentError
        Some are missing, unknown, or given twice.
    """
    names = [param.name for param in given(program.params)]
    made = {param.name for param in program.params if param.made}
    signature = f"{program.name}({', '.join(names)})"
    if len(args) > len(names):
        raise ArgumentError(f"{signature} takes {len(names)} arguments, not {len(args)}")
    values = dict(zip(names, args, strict=False))
    for name, value in kwargs.items():
        if name not in names and name not in made:
            raise ArgumentError(f"{signature} has no parameter {name!r}")
        if name in values:
            raise ArgumentError(f"{signature} got {name!r} twice")
        values[name] = value
    defaults = {param.name: param.default[0] for param in program.params if param.default}
    values = {**defaults, **values}
    missing = [name for name in names if name not in values]
    if missing:
        raise ArgumentError(f"{signature} misses {', '.join(missing)}")
    return values


def _array(program: Program, param: Param, value: object) -> Array:
    where = f"argument {param.name} of {program.name}"
    axes = "" if param.flat else f" with {param.ndim} dimension(s)"
    expected = f"a C-contiguous {param.dtype.value} array{axes}"
    if not isinstance(value, np.ndarray):
        hint = f"make one: {param.name} = np.array({param.name}, np.{param.dtype.value})"
        if not isinstance(value, list | tuple):
            hint = f"the parameters are {', '.join(one.name for one in program.params)}"
        reason = f"expected {expected}, got {type(value).__name__}"
        raise ArgumentError(reason, loc=where, hint=hint)
    if isinstance(value, np.ma.MaskedArray):
        hint = f"fill it, {param.name}.filled(0), and pass the mask as an array of its own"
        raise ArgumentError(f"expected {expected}, got one with a mask", loc=where, hint=hint)
    if type(value) is not np.ndarray:
        value = value.view(np.ndarray)  # of a subclass the elements count, not its __setitem__
    if value.dtype != np.dtype(param.dtype.value) or not _has_axes(value, param):
        raise ArgumentError(
            f"expected {expected}, got {_told(value)}", loc=where, hint=_way_in(param, value)
        )
    if not value.flags.c_contiguous:
        raise ArgumentError(
            f"expected {expected}, got one with strides {value.strides}",
            loc=where,
            hint="pass np.ascontiguousarray(...) and keep it to see the results",
        )
    if param.name in program.stored_arrays and not value.flags.writeable:
        raise ArgumentError(
            "the kernel writes this array, and it is read-only", loc=where, hint="pass a copy"
        )
    if math.prod(max(size, 1) for size in value.shape) > MAX_ELEMENTS:
        hint = "an empty array may have short dimensions only: np.zeros((0, 4, 4), ...)"
        raise ArgumentError(f"an array of shape {value.shape}", loc=where, hint=hint)
    limits = tuple(param.limit(axis) for axis in range(param.ndim))
    if not param.flat and any(n > most for n, most in zip(value.shape, limits, strict=True)):
        raise ArgumentError(
            f"a dimension of {value.shape} is larger than {max(limits)}",
            loc=where,
            hint="run the kernel on pieces of the array",
        )
    return value


def _told(value: Array) -> str:
    kind = "structured" if value.dtype.names else str(value.dtype)
    return f"{kind} with {value.ndim} dimension(s)"


def _way_in(param: Param, value: Array) -> str:
    """What makes of an array of another type or number of dimensions one that fits."""
    name, wanted = param.name, f"np.{param.dtype.value}"
    if value.dtype.names:
        return (
            f"pass one field: np.ascontiguousarray({name}[{value.dtype.names[0]!r}], {wanted}); "
            "a copy, whose results go back by hand"
        )
    if _has_axes(value, param):
        return f"convert it: np.ascontiguousarray({name}, {wanted})"
    if param.ndim == 1:
        return f"pass a view with one dimension: {name}.reshape(-1)"
    shape = ", ".join(["rows", "columns", "depth"][: param.ndim])
    if value.ndim < param.ndim:
        shape = ", ".join([*["1"] * (param.ndim - 1), "-1"])
    return (
        f"pass a view with {param.ndim} dimensions: {name}.reshape({shape}), "
        f"or declare {name} with {value.ndim} in the signature"
    )


def _has_axes(array: Array, param: Param) -> bool:
    return array.ndim == param.ndim or (param.flat and array.ndim > 0)


def _refuse_overlap(arrays: Mapping[str, Array], stored: Container[str]) -> None:
    """Arrays that are only read may overlap: each has a copy of its own."""
    for (one, a), (other, b) in combinations(arrays.items(), 2):
        written = next((name for name in (one, other) if name in stored), None)
        # Exact for contiguous arrays, whose bytes fill their bounds.
        if written is not None and np.may_share_memory(a, b):
            read = other if written == one else one
            raise ArgumentError(
                f"arrays {one} and {other} overlap, and the kernel writes {written}; each has its "
                "own copy in the scratchpad, so a write to one would not show in the other",
                hint=f"pass {read}.copy()",
            )


def _words(array: Array, pitch: int | None) -> int:
    """Words of the array in the scratchpad; of a matrix with a pitch, from its first to its last
    element.
    """
    size = _size_bytes(array)
    if pitch is not None and array.size:
        rows, columns = array.shape
        size = ((rows - 1) * pitch + columns) * (size // array.size)
    return -(-size // WORD_BYTES)


def _rows(
    memory: NDArray[np.uint32], start: int, array: Array, pitch: int | None
) -> NDArray[np.uint8]:
    """The bytes of an array in the scratchpad: in one row, or in those of a matrix with a pitch."""
    raw = memory.view(np.uint8)[start:]
    if pitch is None or not array.size:
        return raw[: _size_bytes(array)]
    rows, columns = array.shape
    size = _size_bytes(array) // array.size
    return as_strided(raw, (rows, size * columns), (size * pitch, 1))


def _size_bytes(array: Array) -> int:
    """Bytes of the array in the scratchpad."""
    return array.size * (min(_part_bytes(array), WORD_BYTES) << (array.dtype.kind == "c"))


def _part_bytes(array: Array) -> int:
    """Bytes of an element in numpy, or of a part of a complex one."""
    return array.dtype.itemsize >> (array.dtype.kind == "c")


def _bytes(name: str, array: Array) -> NDArray[np.uint8]:
    """Elements as they lie in the scratchpad: as in numpy, but 64-bit ones as words, by value. A
    bool is 0 or 1 whatever byte numpy has for it.
    """
    flat = array.reshape(-1)
    if flat.dtype == np.bool_:
        flags: NDArray[np.bool_] = flat.view(np.uint8) != 0
        return flags.view(np.uint8)
    if _part_bytes(flat) <= WORD_BYTES:
        return flat.view(np.uint8)
    if flat.size:
        low, high = _INT_RANGE[DType.I32]
        if int(flat.min()) < low or int(flat.max()) > high:
            raise ArgumentError(
                "an element does not fit the machine's 32 bits", loc=f"argument {name}"
            )
    return flat.astype(np.int32).view(np.uint8)


def _elements(raw: NDArray[np.uint8], array: Array) -> Array:
    if _part_bytes(array) <= WORD_BYTES:
        return raw.view(array.dtype).reshape(array.shape)
    return raw.view(np.int32).astype(array.dtype).reshape(array.shape)


def _scalar(param: Param, value: object) -> int:
    where = f"argument {param.name}"
    if isinstance(value, np.generic):
        value = value.item()
    if param.dtype.is_float:
        if isinstance(value, np.ndarray):
            reason = f"expected {param.dtype.value}, got {_told(value)}"
            raise ArgumentError(reason, loc=where, hint=_number_in(param, value))
        if param.dtype is DType.F32:
            return _float_word(value, where)
        parts = (value.real, value.imag) if isinstance(value, complex) else (value, 0.0)
        low, high = (_float_word(part, where, param.dtype) for part in parts)
        return low | high << WORD_BITS
    if not isinstance(value, int):
        raise ArgumentError(
            f"expected {param.dtype.value}, got {type(value).__name__}",
            loc=where,
            hint=_number_in(param, value),
        )
    counts = param.words == 1 and param.dtype in _ONE_WORD
    low, high = _INT_RANGE[_ONE_WORD[param.dtype] if counts else param.dtype]
    if not low <= value <= high:
        kind = "32 bits" if counts else param.dtype.value
        hint = "it counts the iterations of a loop or indexes an array: both are words"
        raise ArgumentError(
            f"{value} does not fit {kind} ({low} .. {high})",
            loc=where,
            hint=hint if counts else None,
        )
    return value


def _number_in(param: Param, value: object) -> str | None:
    """How to make a scalar of a float that stands for an integer, or of an array."""
    if isinstance(value, float):
        return "convert it with int(...)"
    if not isinstance(value, np.ndarray):
        return None
    if value.size == 1:
        return f"pass its element: {param.name}.item()"
    return "a scalar takes one number: are the arguments in the order of the parameters?"


def _float_word(value: object, where: str, dtype: DType = DType.F32) -> int:
    if not isinstance(value, int | float):
        raise ArgumentError(f"expected {dtype.value}, got {type(value).__name__}", loc=where)
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    word: int = _PACKED_WORD.unpack(_FLOAT.pack(number))[0]
    overflowed = math.isinf(_FLOAT.unpack(_PACKED_WORD.pack(word))[0])
    if overflowed and not (isinstance(value, float) and math.isinf(value)):
        raise ArgumentError(f"{value} does not fit float32", loc=where)
    return word
