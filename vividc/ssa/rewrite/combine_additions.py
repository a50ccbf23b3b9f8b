"""Combines consecutive additions of constants: counters of unrolled iterations stay one addition
from the loop's phi.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import networkx as nx

from vividc.machine.opcodes import Opcode
from vividc.machine.words import signed
from vividc.ssa.flow import block_graph
from vividc.ssa.ir import Block, Const, Function, Instr, Ref, Value

_LIMIT = 1 << 31


@dataclass(frozen=True, slots=True)
class _Sum:
    """base + constant; `exact` as for an instruction."""

    base: Value
    constant: int
    exact: bool


def combine_additions(function: Function) -> Function:
    """`(x + a) + b` becomes `x + (a + b)`, proved not to wrap if both were."""
    graph = block_graph(function)
    by_name = {block.name: block for block in function.blocks}
    known: dict[int, _Sum] = {}
    changed: dict[str, Block] = {}
    for name in reversed(list(nx.dfs_postorder_nodes(graph, function.blocks[0].name))):
        block = by_name[name]
        instrs = tuple(_combined(instr, known) for instr in block.instrs)
        if instrs != block.instrs:
            changed[name] = replace(block, instrs=instrs)
    if not changed:
        return function
    blocks = tuple(changed.get(block.name, block) for block in function.blocks)
    return replace(function, blocks=blocks)


def _combined(instr: Instr, known: dict[int, _Sum]) -> Instr:
    own = _sum(instr)
    if own is None:
        return instr
    inner = known.get(own.base.id) if isinstance(own.base, Ref) else None
    if inner is not None:
        total = inner.constant + own.constant
        exact = inner.exact and own.exact and -_LIMIT <= total < _LIMIT
        own = _Sum(inner.base, signed(total), exact)
        operands = (own.base, Const(own.constant & 0xFFFFFFFF))
        instr = replace(instr, op=Opcode.ADD, operands=operands, exact=exact)
    known[instr.id] = own
    return instr


def _sum(instr: Instr) -> _Sum | None:
    if instr.op not in (Opcode.ADD, Opcode.SUB):
        return None
    left, right = instr.operands
    if isinstance(right, Const) and right.word != _LIMIT:
        word = signed(right.word)
        return _Sum(left, word if instr.op is Opcode.ADD else -word, instr.exact)
    if instr.op is Opcode.ADD and isinstance(left, Const) and left.word != _LIMIT:
        return _Sum(right, signed(left.word), instr.exact)
    return None
