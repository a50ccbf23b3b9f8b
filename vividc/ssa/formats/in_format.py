"""float32 arithmetic of a function in a narrower format, as a precision policy asks for.

Sums, differences, products and fused products round their operands to the format and give a number
of it; everything else (memory, comparisons, functions, conversions to integers) stays float32. What
one operation hands to the next, through phis and selects too, is not converted on the way.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final

from vividc.errors import SourceLoc
from vividc.formats import Format, round_bits, to_float
from vividc.machine.opcodes import Opcode, Type
from vividc.machine.words import float_of
from vividc.ssa.edit import next_id
from vividc.ssa.ir import Block, Const, Function, Instr, Phi, Ref, Undefined, Value
from vividc.ssa.rewrite.dead import remove_unused
from vividc.ssa.rewrite.hoist import hoist_invariants

_STEMS: Final = {
    Opcode.FADD: "fadd",
    Opcode.FSUB: "fsub",
    Opcode.FMUL: "fmul",
    Opcode.FMA: "fma",
    Opcode.FMS: "fms",
    Opcode.FNMA: "fnma",
}

_Condition = Callable[[int, set[int]], bool]


def in_format(function: Function, fmt: Format) -> Function:
    """The function with its float32 arithmetic in `fmt`; the same object if it has none."""
    if not any(i.op in _STEMS for block in function.blocks for i in block.instrs):
        return function
    function = _Converter(function, fmt).converted()
    return hoist_invariants(remove_unused(_Carrier(function, fmt).carried()))


class _Rounding:
    """What both steps share: ids, and numbers rounded to the format."""

    def __init__(self, function: Function, fmt: Format) -> None:
        self.function, self.fmt = function, fmt
        self.next = next_id(function)
        self.round = Opcode(f"fptrunc.{fmt.name}")
        self.extend = Opcode(f"fpext.{fmt.name}")

    def fresh(self) -> int:
        """A number for a new instruction."""
        self.next += 1
        return self.next - 1

    def rounded(self, value: Value, loc: SourceLoc | None, into: list[Instr]) -> Value:
        """The number of the format that is nearest to a float32 value, by an operation if need be,
        put behind `into`.
        """
        if isinstance(value, Const):
            return Const(round_bits(self.fmt, float_of(value.word)))
        for instr in into:
            if instr.op is self.round and instr.operands == (value,):
                return Ref(instr.id)
        into.append(Instr(self.fresh(), self.round, Type.I32, (value,), loc=loc))
        return Ref(into[-1].id)


class _Converter(_Rounding):
    """Each operation with its conversions."""

    def converted(self) -> Function:
        """The function; results keep their ids, as float32."""
        blocks = (replace(block, instrs=self._instrs(block)) for block in self.function.blocks)
        return replace(self.function, blocks=tuple(blocks))

    def _instrs(self, block: Block) -> tuple[Instr, ...]:
        done: list[Instr] = []
        packed = f"{self.fmt.name}x{self.fmt.lanes}"
        for instr in block.instrs:
            if instr.op not in _STEMS:
                done.append(instr)
                continue
            operands = tuple(self.rounded(value, instr.loc, done) for value in instr.operands)
            opcode = Opcode(f"{_STEMS[instr.op]}.{packed}")
            number = replace(instr, id=self.fresh(), op=opcode, type=Type.I32, operands=operands)
            extended = replace(instr, op=self.extend, operands=(Ref(number.id),), lane=None)
            done += [number, extended]
        return tuple(done)


class _Carrier(_Rounding):
    """Phis and selects that carry numbers of the format as such.

    A merge may do so if whatever reads it rounds it (rounding what is merged is rounding the
    merge), or if all that it merges are numbers of the format.
    """

    def __init__(self, function: Function, fmt: Format) -> None:
        super().__init__(function, fmt)
        self.definitions = {item.id: item for b in function.blocks for item in b.items}
        self.merges = {ident for ident, item in self.definitions.items() if _is_merge(item)}
        self.readers = self._readers()
        self.members = self._closed(self._is_rounded) | self._closed(self._is_narrow)
        self.number = {ident: self.fresh() for ident in sorted(self.members)}
        """Id of the number of the format that each float32 value is, or is rounded to."""
        for item in self.definitions.values():
            if isinstance(item, Instr) and item.op is self.extend:
                source = item.operands[0]
                assert isinstance(source, Ref)
                self.number[item.id] = source.id

    def carried(self) -> Function:
        """The function; a member keeps its id for its float32 value."""
        added: dict[str, list[Instr]] = {block.name: [] for block in self.function.blocks}
        phis = {block.name: self._phis(block, added) for block in self.function.blocks}
        blocks = []
        for block in self.function.blocks:
            heads = [
                self._extended(phi.id, phi.loc) for phi in block.phis if phi.id in self.members
            ]
            instrs = (*heads, *self._instrs(block), *added[block.name])
            blocks.append(replace(block, phis=phis[block.name], instrs=instrs))
        return replace(self.function, blocks=tuple(blocks))

    def _phis(self, block: Block, added: dict[str, list[Instr]]) -> tuple[Phi, ...]:
        done = []
        for phi in block.phis:
            if phi.id not in self.members:
                done.append(phi)
                continue
            incoming = tuple(
                (pred, self._number(value, phi.loc, added[pred])) for pred, value in phi.incoming
            )
            done.append(Phi(self.number[phi.id], Type.I32, incoming, phi.loc))
        return tuple(done)

    def _instrs(self, block: Block) -> list[Instr]:
        done: list[Instr] = []
        for instr in block.instrs:
            if instr.id not in self.members:
                done.append(self._reading_numbers(instr))
                continue
            chosen = [self._number(value, instr.loc, done) for value in instr.operands[1:]]
            operands = (instr.operands[0], *chosen)
            number = self.number[instr.id]
            done.append(replace(instr, id=number, type=Type.I32, operands=operands))
            done.append(self._extended(instr.id, instr.loc))
        return done

    def _reading_numbers(self, instr: Instr) -> Instr:
        """Without rounding what is a number of the format already: its word is the number's."""
        operands = tuple(self._unrounded(value) for value in instr.operands)
        return instr if operands == instr.operands else replace(instr, operands=operands)

    def _unrounded(self, value: Value) -> Value:
        item = self.definitions.get(value.id) if isinstance(value, Ref) else None
        if isinstance(item, Instr) and item.op is self.round:
            source = item.operands[0]
            if isinstance(source, Ref) and source.id in self.number:
                return Ref(self.number[source.id])
        return value

    def _extended(self, ident: int, loc: SourceLoc | None) -> Instr:
        return Instr(ident, self.extend, Type.F32, (Ref(self.number[ident]),), loc=loc)

    def _number(self, value: Value, loc: SourceLoc | None, into: list[Instr]) -> Value:
        if isinstance(value, Ref) and value.id in self.number:
            return Ref(self.number[value.id])
        return self.rounded(value, loc, into)

    def _closed(self, holds: _Condition) -> set[int]:
        """The largest set of merges for each of which the condition holds, given the set."""
        kept = set(self.merges)
        while True:
            dropped = {ident for ident in kept if not holds(ident, kept)}
            if not dropped:
                return kept
            kept -= dropped

    def _is_rounded(self, ident: int, kept: set[int]) -> bool:
        readers = self.readers.get(ident, [])
        return bool(readers) and all(
            reader in kept or self._op(reader) is self.round for reader in readers
        )

    def _is_narrow(self, ident: int, kept: set[int]) -> bool:
        return all(self._is_number(v, kept) for v in _merged(self.definitions[ident]))

    def _is_number(self, value: Value, kept: set[int]) -> bool:
        if isinstance(value, Undefined):
            return True
        if isinstance(value, Const):
            number = float_of(value.word)
            return to_float(self.fmt, round_bits(self.fmt, number)) == number
        if not isinstance(value, Ref):
            return False
        return value.id in kept or self._op(value.id) is self.extend

    def _op(self, ident: int) -> Opcode | None:
        item = self.definitions.get(ident)
        return item.opcode if isinstance(item, Instr) else None

    def _readers(self) -> dict[int, list[int]]:
        """Ids of what reads each value; -1 stands for a branch."""
        readers: dict[int, list[int]] = {}
        for block in self.function.blocks:
            reads = [(value, -1) for value in block.branch.read]
            for item in block.items:
                reads += [(value, item.id) for value in _operands(item)]
            for value, reader in reads:
                if isinstance(value, Ref):
                    readers.setdefault(value.id, []).append(reader)
        return readers


def _is_merge(item: Phi | Instr) -> bool:
    return item.type is Type.F32 and (isinstance(item, Phi) or item.op is Opcode.SELECT)


def _operands(item: Phi | Instr) -> tuple[Value, ...]:
    return tuple(v for _, v in item.incoming) if isinstance(item, Phi) else item.operands


def _merged(item: Phi | Instr) -> tuple[Value, ...]:
    return _operands(item) if isinstance(item, Phi) else item.operands[1:]
