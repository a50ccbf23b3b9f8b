"""A kernel whose data-parallel loop can be cut into chunks: what a launch must know about it.

Pure data, which travels in the bundle. The loop runs from the input `FIRST` to the input `LAST`;
`terms` say how the host computes the loop's own bounds, and which bytes of each array a chunk of
iterations touches.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from vividc.errors import SourceLoc
from vividc.machine.opcodes import OPCODES, Opcode

FIRST: Final = "prange.first"
LAST: Final = "prange.last"
START: Final = "prange.start"
"""Input keys: first iteration, the one after the last, and (with a number) a reduction's start."""

CONST: Final = "const"
INPUT: Final = "input"
INDEX: Final = "index"
ANY: Final = "any"
UNION: Final = "union"
CHOICE: Final = "choice"
COUNTER: Final = "counter"
STEPS: Final = "steps"
WIDE_LOW: Final = "add.low"
WIDE_HIGH: Final = "add.high"
"""Ways to combine the two words of a sum of 64 bits."""
CLAMPS: Final = ("lt", "le", "gt", "ge", "ult", "eq")


@dataclass(frozen=True, slots=True)
class Term:
    """An integer value of the kernel, as an interval: a row of a table, whose `args` are earlier
    rows.

    Attributes
    ----------
    op
        "const" (of `word`), "input" (of `key`), "index" (the parallel loop's variable), "any" (of
        `word` bits; 32 and more: anything), "union", "choice" (condition, then, else), "counter"
        (start, limit, step: a loop's variable, also where the loop has ended), "steps" (start,
        step, count: start + step * k for 0 <= k < count), a clamp ("lt", "le", "gt", "ge", "ult",
        "eq": the first where it is so related to the second), or an opcode's name.
    """

    op: str
    args: tuple[int, ...] = ()
    word: int = 0
    key: str = ""


_OPCODES: Final = frozenset(op.value for op in Opcode)
_ARITIES: Final = {CONST: 0, INPUT: 0, INDEX: 0, ANY: 0, CHOICE: 3, COUNTER: 3, STEPS: 3}


def is_well_formed(terms: tuple[Term, ...]) -> bool:
    """Whether every row's `op` is known, with as many arguments as it takes, from earlier rows."""
    return all(
        _has_arity(term) and all(0 <= arg < row for arg in term.args)
        for row, term in enumerate(terms)
    )


def _has_arity(term: Term) -> bool:
    if term.op == UNION:
        return len(term.args) > 0
    if term.op in CLAMPS:
        return len(term.args) == 2  # noqa: PLR2004 - a value and what it is compared with
    if term.op in _ARITIES:
        return len(term.args) == _ARITIES[term.op]
    return term.op in _OPCODES and len(term.args) == OPCODES[Opcode(term.op)].arity


@dataclass(frozen=True, slots=True)
class Access:
    """A load or store: byte offset in the array = (term << shift) + offset.

    `counters`: terms of the variables of the loops inside the parallel one that are around a store
    which happens in every iteration of all of them; None if it may not happen.
    """

    array: str
    is_store: bool
    term: int
    shift: int
    offset: int
    width: int
    counters: tuple[int, ...] | None = None
    loc: SourceLoc | None = field(default=None, compare=False)


@dataclass(frozen=True, slots=True)
class Reduction:
    """A scalar that every iteration adds to.

    Attributes
    ----------
    op
        Opcode's name of what combines two partial results, `WIDE_LOW` or `WIDE_HIGH`; of a
        comparison: `partial` replaces
        `total` if `op(partial, total)` (`swapped`: `op(total, partial)`) is `taken`.
    identity
        The word with which all chunks but the first start; None: all start alike.
    start
        Term of the start value if it is an integer, and `start_word` if it is constant.
    """

    op: str
    identity: int | None
    start: int
    start_word: int | None = None
    swapped: bool = False
    taken: bool | None = None


@dataclass(frozen=True, slots=True)
class Parallel:
    """The parallel loop of a kernel.

    Attributes
    ----------
    first, last
        Terms of the loop's own bounds: it runs for first <= index < last.
    result
        Number of the reduction that the kernel returns, if it returns one.
    is_unsigned
        The bounds are unsigned; they must be below 2**31 all the same.
    """

    terms: tuple[Term, ...]
    first: int
    last: int
    accesses: tuple[Access, ...]
    reductions: tuple[Reduction, ...] = ()
    result: int | None = None
    is_unsigned: bool = False
    loc: SourceLoc | None = field(default=None, compare=False)

    @property
    def input_keys(self) -> frozenset[str]:
        """What is launched beside the parameters."""
        starts = (f"{START}{number}" for number in range(len(self.reductions)))
        return frozenset({FIRST, LAST, *starts})
