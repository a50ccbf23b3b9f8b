"""Affine addresses: the part that does not change in the loop moves into a base computed before it.

A load/store unit adds base + (index << shift) + offset, and the tile controller supplies the
iteration index, so an affine access costs no address arithmetic on the array.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from vividc.machine.opcodes import MEMORY, Opcode, Type
from vividc.ssa.analysis.induction import is_invariant
from vividc.ssa.analysis.polynomial import ITERATION, LoopPolynomials, Polynomial
from vividc.ssa.edit import block_of, next_id, with_blocks
from vividc.ssa.flow import Loop
from vividc.ssa.ir import Const, Function, Instr, Ref, Value

_OFFSET_LIMIT = 1 << 15


@dataclass(frozen=True, slots=True)
class Address:
    """base + ((iteration index if `uses_iv` else 0) << shift) + offset, in bytes."""

    base: Value
    shift: int
    offset: int
    uses_iv: bool

    @property
    def stride_bytes(self) -> int:
        """Bytes from one iteration's access to the next one's."""
        return (1 << self.shift) if self.uses_iv else 0


def fold_addresses(
    function: Function, loop: Loop, preheader: str
) -> tuple[Function, dict[int, Address]]:
    """Addresses of the loop's affine accesses by instruction id, and the function with their bases
    in `preheader`.
    """
    forms = LoopPolynomials(function, loop)
    emitter = _BaseEmitter(next_id(function))
    addresses: dict[int, Address] = {}
    for block in function.blocks:
        if block.name not in loop.blocks:
            continue
        for instr in block.instrs:
            if instr.op in MEMORY and is_invariant(function, loop.blocks, instr.operands[0]):
                address = _address(instr, forms.of(instr.operands[1]), emitter)
                if address is not None:
                    addresses[instr.id] = address
    block = block_of(function, preheader)
    block = replace(block, instrs=(*block.instrs, *emitter.instrs))
    return with_blocks(function, (block,)), addresses


def _address(instr: Instr, index: Polynomial | None, emitter: _BaseEmitter) -> Address | None:
    stride = -1 if index is None else index.coefficient(ITERATION)
    if index is None or stride < 0 or stride & (stride - 1):
        return None  # the unit can only shift the index: other strides stay a recurrence
    shift = instr.shift + max(stride.bit_length() - 1, 0)
    if shift >= 32:  # noqa: PLR2004 - a word's bits
        return None
    offset = instr.offset + (index.coefficient() << instr.shift)
    fixed = index.without(ITERATION).linear()
    terms = tuple((value, factor << instr.shift) for value, factor in fixed.items())
    if not -_OFFSET_LIMIT <= offset < _OFFSET_LIMIT:
        terms, offset = (*terms, (Const(1), offset)), 0
    base = emitter.base(instr, terms)
    return Address(base, shift, offset, uses_iv=stride > 0)


class _BaseEmitter:
    """Emits base + sum of terms once for each distinct sum."""

    def __init__(self, first_id: int) -> None:
        self.instrs: list[Instr] = []
        self._next = first_id
        self._known: dict[tuple[Value, frozenset[tuple[Value, int]]], Value] = {}

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
        instr = Instr(self._next, op, Type.I32, (left, right), loc=access.loc)
        self._next += 1
        self.instrs.append(instr)
        return Ref(instr.id)
