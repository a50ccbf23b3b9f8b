"""Which of two integers is greater: proved from the branches that lead to a block, or what the
inputs of a launch would have to be.

An integer is a sum of values with factors, as far as its sums are exact. That one is not negative
follows from sums that are known not to be: comparisons that hold where a block runs, counters
beside where they start, dimensions (as Fourier and Motzkin eliminate values, one after the other).
Of a minimum or a maximum each side is looked at.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Final

from vividc.machine.opcodes import Opcode
from vividc.machine.words import signed
from vividc.ssa.analysis.induction import induction_of
from vividc.ssa.analysis.polynomial import Polynomial
from vividc.ssa.flow import Flow, flow_of
from vividc.ssa.ir import (
    Const,
    Function,
    Input,
    Instr,
    Phi,
    Ref,
    Value,
    definition_of,
    is_dimension,
    is_pitch,
    without_pitch,
)

_DEEPEST: Final = 4
"""Values that are eliminated one after the other."""

_MOST_STEPS: Final = 400
"""Sums that are looked at for one answer."""

_MOST_WITHIN: Final = 3
"""Comparisons without signs that are asked about for the sake of one."""

_PAIR: Final = 2
_SMALL: Final = 1 << 10
"""Inputs that are compared, and a constant with one of them, of what may be asked for."""

_COMPARED: Final[Mapping[object, str]] = {
    Opcode.ICMP_EQ: "eq",
    Opcode.ICMP_NE: "ne",
    Opcode.ICMP_SLT: "lt",
    Opcode.ICMP_SLE: "le",
    Opcode.ICMP_ULT: "lt",
    Opcode.ICMP_ULE: "le",
}
_UNSIGNED: Final = frozenset({Opcode.ICMP_ULT, Opcode.ICMP_ULE})
_CHOICES: Final = frozenset({Opcode.SMIN, Opcode.SMAX, Opcode.SELECT})


@dataclass(frozen=True, slots=True)
class Sum:
    """Values with factors, in one fixed order, and a constant; what is known of such a sum is that
    it is not negative.
    """

    terms: tuple[tuple[Value, int], ...]
    constant: int = 0

    def plus(self, other: Sum, factor: int = 1) -> Sum:
        """self + factor * other."""
        terms = dict(self.terms)
        for value, times in other.terms:
            terms[value] = terms.get(value, 0) + factor * times
        kept = [(value, times) for value, times in terms.items() if times]
        return Sum(tuple(sorted(kept, key=repr)), self.constant + factor * other.constant)

    def less(self, other: Sum, by: int = 0) -> Sum:
        """self - other - by."""
        made = self.plus(other, -1)
        return Sum(made.terms, made.constant - by)

    def factor(self, value: Value) -> int:
        """That of a value."""
        return next((times for one, times in self.terms if one == value), 0)

    def with_value(self, value: Value, by: Sum) -> Sum:
        """The sum where a value is another."""
        times = self.factor(value)
        return self.plus(Sum(((value, 1),)), -times).plus(by, times)


Lacking = tuple[Sum, ...]
"""Sums of inputs that would have to be at least 0; none: it is proved."""


@dataclass
class Order:
    """What is known of a function's integers.

    `given`: what is assumed of inputs. `may_lack`: whether what is lacking may be assumed, too.
    """

    function: Function
    given: list[Sum] = field(default_factory=list)
    may_lack: bool = False
    _sums: dict[Value, Sum] = field(default_factory=dict)
    _facts: dict[str, tuple[Sum, ...]] = field(default_factory=dict)
    _counted: dict[Value, tuple[Sum, ...]] = field(default_factory=dict)
    _by_value: dict[int, tuple[tuple[Sum, ...], dict[Value, list[Sum]]]] = field(
        default_factory=dict
    )
    _steps: int = 0
    _within: int = 0
    """Comparisons without signs that are asked about now, each for the sake of the one before."""

    def __post_init__(self) -> None:
        self._flow: Flow = flow_of(self.function)

    def sum_of(self, value: Value) -> Sum:
        """A value as a sum."""
        if value not in self._sums:
            self._sums[value] = self._sum(value)
        return self._sums[value]

    def _sum(self, value: Value) -> Sum:
        value = self.function.settled(value)
        if isinstance(value, Const):
            return Sum((), signed(value.word))
        if is_pitch(value) and isinstance(value, Input):
            value = without_pitch(value)
        made = definition_of(self.function, value)
        if isinstance(made, Instr):
            if made.op in (Opcode.ADD, Opcode.SUB) and made.exact:
                left, right = map(self.sum_of, made.operands)
                return left.plus(right, 1 if made.op is Opcode.ADD else -1)
            if made.op is Opcode.MOV:
                return self.sum_of(made.operands[0])
        return Sum(((value, 1),))

    def facts(self, block: str) -> tuple[Sum, ...]:
        """Sums that are not negative wherever `block` runs."""
        if block not in self._facts:
            found: list[Sum] = []
            for condition, truth in reversed([*self._known_in(block)]):
                found += self.implied(condition, truth, found)
            self._facts[block] = tuple(dict.fromkeys(reversed(found)))
        return self._facts[block]

    def _known_in(self, block: str) -> Iterator[tuple[Value, bool]]:
        """Conditions that decide whether a block runs, the nearest first, and their truth in it."""
        for name in self._flow.dominators(block):
            before = self._flow.predecessors[name]
            if len(before) == 1:
                branch = self.function.by_name[before[0]].branch
                if branch.cond is not None and branch.target != branch.otherwise:
                    yield branch.cond, name == branch.target

    def implied(self, condition: Value, truth: bool, facts: Iterable[Sum] = ()) -> Iterator[Sum]:
        """Sums that are not negative if a condition has this truth where these are not."""
        made = definition_of(self.function, condition)
        if not isinstance(made, Instr):
            return
        if made.op in (Opcode.AND, Opcode.OR):
            if (made.op is Opcode.AND) == truth:
                for part in made.operands:
                    yield from self.implied(part, truth, facts)
            return
        kind = _COMPARED.get(made.op)
        left, right = map(self.sum_of, made.operands[:2])
        if kind is None:
            return
        if made.op in _UNSIGNED and not self._are_natural(left, right, tuple(facts)):
            return
        if kind == "lt":
            yield right.less(left, 1) if truth else left.less(right)
        elif kind == "le":
            yield right.less(left) if truth else left.less(right, 1)
        elif (kind == "eq") == truth:
            yield from (left.less(right), right.less(left))

    def truth(self, condition: Value, block: str) -> bool | None:
        """What a condition is where `block` runs; None: either."""
        if self.lacks(condition, True, block) == ():
            return True
        return False if self.lacks(condition, False, block) == () else None

    def lacks(self, condition: Value, truth: bool, block: str) -> Lacking | None:
        """What would have to hold of inputs for a condition to have this truth where `block` runs;
        None: that is not known.
        """
        made = definition_of(self.function, condition)
        if isinstance(condition, Const):
            return () if bool(condition.word) == truth else None
        if not isinstance(made, Instr):
            return None
        if made.op in (Opcode.AND, Opcode.OR):
            parts = [self.lacks(part, truth, block) for part in made.operands]
            return _all(parts) if (made.op is Opcode.AND) == truth else _any(parts)
        if made.op is Opcode.XOR and made.operands[1] == Const(1):
            return self.lacks(made.operands[0], not truth, block)
        return self._compared(made, truth, self.facts(block))

    def _compared(self, made: Instr, truth: bool, facts: tuple[Sum, ...]) -> Lacking | None:
        kind = _COMPARED.get(made.op)
        left, right = map(self.sum_of, made.operands[:2])
        if kind is None or (made.op in _UNSIGNED and not self._are_natural(left, right, facts)):
            return None
        if kind == "lt":
            return self._lacking(right.less(left, 1) if truth else left.less(right), facts)
        if kind == "le":
            return self._lacking(right.less(left) if truth else left.less(right, 1), facts)
        if (kind == "eq") == truth:
            return self.equal(left, right, facts)
        apart = (left.less(right, 1), right.less(left, 1))
        return () if any(self._proved(one, facts) == () for one in apart) else None

    def equal(self, left: Sum, right: Sum, facts: tuple[Sum, ...]) -> Lacking | None:
        """What would have to hold for two sums to be equal."""
        return _all([self._lacking(one, facts) for one in (left.less(right), right.less(left))])

    def is_natural(self, value: Value, block: str) -> bool:
        """Whether a value proves not to be negative where `block` runs."""
        return self.is_proved(self.sum_of(value), self.facts(block))

    def is_proved(self, wanted: Sum, facts: tuple[Sum, ...]) -> bool:
        """Whether a sum proves not to be negative where `facts` are not."""
        return self._proved(wanted, facts) == ()

    def _are_natural(self, left: Sum, right: Sum, facts: tuple[Sum, ...] = ()) -> bool:
        """Whether a comparison without signs is one with signs; not known where that is asked again
        and again on the way to an answer, as where selections follow from one another.
        """
        if self._within == _MOST_WITHIN:
            return False
        self._within += 1
        try:
            return all(self._proved(one, facts) == () for one in (left, right))
        finally:
            self._within -= 1

    def of_terms(self, polynomial: Polynomial) -> Sum:
        """An affine polynomial as a sum."""
        made = Sum((), polynomial.coefficient())
        for value, times in polynomial.linear().items():
            made = made.plus(self.sum_of(value), times)
        return made

    def lacks_below(self, value: Sum, limit: Value, block: str) -> Lacking | None:
        """What would have to hold for a sum to be from 0 to below a limit where `block` runs."""
        facts = self.facts(block)
        ends = (value, self.sum_of(limit).less(value, 1))
        return _all([self._lacking(one, facts) for one in ends])

    def at_most(self, less: Value, more: Value, block: str) -> Lacking | None:
        """What would have to hold for a value to be no more than another where `block` runs."""
        return self._lacking(self.sum_of(more).less(self.sum_of(less)), self.facts(block))

    def _lacking(self, wanted: Sum, facts: tuple[Sum, ...]) -> Lacking | None:
        proved = self._proved(wanted, facts)
        if proved == () or not self.may_lack:
            return proved
        self._steps = 0
        return self._search(wanted, (*facts, *self.given), _DEEPEST, lacks=True)

    def _proved(self, wanted: Sum, facts: tuple[Sum, ...]) -> Lacking | None:
        self._steps = 0
        every = (*facts, *self.given) if self.given else facts
        return self._search(wanted, every, _DEEPEST, lacks=False)

    def _search(
        self, wanted: Sum, facts: tuple[Sum, ...], depth: int, *, lacks: bool
    ) -> Lacking | None:
        """What is lacking for a sum not to be negative."""
        self._steps += 1
        if self._steps > _MOST_STEPS:
            return None
        missing = [value for value, times in wanted.terms if times < 0 or not is_dimension(value)]
        if not missing:
            if wanted.constant >= 0:
                return ()
            if not wanted.terms:
                return None
        choice = next((one for one in wanted.terms if self._choice(one[0])), None)
        if choice is not None:
            return self._split(wanted, choice, facts, depth, lacks=lacks)
        missing = missing or [value for value, _ in wanted.terms]
        missing.sort(key=lambda value: (isinstance(value, Input), wanted.factor(value)))
        for value in missing if depth else ():
            for less in self._without(wanted, value, facts):
                found = self._search(less, facts, depth - 1, lacks=lacks)
                if found is not None:
                    return found
        return (_at_equal(wanted),) if lacks and _is_plausible(wanted) else None

    def _without(self, wanted: Sum, value: Value, facts: tuple[Sum, ...]) -> Iterator[Sum]:
        """A sum less others that are known not to be negative, without this value."""
        times = wanted.factor(value)
        for fact in (*self._about(facts).get(value, ()), *self._bounds(value)):
            own = fact.factor(value)
            if own and times % own == 0 and times // own > 0:
                yield wanted.plus(fact, -(times // own))

    def _about(self, facts: tuple[Sum, ...]) -> dict[Value, list[Sum]]:
        """The sums by values in them: of one tuple they are looked through often."""
        key, known = id(facts), self._by_value.get(id(facts))
        if known is None or known[0] is not facts:
            found: dict[Value, list[Sum]] = {}
            for fact in facts:
                for value, _ in fact.terms:
                    found.setdefault(value, []).append(fact)
            known = self._by_value[key] = facts, found
        return known[1]

    def _choice(self, value: Value) -> Instr | None:
        made = definition_of(self.function, value)
        return made if isinstance(made, Instr) and made.op in _CHOICES else None

    def _split(
        self,
        wanted: Sum,
        choice: tuple[Value, int],
        facts: tuple[Sum, ...],
        depth: int,
        *,
        lacks: bool,
    ) -> Lacking | None:
        """By which side a minimum, maximum or selection is."""
        value, times = choice
        made = self._choice(value)
        assert made is not None
        sides = [self.sum_of(side) for side in made.operands[-2:]]
        cases = [wanted.with_value(value, side) for side in sides]
        if made.op is Opcode.SELECT:
            test = made.operands[0]
            held = [tuple(self.implied(test, truth, facts)) for truth in (True, False)]
            return _all(
                self._search(case, (*facts, *own), depth, lacks=lacks)
                for case, own in zip(cases, held, strict=True)
            )
        is_either = (made.op is Opcode.SMIN) == (times < 0)
        found = (self._search(case, facts, depth, lacks=lacks) for case in cases)
        return _any(found) if is_either else _all(found)

    def _bounds(self, value: Value) -> tuple[Sum, ...]:
        """What is known of a value wherever it is: of a counter that it is not below where it
        starts.
        """
        if value not in self._counted:
            self._counted[value] = ()
            self._counted[value] = tuple(self._of_counter(value))
        return self._counted[value]

    def _of_counter(self, value: Value) -> Iterator[Sum]:
        phi = definition_of(self.function, value)
        if isinstance(value, Input):
            if is_dimension(value):
                yield Sum(((value, 1),))
            return
        if not isinstance(phi, Phi) or not isinstance(value, Ref):
            return
        home = self.function.block_of[value.id]
        body = self._flow.loops.get(home)
        if body is None:
            return
        if self._counts_down(phi, body):
            yield Sum(((value, 1),))
        starts = [one for name, one in phi.incoming if name not in body]
        ends = [self.sum_of(one) for name, one in phi.incoming if name in body]
        steps = [end.less(self.sum_of(value)) for end in ends]
        if len(starts) != 1 or any(step.terms for step in steps):
            return
        ahead = self.sum_of(value).less(self.sum_of(starts[0]))
        if all(step.constant >= 0 for step in steps):
            yield ahead
        elif all(step.constant <= 0 for step in steps):
            yield Sum((), 0).less(ahead)

    def _counts_down(self, phi: Phi, body: frozenset[str]) -> bool:
        """Whether a counter starts with no negative number, and falls by 1 where it is not 0."""
        induction = induction_of(self.function, body, phi)
        if induction is None or induction.start is None or induction.step != -1:
            return False
        again = [name for name, _ in phi.incoming if name in body]
        before = [name for name, _ in phi.incoming if name not in body]
        steps, start = self._steps, self.sum_of(induction.start)
        is_natural = all(self._proved(start, self.facts(name)) == () for name in before)
        self._steps = steps
        return is_natural and all(
            any(self._is_nonzero(phi, *known) for known in self._known_in(name)) for name in again
        )

    def _is_nonzero(self, phi: Phi, condition: Value, truth: bool) -> bool:
        """Whether a condition with this truth says that a phi is not 0."""
        made, zero = definition_of(self.function, condition), Const(0)
        if not isinstance(made, Instr):
            return False
        if made.op is Opcode.ICMP_ULT:
            return truth and made.operands == (zero, Ref(phi.id))
        kind = Opcode.ICMP_NE if truth else Opcode.ICMP_EQ
        return made.op is kind and {*made.operands} == {zero, Ref(phi.id)}


def _all(parts: Iterable[Lacking | None]) -> Lacking | None:
    found: dict[Sum, None] = {}
    for part in parts:
        if part is None:
            return None
        found |= dict.fromkeys(part)
    return tuple(found)


def _any(parts: Iterable[Lacking | None]) -> Lacking | None:
    known = [part for part in parts if part is not None]
    return min(known, key=len, default=None)


def _is_plausible(wanted: Sum) -> bool:
    """Whether a sum of inputs may be asked for: it is not negative where all are one large number,
    and compares no more than two of them.
    """
    factors = [times for _, times in wanted.terms]
    if not factors or len(factors) > _PAIR or any(abs(times) != 1 for times in factors):
        return False
    if not all(isinstance(value, Input) for value, _ in wanted.terms):
        return False
    is_about_arrays = any(is_dimension(value) for value, _ in wanted.terms)
    if not is_about_arrays and len(factors) > 1:
        return False  # of two scalars neither is known to be the larger one
    if len(factors) > 1 and factors[0] == factors[1]:
        return False
    is_held = wanted.constant >= 0 if len(factors) > 1 else factors[0] > 0
    return is_held and abs(wanted.constant) < _SMALL


def _at_equal(wanted: Sum) -> Sum:
    """What is asked for: of two inputs that one is not less than the other, if less would do."""
    return replace(wanted, constant=0) if len(wanted.terms) == _PAIR else wanted
