"""Remove what the ranges prove: comparisons with one outcome, and all that hangs on them."""

from __future__ import annotations

from dataclasses import replace

from vividc.frontend.ranges import Ranges
from vividc.frontend.ssa import (
    Exit,
    Int,
    Local,
    Op,
    Operand,
    WideBlock,
    WideFunction,
    remove_dead,
    remove_unreachable,
    substitute,
)


def fold_by_ranges(function: WideFunction, ranges: Ranges) -> WideFunction:
    """Fold decided comparisons, selects on them and branches on them, then drop dead code.

    This removes the wraparound of negative indices where an index is not negative.
    """
    known: dict[str, Operand] = {}
    for block in function.blocks:
        for op in block.ops:
            outcome = ranges.compare_at(op, block.name)
            if outcome is not None:
                known[op.name] = Int(int(outcome))
    while known:
        function = remove_dead(substitute(function, known))
        known = _trivial(function)
    blocks = tuple(replace(block, exit=_decided(block.exit)) for block in function.blocks)
    return remove_dead(remove_unreachable(replace(function, blocks=blocks)))


def _trivial(function: WideFunction) -> dict[str, Operand]:
    """Instructions whose result is one of their operands or a constant."""
    known: dict[str, Operand] = {}
    for block in function.blocks:
        for op in block.ops:
            value = _value(op)
            if value is not None:
                known[op.name] = value
        known.update(_copies(block))
    return known


def _value(op: Op) -> Operand | None:
    if op.op == "select":
        cond, yes, no = op.args
        if isinstance(cond, Int):
            return yes if cond.value & 1 else no
        return yes if yes == no else None
    if op.op == "add" and Int(0) in op.args:
        return op.args[0] if op.args[1] == Int(0) else op.args[1]
    return _logic(op) if op.op in ("and", "or", "xor") and op.type == "i1" else None


def _logic(op: Op) -> Operand | None:
    constants = [arg for arg in op.args if isinstance(arg, Int)]
    if len(constants) != 1:
        return None
    [other] = [arg for arg in op.args if not isinstance(arg, Int)]
    truth = constants[0].value & 1
    if op.op == "xor":
        return None if truth else other
    absorbs = truth if op.op == "or" else not truth
    return Int(truth) if absorbs else other


def _copies(block: WideBlock) -> dict[str, Operand]:
    """Phis of one predecessor."""
    return {
        phi.name: phi.incoming[0][1]
        for phi in block.phis
        if len(phi.incoming) == 1 and phi.incoming[0][1] != Local(phi.name)
    }


def _decided(leave: Exit) -> Exit:
    if not isinstance(leave.cond, Int):
        return leave
    target = leave.targets[0] if leave.cond.value & 1 else leave.targets[1]
    return replace(leave, targets=(target,), cond=None)
