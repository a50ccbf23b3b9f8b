"""Words as polynomials in values that are not taken apart, modulo 2**32: equal polynomials, equal
words.

`Polynomials` takes a function's values apart down to phis, loads and inputs. `LoopPolynomials`
gives the values of one loop as affine functions of the number of its iteration.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final

from vividc.machine.opcodes import Opcode
from vividc.machine.words import signed
from vividc.ssa.analysis.induction import Induction, induction_of, is_invariant
from vividc.ssa.flow import Loop
from vividc.ssa.ir import Const, Function, Input, Phi, Value, definition_of

Monomial = tuple[Value, ...]
ITERATION: Final = Input("%iteration")
"""Symbol of `LoopPolynomials` for the number of the loop's iteration, from 0: no input's key."""
_MAX_TERMS = 12
_MAX_DEGREE = 4


@dataclass(frozen=True)
class Polynomial:
    """Coefficient of each product of values; the values of a product are in one fixed order."""

    terms: Mapping[Monomial, int]

    def plus(self, other: Polynomial, factor: int = 1) -> Polynomial:
        """self + factor * other."""
        terms = dict(self.terms)
        for monomial, coefficient in other.terms.items():
            terms[monomial] = signed(terms.get(monomial, 0) + factor * coefficient)
        return Polynomial({m: c for m, c in terms.items() if c})

    def times(self, other: Polynomial) -> Polynomial:
        """self * other."""
        terms: dict[Monomial, int] = {}
        for mine, a in self.terms.items():
            for theirs, b in other.terms.items():
                product = (*mine, *theirs)
                if mine and theirs:
                    product = tuple(sorted(product, key=repr))
                terms[product] = signed(terms.get(product, 0) + a * b)
        return Polynomial({m: c for m, c in terms.items() if c})

    def divided(self, by: int) -> Polynomial:
        """The polynomial of which this one is `by` times; all of its factors are multiples."""
        return Polynomial({monomial: factor // by for monomial, factor in self.terms.items()})

    def linear_in(self, value: Value) -> tuple[Polynomial, Polynomial] | None:
        """(a, b) with self = a * value + b and no `value` in a or b; None if it is not linear."""
        slope: dict[Monomial, int] = {}
        rest: dict[Monomial, int] = {}
        for monomial, coefficient in self.terms.items():
            count = monomial.count(value)
            if count > 1:
                return None
            if count:
                slope[tuple(item for item in monomial if item != value)] = coefficient
            else:
                rest[monomial] = coefficient
        return Polynomial(slope), Polynomial(rest)

    def coefficient(self, *monomial: Value) -> int:
        """That of a product of values; of no values, the constant."""
        return self.terms.get(monomial, 0)

    def without(self, value: Value) -> Polynomial:
        """Its terms without `value`."""
        return Polynomial({m: c for m, c in self.terms.items() if value not in m})

    def linear(self) -> dict[Value, int]:
        """Coefficient of each value in an affine form."""
        return {value: c for (value,), c in ((m, c) for m, c in self.terms.items() if m)}

    @property
    def constant(self) -> int | None:
        """The word (signed) of a polynomial without values, else None."""
        if not self.terms:
            return 0
        return self.terms.get(()) if len(self.terms) == 1 else None


def constant(word: int) -> Polynomial:
    """The polynomial of a word."""
    word = signed(word)
    return Polynomial({(): word} if word else {})


def symbol(value: Value) -> Polynomial:
    """The polynomial of a value that is not taken apart."""
    return Polynomial({(value,): 1})


@dataclass
class Polynomials:
    """Polynomials of a function's values, through additions, products and shifts by constants.

    `pitches`: a pitch is a value of its own, not the dimension that it equals.
    """

    function: Function
    pitches: bool = False
    _memo: dict[Value, Polynomial] = field(init=False, default_factory=dict)

    def of(self, value: Value) -> Polynomial:
        """The polynomial of `value`; a symbol where it would get long."""
        if value not in self._memo:
            self._memo[value] = self._compute(value)
        return self._memo[value]

    def _compute(self, value: Value) -> Polynomial:
        value = value if self.pitches else self.function.settled(value)
        if isinstance(value, Const):
            return constant(value.word)
        if isinstance(value, Input):
            return symbol(value)
        item = definition_of(self.function, value)
        rule = None if item is None or isinstance(item, Phi) else _RULES.get(item.opcode)
        if item is None or isinstance(item, Phi) or rule is None:
            return symbol(value)
        made = rule([self.of(operand) for operand in item.operands])
        if made is None or len(made.terms) > _MAX_TERMS:
            return symbol(value)
        short = all(len(monomial) <= _MAX_DEGREE for monomial in made.terms)
        return made if short else symbol(value)


@dataclass
class LoopPolynomials:
    """Affine forms of a loop's values: in `ITERATION`, and in values from outside the loop, which
    are not taken apart. `symbolic`: with products of one of these and `ITERATION`, too.
    """

    function: Function
    loop: Loop
    symbolic: bool = False
    _memo: dict[Value, Polynomial | None] = field(init=False, default_factory=dict)

    def of(self, value: Value) -> Polynomial | None:
        """The affine form of `value`; None if it has none."""
        if value not in self._memo:
            self._memo[value] = self._compute(value)
        return self._memo[value]

    def _compute(self, value: Value) -> Polynomial | None:
        settled = self.function.settled(value)
        if isinstance(settled, Const):
            return constant(settled.word)
        if is_invariant(self.function, self.loop.blocks, value):
            return symbol(value)
        item = definition_of(self.function, value)
        if item is None or isinstance(item, Phi):
            return None if item is None else self._of_phi(item)
        rule = _RULES.get(item.opcode)
        operands = [] if rule is None else [self.of(operand) for operand in item.operands]
        known = [operand for operand in operands if operand is not None]
        made = None if rule is None or len(known) < len(operands) else rule(known)
        is_known = made is not None and all(map(self._is_known, made.terms))
        return made if is_known else None

    def _is_known(self, monomial: Monomial) -> bool:
        limit = 2 if self.symbolic and monomial.count(ITERATION) == 1 else 1
        return len(monomial) <= limit

    def _of_phi(self, phi: Phi) -> Polynomial | None:
        induction = induction_of(self.function, self.loop.blocks, phi)
        if induction is None or induction.start is None:
            return None
        start, step = self.of(induction.start), self._step(induction)
        if start is None or step is None:
            return None
        return step.times(symbol(ITERATION)).plus(start)

    def _step(self, induction: Induction) -> Polynomial | None:
        if induction.step is not None:
            return constant(induction.step)
        by = self.of(induction.by) if self.symbolic else None
        sign = -1 if induction.update.mnemonic == "sub" else 1
        return None if by is None else by.times(constant(sign))


def _shift(operands: list[Polynomial]) -> Polynomial | None:
    amount = operands[1].constant
    if amount is None or not 0 <= amount < 32:  # noqa: PLR2004 - a word's bits
        return None
    return operands[0].times(constant(1 << amount))


_RULES: dict[Opcode, Callable[[list[Polynomial]], Polynomial | None]] = {
    Opcode.ADD: lambda o: o[0].plus(o[1]),
    Opcode.SUB: lambda o: o[0].plus(o[1], -1),
    Opcode.MUL: lambda o: o[0].times(o[1]),
    Opcode.SHL: _shift,
    Opcode.MOV: lambda o: o[0],
}
