"""Flattened rectangular nests: every outer iteration runs the inner loop as often.

The iterations of the flattened loop are then counted, so that no predicate ends it and nothing has
to wait for one. An index i * columns + j that runs through whole rows is the iteration index itself
(loop coalescing, Polychronopoulos 1987).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from vividc.machine.opcodes import MEMORY, Opcode, Type
from vividc.ssa.analysis.counted import count_loop
from vividc.ssa.analysis.counters import Counter, counter_of, defined_in, is_length
from vividc.ssa.analysis.polynomial import Polynomial, Polynomials
from vividc.ssa.edit import block_of, next_id, with_blocks
from vividc.ssa.flow import Loop, dominators, preheader_of
from vividc.ssa.ir import Branch, Const, Function, Instr, Phi, Ref, Value
from vividc.ssa.loops.flatten.rotate import can_rotate, used_outside

_INT_MAX = 0x7FFFFFFF


@dataclass(frozen=True)
class Rectangle:
    """What is known of a rectangular nest before it is flattened.

    Attributes
    ----------
    total
        Iterations of the flattened loop.
    runs
        The predicate that the inner loop has an iteration.
    indices
        For accesses in the inner loop whose index is stride * (iteration of the flattened loop) +
        base: (stride, base), by id of the access.
    """

    total: Value
    runs: Value
    indices: dict[int, tuple[int, Value]]


def rectangle(function: Function, outer: Loop, inner: Loop) -> tuple[Function, Rectangle | None]:
    """Recognises a rectangular nest, and computes what is known of it before the outer loop.

    Refused: exits from elsewhere than the two headers, outer iterations that skip the inner loop,
    trip counts that `count_loop` refuses, and inner bounds that change in the outer loop.
    """
    pair = _counters(function, outer, inner)
    if pair is None:
        return function, None
    before = preheader_of(function, outer)
    counted, outer_trip = count_loop(function, outer, before)
    counted, inner_trip = count_loop(counted, inner, before)
    if outer_trip is None or inner_trip is None:
        return function, None
    emitter = _Emitter(next_id(counted), block_of(function, outer.header).branch)
    idle = _may_be_skipped(function, outer, inner)
    rows = emitter.at_least(outer_trip.value, 0, pair[0])
    columns = emitter.at_least(inner_trip.value, 0 if idle else 1, pair[1])
    total = emitter.product(rows, columns, safe=all(map(_is_short, pair)))
    runs: Value = Const(1)
    if not idle:
        runs = emitter.emit(Opcode.ICMP_SLT, Const(0), inner_trip.value)
    emitter.varying = defined_in(function, outer)
    indices = _linear_indices(counted, inner, pair, emitter)
    block = block_of(counted, before)
    block = replace(block, instrs=(*block.instrs, *emitter.instrs))
    return with_blocks(counted, (block,)), Rectangle(total, runs, indices)


def count_flattened(function: Function, outer: Loop, inner: Loop, found: Rectangle) -> Function:
    """The flattened loop, ended by a count of its iterations.

    Parameters
    ----------
    outer, inner
        The loops as they were, the inner one rotated. Its header still tests whether there is an
        iteration.
    """
    block = block_of(function, outer.header)
    before = preheader_of(function, outer)
    ident = next_id(function)
    ahead = Instr(ident + 1, Opcode.ADD, Type.I32, (Ref(ident), Const(1)), loc=block.branch.loc)
    sources = [name for name, _ in block.phis[0].incoming]
    number = Phi(
        ident,
        Type.I32,
        tuple((name, Const(0) if name == before else Ref(ahead.id)) for name in sources),
        block.branch.loc,
    )
    test = Instr(
        ident + 2, Opcode.ICMP_SLT, Type.PRED, (Ref(ident), found.total), loc=block.branch.loc
    )
    branch = block.branch
    stays, leaves = branch.target, branch.otherwise
    if stays not in outer.blocks:
        stays, leaves = leaves, stays
    free = ident + 3
    moved: list[Instr] = []
    index: dict[int, Value] = {}
    for access, (stride, base) in found.indices.items():
        scaled, added = Ref(free), Ref(free + 1)
        free += 2
        operands = (Ref(ident), Const(stride & 0xFFFFFFFF))
        moved.append(Instr(scaled.id, Opcode.MUL, Type.I32, operands))
        moved.append(Instr(added.id, Opcode.ADD, Type.I32, (scaled, base)))
        index[access] = added
    changed = replace(
        block,
        phis=(*block.phis, number),
        instrs=(*block.instrs, ahead, test, *moved),
        branch=Branch(stays, Ref(test.id), leaves, loc=branch.loc),
    )
    first = block_of(function, inner.header)
    first = replace(first, branch=replace(first.branch, cond=found.runs))
    function = with_blocks(function, (changed, first))
    blocks = tuple(
        replace(b, instrs=tuple(_reindexed(instr, index) for instr in b.instrs))
        for b in function.blocks
    )
    return replace(function, blocks=blocks)


def _reindexed(instr: Instr, index: dict[int, Value]) -> Instr:
    if instr.id not in index:
        return instr
    base, _, *rest = instr.operands
    return replace(instr, operands=(base, index[instr.id], *rest))


def _counters(function: Function, outer: Loop, inner: Loop) -> tuple[Counter, Counter] | None:
    for loop in (outer, inner):
        if any(source != loop.header for source, _ in loop.exits):
            return None
    dominating = dominators(function)
    if inner.header not in dominating[outer.latches[0]]:
        return None
    first, second = counter_of(function, outer), counter_of(function, inner)
    if first is None or second is None:
        return None
    header = block_of(function, inner.header)
    if header.branch.target not in inner.blocks or not can_rotate(function, inner):
        return None
    own = defined_in(function, outer)
    varies = [v for v in (second.limit, second.initial) if isinstance(v, Ref) and v.id in own]
    return None if varies else (first, second)


def _may_be_skipped(function: Function, outer: Loop, inner: Loop) -> bool:
    """Whether outer iterations that do not run the inner loop leave no trace."""
    stores = any(
        instr.op is Opcode.STORE
        for block in function.blocks
        if block.name in outer.blocks - inner.blocks
        for instr in block.instrs
    )
    return not stores and not used_outside(function, outer)


def _linear_indices(
    function: Function, inner: Loop, pair: tuple[Counter, Counter], emitter: _Emitter
) -> dict[int, tuple[int, Value]]:
    """Indices that run through the nest without a gap, as (stride, base computed before it)."""
    outer_counter, inner_counter = pair
    if abs(inner_counter.step) != 1:
        return {}
    known = Polynomials(function)
    first, second = known.of(inner_counter.initial), known.of(inner_counter.limit)
    trip = second.plus(first, -1).times(_number(inner_counter.step))
    found: dict[int, tuple[int, Value]] = {}
    for block in function.blocks:
        if block.name not in inner.blocks:
            continue
        for instr in block.instrs:
            if instr.op not in MEMORY:
                continue
            linear = _in_iterations(known, instr.operands[1], outer_counter, inner_counter, trip)
            base = None if linear is None else emitter.polynomial(linear[1])
            if linear is not None and base is not None:
                found[instr.id] = (linear[0], base)
    return found


def _in_iterations(
    known: Polynomials, index: Value, outer: Counter, inner: Counter, trip: Polynomial
) -> tuple[int, Polynomial] | None:
    """(stride, base) if index = stride * (outer iteration * trip + inner iteration) + base."""
    in_inner = known.of(index).linear_in(Ref(inner.phi.id))
    if in_inner is None:
        return None
    slope, rest = in_inner
    in_outer = rest.linear_in(Ref(outer.phi.id))
    factor = slope.constant
    if in_outer is None or not factor:
        return None
    row, base = in_outer
    stride = factor * inner.step
    if row.times(_number(outer.step)) != trip.times(_number(stride)):
        return None
    base = base.plus(row.times(known.of(outer.initial)))
    return stride, base.plus(known.of(inner.initial), factor)


def _is_short(counter: Counter) -> bool:
    return is_length(counter.limit) and is_length(counter.initial)


def _number(word: int) -> Polynomial:
    return Polynomial({(): word})


@dataclass
class _Emitter:
    """Instructions to be put before the nest."""

    next_id: int
    like: Branch
    varying: set[int] = field(default_factory=set)
    instrs: list[Instr] = field(default_factory=list)

    def emit(self, op: Opcode, left: Value, right: Value) -> Value:
        """One more integer instruction."""
        compares = op in (Opcode.ICMP_SLT, Opcode.ICMP_NE, Opcode.OR)
        kind = Type.PRED if compares else Type.I32
        self.instrs.append(Instr(self.next_id, op, kind, (left, right), loc=self.like.loc))
        self.next_id += 1
        return Ref(self.next_id - 1)

    def at_least(self, trip: Value, least: int, counter: Counter) -> Value:
        """max(trip, least); a dimension needs no maximum with 0."""
        if isinstance(trip, Const):
            return Const(max(trip.word, least))
        if least == 0 and trip == counter.limit and is_length(trip):
            return trip
        return self.emit(Opcode.SMAX, trip, Const(least))

    def product(self, left: Value, right: Value, *, safe: bool) -> Value:
        """left * right of natural numbers, at most 2**31 - 1; `safe` if that cannot be exceeded."""
        low = self.emit(Opcode.MUL, left, right)
        if safe:
            return low
        high = self.emit(Opcode.MULHS, left, right)
        overflows = self.emit(Opcode.ICMP_NE, high, Const(0))
        negative = self.emit(Opcode.ICMP_SLT, low, Const(0))
        either = self.emit(Opcode.OR, overflows, negative)
        operands = (either, Const(_INT_MAX), low)
        self.instrs.append(
            Instr(self.next_id, Opcode.SELECT, Type.I32, operands, loc=self.like.loc)
        )
        self.next_id += 1
        return Ref(self.next_id - 1)

    def polynomial(self, total: Polynomial) -> Value | None:
        """The word of a polynomial; None if it reads a value of the nest."""
        read = {value.id for m in total.terms for value in m if isinstance(value, Ref)}
        if read & self.varying:
            return None
        value: Value = Const(0)
        for monomial, coefficient in total.terms.items():
            term: Value = Const(coefficient & 0xFFFFFFFF)
            for factor in monomial:
                term = factor if term == Const(1) else self.emit(Opcode.MUL, term, factor)
            value = term if value == Const(0) else self.emit(Opcode.ADD, value, term)
        return value
