"""Contraction of products and sums before a function is transformed: every form of it then rounds
alike.

`passes.contract_fma` decides by a product's readers in one region. Threads and jammed copies that
share a product, and predicates that make one region of several, would change that.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace

from vividc.machine.opcodes import FUSED, Opcode
from vividc.ssa.edit import read_values
from vividc.ssa.flow import pipelined_loops
from vividc.ssa.ir import Function, Instr, Ref, Value, definition_of


def contract(function: Function) -> Function:
    """Turn `a*b + c`, `a*b - c` and `c - a*b` into one operation, as `passes.contract_fma` would in
    the function as it is.

    The product has no other reader, and is in the same block, or in the same innermost loop.
    """
    return _Contraction(function).run()


@dataclass
class _Contraction:
    function: Function
    gone: set[int] = field(default_factory=set)

    def __post_init__(self) -> None:
        loops = pipelined_loops(self.function)
        self.region: dict[int, str] = {}
        self.readers: Counter[int] = Counter()
        for block in self.function.blocks:
            home = next((o.header for o in loops if block.name in o.blocks), block.name)
            self.region |= {instr.id: home for instr in block.instrs}
            self.readers.update(v.id for v in read_values(block) if isinstance(v, Ref))

    def run(self) -> Function:
        changed = [
            replace(block, instrs=tuple(self._contracted(instr) for instr in block.instrs))
            for block in self.function.blocks
        ]
        if not self.gone:
            return self.function
        blocks = tuple(
            replace(block, instrs=tuple(i for i in block.instrs if i.id not in self.gone))
            for block in changed
        )
        return replace(self.function, blocks=blocks)

    def _contracted(self, instr: Instr) -> Instr:
        if instr.op not in (Opcode.FADD, Opcode.FSUB):
            return instr
        for port in (0, 1):
            product = self._product(instr, instr.operands[port])
            if product is not None:
                self.gone.add(product.id)
                operands = (*product.operands, instr.operands[1 - port])
                return replace(instr, op=FUSED[instr.opcode, port], operands=operands)
        return instr

    def _product(self, reader: Instr, value: Value) -> Instr | None:
        product = definition_of(self.function, value)
        if not isinstance(product, Instr) or product.op is not Opcode.FMUL:
            return None
        if self.readers[product.id] != 1:
            return None
        return product if self.region[product.id] == self.region[reader.id] else None
