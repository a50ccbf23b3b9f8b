"""The kernel as the frontend hands it over: typed SSA instructions in basic blocks, with source
lines.

This is the one type between `frontend` and `dfg`. It is close to LLVM IR but holds only what an
array can run: 32-bit integers and floats, predicates, array accesses, `phi`, and branches. 64-bit
integers and doubles have been narrowed by the frontend before.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum

from vividc.dfg.lanes import Lane
from vividc.dfg.opcodes import Opcode, Type
from vividc.dfg.words import SIGN_BIT, WORD_MASK
from vividc.errors import SourceLoc

MAX_DIMENSION = 1 << 14
"""No dimension of words may be larger: ranges of indices are proved with `Param.limit`, a launch
checks it."""
MAX_SPREAD = 1 << 24
"""The first dimension of an array of a kernel that is spread over tiles may be as large as this."""
MAX_ELEMENTS = 1 << 29
"""No array has more, as addresses have 32 bits; nor have two dimensions beside one of size 0."""


TRAP = "raise."
"""Starts the name of an array that stands for an exception."""

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

    @property
    def size_bytes(self) -> int:
        """Bytes of an element in the scratchpad, where int64 is narrowed to a word."""
        return _SIZE_BYTES.get(self, 4)

    @property
    def is_signed(self) -> bool:
        """Whether negative integers are among its values."""
        return self in (DType.I8, DType.I16, DType.I32, DType.I64)


_SIZE_BYTES = {DType.I8: 1, DType.U8: 1, DType.BOOL: 1, DType.I16: 2, DType.U16: 2, DType.F16: 2}


WIDE_DTYPES = frozenset({DType.I64, DType.U64})
"""Scalars of two words, if their values need them."""


@dataclass(frozen=True, slots=True)
class Param:
    """One parameter of the kernel's function. `ndim` 0: a scalar.

    `flat`: an array of any number of dimensions, whose elements the kernel counts in C order (as C
    does, which knows no shapes).
    `words` 2: a scalar of 64 bits, of which the host supplies both words; else its value must fit
    one (the launch checks it). `longest`: the most elements along the first dimension; 0: as many
    as along the others.
    """

    name: str
    dtype: DType
    ndim: int = 0
    flat: bool = False
    words: int = 1
    longest: int = field(default=0, compare=False)

    @property
    def max_dimension(self) -> int:
        """The most elements along a dimension: of bytes in one dimension as many as of words fill
        the same memory.
        """
        return MAX_DIMENSION * (4 // self.dtype.size_bytes if self.ndim == 1 else 1)

    def limit(self, axis: int) -> int:
        """The most elements along a dimension, the first of which may be cut at launch."""
        return self.longest if self.longest and axis == 0 else self.max_dimension


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

    def at_launch(self, inputs: Mapping[str, int]) -> LocalArray:
        """The array with the words it has for these inputs."""
        if not self.size:
            return self
        words = max(evaluate_formula(self.size, inputs), 0)
        return LocalArray(self.name, words, self.contents, loops=self.loops)


Formula = tuple[str | int, ...]
"""A number that the launch decides, in postfix form: integers, input keys behind "s:" (signed) or
"u:" (unsigned), and the operators "+", "*", "//", "max" and "min"."""


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


@dataclass(frozen=True, slots=True)
class Ref:
    """The result of the instruction with this id."""

    id: int


@dataclass(frozen=True, slots=True)
class Const:
    """A word: integers modulo 2**32, floats as IEEE bits, predicates 0 or 1."""

    word: int


@dataclass(frozen=True, slots=True)
class Undefined(Const):
    """A word that nobody reads: any word may stand for it. It is 0 where it has to be something."""

    word: int = 0


@dataclass(frozen=True, slots=True)
class Input:
    """A word the host supplies at launch.

    `key` is "n" for scalar parameter n (and "n.high" for the high word of one of 64 bits), "&x" for
    the byte address of array x in the scratchpad, and "x.shape0", "x.shape1", ... for its
    dimensions.
    """

    key: str


Value = Ref | Const | Input


@dataclass(frozen=True, slots=True)
class Instr:
    """One SSA instruction.

    `op` is an `Opcode`: an operation, `load` (operands: base, index), `store` (operands: base,
    index, value); a predicate may be the last operand of both. The byte address is base +
    (index << shift) + offset; `array` names the array accessed, `width` the bytes of the access (1,
    2 or 4), and `signed` says that a load of less than a word sign-extends. `exact`: an integer
    addition or subtraction that is proved not to wrap as a signed word. `distinct`: header of a
    loop in whose run an address that such an access has touched comes back only at accesses with
    the same index that follow this one in the program, before the index changes. `subscript`: of an
    element of a parameter, the constants among its subscripts, None for others; () if unknown.
    `lane`: the thread that a copy belongs to.
    """

    id: int
    op: Opcode
    type: Type
    operands: tuple[Value, ...]
    array: str = ""
    shift: int = 0
    offset: int = 0
    width: int = 4
    signed: bool = False
    exact: bool = False
    distinct: str = ""
    subscript: tuple[int | None, ...] = ()
    loc: SourceLoc | None = field(default=None, compare=False)
    lane: Lane | None = field(default=None, compare=False)


@dataclass(frozen=True, slots=True)
class Phi:
    """An SSA phi: `incoming` maps a predecessor block's name to the value."""

    id: int
    type: Type
    incoming: tuple[tuple[str, Value], ...]
    loc: SourceLoc | None = field(default=None, compare=False)


@dataclass(frozen=True, slots=True)
class Branch:
    """The block's terminator. `cond` None: jump to `target`. No target: return (`value` if any, and
    `high`, its high word, if one word may not hold it).
    """

    target: str | None = None
    cond: Value | None = None
    otherwise: str | None = None
    value: Value | None = None
    loc: SourceLoc | None = field(default=None, compare=False)
    high: Value | None = None

    @property
    def read(self) -> tuple[Value, ...]:
        """The words that the terminator reads."""
        words = (self.cond, self.value, self.high)
        return tuple(word for word in words if word is not None)

    @property
    def successors(self) -> tuple[str, ...]:
        """Names of the blocks that may follow."""
        names = (self.target, self.otherwise) if self.cond is not None else (self.target,)
        return tuple(name for name in names if name is not None)


@dataclass(frozen=True, slots=True)
class Block:
    """A basic block."""

    name: str
    phis: tuple[Phi, ...]
    instrs: tuple[Instr, ...]
    branch: Branch


@dataclass(frozen=True)
class Function:
    """A kernel in SSA form; the first block is the entry. Loops are in while or do-while form.

    `sequential` names the headers of innermost loops that are not to be modulo-scheduled: they run
    block by block, like the loops around them. `locals` are the kernel's own arrays.
    """

    name: str
    params: tuple[Param, ...]
    blocks: tuple[Block, ...]
    returns: DType | None = None
    file: str = ""
    sequential: frozenset[str] = frozenset()
    locals: tuple[LocalArray, ...] = ()


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
