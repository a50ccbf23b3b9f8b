"""Flat indices of matrices as subscripts, where a number is taken to be the length of a row.

`np.dot` and helpers index parameters flatly, by sizes that may be another array's; a launch, which
knows all sizes, checks that the rows are so long, and that all that is touched is in the array.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from vividc.machine.opcodes import MEMORY, Opcode, Type
from vividc.machine.product import Size
from vividc.ssa.edit import next_id, with_blocks
from vividc.ssa.ir import (
    Block,
    Const,
    Function,
    Input,
    Instr,
    Ref,
    Value,
    definition_of,
    is_pitch,
    pitch_of,
)

_NDIM = 2


def with_rows(function: Function) -> tuple[Function, tuple[tuple[str, Size], ...]]:
    """A function whose accesses i * n + j of matrices have subscripts i and j, and the row lengths
    n by which they have.
    """
    rows = _Rows(function)
    changed = [block for block in map(rows.block, function.blocks) if block is not None]
    if not changed:
        return function, ()
    return with_blocks(function, changed), tuple(dict.fromkeys(rows.strides))


@dataclass
class _Rows:
    function: Function
    strides: list[tuple[str, Size]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.free = next_id(self.function)
        self.matrices = {p.name for p in self.function.params if p.ndim == _NDIM and not p.flat}

    def block(self, block: Block) -> Block | None:
        """The block with subscripts; None: it is as it was."""
        instrs: list[Instr] = []
        for instr in block.instrs:
            instrs += self._with_subscripts(instr)
        if len(instrs) == len(block.instrs):
            return None
        return replace(block, instrs=tuple(instrs))

    def _with_subscripts(self, instr: Instr) -> list[Instr]:
        found = self._parts(instr) if self._is_flat(instr) else None
        if found is None:
            return [instr]
        row, length, column = found
        times = replace(_blank(instr), id=self.free, op=Opcode.MUL)
        pitch = pitch_of(instr.array, 1)
        times = replace(times, operands=(row, pitch))
        index = replace(times, id=self.free + 1, op=Opcode.ADD, operands=(Ref(times.id), column))
        self.free += 2
        size = Size(length.word) if isinstance(length, Const) else Size(0, ((length.key, 1),))
        self.strides.append((instr.array, size))
        operands = (instr.operands[0], Ref(index.id), *instr.operands[2:])
        return [times, index, replace(instr, operands=operands)]

    def _is_flat(self, instr: Instr) -> bool:
        return instr.op in MEMORY and instr.array in self.matrices and not instr.subscript

    def _parts(self, instr: Instr) -> tuple[Value, Input | Const, Value] | None:
        """Row, length of a row, and column of an index."""
        add = definition_of(self.function, instr.operands[1])
        if not isinstance(add, Instr) or add.op is not Opcode.ADD:
            return None
        for times, column in (add.operands, add.operands[::-1]):
            made = definition_of(self.function, times)
            if not isinstance(made, Instr) or made.op is not Opcode.MUL:
                continue
            for row, length in (made.operands, made.operands[::-1]):
                settled = self.function.settled(length)
                is_size = isinstance(length, Input) and not is_pitch(length)
                if is_size and isinstance(settled, Input | Const):
                    return row, settled, column
        return None


def _blank(instr: Instr) -> Instr:
    return Instr(0, Opcode.ADD, Type.I32, (), loc=instr.loc)
