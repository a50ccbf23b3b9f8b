"""numpy arguments to scratchpad words and launch inputs, and back; every mismatch is refused."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from struct import Struct
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vividc.errors import ArgumentError
from vividc.program import MAX_DIMENSION, DType, LocalArray, Param, Program, place_arrays

Array = NDArray[np.generic]

_INT_RANGE: Final = {
    DType.I32: (-(1 << 31), (1 << 31) - 1),
    DType.U32: (0, (1 << 32) - 1),
    DType.I64: (-(1 << 31), (1 << 31) - 1),
    DType.BOOL: (0, 1),
}
_WORD_MASK: Final = 0xFFFFFFFF
_FLOAT: Final = Struct("@f")
_WORD: Final = Struct("@I")


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
    """

    memory: NDArray[np.uint32]
    inputs: Mapping[str, int]
    arrays: Mapping[str, Array]
    addresses: Mapping[str, int]
    locals: tuple[LocalArray, ...] = ()

    @property
    def extents(self) -> dict[str, tuple[int, int]]:
        """First byte and end of each array in the scratchpad."""
        sizes = {name: array.size for name, array in self.arrays.items()}
        sizes |= {local.name: local.words for local in self.locals}
        return {
            name: (self.addresses[name], self.addresses[name] + 4 * words)
            for name, words in sizes.items()
        }

    def copy_back(self, memory: NDArray[np.uint32], stored: frozenset[str]) -> None:
        """Write the arrays named in `stored` from the scratchpad into the caller's arrays."""
        for name, array in self.arrays.items():
            if name in stored:
                start = self.addresses[name] // 4
                array[...] = _elements(memory[start : start + array.size], array)


def bind(program: Program, args: Sequence[object], kwargs: Mapping[str, object]) -> Bound:
    """Bind arguments to the program's parameters.

    Raises
    ------
    ArgumentError
        Missing or surplus arguments, a wrong dtype or number of dimensions, an array that is not
        C-contiguous, that overlaps another, or is read-only but written; a scalar out of range;
        arrays that do not fit the scratchpad.
    """
    values = _by_name(program, args, kwargs)
    arrays: dict[str, Array] = {}
    inputs: dict[str, int] = {}
    for param in program.params:
        if param.ndim:
            array = _array(program, param, values[param.name])
            arrays[param.name] = array
            inputs.update({f"{param.name}.shape{k}": n for k, n in enumerate(array.shape)})
        else:
            inputs[param.name] = _scalar(param, values[param.name])
    _refuse_overlap(arrays)
    sizes = [(name, array.size) for name, array in arrays.items()]
    sizes += [(local.name, local.words) for local in program.locals]
    addresses = place_arrays(sizes, program.fabric.scratchpad, program.banks)
    memory = np.zeros(program.fabric.scratchpad.words, np.uint32)
    for name, array in arrays.items():
        start = addresses[name] // 4
        memory[start : start + array.size] = _words(name, array)
        inputs[f"&{name}"] = addresses[name]
    for local in program.locals:
        _place_local(local, addresses[local.name], memory, inputs)
    return Bound(memory, inputs, arrays, addresses, program.locals)


def _place_local(
    local: LocalArray, address: int, memory: NDArray[np.uint32], inputs: dict[str, int]
) -> None:
    inputs[f"&{local.name}"] = address
    if local.contents:
        start = address // 4
        memory[start : start + len(local.contents)] = local.contents


def returned(dtype: DType, word: int) -> int | float | bool:
    """A word as the Python scalar that numba would return."""
    if dtype is DType.F32:
        value: float = _FLOAT.unpack(_WORD.pack(word))[0]
        return value
    if dtype is DType.BOOL:
        return word != 0
    return word if dtype is DType.U32 else word - ((word & 0x80000000) << 1)


