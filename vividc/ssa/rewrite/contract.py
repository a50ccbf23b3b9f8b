"""Contraction of products and sums before a function is transformed: every form of it then rounds
alike.

`passes.contract_fma` decides by a product's readers in one region. Threads and jammed copies that
share a product, and predicates that make one region of several, would change that.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace

from vividc.machine.opcodes import Opcode
from vividc.machine.words import SIGN_BIT
from vividc.ssa.edit import uses
from vividc.ssa.flow import pipelined_loops
from vividc.ssa.ir import Const, Function, Instr, Ref, Value


def contract(function: Function) -> Function:
    """Turn `a*b + c`, `a*b - c` and `c - a*b` into one `fma`, as `passes.contract_fma` would in the
    function as it is.

    The product has no other reader, and is in the same block, or in the same innermost loop. A
    subtraction needs an operand whose negation is free.
    """
    return _Contraction(function).run()


@dataclass
class _Contraction:
    function: Function
    gone: set[int] = field(default_factory=set)

    def __post_init__(self) -> None:
        loops = pipelined_loops(self.function)
        self.instrs: dict[int, Instr] = {}
        self.region: dict[int, str] = {}
        self.readers: Counter[int] = Counter()
        for block in self.function.blocks:
            home = next((o.header for o in loops if block.name in o.blocks), block.name)
            self.instrs |= {instr.id: instr for instr in block.instrs}
            self.region |= {instr.id: home for instr in block.instrs}
            values = [*uses(block), *(value for phi in block.phis for _, value in phi.incoming)]
            self.readers.update(value.id for value in values if isinstance(value, Ref))

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
            operands = None if product is None else self._operands(instr, product, port)
            if product is not None and operands is not None:
                self.gone.add(product.id)
                return replace(instr, op=Opcode.FMA, operands=operands)
        return instr

    def _product(self, reader: Instr, value: Value) -> Instr | None:
        product = self.instrs.get(value.id) if isinstance(value, Ref) else None
        if product is None or product.op is not Opcode.FMUL or self.readers[product.id] != 1:
            return None
        return product if self.region[product.id] == self.region[reader.id] else None

    def _operands(self, instr: Instr, product: Instr, port: int) -> tuple[Value, ...] | None:
        first, second = product.operands
        addend = instr.operands[1 - port]
        if instr.op is Opcode.FADD:
            return first, second, addend
        if port == 0:
            negated = self._negated(addend)
            return None if negated is None else (first, second, negated)
        for factor, other in ((second, first), (first, second)):
            negated = self._negated(factor)
            if negated is not None:
                return other, negated, addend
        return None

    def _negated(self, value: Value) -> Value | None:
        """A value that is `-value` at no cost."""
        if isinstance(value, Const):
            return Const(value.word ^ SIGN_BIT)
        negation = self.instrs.get(value.id) if isinstance(value, Ref) else None
        return negation.operands[0] if negation is not None and negation.op is Opcode.FNEG else None
