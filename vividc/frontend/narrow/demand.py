"""How many low bits of each 64-bit integer anything reads: where they lie within a word, the word
suffices.
"""

from __future__ import annotations

from collections.abc import Iterator

from vividc.frontend.llvm.ir import Int, Local, Op, Operand, WideBlock, WideFunction, exit_uses
from vividc.frontend.ranges.interval import width

_ALL = 64
_WORD = 32
_RING = frozenset({"add", "sub", "mul", "or", "xor", "freeze"})


def demanded_bits(function: WideFunction) -> dict[str, int]:
    """Low bits demanded of each result and parameter; values that nothing reads are missing.

    A backward analysis in the manner of Budiu, Sakr, Walker and Goldstein, "BitValue inference"
    (2000), with low bits only.
    """
    demand: dict[str, int] = {}
    changed = True
    while changed:
        changed = False
        for block in reversed(function.blocks):
            for operand, bits in _demands(block, demand):
                if isinstance(operand, Local) and demand.get(operand.name, 0) < bits:
                    demand[operand.name] = bits
                    changed = True
    return demand


def _demands(block: WideBlock, demand: dict[str, int]) -> Iterator[tuple[Operand, int]]:
    for operand in exit_uses(block.exit):
        yield operand, _ALL
    for op in reversed(block.ops):
        yield from _of_operands(op, demand.get(op.name, 0))
    for phi in block.phis:
        for _, value in phi.incoming:
            yield value, demand.get(phi.name, 0)


def _of_operands(op: Op, bits: int) -> Iterator[tuple[Operand, int]]:
    if op.op == "store":
        yield op.args[0], 8 * op.width
        yield op.args[1], _WORD
    elif op.op == "load":
        yield op.args[0], _WORD
    elif op.op == "select":
        yield op.args[0], 1
        yield from ((arg, bits) for arg in op.args[1:])
    elif op.op in ("trunc", "zext"):
        yield op.args[0], min(bits, width(op.type), width(op.source))
    elif op.op == "and":
        yield from _of_mask(op, bits)
    elif op.op in _RING:
        yield from ((arg, bits) for arg in op.args)
    elif op.op in ("shl", "lshr", "ashr") and isinstance(op.args[1], Int):
        by = op.args[1].value
        yield op.args[0], max(bits - by, 0) if op.op == "shl" else min(bits + by, _ALL)
    else:
        yield from ((arg, _ALL) for arg in op.args)


def _of_mask(op: Op, bits: int) -> Iterator[tuple[Operand, int]]:
    left, right = op.args
    mask = right.value if isinstance(right, Int) and right.value >= 0 else None
    yield left, bits if mask is None else min(bits, mask.bit_length())
    yield right, bits