def _by_name(
    program: Program, args: Sequence[object], kwargs: Mapping[str, object]
) -> dict[str, object]:
    names = [param.name for param in program.params]
    signature = f"{program.name}({', '.join(names)})"
    if len(args) > len(names):
        raise ArgumentError(f"{signature} takes {len(names)} arguments, not {len(args)}")
    values = dict(zip(names, args, strict=False))
    for name, value in kwargs.items():
        if name not in names:
            raise ArgumentError(f"{signature} has no parameter {name!r}")
        if name in values:
            raise ArgumentError(f"{signature} got {name!r} twice")
        values[name] = value
    missing = [name for name in names if name not in values]
    if missing:
        raise ArgumentError(f"{signature} misses {', '.join(missing)}")
    return values


def _array(program: Program, param: Param, value: object) -> Array:
    where = f"argument {param.name} of {program.name}"
    expected = f"a C-contiguous {param.dtype.value} array with {param.ndim} dimension(s)"
    if not isinstance(value, np.ndarray):
        raise ArgumentError(f"expected {expected}, got {type(value).__name__}", loc=where)
    if value.dtype != np.dtype(param.dtype.value) or value.ndim != param.ndim:
        raise ArgumentError(
            f"expected {expected}, got {value.dtype} with {value.ndim}",
            loc=where,
            hint=f"convert it: np.ascontiguousarray({param.name}, np.{param.dtype.value})",
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
    if max(value.shape) > MAX_DIMENSION:
        raise ArgumentError(
            f"a dimension of {value.shape} is larger than {MAX_DIMENSION}",
            loc=where,
            hint="run the kernel on pieces of the array",
        )
    return value


def _refuse_overlap(arrays: Mapping[str, Array]) -> None:
    for (one, a), (other, b) in combinations(arrays.items(), 2):
        # Exact for contiguous arrays, whose bytes fill their bounds.
        if np.may_share_memory(a, b):
            raise ArgumentError(
                f"arrays {one} and {other} overlap; each has its own copy in the scratchpad, so a "
                "write to one would not show in the other",
                hint=f"pass {other}.copy()",
            )


def _words(name: str, array: Array) -> NDArray[np.uint32]:
    """Elements as words, one each: 32-bit ones as they are, others by value."""
    flat = array.reshape(-1)
    if flat.dtype.itemsize == _WORD.size:
        return flat.view(np.uint32)
    if flat.dtype != np.bool_ and flat.size:
        low, high = _INT_RANGE[DType.I64]
        if int(flat.min()) < low or int(flat.max()) > high:
            raise ArgumentError(
                "an element does not fit the machine's 32 bits", loc=f"argument {name}"
            )
    return flat.astype(np.int32).view(np.uint32)


def _elements(words: NDArray[np.uint32], array: Array) -> Array:
    if array.dtype.itemsize == _WORD.size:
        return words.view(array.dtype).reshape(array.shape)
    return words.view(np.int32).astype(array.dtype).reshape(array.shape)


def _scalar(param: Param, value: object) -> int:
    where = f"argument {param.name}"
    if isinstance(value, np.generic):
        value = value.item()
    if param.dtype is DType.F32:
        return _float_word(value, where)
    if not isinstance(value, int):
        raise ArgumentError(
            f"expected {param.dtype.value}, got {type(value).__name__}",
            loc=where,
            hint="convert it with int(...)" if isinstance(value, float) else None,
        )
    low, high = _INT_RANGE[param.dtype]
    if not low <= value <= high:
        kind = "32 bits" if param.dtype is DType.I64 else param.dtype.value
        raise ArgumentError(
            f"{value} does not fit {kind} ({low} .. {high})",
            loc=where,
            hint="the machine's words have 32 bits",
        )
    return value & _WORD_MASK


def _float_word(value: object, where: str) -> int:
    if not isinstance(value, int | float):
        raise ArgumentError(f"expected float32, got {type(value).__name__}", loc=where)
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    word: int = _WORD.unpack(_FLOAT.pack(number))[0]
    overflowed = math.isinf(_FLOAT.unpack(_WORD.pack(word))[0])
    if overflowed and not (isinstance(value, float) and math.isinf(value)):
        raise ArgumentError(f"{value} does not fit float32", loc=where)
    return word
