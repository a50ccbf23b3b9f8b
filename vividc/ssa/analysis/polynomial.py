"""Words as polynomials in values that are not taken apart, modulo 2**32: equal polynomials, equal
words.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from vividc.machine.opcodes import Opcode
from vividc.machine.words import signed
from vividc.ssa.ir import Const, Function, Instr, Ref, Value

Monomial = tuple[Value, ...]
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
                product = tuple(sorted((*mine, *theirs), key=repr))
                terms[product] = signed(terms.get(product, 0) + a * b)
        return Polynomial({m: c for m, c in terms.items() if c})

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
    """Polynomials of a function's values, through additions, products and shifts by constants."""

    function: Function
    _instrs: dict[int, Instr] = field(init=False)
    _memo: dict[Value, Polynomial] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        """Indexes the definitions."""
        self._instrs = {i.id: i for block in self.function.blocks for i in block.instrs}

    def of(self, value: Value) -> Polynomial:
        """The polynomial of `value`; a symbol where it would get long."""
        if value not in self._memo:
            self._memo[value] = self._compute(value)
        return self._memo[value]

    def _compute(self, value: Value) -> Polynomial:
        if isinstance(value, Const):
            return constant(value.word)
        if not isinstance(value, Ref) or value.id not in self._instrs:
            return symbol(value)
        instr = self._instrs[value.id]
        rule = _RULES.get(instr.opcode)
        made = None if rule is None else rule([self.of(operand) for operand in instr.operands])
        if made is None or len(made.terms) > _MAX_TERMS:
            return symbol(value)
        short = all(len(monomial) <= _MAX_DEGREE for monomial in made.terms)
        return made if short else symbol(value)


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
