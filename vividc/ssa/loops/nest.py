"""Two nested loops as unroll-and-jam sees them, and whether their order may change."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property

from vividc.machine.opcodes import MEMORY, Opcode
from vividc.machine.words import WORD_BYTES
from vividc.ssa.analysis.alias import different_elements
from vividc.ssa.analysis.counted import count_loop
from vividc.ssa.analysis.induction import is_invariant
from vividc.ssa.analysis.polynomial import (
    ITERATION,
    LoopPolynomials,
    Polynomial,
    constant,
    symbol,
)
from vividc.ssa.edit import block_of
from vividc.ssa.flow import Loop, find_loops, preheader_of
from vividc.ssa.ir import Function, Instr, Ref, Value
from vividc.ssa.rewrite.refusal import Refusal


class Part(IntEnum):
    """Where in an iteration of the outer loop: before the inner one, in it, after it."""

    BEFORE = 0
    INNER = 1
    AFTER = 2


@dataclass(frozen=True)
class Nest:
    """An outer loop with one inner loop.

    Attributes
    ----------
    before
        Blocks from the outer header to the inner preheader, a straight chain.
    entry, leave
        First block of the inner loop's body, and the block after it.
    """

    function: Function
    outer: Loop
    inner: Loop
    before: tuple[str, ...]
    entry: str
    leave: str

    def part(self, name: str) -> Part:
        """The part of the outer body that a block is in."""
        if name in self.before:
            return Part.BEFORE
        return Part.INNER if name in self.inner.blocks else Part.AFTER

    @cached_property
    def accesses(self) -> tuple[Access, ...]:
        """Loads and stores of the nest."""
        outer = LoopPolynomials(self.function, self.outer)
        inner = LoopPolynomials(self.function, self.inner)
        return tuple(
            _access(instr, self.part(block.name), outer, inner)
            for block in self.function.blocks
            if block.name in self.outer.blocks
            for instr in block.instrs
            if instr.op in MEMORY
        )


@dataclass(frozen=True)
class Access:
    """A load or store; its byte address is `inner` * inner iteration + `outer`, None if unknown."""

    instr: Instr
    part: Part
    outer: Polynomial | None
    inner: int

    @property
    def is_store(self) -> bool:
        """Writes memory."""
        return self.instr.op is Opcode.STORE


def find_nest(function: Function, outer: Loop) -> Nest | Refusal:
    """`outer` as a nest of two counted loops that leave at their headers only, the inner one as
    often in every iteration.
    """
    within = [
        loop
        for loop in find_loops(function)
        if loop.header in outer.blocks and loop.header != outer.header
    ]
    if len(within) != 1:
        count = "no loop is" if not within else f"{len(within)} loops are"
        return Refusal(f"{count} inside it, and not one")
    (inner,) = within
    if any(source != loop.header for loop in (outer, inner) for source, _ in loop.exits):
        return Refusal("a loop is left by a break")
    if len(outer.exits) != 1 or len(inner.exits) != 1 or inner.latches == (inner.header,):
        return Refusal("a loop is not tested at its start")
    before = _chain(function, outer, inner)
    leave = inner.exits[0][1]
    if before is None or leave == outer.header or leave not in outer.blocks:
        return Refusal("other control flow surrounds the inner loop")
    header = block_of(function, inner.header)
    entry = next(name for name in header.branch.successors if name in inner.blocks)
    if not _same_trips(function, outer, inner):
        return Refusal("the inner loop's trip count changes with the outer loop")
    return Nest(function, outer, inner, before, entry, leave)


def forbids_jam(nest: Nest, factor: int) -> Refusal | None:
    """A dependence that would be reversed if `factor` outer iterations shared each inner one.

    Iteration i + d (0 < d < factor) then does its first part before the later parts of iteration i,
    and inner iteration j of i + d comes before j + 1 of i (Callahan, Cocke and Kennedy 1988).
    """
    for first in nest.accesses:
        for second in nest.accesses:
            if first.instr.array != second.instr.array or second.part > first.part:
                continue
            if not (first.is_store or second.is_store):
                continue
            if first.part == second.part != Part.INNER:
                continue
            if different_elements(first.instr.subscript, second.instr.subscript):
                continue
            if any(_reversed(first, second, d) for d in range(1, factor)):
                places = f"{_place(first.instr)} and {_place(second.instr)}"
                return Refusal(f"accesses to {first.instr.array} may depend: {places}")
    return None


def _reversed(first: Access, second: Access, distance: int) -> bool:
    """Whether `second`, `distance` outer iterations later, may touch a word that `first` touches
    after it in the jammed order.
    """
    gap = _gap(first, second, distance)
    if gap is None:
        return True
    if first.part is Part.INNER and second.part is Part.INNER:
        if first.inner != second.inner:
            return True
        return any(ahead < 0 for ahead in _solutions(first.inner, gap))
    if first.inner or second.inner:  # only the inner one of the two moves
        stride = second.inner if second.part is Part.INNER else -first.inner
        return any(iteration >= 0 for iteration in _solutions(stride, gap))
    return abs(gap) < WORD_BYTES


def _gap(first: Access, second: Access, distance: int) -> int | None:
    """Address of `first` minus that of `second` `distance` iterations later, inner counters 0."""
    if first.outer is None or second.outer is None:
        return None
    apart = first.outer.plus(second.outer, -1).constant
    return None if apart is None else apart - second.outer.coefficient(ITERATION) * distance


def _solutions(stride: int, gap: int) -> Iterator[int]:
    """Integers x, of either sign where all are, with stride * x within a word of `gap`."""
    if stride == 0:
        if abs(gap) < WORD_BYTES:
            yield from (-1, 1)
        return
    near = gap // stride
    reach = 1 + WORD_BYTES // abs(stride)
    for candidate in range(near - reach, near + reach + 1):
        if abs(stride * candidate - gap) < WORD_BYTES:
            yield candidate


def _access(instr: Instr, part: Part, outer: LoopPolynomials, inner: LoopPolynomials) -> Access:
    base, index = instr.operands[0], instr.operands[1]
    form = inner.of(index) if part is Part.INNER else symbol(index)
    if form is None or not is_invariant(outer.function, outer.loop.blocks, base):
        return Access(instr, part, None, 0)
    total = constant(instr.offset + (form.coefficient() << instr.shift)).plus(symbol(base))
    for value, factor in form.without(ITERATION).linear().items():
        term = outer.of(value)
        if term is None:
            return Access(instr, part, None, 0)
        total = total.plus(term, factor << instr.shift)
    return Access(instr, part, total, form.coefficient(ITERATION) << instr.shift)


def _chain(function: Function, outer: Loop, inner: Loop) -> tuple[str, ...] | None:
    """The blocks from the outer header to the inner preheader if nothing branches in between."""
    header = block_of(function, outer.header)
    chain = [outer.header]
    name = next(name for name in header.branch.successors if name in outer.blocks)
    while name != inner.header:
        block = block_of(function, name)
        if len(block.branch.successors) != 1 or name in chain:
            return None
        chain.append(name)
        name = block.branch.successors[0]
    return tuple(chain) if len(chain) > 1 else None


def _same_trips(function: Function, outer: Loop, inner: Loop) -> bool:
    counted, trip = count_loop(function, inner, preheader_of(function, inner))
    if trip is None:
        return False
    own = {
        instr.id: instr
        for block in counted.blocks
        if block.name in outer.blocks
        for instr in block.instrs
    }
    phis = {p.id for b in counted.blocks if b.name in outer.blocks for p in b.phis}

    def fixed(value: Value) -> bool:
        if not isinstance(value, Ref) or (value.id not in own and value.id not in phis):
            return True
        instr = own.get(value.id)
        return instr is not None and instr.op not in MEMORY and all(map(fixed, instr.operands))

    return fixed(trip.value)


def _place(instr: Instr) -> str:
    name = instr.mnemonic
    return name if instr.loc is None else f"{name} in line {instr.loc.line}"
