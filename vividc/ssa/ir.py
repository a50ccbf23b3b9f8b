"""A kernel in SSA: typed instructions in basic blocks, with source lines, from LLVM's text to the
words that regions are cut from.

Two vocabularies share this form. As it is read, a function is *LLVM's*: operations and types are
LLVM's by name ("getelementptr", "i64", "double", "ptr"), constants are integers of any width and
doubles. `frontend.narrow` leaves *words*: opcodes of the machine on 32-bit integers and floats,
predicates and array accesses, all that an array can run. Everything is frozen; a pass returns a new
function.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from functools import cached_property

from vividc.errors import InternalError, SourceLoc
from vividc.host.once import made_soon
from vividc.machine.lanes import Lane
from vividc.machine.opcodes import Opcode, Type
from vividc.machine.params import (
    DType,
    LocalArray,
    Param,
)
from vividc.ssa.results import Results

Kind = Type | str
"""The type of a value: a word's, or of LLVM's by its name."""
Key = int | str
"""What names a value: the id of a result, the key of an input."""


@made_soon
@dataclass(frozen=True, slots=True)
class Ref:
    """The result of the phi or instruction with this id."""

    id: int

    @property
    def key(self) -> Key:
        """Its id."""
        return self.id


@made_soon
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
    """What the host supplies at launch; of LLVM's functions a value of 64 bits, too.

    `key` is "n" for scalar parameter n (and "n.high" for the high word of one of 64 bits), "&x" for
    the byte address of array x in the scratchpad, and "x.shape0", "x.shape1", ... for its
    dimensions. "x.pitch1", "x.pitch2" are dimensions, too, as elements x[i, j] are addressed with
    them, and nothing else is: of the index as a polynomial, the part with the factor "x.pitch1" is
    the first subscript times it, the rest the second; each lies in its dimension.
    """

    key: str


_SHAPE, _PITCH = ".shape", ".pitch"


def pitch_of(array: str, axis: int) -> Input:
    """A dimension of an array, in addresses of its elements."""
    return Input(f"{array}{_PITCH}{axis}")


def is_pitch(value: Value) -> bool:
    """Whether `value` is a pitch."""
    return isinstance(value, Input) and _PITCH in value.key


def without_pitch(value: Input) -> Input:
    """The dimension that a pitch is; any other input itself."""
    return Input(_SHAPE.join(value.key.rsplit(_PITCH, 1)))


def is_dimension(value: Value) -> bool:
    """Whether `value` is a dimension of an array."""
    return is_pitch(value) or (isinstance(value, Input) and _SHAPE in value.key)


@dataclass(frozen=True, slots=True)
class Int:
    """An integer constant of LLVM's, as it prints it (signed); predicates are 0 and 1."""

    value: int


@dataclass(frozen=True, slots=True, eq=False)
class Float:
    """A floating-point constant of LLVM's, exact. Equal by its bits: -0.0 is not 0.0, and NaN is
    itself.
    """

    value: float

    @property
    def bits(self) -> int:
        """Those of the double."""
        return int.from_bytes(struct.pack("<d", self.value), "little")

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Float) and self.bits == other.bits

    def __hash__(self) -> int:
        return hash(self.bits)


@dataclass(frozen=True, slots=True)
class Global:
    """A global variable or function of LLVM's module, or the place `offset` bytes into it."""

    name: str
    offset: int = 0


@dataclass(frozen=True, slots=True)
class Parts:
    """A constant array or structure of LLVM's, member by member; without values: zeros, or
    undefined.
    """

    values: tuple[Value, ...] = ()


Named = Ref | Input
"""Values that are computed or supplied, not constant."""
Value = Ref | Const | Input | Int | Float | Global | Parts
"""An operand. In a function of words: `Ref`, `Const` or `Input`."""


