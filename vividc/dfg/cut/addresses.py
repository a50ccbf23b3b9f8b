"""Affine addresses: the part that does not change in the loop moves into a base computed before it.

A load/store unit adds base + (index << shift) + offset, and the tile controller supplies the
iteration index, so an affine access whose stride is a power of two costs no address arithmetic on
the array. One of another stride takes an induction variable as its index, which is one addition an
iteration for all accesses of that stride, or of that stride times a power of two.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

from vividc.machine.opcodes import MEMORY, Opcode, Type
from vividc.ssa.analysis.induction import constant_step, is_invariant
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
    stride_bytes
        From one iteration's access to the next one's.
    """

    base: Value
    shift: int
    offset: int
    index: Value
    stride_bytes: int


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
        self._forms = LoopPolynomials(function, loop)
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
        stride = form.coefficient(ITERATION)
        index, shift = self._index(form, stride, instr)
        if shift >= 32:  # noqa: PLR2004 - a word's bits
            return None
        form = form.plus(self._indices[index], -(1 << shift))
        offset = instr.offset + form.coefficient()
        terms = tuple(form.linear().items())
        if not -_OFFSET_LIMIT <= offset < _OFFSET_LIMIT:
            terms, offset = (*terms, (Const(1), offset)), 0
        return Address(self._emitter.base(instr, terms), shift, offset, index, stride)

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
            if constant_step(self._function, self._loop, phi) and form is not None:
                yield Ref(phi.id), form

    def _index(self, form: Polynomial, stride: int, instr: Instr) -> tuple[Value, int]:
        """An index that moves by the stride, shifted: one that leaves the fewest terms."""
        if stride == 0:
            return _FIXED, instr.shift
        if stride > 0 and stride & (stride - 1) == 0:
            return ITERATION, stride.bit_length() - 1
        found = []
        for index, own in self._indices.items():
            step = own.coefficient(ITERATION)
            factor = stride // step if step else 0
            if factor > 0 and factor & (factor - 1) == 0 and step * factor == stride:
                found.append((len(form.plus(own, -factor).terms), factor.bit_length() - 1, index))
        if found:
            _, shift, index = min(found, key=lambda item: item[:2])
            return index, shift
        shift = (stride & -stride).bit_length() - 1
        return self._new_index(stride >> shift, instr), shift

    def _new_index(self, step: int, instr: Instr) -> Value:
        """An induction variable from 0 on."""
        index, update = self._emitter.fresh(), self._emitter.fresh()
        again = tuple((name, Ref(update)) for name in self._loop.latches)
        incoming: tuple[tuple[str, Value], ...] = ((self._preheader, Const(0)), *again)
        self._phis.append(Phi(index, Type.I32, incoming, loc=instr.loc))
        by = Const(step & 0xFFFFFFFF)
        self._updates.append(Instr(update, Opcode.ADD, Type.I32, (Ref(index), by), loc=instr.loc))
        self._indices[Ref(index)] = symbol(ITERATION).times(constant(step))
        return Ref(index)


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
            for term, factor in terms:
                value = self._emit(access, Opcode.ADD, value, self._scaled(access, term, factor))
            self._known[key] = value
        return self._known[key]

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
