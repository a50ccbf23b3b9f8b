"""Whether iterations of a loop prove to touch bytes of their own in every array that it writes."""

from __future__ import annotations

from functools import cached_property

from vividc.machine.opcodes import MEMORY, Opcode
from vividc.machine.words import signed
from vividc.ssa.analysis.counters import counter_of, defined_in
from vividc.ssa.analysis.induction import constant_step
from vividc.ssa.analysis.levels import Level, level_of, with_own_latches
from vividc.ssa.analysis.order import Order
from vividc.ssa.analysis.polynomial import Monomial, Polynomial, Polynomials, constant, symbol
from vividc.ssa.flow import Loop
from vividc.ssa.ir import Const, Function, Input, Instr, Ref, Value, definition_of, is_pitch
from vividc.ssa.loops.threads.make import private_arrays
from vividc.ssa.polyhedral.subscripts import FlatRows
from vividc.ssa.rewrite.normalize import canonical_loops


def meeting_array(function: Function, header: str) -> str | None:
    """An array in which two iterations of the loop at `header` may meet, one of them writing; None
    if there is none.

    Iterations stay apart where all places are a counter times a constant, plus what is fixed, plus
    what differs by less: constants, counters of inner loops, masked words; and where they are in
    the row of the counter's number, whatever the column: a subscript outside its dimension is
    undefined, and a flat index proves to be in the row.
    """
    function = with_own_latches(canonical_loops(function), header)
    level = level_of(function, header)
    own = set(private_arrays(function, level))
    accesses = [i for block in level.blocks.values() for i in block.instrs if i.op in MEMORY]
    written = {i.array: None for i in accesses if i.op is Opcode.STORE}
    steps = {phi.id: constant_step(function, level.loop, phi) for phi in level.header.phis}
    proof = _Proof(function, level)
    for array in written:
        group = [instr for instr in accesses if instr.array == array]
        apart = any(
            proof.in_windows(group, ident, step) or proof.in_rows(group, ident)
            for ident, step in steps.items()
            if step
        )
        if array not in own and not apart:
            return array
    return None


class _Proof:
    def __init__(self, function: Function, level: Level) -> None:
        self.function = function
        self.known = Polynomials(function)
        self.by_pitch = Polynomials(function, pitches=True)
        self.varying: set[Value] = {Ref(i) for i in defined_in(function, level.loop)}
        self.loops = [inner.loop for inner in level.all_levels() if inner is not level]
        self.home = {i.id: name for name, block in level.blocks.items() for i in block.instrs}

    def in_windows(self, group: list[Instr], counter: int, step: int) -> bool:
        """Whether all bytes of iteration i lie in a window that moves on by its own length."""
        forms = set()
        touched: list[int] = []
        for instr in group:
            parts = self._parts(instr, counter)
            if parts is None or parts[0].constant is None:
                return False
            element = 1 << instr.shift
            window = self._window(instr, parts[1])
            if window is None:
                return False
            rest = parts[1].times(constant(element)).terms.items()
            fixed = tuple(sorted((term for term in rest if self._is_fixed(term[0])), key=repr))
            forms.add((parts[0].constant * element, fixed))
            first, last = (end * element + instr.offset for end in window)
            touched += (first, last + instr.width - 1)
        [*slopes] = {slope for slope, _ in forms}
        return len(forms) == 1 and max(touched) - min(touched) < abs(signed(slopes[0] * step))

    def _is_fixed(self, monomial: Monomial) -> bool:
        """Whether a product of values, not of none, is the same in all iterations."""
        return bool(monomial) and not any(value in self.varying for value in monomial)

    def _window(self, instr: Instr, rest: Polynomial) -> tuple[int, int] | None:
        """The least and the greatest sum of what is not fixed in a part of an index."""
        least = most = rest.coefficient()
        for monomial, factor in rest.terms.items():
            if not monomial or self._is_fixed(monomial):
                continue
            ends = self._extent(monomial[0], instr) if len(monomial) == 1 else None
            if ends is None:
                return None
            least += min(factor * end for end in ends)
            most += max(factor * end for end in ends)
        return least, most

    def _extent(self, value: Value, instr: Instr) -> tuple[int, int] | None:
        """The least and the greatest word of a value where an instruction reads it, if known."""
        item = definition_of(self.function, value)
        if isinstance(item, Instr) and item.op is Opcode.AND:
            masks = [signed(v.word) for v in item.operands if isinstance(v, Const)]
            return (0, masks[0]) if masks and masks[0] >= 0 else None
        loop = next((loop for loop in self.loops if self._counts(loop, value)), None)
        if loop is None or self.home[instr.id] not in loop.blocks - {loop.header}:
            return None
        counter = counter_of(self.function, loop)
        assert counter is not None
        ends = [self.function.settled(end) for end in (counter.initial, counter.limit)]
        known = [signed(end.word) for end in ends if isinstance(end, Const)]
        if len(known) < len(ends):
            return None
        first, last = known[0], known[1] - (1 if counter.step > 0 else -1)
        return min(first, last), max(first, last)

    def _counts(self, loop: Loop, value: Value) -> bool:
        counter = counter_of(self.function, loop)
        return counter is not None and value == Ref(counter.phi.id)

    @cached_property
    def order(self) -> Order:
        """What is known of the integers."""
        return Order(self.function)

    def in_rows(self, group: list[Instr], counter: int) -> bool:
        """Whether all accesses are to elements (i, ...) of an array of several dimensions: by
        subscripts, or by flat indices that prove to be in the row.
        """
        param = next((p for p in self.function.params if p.name == group[0].array), None)
        if param is None or param.ndim < 2 or param.flat:  # noqa: PLR2004 - rows and columns
            return False
        dims: set[Value] = {Input(f"{param.name}.shape{n}") for n in range(1, param.ndim)}
        for instr in group:
            parts = self._parts(instr, counter)
            if parts is None:
                return False
            [*slope] = parts[0].terms.items()
            if len(slope) != 1 or set(slope[0][0]) != dims or slope[0][1] != 1:
                return False
            if len(slope[0][0]) != len(dims) or any(dims <= set(m) for m in parts[1].terms):
                return False
            if not (self._is_by_subscripts(instr) or self._is_flat_in_row(instr, counter)):
                return False
        return True

    def _is_by_subscripts(self, instr: Instr) -> bool:
        """Whether an access is by subscripts, each of which lies in its dimension."""
        index = self.by_pitch.of(instr.operands[1])
        return any(is_pitch(value) for monomial in index.terms for value in monomial)

    def _is_flat_in_row(self, instr: Instr, counter: int) -> bool:
        """Whether a flat index proves to be in the row of the counter's number."""
        rows = FlatRows(self.function, self.order)
        found = rows.taken_apart(instr, self.by_pitch.of(instr.operands[1]), self._is_below)
        return found is not None and found[0] == symbol(Ref(counter))

    def _is_below(self, column: Polynomial, length: Input, access: Instr) -> bool:
        """Whether a column is from 0 to below the length of its row."""
        if any(len(monomial) > 1 for monomial in column.terms):
            return False
        block = self.home[access.id]
        return self.order.lacks_below(self.order.of_terms(column), length, block) == ()

    def _parts(self, instr: Instr, counter: int) -> tuple[Polynomial, Polynomial] | None:
        """(a, b) of an index a * counter + b into the array from its start."""
        if instr.operands[0] != Input(f"&{instr.array}"):
            return None
        return self.known.of(instr.operands[1]).linear_in(Ref(counter))
