"""Words of forms, quotients and tests, written as instructions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from vividc.errors import SourceLoc
from vividc.host.once import changed
from vividc.machine.division import quotient_by_constant
from vividc.machine.opcodes import Opcode, Type
from vividc.machine.words import WORD_BITS, WORD_MASK
from vividc.ssa.edit import FreshIds
from vividc.ssa.ir import Const, Input, Instr, Ref, Value, pitch_of
from vividc.ssa.polyhedral.forms import Form
from vividc.ssa.polyhedral.loops import Quotient, Test
from vividc.ssa.polyhedral.relations import LARGE
from vividc.ssa.polyhedral.subscripts import Place, element_bytes

_LARGEST_DIVIDEND = (1 << 31) - 1


class Words:
    """Writes instructions to the end of `instrs`.

    Attributes
    ----------
    names
        The words of names: symbols, and counters of the loops that are open.
    order
        Names of the open loops, from the outside in: sums begin with what changes least.
    loc
        The source line of what is written.
    """

    def __init__(
        self,
        ids: FreshIds,
        symbols: Mapping[str, Value],
        quotients: Mapping[str, Quotient],
        rows: Mapping[str, Input],
        lengths: frozenset[str],
    ) -> None:
        self.ids = ids
        self.names = dict(symbols)
        self.order: list[str] = []
        self.instrs: list[Instr] = []
        self.loc: SourceLoc | None = None
        self._unbounded = symbols.keys() - lengths
        self._quotients = quotients
        self._rows = rows
        self._predicates: set[Value] = set()

    def emit(self, opcode: Opcode, *operands: Value | int, exact: bool = False) -> Value:
        """An operation on integers or predicates."""
        values = tuple(Const(v & WORD_MASK) if isinstance(v, int) else v for v in operands)
        is_test = opcode.value.startswith("icmp") or self._predicates.issuperset(values)
        kind = Type.PRED if is_test else Type.I32
        instr = Instr(self.ids(), opcode, kind, values, exact=exact, loc=self.loc)
        self.instrs.append(instr)
        if is_test:
            self._predicates.add(Ref(instr.id))
        return Ref(instr.id)

    def of(self, form: Form) -> Value:
        """The word of a form."""
        return self._sum([(self._name(n), f) for n, f in self._ordered(form)], form.constant)

    def bound(self, form: Form) -> Value:
        """The word of a form in a bound or test. A symbol that is not a length counts as no less
        than what cannot wrap: such a loop has no iterations either way.
        """
        if not form.constant and [factor for _, factor in form.terms] == [1]:
            return self.of(form)
        return self._narrow(form)

    def _narrow(self, form: Form) -> Value:
        """As `bound`, of symbols that are clamped whatever the form is."""
        terms = [(self._clamped(n), f) for n, f in self._ordered(form)]
        return self._sum(terms, form.constant, exact=True)

    def extreme(self, forms: tuple[Form, ...], op: Opcode) -> Value:
        """The least or largest of several bounds."""
        words = [self.bound(one) for one in forms]
        result = words[0]
        for word in words[1:]:
            result = self.emit(op, result, word)
        return result

    def test(self, test: Test) -> Value:
        """A predicate."""
        if test.parts:
            op = Opcode.AND if test.relation == "and" else Opcode.OR
            result = self.test(test.parts[0])
            for part in test.parts[1:]:
                result = self.emit(op, result, self.test(part))
            return result
        left = self.bound(replace(test.left, constant=0))
        limit = -test.left.constant
        if test.relation == "==":
            return self.emit(Opcode.ICMP_EQ, left, limit)
        if test.relation in ("<", "<="):
            return self.emit(Opcode.ICMP_SLT, left, limit + (test.relation == "<="))
        return self.emit(Opcode.ICMP_SLT, limit - (test.relation == ">="), left)

    def element(self, subscripts: tuple[Form, ...], pitches: tuple[Input, ...]) -> Value:
        """The index of an element, the constant of the last subscript aside; `pitches` are the
        array's dimensions but for the first.
        """
        terms: list[tuple[Value, int]] = []
        for position, form in enumerate(subscripts):
            below = pitches[position:]
            for name, factor in self._ordered(form):
                terms.append((self._scaled(self._name(name), below), factor))
            if form.constant and below:
                size = below[0] if len(below) == 1 else self._scaled(below[0], below[1:])
                terms.append((size, form.constant))
        return self._sum(terms, 0)

    def access(self, instr: Instr, place: Place, rest: tuple[Value, ...]) -> Value:
        """An access to an element as by `instr`; `rest`: the value of a store, and a predicate."""
        axes = range(1, len(place.subscripts))
        pitches = tuple(self._pitch(instr.array, axis) for axis in axes)
        array, base, subscript = instr.array, instr.operands[0], instr.subscript
        if place.owner != array:
            array, base, subscript = str(place.owner), Input(f"&{place.owner}"), ()
            pitches = tuple(self._length(instr.array, axis) for axis in axes)
        index = self.element(place.subscripts, pitches)
        step = element_bytes(instr)
        made = changed(
            instr,
            id=self.ids(),
            array=array,
            operands=(base, index, *rest),
            shift=step.bit_length() - 1,
            offset=place.subscripts[-1].constant * step,
            distinct="",
            subscript=subscript,
        )
        self.instrs.append(made)
        return Ref(made.id)

    def _pitch(self, array: str, axis: int) -> Input:
        return self._rows.get(array) or pitch_of(array, axis)

    def _length(self, array: str, axis: int) -> Input:
        return self._rows.get(array) or Input(f"{array}.shape{axis}")

    def as_loaded(self, load: Instr, value: Value) -> Value:
        """What a load of less than a word gives after a value is stored there."""
        above = Const(WORD_BITS - 8 * load.width)
        if not load.signed:
            return self.emit(Opcode.AND, value, Const(WORD_MASK >> above.word))
        return self.emit(Opcode.ASHR, self.emit(Opcode.SHL, value, above), above)

    def forget(self, names: Iterable[str]) -> None:
        """Quotients of what has changed are computed again."""
        gone = set(names)
        for name, quotient in self._quotients.items():
            if quotient.dividend.names & gone:
                self.names.pop(name, None)

    def _scaled(self, value: Value, pitches: tuple[Input, ...]) -> Value:
        for pitch in pitches:
            value = self.emit(Opcode.MUL, value, pitch)
        return value

    def _ordered(self, form: Form) -> list[tuple[str, int]]:
        depth = {name: position + 1 for position, name in enumerate(self.order)}
        return sorted(form.terms, key=lambda term: (depth.get(term[0], 0), term[0]))

    def _clamped(self, name: str) -> Value:
        value = self._name(name)
        return self.emit(Opcode.SMAX, value, -LARGE) if name in self._unbounded else value

    def _name(self, name: str) -> Value:
        if name not in self.names:
            quotient = self._quotients[name]
            dividend = self._narrow(quotient.dividend)  # what it is part of may add to it
            self.names[name] = self._divided(dividend, quotient.divisor, quotient.remainder)
        return self.names[name]

    def _divided(self, dividend: Value, divisor: int, remainder: bool) -> Value:
        if divisor & (divisor - 1) == 0:
            if remainder:
                return self.emit(Opcode.AND, dividend, divisor - 1)
            return self.emit(Opcode.ASHR, dividend, divisor.bit_length() - 1)
        quotient = quotient_by_constant(self.emit, dividend, divisor, _LARGEST_DIVIDEND)
        if not remainder:
            assert not isinstance(quotient, int)
            return quotient
        return self.emit(Opcode.SUB, dividend, self.emit(Opcode.MUL, quotient, divisor))

    def _sum(self, terms: Iterable[tuple[Value, int]], constant: int, exact: bool = False) -> Value:
        total: Value | None = None
        for value, factor in terms:
            scaled = value
            if abs(factor) != 1:
                scaled = self.emit(Opcode.MUL, value, abs(factor))
            if total is None and factor > 0:
                total = scaled
            else:
                op = Opcode.ADD if factor > 0 else Opcode.SUB
                total = self.emit(op, 0 if total is None else total, scaled, exact=exact)
        if total is None:
            return Const(constant & WORD_MASK)
        return self.emit(Opcode.ADD, total, constant, exact=exact) if constant else total