LLVM_BINARY = frozenset(
    [
        "add",
        "sub",
        "mul",
        "sdiv",
        "udiv",
        "srem",
        "urem",
        "shl",
        "lshr",
        "ashr",
        "and",
        "or",
        "xor",
        "fadd",
        "fsub",
        "fmul",
        "fdiv",
        "frem",
        "sfloordiv",
        "sfloorrem",
        "ufloordiv",
        "ufloorrem",
    ]
)
"""LLVM's operations on two values of one type, and Python's divisions, which round down."""
LLVM_CASTS = frozenset(
    [
        "trunc",
        "zext",
        "sext",
        "fptrunc",
        "fpext",
        "fptoui",
        "fptosi",
        "uitofp",
        "sitofp",
        "ptrtoint",
        "inttoptr",
        "bitcast",
        "addrspacecast",
    ]
)
"""LLVM's conversions."""


@made_soon
@dataclass(frozen=True, slots=True)
class Instr:
    """One instruction.

    Attributes
    ----------
    op
        An `Opcode`; before narrowing the name of LLVM's opcode.
    type
        Of the result; before narrowing LLVM's name, of a store that of what is stored, of a
        comparison that of its operands.
    operands
        Of `load`: base, index; of `store`: base, index, value; a predicate may be the last of both.
        LLVM's: of `load` the index once the address is resolved, the pointer before; of `store` the
        value, then the same.
    array, shift, offset
        Accesses: the byte address is base of `array` + (index << shift) + offset.
    width, signed
        Accesses: bytes (1, 2 or 4); whether a load of less than a word sign-extends.
    exact
        An integer sum or difference that is proved not to wrap as a signed word.
    distinct
        Header of a loop in whose run an address that such an access has touched comes back only at
        accesses with the same index that follow this one in the program, before the index changes.
    subscript
        Accesses to an element of a parameter: the constants among its subscripts, None for others;
        () if nothing is known.
    pred
        LLVM's: the predicate of a comparison, or the callee of a call.
    source
        LLVM's: the type before a conversion; the element type of a `getelementptr`; the type of
        what `extractvalue` reads from, and of what `insertvalue` puts in.
    strides
        LLVM's `getelementptr`: bytes per unit of each index; `insertvalue`, `extractvalue`: the
        indices.
    flags
        What LLVM may assume of it, such as "nsw".
    lane
        The thread that a copy belongs to.
    """

    id: int
    op: Opcode | str
    type: Kind
    operands: tuple[Value, ...]
    array: str = ""
    shift: int = 0
    offset: int = 0
    width: int = 4
    signed: bool = False
    exact: bool = False
    distinct: str = ""
    subscript: tuple[int | None, ...] = ()
    pred: str = ""
    source: str = ""
    strides: tuple[int, ...] = ()
    flags: frozenset[str] = frozenset()
    loc: SourceLoc | None = field(default=None, compare=False)
    lane: Lane | None = field(default=None, compare=False)

    @property
    def mnemonic(self) -> str:
        """The operation's name."""
        return self.op.value if isinstance(self.op, Opcode) else self.op

    @property
    def has_result(self) -> bool:
        """Whether it gives a value."""
        return self.op not in ("store", Opcode.STORE) and self.type != "void"

    @property
    def opcode(self) -> Opcode:
        """The machine's operation, of an instruction on words."""
        if not isinstance(self.op, Opcode):
            raise InternalError(f"LLVM's {self.op} among words")
        return self.op


@made_soon
@dataclass(frozen=True, slots=True)
class Phi:
    """An SSA phi: `incoming` maps a predecessor block's name to the value."""

    id: int
    type: Kind
    incoming: tuple[tuple[str, Value], ...]
    loc: SourceLoc | None = field(default=None, compare=False)


@dataclass(frozen=True, slots=True)
class Branch:
    """The block's terminator. `cond` None: jump to `target`. No target: return (`value` if any, and
    `high`, its high word, if one word may not hold it). `unreachable`: LLVM's, of what never runs.
    """

    target: str | None = None
    cond: Value | None = None
    otherwise: str | None = None
    value: Value | None = None
    loc: SourceLoc | None = field(default=None, compare=False)
    high: Value | None = None
    unreachable: bool = False

    @property
    def read(self) -> tuple[Value, ...]:
        """The values that the terminator reads."""
        words = (self.cond, self.value, self.high)
        return tuple(word for word in words if word is not None)

    @property
    def successors(self) -> tuple[str, ...]:
        """Names of the blocks that may follow."""
        first, second = self.target, self.otherwise if self.cond is not None else None
        if first is None:
            return () if second is None else (second,)
        return (first,) if second is None else (first, second)


