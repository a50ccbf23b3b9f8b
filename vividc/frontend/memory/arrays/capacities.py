"""How many elements the arrays of lists hold: as many as a list has at most, if that is known at
launch, else `MOST_NEEDED`, and what makes the list longer tests that it fits.
"""

from __future__ import annotations

from dataclasses import replace

from vividc.frontend.llvm.calls import FITS, MOST_NEEDED
from vividc.frontend.memory.arrays.by_array import roots_of
from vividc.frontend.ranges.launch_sizes import LaunchSizes
from vividc.machine.params import Formula
from vividc.ssa.ir import Block, Function, Instr, Int, Key


def with_capacities(function: Function) -> tuple[Function, dict[Key, Formula]]:
    """The function without calls of `FITS`, and the elements of each array that they ask for."""
    asked = [(op, block.name) for block in function.blocks for op in block.instrs if _asks(op)]
    if not asked:
        return function, {}
    sizes = LaunchSizes(function)
    bounds = {op.id: sizes.bound(op.operands[1], block) for op, block in asked}
    needed: dict[Key, Formula] = {}
    for op, _ in asked:
        bound = bounds[op.id] or (MOST_NEEDED,)
        for root in roots_of(function, op.operands[0]):
            before = needed.get(root, bound)
            needed[root] = bound if before == bound else (*before, *bound, "max")

    def answered(block: Block) -> Block:
        ops = (_answer(op, bounds[op.id]) if _asks(op) else op for op in block.instrs)
        return replace(block, instrs=tuple(ops))

    return replace(function, blocks=tuple(map(answered, function.blocks))), needed


def _answer(op: Instr, bound: Formula | None) -> Instr:
    """Whether so many elements fit: always where they have a bound."""
    if bound is not None:
        return Instr(op.id, "icmp", "i64", (Int(0), Int(0)), pred="eq", loc=op.loc)
    size = op.operands[1], Int(MOST_NEEDED)
    return Instr(op.id, "icmp", "i64", size, pred="ule", loc=op.loc)


def _asks(op: Instr) -> bool:
    return op.op == "call" and op.pred.startswith(FITS)
