"""isl's expressions of words over the iterations of a nest, when a block of it runs, and how long
isl may take.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Final

import islpy as isl

from vividc.machine.opcodes import Opcode
from vividc.machine.params import MAX_DIMENSION
from vividc.machine.words import INT_MAX, SIGN_BIT, WORD_BITS, signed
from vividc.ssa.analysis.counters import counter_of
from vividc.ssa.analysis.induction import induction_of, is_invariant, never_wraps
from vividc.ssa.edit import block_of
from vividc.ssa.flow import Loop, find_loops, flow_of
from vividc.ssa.ir import (
    Const,
    Function,
    Input,
    Instr,
    Phi,
    Ref,
    Value,
    is_dimension,
    without_pitch,
)

_INT_MIN: Final = -SIGN_BIT
_WORDS: Final = 1 << WORD_BITS
_MOST_PIECES: Final = 8
_DOMAIN_PIECES: Final = 16
"""Convex ones, of the iterations in which a block may run: each condition of 88 multiplies them
(NPBench's channel_flow, whose parts of arrays have sizes from other parts).
"""
_LONGEST: Final = MAX_DIMENSION * 4
OPERATIONS: Final = 20_000_000
"""Of isl's for one question about a tree of loops. It takes no notice of the clock, and one tree of
a random nest took it 50 minutes without an end; these take about 10 s.
"""


@contextmanager
def bounded(operations: int = OPERATIONS) -> Iterator[bool]:
    """isl gives up where it would take long; nothing is known then. The value: whether it has all
    these operations, as none were set before.
    """
    context = isl.DEFAULT_CONTEXT
    before = context.get_max_operations()
    context.reset_operations()
    context.set_max_operations(min(operations, before or operations))
    try:
        yield not before
    except isl.Error:  # it says at random what it was doing then
        pass
    finally:
        context.set_max_operations(before)


def integer(value: isl.Val) -> int:
    """A whole number of isl's.

    Raises
    ------
    isl.Error
        No operations are left, of which writing it takes some: islpy gives None then.
    """
    text = value.to_str()
    if text is None:
        raise isl.Error("a number was not written: no operations are left")
    return int(text)


@dataclass(frozen=True, slots=True)
class Expression:
    """An integer for each iteration of a nest, and bounds of it."""

    aff: isl.PwAff
    low: int
    high: int

    def plus(self, other: Expression, factor: int = 1) -> Expression:
        """self + factor * other."""
        times = other.times(factor)
        return Expression(self.aff.add(times.aff), self.low + times.low, self.high + times.high)

    def times(self, factor: int) -> Expression:
        """self * factor."""
        ends = (self.low * factor, self.high * factor)
        return Expression(self.aff.scale_val(isl.Val(factor)), min(ends), max(ends))

    def modulo(self, size: int) -> Expression:
        """The rest, not negative, of the division by `size`."""
        if self.low >= 0 and self.high < size:
            return self
        return Expression(self.aff.mod_val(isl.Val(size)), 0, size - 1)

    def divided(self, size: int) -> Expression:
        """The quotient by `size`, rounded down."""
        aff = self.aff.scale_down_val(isl.Val(size)).floor()
        return Expression(aff, self.low // size, self.high // size)

    @property
    def word(self) -> Expression:
        """The signed word that is left of it."""
        if self.low >= _INT_MIN and self.high <= INT_MAX:
            return self
        offset = isl.Val(SIGN_BIT)
        aff = self.aff.add_constant_val(offset).mod_val(isl.Val(_WORDS))
        return Expression(aff.add_constant_val(offset.neg()), _INT_MIN, INT_MAX)

    @property
    def unsigned(self) -> Expression:
        """The word that is left of it, unsigned."""
        return self.modulo(_WORDS)


@dataclass
class Expressions:
    """Signed words of `function` over the iteration indices of `loops`, outermost first, each of
    which holds the next. Values from outside them are parameters, as are the iteration indices of
    loops around them.

    Without loops: the values in one run of a block. `most`: no loop has more iterations.
    """

    function: Function
    loops: Sequence[Loop] = ()
    most: int = _WORDS
    _symbols: dict[Value | tuple[object, ...], Expression] = field(init=False, default_factory=dict)
    _facts: isl.Set = field(init=False)
    _memo: dict[Value, Expression | None] = field(init=False, default_factory=dict)
    _runs: dict[str, isl.Set] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        """Indexes definitions and loops."""
        self._space = isl.Space.set_alloc(isl.DEFAULT_CONTEXT, 0, len(self.loops))
        self._facts = isl.Set.universe(self._space)
        for number in range(len(self.loops)):
            self._facts = self._facts.lower_bound_val(isl.dim_type.set, number, isl.Val(0))
            last = isl.Val(self.most - 1)
            self._facts = self._facts.upper_bound_val(isl.dim_type.set, number, last)
        self._headers = {loop.header: loop for loop in find_loops(self.function)}
        self._dims = {loop.header: number for number, loop in enumerate(self.loops)}
        self._blocks = self.function.block_of

    @property
    def universe(self) -> isl.Set:
        """All iterations, and what is known of the parameters met so far."""
        return self._facts

    @property
    def met(self) -> int:
        """How many parameters were met so far."""
        return len(self._symbols)

    def of(self, value: Value) -> Expression | None:
        """The signed word `value` in the iteration that computes it; None if it is not affine."""
        if value not in self._memo:
            self._memo[value] = None  # of a cycle through phis nothing is known but by `_header`
            try:
                found = self._compute(value)
            except isl.Error:  # out of operations, which says nothing about the value
                del self._memo[value]
                raise
            if found is not None and found.aff.n_piece() > _MOST_PIECES:
                found = None
            if found is None and self.is_fixed(value):
                found = self.symbol(value)
            self._memo[value] = found
        return self._memo[value]

    def is_fixed(self, value: Value) -> bool:
        """Whether `value` comes from outside the loops, or is computed once."""
        return not self.loops or is_invariant(self.function, self.loops[0].blocks, value)

    def symbol(
        self, key: Value | tuple[object, ...], low: int = _INT_MIN, high: int = INT_MAX
    ) -> Expression:
        """The parameter that stands for `key`."""
        if isinstance(key, Input):
            key = without_pitch(key)
            low, high = (0, _LONGEST) if is_dimension(key) else (low, high)
        if key not in self._symbols:
            name = isl.Id(f"p{len(self._symbols)}", context=isl.DEFAULT_CONTEXT)
            aff = isl.PwAff.param_on_domain_id(isl.Set.universe(self._space), name)
            made = self._symbols[key] = Expression(aff, low, high)
            self._facts = self._facts.intersect(made.aff.ge_set(self.constant(low).aff))
            self._facts = self._facts.intersect(made.aff.le_set(self.constant(high).aff))
        return self._symbols[key]

    def parameters(self, space: isl.Space) -> Iterator[tuple[Value | tuple[object, ...], int]]:
        """What the parameters of a space stand for, with their positions."""
        keys = list(self._symbols)
        for position in range(space.dim(isl.dim_type.param)):
            name = str(space.get_dim_name(isl.dim_type.param, position))
            yield keys[int(name[1:])], position

    def constant(self, value: int) -> Expression:
        """An integer."""
        domain = isl.Set.universe(self._space)
        return Expression(isl.PwAff.val_on_domain(domain, isl.Val(value)), value, value)

    def domain(self, block: str) -> isl.Set:
        """Iterations in which `block` may run: branches on every way there say so, but those by
        which it would have too many pieces.
        """
        if block not in self._runs:
            runs = isl.Set.universe(self._space)
            for condition, truth in _conditions(self.function, block):
                held = self.holds(condition, truth)
                if held is not None and runs.n_basic_set() * held.n_basic_set() <= _DOMAIN_PIECES:
                    runs = runs.intersect(held)
            self._runs[block] = runs
        return self._runs[block].intersect(self._facts)

    def holds(self, predicate: Value, truth: bool) -> isl.Set | None:
        """Iterations in which a predicate has this truth; None if it is not affine."""
        item = self.function.definitions.get(predicate.id) if isinstance(predicate, Ref) else None
        if not isinstance(item, Instr):
            return None
        if item.op in _JOINED:
            return self._joined(item, truth)
        if item.op is Opcode.XOR and item.operands[1] == Const(1):
            return self.holds(item.operands[0], not truth)
        rule = _COMPARED.get(item.op) if isinstance(item.op, Opcode) else None
        operands = [self.of(operand) for operand in item.operands] if rule is not None else []
        known = [operand for operand in operands if operand is not None]
        if rule is None or len(known) < len(operands):
            return None
        if item.op in (Opcode.ICMP_ULT, Opcode.ICMP_ULE):
            known = [operand.unsigned for operand in known]
        made = rule(*(operand.aff for operand in known))
        return made if truth else made.complement()

    def _joined(self, item: Instr, truth: bool) -> isl.Set | None:
        """Of a conjunction or a disjunction."""
        left, right = (self.holds(operand, truth) for operand in item.operands)
        both = (item.op is Opcode.AND) == truth
        if left is None or right is None:
            return (left or right) if both else None
        return left.intersect(right) if both else left.union(right)

    def _compute(self, value: Value) -> Expression | None:
        value = self.function.settled(value)
        if isinstance(value, Const):
            return self.constant(signed(value.word))
        if not isinstance(value, Ref):
            return self.symbol(value)
        item = self.function.definitions[value.id]
        if isinstance(item, Phi):
            return self._phi(item)
        if item.op is Opcode.SELECT:
            return self._select(item)
        rule = _RULES.get(item.opcode)
        if rule is None:
            return None
        operands = [self.of(operand) for operand in item.operands]
        known = [operand for operand in operands if operand is not None]
        made = rule(known) if len(known) == len(operands) else None
        return None if made is None else _exactly(made) if item.exact else made.word

    def _phi(self, phi: Phi) -> Expression | None:
        """Of a loop's header: what it starts at, and its step times the iteration index."""
        loop = self._headers.get(self._blocks[phi.id])
        if loop is None or len(loop.latches) != 1:
            return None
        found = induction_of(self.function, loop.blocks, phi)
        step = None if found is None else found.step
        start = None if found is None or found.start is None else self.of(found.start)
        if step is None or start is None:
            return None
        made = start.plus(self._index(loop), step)
        counter = counter_of(self.function, loop)
        if counter is None or counter.phi.id != phi.id:
            exact = never_wraps(self.function, loop.blocks, Ref(phi.id), by_one=False)
            if not exact and loop.header not in self._dims:
                return None  # a parameter is simpler
            return _exactly(made) if exact else made.word
        limit = self.of(counter.limit)
        low, high = (start.low, INT_MAX) if step > 0 else (_INT_MIN, start.high)
        if limit is not None and step > 0:
            high = min(high, max(start.high, limit.high - 1 + step))
        if limit is not None and step < 0:
            low = max(low, min(start.low, limit.low + 1 + step))
        return Expression(made.aff, max(low, made.low), min(high, made.high))

    def _index(self, loop: Loop) -> Expression:
        """The iteration index of a loop."""
        if loop.header not in self._dims:
            return self.symbol(("iteration", loop.header), 0, _WORDS)
        where = isl.LocalSpace.from_space(self._space)
        aff = isl.Aff.var_on_domain(where, isl.dim_type.set, self._dims[loop.header])
        return Expression(isl.PwAff.from_aff(aff), 0, self.most)

    def _select(self, item: Instr) -> Expression | None:
        condition, *values = item.operands
        held = self.holds(condition, True)
        taken, other = (self.of(value) for value in values)
        if held is None or taken is None or other is None:
            return None
        aff = taken.aff.intersect_domain(held)
        aff = aff.union_add(other.aff.intersect_domain(held.complement()))
        return Expression(aff, min(taken.low, other.low), max(taken.high, other.high))


def _conditions(function: Function, block: str) -> Iterator[tuple[Value, bool]]:
    """Predicates, and the truth that each had when `block` was reached: those of branches with an
    edge that every way there takes.
    """
    flow = flow_of(function)
    for name in flow.dominators(block):
        before = flow.predecessors[name]
        branch = block_of(function, before[0]).branch if len(before) == 1 else None
        if branch is not None and branch.cond is not None and branch.target != branch.otherwise:
            yield branch.cond, branch.target == name


def _exactly(made: Expression) -> Expression:
    """What is proved to be a signed word."""
    return Expression(made.aff, max(made.low, _INT_MIN), min(made.high, INT_MAX))


def _product(operands: list[Expression]) -> Expression | None:
    for left, right in (operands, operands[::-1]):
        if right.low == right.high:
            return left.times(right.low)
    return None


def _shifted(operands: list[Expression]) -> Expression | None:
    left, right = operands
    if right.low == right.high and 0 <= right.low < WORD_BITS:
        return left.times(1 << right.low)
    return None


def _shifted_right(operands: list[Expression]) -> Expression | None:
    left, right = operands
    if right.low == right.high and 0 <= right.low < WORD_BITS:
        return left.divided(1 << right.low)
    return None


def _masked(operands: list[Expression]) -> Expression | None:
    for left, right in (operands, operands[::-1]):
        size = right.low + 1
        if right.low == right.high and right.low > 0 and not size & right.low:
            return left.modulo(size)
    return None


def _inverted(operands: list[Expression]) -> Expression | None:
    for left, right in (operands, operands[::-1]):
        if right.low == right.high == -1:
            return right.plus(left, -1)
    return None


def _extreme(name: str) -> _Rule:
    def rule(operands: list[Expression]) -> Expression:
        left, right = operands
        aff = getattr(left.aff, name)(right.aff)
        pick = {"min": min, "max": max}[name]
        return Expression(aff, pick(left.low, right.low), pick(left.high, right.high))

    return rule


_Rule = Callable[[list[Expression]], Expression | None]
_RULES: dict[Opcode, _Rule] = {
    Opcode.ADD: lambda o: o[0].plus(o[1]),
    Opcode.SUB: lambda o: o[0].plus(o[1], -1),
    Opcode.MUL: _product,
    Opcode.SHL: _shifted,
    Opcode.ASHR: _shifted_right,
    Opcode.LSHR: lambda o: _shifted_right([o[0].unsigned, o[1]]),
    Opcode.AND: _masked,
    Opcode.XOR: _inverted,
    Opcode.SMIN: _extreme("min"),
    Opcode.SMAX: _extreme("max"),
    Opcode.MOV: lambda o: o[0],
}
_JOINED: Final = (Opcode.AND, Opcode.OR)
_COMPARED: dict[Opcode, Callable[[isl.PwAff, isl.PwAff], isl.Set]] = {
    Opcode.ICMP_EQ: lambda a, b: a.eq_set(b),
    Opcode.ICMP_NE: lambda a, b: a.ne_set(b),
    Opcode.ICMP_SLT: lambda a, b: a.lt_set(b),
    Opcode.ICMP_SLE: lambda a, b: a.le_set(b),
    Opcode.ICMP_ULT: lambda a, b: a.lt_set(b),
    Opcode.ICMP_ULE: lambda a, b: a.le_set(b),
}
