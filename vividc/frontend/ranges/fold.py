"""Remove what the ranges prove: comparisons with one outcome, and all that hangs on them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from vividc.frontend.llvm.ir import (
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
from vividc.frontend.ranges.ranges import Ranges

_WORD = 32
_NEUTRAL_ZERO = frozenset({"add", "sub", "or", "xor", "shl", "lshr", "ashr"})


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
    function = _without_trivial(substitute(function, known))
    blocks = tuple(replace(block, exit=_decided(block.exit)) for block in function.blocks)
    function = _without_trivial(remove_unreachable(replace(function, blocks=blocks)))
    return _merge_chains(function)


def _merge_chains(function: WideFunction) -> WideFunction:
    """Join a block with its only successor where that has no other predecessor, and so no phis."""
    blocks = {block.name: block for block in function.blocks}
    predecessors = {name: 0 for name in blocks}
    for block in function.blocks:
        for target in block.exit.targets:
            predecessors[target] += 1
    renamed: dict[str, str] = {}
    for name in list(blocks):
        while name in blocks:
            block = blocks[name]
            target = block.exit.targets[0] if len(block.exit.targets) == 1 else name
            follower = blocks[target]
            if target == name or predecessors[target] != 1 or follower.phis:
                break
            del blocks[target]
            blocks[name] = replace(block, ops=(*block.ops, *follower.ops), exit=follower.exit)
            renamed[target] = name

    def final(name: str) -> str:
        while name in renamed:
            name = renamed[name]
        return name

    return replace(function, blocks=tuple(_renamed_phis(b, final) for b in blocks.values()))


def _renamed_phis(block: WideBlock, rename: Callable[[str], str]) -> WideBlock:
    phis = tuple(
        replace(phi, incoming=tuple((rename(pred), value) for pred, value in phi.incoming))
        for phi in block.phis
    )
    return replace(block, phis=phis)


def _without_trivial(function: WideFunction) -> WideFunction:
    function = remove_dead(function)
    while known := _trivial(function):
        function = remove_dead(substitute(function, known))
    return function


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
    if op.op in _NEUTRAL_ZERO and op.args[1] == Int(0):
        return op.args[0]
    if op.op in ("add", "or", "xor") and op.args[0] == Int(0):
        return op.args[1]
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


def recover_extensions(function: WideFunction) -> WideFunction:
    """Rewrite `(x << a) >> b`, both at least 32, in words: LLVM's form of sign or zero extending a
    truncation.
    """
    blocks = tuple(
        replace(block, ops=tuple(new for op in block.ops for new in _in_words(function, op)))
        for block in function.blocks
    )
    return remove_dead(replace(function, blocks=blocks))


def _in_words(function: WideFunction, op: Op) -> tuple[Op, ...]:
    by = _high_shift(op, ("ashr", "lshr"))
    if by is None or not isinstance(op.args[0], Local):
        return (op,)
    inner = function.definitions.get(op.args[0].name)
    up = _high_shift(inner, ("shl",)) if isinstance(inner, Op) else None
    if up is None or not isinstance(inner, Op):
        return (op,)
    word, high, low = (Local(f"{op.name}.{part}") for part in ("word", "high", "low"))
    return (
        Op(word.name, "trunc", "i32", inner.args[:1], source="i64", loc=op.loc),
        Op(high.name, "shl", "i32", (word, Int(up - _WORD)), loc=op.loc),
        Op(low.name, op.op, "i32", (high, Int(by - _WORD)), loc=op.loc),
        Op(op.name, "sext" if op.op == "ashr" else "zext", "i64", (low,), source="i32", loc=op.loc),
    )


def _high_shift(op: Op, opcodes: tuple[str, ...]) -> int | None:
    """Amount of a 64-bit shift by at least a word."""
    if op.op not in opcodes or op.type != "i64":
        return None
    amount = op.args[1]
    return amount.value if isinstance(amount, Int) and amount.value >= _WORD else None