@made_soon
@dataclass(frozen=True, slots=True)
class Block:
    """A basic block."""

    name: str
    phis: tuple[Phi, ...]
    instrs: tuple[Instr, ...]
    branch: Branch

    @property
    def items(self) -> tuple[Phi | Instr, ...]:
        """Phis, then instructions."""
        return (*self.phis, *self.instrs)


@dataclass(frozen=True)
class Function:
    """A kernel in SSA form; the first block is the entry.

    Attributes
    ----------
    name, params, returns, file
        As the program will name them; LLVM's functions may leave them out.
    sequential
        Headers of innermost loops that are not to be modulo-scheduled: they run block by block,
        like the loops around them.
    locals
        The kernel's own arrays.
    results
        What it returns besides a word.
    inputs
        LLVM's: key and type of each parameter.
    result
        LLVM's: the type that is returned.
    spaced
        Matrices whose rows a launch may lay further apart than they are long: their pitches stay
        inputs.
    """

    name: str
    params: tuple[Param, ...]
    blocks: tuple[Block, ...]
    returns: DType | None = None
    file: str = ""
    sequential: frozenset[str] = frozenset()
    locals: tuple[LocalArray, ...] = ()
    inputs: tuple[tuple[str, str], ...] = ()
    result: str = ""
    spaced: frozenset[str] = frozenset()
    results: Results | None = None

    @property
    def is_llvm(self) -> bool:
        """Whether operations and types are LLVM's: it was not narrowed to words yet."""
        return bool(self.result)

    @cached_property
    def known(self) -> dict[str, int]:
        """Words of the inputs that every launch supplies alike, by key, pitches included."""
        words: dict[str, int] = {}
        for param in self.params:
            words |= param.known_words
            if param.ndim:
                pitches = enumerate(param.known)
                words |= {pitch_of(param.name, axis).key: size for axis, size in pitches}
        return words

    def settled(self, value: Value) -> Value:
        """An operand as the back end has it: a constant if it is a known input, and no pitch but of
        what is spaced.
        """
        if not isinstance(value, Input):
            return value
        word = self.known.get(value.key)
        if word is not None:
            return Const(word)
        spaced = is_pitch(value) and value.key.rsplit(_PITCH, 1)[0] in self.spaced
        return value if spaced else without_pitch(value)

    @cached_property
    def by_name(self) -> dict[str, Block]:
        """Block of each name."""
        return {block.name: block for block in self.blocks}

    @cached_property
    def definitions(self) -> dict[Key, Phi | Instr]:
        """Phi or instruction of each id; inputs have none."""
        return {item.id: item for block in self.blocks for item in block.items}

    @cached_property
    def block_of(self) -> dict[Key, str]:
        """Name of the block that defines each id."""
        return {item.id: block.name for block in self.blocks for item in block.items}


def type_name(kind: Kind) -> str:
    """The name of a type."""
    return kind.value if isinstance(kind, Type) else kind


def truth_of(value: Value) -> bool | None:
    """The truth of a predicate that is constant."""
    if isinstance(value, Const):
        return bool(value.word)
    return bool(value.value & 1) if isinstance(value, Int) else None


def definition_of(function: Function, value: Value | None) -> Phi | Instr | None:
    """The phi or instruction that a value is the result of."""
    return function.definitions.get(value.id) if isinstance(value, Ref) else None


def type_of(function: Function, value: Value) -> str:
    """LLVM's type of a value ("" for constants)."""
    if isinstance(value, Input):
        return dict(function.inputs)[value.key]
    definition = definition_of(function, value)
    return "" if definition is None else result_type(definition)


def result_type(item: Phi | Instr) -> str:
    """LLVM's type of a result."""
    if isinstance(item, Instr) and item.op in ("icmp", "fcmp"):
        return "i1"
    return str(item.type)
