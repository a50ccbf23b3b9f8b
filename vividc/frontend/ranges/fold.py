"""Remove what the ranges prove: comparisons with one outcome, and all that hangs on them."""

from __future__ import annotations

from dataclasses import replace

from vividc.frontend.ranges.known import ranges_of
from vividc.frontend.ranges.ranges import Ranges
from vividc.host import time_limit
from vividc.ssa.edit import FreshIds, substitute
from vividc.ssa.ir import Block, Function, Instr, Int, Ref, Value, definition_of
from vividc.ssa.rewrite.blocks import merge_chains
from vividc.ssa.rewrite.dead import remove_unused
from vividc.ssa.rewrite.simplify import fold_branches

_WORD = 32
_NEUTRAL_ZERO = frozenset({"add", "sub", "or", "xor", "shl", "lshr", "ashr"})


def fold_by_ranges(function: Function) -> Function:
    """Fold decided comparisons, selects on them and branches on them, then drop dead code.

    This removes the wraparound of negative indices where an index is not negative. A branch knows
    more than the comparison that it reads, which LLVM moves out of loops: in one over `range(n)`, n
    is not 0.
    """
    ranges = ranges_of(function)
    known: dict[int, Value] = {}
    for block in function.blocks:
        for op in block.instrs:
            outcome = ranges.compare_at(op, block.name)
            if outcome is not None:
                known[op.id] = Int(int(outcome))
    blocks = tuple(_decided(function, block, ranges) for block in function.blocks)
    if any(new is not old for new, old in zip(blocks, function.blocks, strict=True)):
        function = replace(function, blocks=blocks)
    function = _without_trivial(substitute(function, known))
    return merge_chains(_without_trivial(fold_branches(function)))


def _decided(function: Function, block: Block, ranges: Ranges) -> Block:
    """The block with a constant for its branch's condition if that has one outcome here."""
    cond = block.branch.cond
    made = definition_of(function, cond) if isinstance(cond, Ref) else None
    if not isinstance(made, Instr):
        return block
    outcome = ranges.compare_at(made, block.name)
    if outcome is None and _is_not_zero(function, made, block.name, ranges):
        outcome = made.pred == "ne"
    if outcome is None:
        return block
    return replace(block, branch=replace(block.branch, cond=Int(int(outcome))))


def _is_not_zero(function: Function, made: Instr, block: str, ranges: Ranges) -> bool:
    """Whether a value that is compared with 0 is known not to be, by what it was extended to: LLVM
    compares it before, and with other values behind.
    """
    if made.op != "icmp" or made.pred not in ("eq", "ne") or made.operands[1] != Int(0):
        return False
    compared = made.operands[0]
    return any(
        op.op in ("sext", "zext")
        and op.operands[0] == compared
        # where it does not run, its range says nothing
        and ranges.is_nonzero(Ref(op.id), block)
        for name in ranges.flow.dominators(block)
        for op in function.by_name[name].instrs
    )


def _without_trivial(function: Function) -> Function:
    function = remove_unused(function)
    while known := _trivial(function):
        time_limit.step("it was lowered")
        function = remove_unused(substitute(function, known))
    return function


def _trivial(function: Function) -> dict[int, Value]:
    """Instructions whose result is one of their operands or a constant."""
    known: dict[int, Value] = {}
    for block in function.blocks:
        for op in block.instrs:
            value = _value(op)
            if value is not None:
                known[op.id] = value
        known.update(_copies(block))
    return known


def _value(op: Instr) -> Value | None:
    if op.op == "select":
        cond, yes, no = op.operands
        if isinstance(cond, Int):
            return yes if cond.value & 1 else no
        return yes if yes == no else None
    if op.op in _NEUTRAL_ZERO and op.operands[1] == Int(0):
        return op.operands[0]
    if op.op in ("add", "or", "xor") and op.operands[0] == Int(0):
        return op.operands[1]
    return _logic(op) if op.op in ("and", "or", "xor") and op.type == "i1" else None


def _logic(op: Instr) -> Value | None:
    constants = [arg for arg in op.operands if isinstance(arg, Int)]
    if len(constants) != 1:
        return None
    [other] = [arg for arg in op.operands if not isinstance(arg, Int)]
    truth = constants[0].value & 1
    if op.op == "xor":
        return None if truth else other
    absorbs = truth if op.op == "or" else not truth
    return Int(truth) if absorbs else other


def _copies(block: Block) -> dict[int, Value]:
    """Phis of one predecessor."""
    return {
        phi.id: phi.incoming[0][1]
        for phi in block.phis
        if len(phi.incoming) == 1 and phi.incoming[0][1] != Ref(phi.id)
    }


def recover_extensions(function: Function) -> Function:
    """Rewrite `(x << a) >> b`, both at least 32, in words: LLVM's form of sign or zero extending a
    truncation.
    """
    ids = FreshIds(function)
    blocks = (
        replace(block, instrs=tuple(n for op in block.instrs for n in _in_words(function, op, ids)))
        for block in function.blocks
    )
    return remove_unused(replace(function, blocks=tuple(blocks)))


def _in_words(function: Function, op: Instr, ids: FreshIds) -> tuple[Instr, ...]:
    by = _high_shift(op, ("ashr", "lshr"))
    if by is None:
        return (op,)
    inner = definition_of(function, op.operands[0])
    up = _high_shift(inner, ("shl",)) if isinstance(inner, Instr) else None
    if up is None or not isinstance(inner, Instr):
        return (op,)
    word = Instr(ids(), "trunc", "i32", inner.operands[:1], source="i64", loc=op.loc)
    high = Instr(ids(), "shl", "i32", (Ref(word.id), Int(up - _WORD)), loc=op.loc)
    low = Instr(ids(), op.op, "i32", (Ref(high.id), Int(by - _WORD)), loc=op.loc)
    extend = "sext" if op.op == "ashr" else "zext"
    whole = Instr(op.id, extend, "i64", (Ref(low.id),), source="i32", loc=op.loc)
    return (word, high, low, whole)


def _high_shift(op: Instr, opcodes: tuple[str, ...]) -> int | None:
    """Amount of a 64-bit shift by at least a word."""
    if op.op not in opcodes or op.type != "i64":
        return None
    amount = op.operands[1]
    return amount.value if isinstance(amount, Int) and amount.value >= _WORD else None
