"""How many low bits of each 64-bit integer are read: if they lie within a word, the word
suffices.
"""

from __future__ import annotations

from collections.abc import Iterator

from vividc.frontend.ranges.interval import width
from vividc.machine.words import WORD_BITS
from vividc.ssa.ir import Block, Function, Instr, Int, Key, Named, Value

_ALL = 64
_RING = frozenset({"add", "sub", "mul", "or", "xor", "freeze"})


def demanded_bits(function: Function) -> dict[Key, int]:
    """Low bits demanded of each result and parameter; values that nothing reads are missing.

    A backward analysis in the manner of Budiu, Sakr, Walker and Goldstein, "BitValue inference"
    (2000), with low bits only.
    """
    demand: dict[Key, int] = {}
    changed = True
    while changed:
        changed = False
        for block in reversed(function.blocks):
            for operand, bits in _demands(block, demand):
                if isinstance(operand, Named) and demand.get(operand.key, 0) < bits:
                    demand[operand.key] = bits
                    changed = True
    return demand


def _demands(block: Block, demand: dict[Key, int]) -> Iterator[tuple[Value, int]]:
    for operand in block.branch.read:
        yield operand, _ALL
    for op in reversed(block.instrs):
        yield from _of_operands(op, demand.get(op.id, 0))
    for phi in block.phis:
        for _, value in phi.incoming:
            yield value, demand.get(phi.id, 0)


def _of_operands(op: Instr, bits: int) -> Iterator[tuple[Value, int]]:
    if op.op == "store":
        yield op.operands[0], 8 * op.width
        yield op.operands[1], WORD_BITS
    elif op.op == "load":
        yield op.operands[0], WORD_BITS
    elif op.op == "select":
        yield op.operands[0], 1
        yield from ((arg, bits) for arg in op.operands[1:])
    elif op.op in ("trunc", "zext"):
        yield op.operands[0], min(bits, width(op.type), width(op.source))
    elif op.op == "and":
        yield from _of_mask(op, bits)
    elif op.op in _RING:
        yield from ((arg, bits) for arg in op.operands)
    elif op.op in ("shl", "lshr", "ashr") and isinstance(op.operands[1], Int):
        by = op.operands[1].value
        yield op.operands[0], max(bits - by, 0) if op.op == "shl" else min(bits + by, _ALL)
    else:
        yield from ((arg, _ALL) for arg in op.operands)


def _of_mask(op: Instr, bits: int) -> Iterator[tuple[Value, int]]:
    left, right = op.operands
    mask = right.value if isinstance(right, Int) and right.value >= 0 else None
    yield left, bits if mask is None else min(bits, mask.bit_length())
    yield right, bits
