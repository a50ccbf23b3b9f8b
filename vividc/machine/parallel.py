"""A kernel whose data-parallel loop can be cut into chunks: what a launch must know about it.

Pure data, which travels in the bundle. The loop runs from the input `FIRST` to the input `LAST`;
`terms` say how the host computes the loop's own bounds, and which bytes of each array a chunk of
iterations touches. `Order` is that of a kernel's nests of loops, each a program with such a loop.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final

from vividc.errors import SourceLoc
from vividc.machine.opcodes import OPCODES, Opcode

FIRST: Final = "prange.first"
LAST: Final = "prange.last"
START: Final = "prange.start"
"""Input keys: first iteration, the one after the last, and (with a number) a reduction's start."""
BLOCK_FIRST: Final = "prange.block.first"
BLOCK_LAST: Final = "prange.block.last"
"""Input keys: the loops directly inside the parallel one run over no more than this, if they are
blocked.
"""
BESIDE_FIRST: Final = "prange.beside.first"
BESIDE_LAST: Final = "prange.beside.last"
"""Input keys, with the number of a loop beside the parallel one: its part of a chunk."""

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
    `subscripts`: terms of the subscripts of an element of an array with several dimensions; () if
    they are not known.
    `beside`: the number of the loop beside the parallel one that it is in; `counters` are then the
    variables of this loop and of those inside it, and `leads` says that no load of the array comes
    before it.
    """

    array: str
    is_store: bool
    term: int
    shift: int
    offset: int
    width: int
    counters: tuple[int, ...] | None = None
    subscripts: tuple[int, ...] = ()
    beside: int | None = None
    leads: bool = False
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
class Beside:
    """A loop before or after the parallel one that runs between two inputs of its own: chunks may
    share its iterations, if none of them touches what another one writes.

    `first`, `last`: terms of its own bounds. `is_before`: all of it runs before the parallel loop.
    """

    first: int
    last: int
    is_before: bool


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
    blocked
        Terms of the first value and the limit of each loop directly inside, if these run between
        `BLOCK_FIRST` and `BLOCK_LAST` only, and do all that an iteration stores.
    around
        Input keys of the counters of loops around it.
    beside
        Loops before and after it, whose iterations are shared, too.
    sliced
        Arrays of the kernel's own that a launch cuts into slices as it does those of arguments:
        each chunk has its own, and nobody else needs what is left there.
    alike
        Arrays to which every chunk stores the same words, whatever its iterations, and from which
        none loads: what one of them leaves there is what all do.
    """

    terms: tuple[Term, ...]
    first: int
    last: int
    accesses: tuple[Access, ...]
    reductions: tuple[Reduction, ...] = ()
    result: int | None = None
    is_unsigned: bool = False
    blocked: tuple[tuple[int, int], ...] = ()
    around: tuple[str, ...] = ()
    beside: tuple[Beside, ...] = ()
    sliced: tuple[str, ...] = ()
    alike: tuple[str, ...] = ()
    loc: SourceLoc | None = field(default=None, compare=False)

    @property
    def input_keys(self) -> frozenset[str]:
        """What is launched beside the parameters."""
        starts = (f"{START}{number}" for number in range(len(self.reductions)))
        block = (BLOCK_FIRST, BLOCK_LAST) if self.blocked else ()
        ends = (key for n in range(len(self.beside)) for key in beside_keys(n))
        return frozenset({FIRST, LAST, *starts, *block, *ends, *self.around})


def beside_keys(number: int) -> tuple[str, str]:
    """Input keys: the first iteration of a loop beside the parallel one, and the one after the
    last.
    """
    return f"{BESIDE_FIRST}{number}", f"{BESIDE_LAST}{number}"


REPEAT: Final = "repeat"
"""Input keys, with a number: the counter of a loop around nests."""


@dataclass(frozen=True, slots=True)
class Repeat:
    """A loop around nests, or around further such loops.

    Attributes
    ----------
    key
        Of the input that gives its counter to the nests.
    first, last
        Terms of its first value, and of the limit that it does not reach.
    body
        Numbers of nests, and loops.
    """

    key: str
    first: int
    last: int
    step: int
    body: tuple[int | Repeat, ...]


@dataclass(frozen=True, slots=True)
class Order:
    """What runs after what; `terms` say how the host computes bounds of loops."""

    terms: tuple[Term, ...]
    items: tuple[int | Repeat, ...]

    @property
    def keys(self) -> frozenset[str]:
        """Inputs beside the parameters."""
        return frozenset(repeat.key for repeat in _repeats(self.items))

    def is_of(self, nests: int) -> bool:
        """Whether it is one of so many nests, and its bounds are terms."""
        used = [n for r in _repeats(self.items) for n in (r.first, r.last)]
        numbers = [*_numbers(self.items)]
        in_table = all(0 <= number < len(self.terms) for number in used)
        steps = all(repeat.step for repeat in _repeats(self.items))
        return in_table and steps and all(0 <= number < nests for number in numbers)

    def runs(self, bound: Callable[[int, Mapping[str, int]], int]) -> Iterator[Run]:
        """The nests in the order of their runs, each with the counters around it.

        Parameters
        ----------
        bound
            Gives a term's value, of counters.
        """
        yield from _runs(self.items, {}, bound)


Run = tuple[int, Mapping[str, int]]


def _runs(
    items: tuple[int | Repeat, ...],
    counters: Mapping[str, int],
    bound: Callable[[int, Mapping[str, int]], int],
) -> Iterator[Run]:
    for item in items:
        if isinstance(item, int):
            yield item, counters
            continue
        for value in range(bound(item.first, counters), bound(item.last, counters), item.step):
            yield from _runs(item.body, {**counters, item.key: value}, bound)


def _numbers(items: tuple[int | Repeat, ...]) -> Iterator[int]:
    for item in items:
        yield from (item,) if isinstance(item, int) else _numbers(item.body)


def _repeats(items: tuple[int | Repeat, ...]) -> Iterator[Repeat]:
    for item in items:
        if isinstance(item, Repeat):
            yield item
            yield from _repeats(item.body)
