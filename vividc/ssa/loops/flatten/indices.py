"""Indices of a flattened loop, with what does not change in it moved into base and offset.

Neighbours (i + 1, j - 1) and (i, j) of a stencil then share one index: their addresses differ by
words that are computed once, before the loop.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from vividc.machine.opcodes import MEMORY, Opcode, Type
from vividc.machine.words import signed
from vividc.ssa.analysis.counters import defined_in
from vividc.ssa.analysis.polynomial import Polynomial, Polynomials, constant
from vividc.ssa.edit import block_of, next_id, with_blocks
from vividc.ssa.flow import Loop, preheader_of
from vividc.ssa.ir import Const, Function, Input, Instr, Ref, Value

_OFFSET_LIMIT = 1 << 15


def fold_indices(function: Function, loop: Loop) -> Function:
    """The same function, with the index of each access in `loop` reduced to what changes there.

    Indices that are not sums of products, and bases that change in the loop, stay as they are.
    """
    edit = _Edit(function, loop)
    changed = [
        replace(block, instrs=tuple(new for instr in block.instrs for new in edit.folded(instr)))
        for block in function.blocks
        if block.name in loop.blocks
    ]
    function = with_blocks(function, changed)
    before = block_of(function, preheader_of(function, loop))
    return with_blocks(function, (replace(before, instrs=(*before.instrs, *edit.before)),))


def unfold_bases(function: Function, loop: Loop) -> Function | None:
    """The same function, with accesses in `loop` on bases that do not change there: what
    `fold_indices` moved into a base in front of an inner loop is put back into the index.

    None if a base is not the address of an array plus whole elements.
    """
    edit = _Edit(function, loop)
    changed = []
    for block in function.blocks:
        if block.name not in loop.blocks:
            continue
        instrs: list[Instr] = []
        for instr in block.instrs:
            new = edit.unfolded(instr)
            if new is None:
                return None
            instrs += new
        changed.append(replace(block, instrs=tuple(instrs)))
    return with_blocks(function, changed)


def _is_address(value: Value) -> bool:
    return isinstance(value, Input) and value.key.startswith("&")


@dataclass
class _Edit:
    function: Function
    loop: Loop
    before: list[Instr] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.free = next_id(self.function)
        self.known = Polynomials(self.function)
        self.varying = {Ref(ident) for ident in defined_in(self.function, self.loop)}

    def folded(self, instr: Instr) -> list[Instr]:
        """The instructions that stand for `instr`."""
        if instr.op not in MEMORY or instr.operands[0] in self.varying:
            return [instr]
        base, index, *rest = instr.operands
        moving, fixed, offset = self._parts(instr, self.known.of(index))
        if not fixed.terms and offset == instr.offset:
            return [instr]
        if fixed.terms:
            scaled = fixed.times(constant(1 << instr.shift))
            base = self._sum(scaled, self.before, instr, base)
        own: list[Instr] = []
        index = self._sum(moving, own, instr)
        return [*own, replace(instr, operands=(base, index, *rest), offset=offset)]

    def unfolded(self, instr: Instr) -> list[Instr] | None:
        """The instructions that stand for `instr`, on a base that is fixed; None if there is no
        way.
        """
        if instr.op not in MEMORY or instr.operands[0] not in self.varying:
            return [instr]
        _, index, *rest = instr.operands
        element = 1 << instr.shift
        total = self.known.of(instr.operands[0])
        arrays = [m for m in total.terms if len(m) == 1 and _is_address(m[0])]
        others = {m: c for m, c in total.terms.items() if m not in arrays}
        if len(arrays) != 1 or total.terms[arrays[0]] != 1:
            return None
        if any(c % element or any(map(_is_address, m)) for m, c in others.items()):
            return None
        more = Polynomial({m: c // element for m, c in others.items()})
        own: list[Instr] = []
        index = self._sum(self.known.of(index).plus(more), own, instr)
        return [*own, replace(instr, operands=(arrays[0][0], index, *rest))]

    def _parts(self, instr: Instr, index: Polynomial) -> tuple[Polynomial, Polynomial, int]:
        """What changes in the loop, what does not, and the offset in bytes."""
        moving = {m: c for m, c in index.terms.items() if self.varying.intersection(m)}
        fixed = {m: c for m, c in index.terms.items() if m not in moving}
        offset = instr.offset + (index.coefficient() << instr.shift)
        if -_OFFSET_LIMIT <= offset < _OFFSET_LIMIT:
            fixed.pop((), None)
        else:
            offset = instr.offset
        return Polynomial(moving), Polynomial(fixed), offset

    def _sum(
        self, total: Polynomial, place: list[Instr], like: Instr, first: Value | None = None
    ) -> Value:
        """Emits the word of a polynomial (plus `first`), the longest products first."""
        value = first
        order = sorted(total.terms.items(), key=lambda item: (-len(item[0]), repr(item[0])))
        for monomial, coefficient in order:
            term: Value | None = None if abs(coefficient) == 1 and monomial else Const(coefficient)
            for factor in monomial:
                term = factor if term is None else self._product(place, like, factor, term)
            assert term is not None
            if value is None and coefficient != -1:
                value = term
            else:
                op = Opcode.SUB if coefficient == -1 and monomial else Opcode.ADD
                start = Const(0) if value is None else value
                value = self._emit(place, like, op, start, term)
        return Const(0) if value is None else value

    def _product(self, place: list[Instr], like: Instr, left: Value, right: Value) -> Value:
        word = signed(right.word) if isinstance(right, Const) else 0
        if word > 0 and word & (word - 1) == 0:
            amount = Const(word.bit_length() - 1)
            return self._emit(place, like, Opcode.SHL, left, amount)
        return self._emit(place, like, Opcode.MUL, left, right)

    def _emit(
        self, place: list[Instr], like: Instr, op: Opcode, left: Value, right: Value
    ) -> Value:
        operands = tuple(
            Const(v.word & 0xFFFFFFFF) if isinstance(v, Const) else v for v in (left, right)
        )
        place.append(Instr(self.free, op, Type.I32, operands, loc=like.loc))
        self.free += 1
        return Ref(self.free - 1)
