"""The kernel as the frontend hands it over: typed SSA instructions in basic blocks, with source
lines.

This is the one type between `frontend` and `dfg`. It is close to LLVM IR but holds only what an
array can run: 32-bit integers and floats, predicates, array accesses, `phi`, and branches. 64-bit
integers and doubles have been narrowed by the frontend before.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

from vividc.dfg.opcodes import Opcode, Type
from vividc.errors import SourceLoc

MAX_DIMENSION = 1 << 14
"""No array dimension may be larger: ranges of indices are proved with it, a launch checks it."""


class DType(Enum):
    """Element type of an array or type of a scalar parameter; the value is numpy's name."""

    F32 = "float32"
    I32 = "int32"
    U32 = "uint32"
    I64 = "int64"
    BOOL = "bool"


@dataclass(frozen=True, slots=True)
class Param:
    """One parameter of the Python function. `ndim` 0: a scalar."""

    name: str
    dtype: DType
    ndim: int = 0


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

    `key` is "n" for scalar parameter n, "&x" for the byte address of array x in the scratchpad, and
    "x.shape0", "x.shape1", ... for its dimensions.
    """

    key: str


Value = Ref | Const | Input


@dataclass(frozen=True, slots=True)
class Instr:
    """One SSA instruction.

    `op` is an `Opcode`: an operation, `load` (operands: base, index), `store` (operands: base,
    index, value); in straight code a predicate may be the last operand. The byte address is base +
    (index << shift) + offset; `array` names the array accessed. `exact`: an integer addition or
    subtraction that is proved not to wrap as a signed word. `distinct`: header of a loop in whose
    run an address that such an access has touched comes back only at accesses with the same index
    that follow this one in the program, before the index changes.
    """

    id: int
    op: Opcode
    type: Type
    operands: tuple[Value, ...]
    array: str = ""
    shift: int = 0
    offset: int = 0
    exact: bool = False
    distinct: str = ""
    loc: SourceLoc | None = field(default=None, compare=False)


@dataclass(frozen=True, slots=True)
class Phi:
    """An SSA phi: `incoming` maps a predecessor block's name to the value."""

    id: int
    type: Type
    incoming: tuple[tuple[str, Value], ...]
    loc: SourceLoc | None = field(default=None, compare=False)


@dataclass(frozen=True, slots=True)
class Branch:
    """The block's terminator. `cond` None: jump to `target`. No target: return (`value` if any)."""

    target: str | None = None
    cond: Value | None = None
    otherwise: str | None = None
    value: Value | None = None
    loc: SourceLoc | None = field(default=None, compare=False)

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
    block by block, like the loops around them.
    """

    name: str
    params: tuple[Param, ...]
    blocks: tuple[Block, ...]
    returns: DType | None = None
    file: str = ""
    sequential: frozenset[str] = frozenset()
