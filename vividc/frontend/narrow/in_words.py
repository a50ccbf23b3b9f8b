"""A kernel as it would be if some of its lines cast their 64-bit integers to int32."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace
from typing import Final

from vividc.ssa.edit import FreshIds, map_values
from vividc.ssa.ir import LLVM_BINARY, Block, Function, Input, Instr, Ref, Value, type_of

_WIDE: Final = "i64"
_WORD: Final = "i32"
_COMPUTES: Final = LLVM_BINARY | {"icmp", "select", "call"}


def in_words(function: Function, lines: Collection[int]) -> Function:
    """The function with casts to int32 around what its lines compute in 64 bits, and around the
    operands: as if they were written there. Where a value does not fit, it is another function.

    Parameters
    ----------
    function
        LLVM's, without pointers.
    lines
        Of the function's file.
    """
    casts = _Casts(function, frozenset(lines))
    blocks = [casts.block(block) for block in function.blocks]

    def cast(value: Value) -> Value:
        return casts.results.get(value.id, value) if isinstance(value, Ref) else value

    return replace(function, blocks=tuple(map_values(block, cast) for block in blocks))


class _Casts:
    """`results`: what stands for the result of an instruction on these lines, by its id."""

    def __init__(self, function: Function, lines: frozenset[int]) -> None:
        self.function = function
        self.lines = lines
        self.results: dict[int, Value] = {}
        self.ids = FreshIds(function)

    def block(self, block: Block) -> Block:
        """The block with casts; uses of the results are as they were."""
        return replace(block, instrs=tuple(new for op in block.instrs for new in self._around(op)))

    def _around(self, op: Instr) -> Iterator[Instr]:
        here = op.loc is not None and op.loc.line in self.lines and op.op in _COMPUTES
        if not here or _WIDE not in (op.type, op.source):
            yield op
            return
        operands: list[Value] = []
        for value in op.operands:
            wide = isinstance(value, Ref | Input) and type_of(self.function, value) == _WIDE
            if not wide or self._is_cast(value):
                operands.append(value)
                continue
            word, whole = self._cast(value, op)
            yield from (word, whole)
            operands.append(Ref(whole.id))
        if op.type != _WIDE or op.op == "icmp":
            yield replace(op, operands=tuple(operands))
            return
        made = replace(op, id=self.ids(), operands=tuple(operands))
        word, whole = self._cast(Ref(made.id), op)
        self.results[op.id] = Ref(whole.id)
        yield from (made, word, whole)

    def _is_cast(self, value: Value) -> bool:
        """Whether a result of these lines stands for the value, which is cast already."""
        return isinstance(value, Ref) and value.id in self.results

    def _cast(self, value: Value, op: Instr) -> tuple[Instr, Instr]:
        word = Instr(self.ids(), "trunc", _WORD, (value,), source=_WIDE, loc=op.loc)
        whole = Instr(self.ids(), "sext", _WIDE, (Ref(word.id),), source=_WORD, loc=op.loc)
        return word, whole
