"""Parameters and arrays of a kernel, and the numbers that its launch decides."""

from __future__ import annotations

import operator
from collections.abc import Callable, Container, Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING

from vividc.errors import SourceLoc
from vividc.machine.words import SIGN_BIT, WORD_BITS, WORD_BYTES, WORD_MASK

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

MAX_DIMENSION = 1 << 14
"""No dimension of words may be larger: ranges of indices are proved with `Param.limit`, a launch
checks it."""


MAX_SPREAD = 1 << 24
"""The first dimension of an array of a kernel that is spread over tiles may be as large as this."""


MAX_NDIM = 6
"""Dimensions of an array."""


MAX_ELEMENTS = 1 << 29
"""No array has more, as addresses have 32 bits; nor have two dimensions beside one of size 0."""


TRAP = "raise."
"""Starts the name of an array that stands for an exception; by itself, the name of the array at
whose address they all are.
"""


def base_of(array: str) -> str:
    """The key of an array's address."""
    return f"&{TRAP}" if array.startswith(TRAP) else f"&{array}"


HIGH_SUFFIX = ".high"
"""Ends the key of the high word of a 64-bit parameter."""


class DType(Enum):
    """Element type of an array or type of a scalar parameter; the value is numpy's name."""

    F32 = "float32"
    F16 = "float16"  # of arrays only
    I32 = "int32"
    U32 = "uint32"
    I16 = "int16"
    U16 = "uint16"
    I8 = "int8"
    U8 = "uint8"
    I64 = "int64"
    U64 = "uint64"
    BOOL = "bool"
    C64 = "complex64"

    @property
    def size_bytes(self) -> int:
        """Bytes of an element in the scratchpad, where int64 is narrowed to a word."""
        return _SIZE_BYTES.get(self, 4)

    @property
    def is_float(self) -> bool:
        """Whether its words are floats: a complex64 has two, its real part first."""
        return self in (DType.F32, DType.C64)

    @property
    def is_signed(self) -> bool:
        """Whether negative integers are among its values."""
        return self in (DType.I8, DType.I16, DType.I32, DType.I64)


_SIZE_BYTES = {DType.I8: 1, DType.U8: 1, DType.BOOL: 1, DType.I16: 2, DType.U16: 2, DType.F16: 2}
_SIZE_BYTES |= {DType.C64: 8}


def sizes_text(sizes: Mapping[str, tuple[int, ...] | int]) -> str:
    """Shapes and integers as a person writes them, such as `A 20x30, n = 16`."""
    return ", ".join(
        f"{name} = {size}" if isinstance(size, int) else f"{name} {'x'.join(map(str, size))}"
        for name, size in sizes.items()
    )


WIDE_DTYPES = frozenset({DType.I64, DType.U64})
"""Scalars of two words, if their values need them."""


Formula = tuple[str | int, ...]
"""A number that the launch decides, in postfix form: integers, input keys behind "s:" (signed) or
"u:" (unsigned), and the operators "+", "*", "//", "max" and "min"."""


