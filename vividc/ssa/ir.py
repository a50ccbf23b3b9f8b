"""The kernel as the frontend hands it over: typed SSA instructions in basic blocks, with source
lines.

This is the one type between `frontend` and `dfg`. It is close to LLVM IR but holds only what an
array can run: 32-bit integers and floats, predicates, array accesses, `phi`, and branches. 64-bit
integers and doubles have been narrowed by the frontend before.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from vividc.errors import SourceLoc
from vividc.machine.lanes import Lane
from vividc.machine.opcodes import Opcode, Type
from vividc.machine.params import (
    DType,
    LocalArray,
    Param,
)


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
