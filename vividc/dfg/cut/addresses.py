"""Affine addresses: the part that does not change in the loop moves into a base computed before it.

A load/store unit adds base + (index << shift) + offset, and the tile controller supplies the
iteration index, so an affine access whose stride is a power of two costs no address arithmetic on
the array. One of another stride takes an induction variable as its index, which is one addition an
iteration for all accesses of that stride, or of that stride times a power of two.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

from vividc.machine.opcodes import MEMORY, Opcode, Type
from vividc.ssa.analysis.induction import is_invariant
from vividc.ssa.analysis.polynomial import ITERATION, LoopPolynomials, Polynomial, constant, symbol
from vividc.ssa.edit import block_of, next_id, with_blocks
from vividc.ssa.flow import Loop
from vividc.ssa.ir import Const, Function, Instr, Phi, Ref, Value

_OFFSET_LIMIT = 1 << 15
_FIXED: Final = Const(0)


@dataclass(frozen=True, slots=True)
class Address:
    """base + (index << shift) + offset, in bytes.

    Attributes
    ----------
    index
        `ITERATION`, an induction variable, or 0 of an address that does not change.
    """

    base: Value
    shift: int
    offset: int
    index: Value


def fold_addresses(
    function: Function, loop: Loop, preheader: str
) -> tuple[Function, dict[int, Address]]:
    """Addresses of the loop's affine accesses by instruction id, and the function with their bases
    in `preheader` and the induction variables that they take besides.
    """
    folding = _Folding(function, loop, preheader)
    addresses: dict[int, Address] = {}
    for block in function.blocks:
        if block.name not in loop.blocks:
            continue
        for instr in block.instrs:
            if instr.op in MEMORY and is_invariant(function, loop.blocks, instr.operands[0]):
                address = folding.address(instr)
                if address is not None:
                    addresses[instr.id] = address
    return folding.function(), addresses


class _Folding:
    """What the accesses of one loop share: bases, and induction variables."""

    def __init__(self, function: Function, loop: Loop, preheader: str) -> None:
        self._function, self._loop, self._preheader = function, loop, preheader
        self._forms = LoopPolynomials(function, loop, symbolic=True)
        self._emitter = _BaseEmitter(next_id(function))
        self._indices = dict(self._own_variables())
        self._phis: list[Phi] = []
        self._updates: list[Instr] = []

    def address(self, instr: Instr) -> Address | None:
        """The address of an access; None if it is not affine."""
        form = self._forms.of(instr.operands[1])
        if form is None:
            return None
        form = form.times(constant(1 << instr.shift))
        index, shift = self._index(form, instr)
        if shift >= 32:  # noqa: PLR2004 - a word's bits
            return None
        form = form.plus(self._indices[index], -(1 << shift))
        offset = instr.offset + form.coefficient()
        terms = tuple(form.linear().items())
        if not -_OFFSET_LIMIT <= offset < _OFFSET_LIMIT:
            terms, offset = (*terms, (Const(1), offset)), 0
        return Address(self._emitter.base(instr, terms), shift, offset, index)

    def function(self) -> Function:
        """The function with what the addresses need."""
        before = block_of(self._function, self._preheader)
        before = replace(before, instrs=(*before.instrs, *self._emitter.instrs))
        header = block_of(self._function, self._loop.header)
        header = replace(
            header,
            phis=(*header.phis, *self._phis),
            instrs=(*self._updates, *header.instrs),
        )
        return with_blocks(self._function, (before, header))

    def _own_variables(self) -> Iterator[tuple[Value, Polynomial]]:
        """What an index may be, with its form."""
        yield _FIXED, constant(0)
        yield ITERATION, symbol(ITERATION)
        for phi in block_of(self._function, self._loop.header).phis:
            form = self._forms.of(Ref(phi.id))
            if form is not None and _slope(form).terms:
                yield Ref(phi.id), form

    def _index(self, form: Polynomial, instr: Instr) -> tuple[Value, int]:
        """An index that moves by the form's slope, shifted: one that leaves the fewest terms."""
        slope = _slope(form)
        if not slope.terms:
            return _FIXED, instr.shift
        powers = min((c & -c).bit_length() - 1 for c in slope.terms.values())
        if slope.constant == 1 << powers:
            return ITERATION, powers
        found = []
        for index, own in self._indices.items():
            for shift in range(powers + 1):
                if _slope(own).times(constant(1 << shift)) == slope:
                    found.append((len(form.plus(own, -(1 << shift)).terms), shift, index))
        if found:
            _, shift, index = min(found, key=lambda item: item[:2])
            return index, shift
        step = Polynomial({monomial: c >> powers for monomial, c in slope.terms.items()})
        return self._new_index(step, instr), powers

    def _new_index(self, step: Polynomial, instr: Instr) -> Value:
        """An induction variable from 0 on."""
        by = self._emitter.sum(instr, Const(step.coefficient() & 0xFFFFFFFF), step.linear())
        index, update = self._emitter.fresh(), self._emitter.fresh()
        again = tuple((name, Ref(update)) for name in self._loop.latches)
        incoming: tuple[tuple[str, Value], ...] = ((self._preheader, Const(0)), *again)
        self._phis.append(Phi(index, Type.I32, incoming, loc=instr.loc))
        self._updates.append(Instr(update, Opcode.ADD, Type.I32, (Ref(index), by), loc=instr.loc))
        self._indices[Ref(index)] = symbol(ITERATION).times(step)
        return Ref(index)


def _slope(form: Polynomial) -> Polynomial:
    """What one iteration adds."""
    parts = form.linear_in(ITERATION)
    assert parts is not None
    return parts[0]


class _BaseEmitter:
    """Emits base + sum of terms once for each distinct sum."""

    def __init__(self, first_id: int) -> None:
        self.instrs: list[Instr] = []
        self._next = first_id
        self._known: dict[tuple[Value, frozenset[tuple[Value, int]]], Value] = {}

    def fresh(self) -> int:
        """The id of a new value."""
        self._next += 1
        return self._next - 1

    def base(self, access: Instr, terms: tuple[tuple[Value, int], ...]) -> Value:
        """The base address of `access` plus the terms (in bytes)."""
        value = access.operands[0]
        key = (value, frozenset(terms))
        if key not in self._known:
            self._known[key] = self.sum(access, value, dict(terms))
        return self._known[key]

    def sum(self, access: Instr, value: Value, terms: Mapping[Value, int]) -> Value:
        """A value plus terms."""
        for term, factor in terms.items():
            scaled = self._scaled(access, term, factor)
            value = scaled if value == _FIXED else self._emit(access, Opcode.ADD, value, scaled)
        return value

    def _scaled(self, access: Instr, term: Value, factor: int) -> Value:
        if isinstance(term, Const):
            return Const((term.word * factor) & 0xFFFFFFFF)
        if factor == 1:
            return term
        if factor > 0 and factor & (factor - 1) == 0:
            return self._emit(access, Opcode.SHL, term, Const(factor.bit_length() - 1))
        return self._emit(access, Opcode.MUL, term, Const(factor & 0xFFFFFFFF))

    def _emit(self, access: Instr, op: Opcode, left: Value, right: Value) -> Value:
        instr = Instr(self.fresh(), op, Type.I32, (left, right), loc=access.loc)
        self.instrs.append(instr)
        return Ref(instr.id)