@dataclass(frozen=True, slots=True)
class Param:
    """One parameter of the kernel's function. `ndim` 0: a scalar.

    `flat`: an array of any number of dimensions, whose elements the kernel counts in C order (as C
    does, which knows no shapes).
    `words` 2: a scalar of 64 bits, of which the host supplies both words (of a complex64 the real
    part and, as the high word, the imaginary one); else its value must fit one (the launch checks
    it). `longest`: the most elements along the first dimension; 0: as many
    as along the others.
    `known`: the only shape that the array may have, or the only value of the scalar (the launch
    checks it); (): any.
    `made`: the formula of the words of an array that no caller gives: the kernel returns it, and
    the launch makes it, of zeros; (): any other.
    `default`: the value of a scalar that a caller leaves out; (): it may not.
    """

    name: str
    dtype: DType
    ndim: int = 0
    flat: bool = False
    words: int = 1
    longest: int = field(default=0, compare=False)
    known: tuple[int, ...] = ()
    made: Formula = ()
    default: tuple[bool | int | float, ...] = field(default=(), compare=False)

    @property
    def max_dimension(self) -> int:
        """The most elements along a dimension: of bytes in one dimension as many as of words fill
        the same memory.
        """
        return MAX_DIMENSION * max(4 // self.dtype.size_bytes if self.ndim == 1 else 1, 1)

    @property
    def per_word(self) -> int:
        """Elements that a word holds: 4 of bytes, 1 of words or more."""
        return max(WORD_BYTES // self.dtype.size_bytes, 1)

    @property
    def type_text(self) -> str:
        """Its type as in a signature."""
        axes = ", ".join([":"] * (self.ndim - 1) + ["::1"])
        return f"{self.dtype.value}[{axes}]" if self.ndim else self.dtype.value

    def limit(self, axis: int) -> int:
        """The most elements along a dimension, the first of which may be cut at launch."""
        return self.longest if self.longest and axis == 0 else self.max_dimension

    def words_at(self, inputs: Mapping[str, int]) -> int:
        """Words of an array that the launch makes."""
        return max(evaluate_formula(self.made, inputs), 0)

    @property
    def known_words(self) -> dict[str, int]:
        """The launch words that are known, by key."""
        if not self.known:
            return {}
        if self.ndim:
            return {f"{self.name}.shape{axis}": size for axis, size in enumerate(self.known)}
        return self.words_of(self.known[0])

    def words_of(self, value: int) -> dict[str, int]:
        """The launch words of a scalar's value, by key."""
        low = value & (1 << 8 * min(self.dtype.size_bytes, WORD_BYTES)) - 1
        if self.words == 1:
            return {self.name: low}
        return {self.name: low, self.name + HIGH_SUFFIX: value >> WORD_BITS & WORD_MASK}


def given(params: Iterable[Param]) -> tuple[Param, ...]:
    """The parameters that a caller gives arguments for."""
    return tuple(param for param in params if not param.made)


@dataclass(frozen=True, slots=True)
class LocalArray:
    """An array of the kernel's own in the scratchpad: `words` words.

    `contents`: the words of a constant table, which is there before the kernel starts and is never
    written. None: an array the kernel allocates; what it holds at first is undefined. Its address
    is the input "&" + `name`. `size`: the formula of its words where the launch decides them;
    `words` is 0 then. `loops`: where the loops around its allocation begin: each of their
    iterations has an array of its own, at the same place. An array whose name starts with `TRAP`
    has no words: an access to it stands for an exception.
    """

    name: str
    words: int
    contents: tuple[int, ...] | None = None
    size: tuple[str | int, ...] = ()
    loops: tuple[SourceLoc, ...] = field(default=(), compare=False)

    def fill(self, memory: NDArray[np.uint32], address: int) -> None:
        """Write the contents of a constant table that lies at a byte address of a scratchpad."""
        if self.contents:
            start = address // WORD_BYTES
            memory[start : start + len(self.contents)] = self.contents

    def at_launch(self, inputs: Mapping[str, int]) -> LocalArray:
        """The array with the words it has for these inputs."""
        if not self.size:
            return self
        words = max(evaluate_formula(self.size, inputs), 0)
        return LocalArray(self.name, words, self.contents, loops=self.loops)


def named_array(name: str) -> str:
    """An array of a kernel's own as a person knows it: by its line."""
    made = name.rpartition(".line")[2] if ".line" in name else ""
    return f"the array made in line {made}" if made else "an array that it makes"


def evaluate_formula(formula: Formula, inputs: Mapping[str, int]) -> int:
    """The formula's value for a launch.

    Parameters
    ----------
    inputs
        Word of each launch key; a 64-bit scalar may have a second one.
    """
    stack: list[int] = []
    for item in formula:
        if isinstance(item, int):
            stack.append(item)
        elif item in _FORMULA_OPERATORS:
            right, left = stack.pop(), stack.pop()
            stack.append(_FORMULA_OPERATORS[item](left, right))
        else:
            stack.append(_input_value(item[2:], inputs, signed=item.startswith("s:")))
    return stack.pop()


def is_formula(formula: Formula, keys: Container[str]) -> bool:
    """Whether it is one, of these inputs, whose value exists for all launches."""
    depth = 0
    for number, item in enumerate(formula):
        if isinstance(item, int):
            depth += 1
        elif item in _FORMULA_OPERATORS:
            divides = item == "//" and formula[number - 1] in (0, *_FORMULA_OPERATORS)
            if depth < 2 or divides:  # noqa: PLR2004 - two operands
                return False
            depth -= 1
        elif item[:2] in ("s:", "u:") and item[2:] in keys:
            depth += 1
        else:
            return False
    return depth == 1


def _input_value(key: str, inputs: Mapping[str, int], *, signed: bool) -> int:
    value, bits = inputs[key], 32
    if key + HIGH_SUFFIX in inputs:
        value, bits = value | inputs[key + HIGH_SUFFIX] << 32, 64
    return value - (1 << bits) if signed and value >> bits - 1 else value


_FORMULA_OPERATORS: dict[str, Callable[[int, int], int]] = {
    "+": operator.add,
    "*": operator.mul,
    "//": operator.floordiv,
    "max": max,
    "min": min,
}


def joined(returns: DType | None, low: int, high: int | None) -> int:
    """A returned integer modulo 2**64 if its type has 64 bits; any other word as it is.

    Parameters
    ----------
    high
        None: the word `low` is the value, signed or unsigned as the type is.
    """
    if returns not in WIDE_DTYPES:
        return low
    if high is None:
        high = WORD_MASK if returns is DType.I64 and low & SIGN_BIT else 0
    return low | high << 32
