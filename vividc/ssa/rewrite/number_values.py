"""Common subexpressions of a function: one instruction per value, in its block or in all blocks
that it dominates.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import networkx as nx

from vividc.machine.opcodes import MEMORY, OPCODES, Opcode
from vividc.ssa.edit import replaced
from vividc.ssa.flow import block_graph, dominators
from vividc.ssa.ir import Block, Function, Instr, Kind, Ref, Value

_Key = tuple[Opcode, Kind, tuple[Value, ...]]


def number_values(function: Function) -> Function:
    """Merges operations, accesses to memory aside, that have equal operands and where one is
    computed on every path to the other.

    Two additions of which one is proved not to wrap count as that one's equal only if the proof
    holds for the one that stays.
    """
    dominating = dominators(function)
    by_name = {block.name: block for block in function.blocks}
    order = nx.dfs_postorder_nodes(block_graph(function), function.blocks[0].name)
    blocks = [by_name[name] for name in reversed(list(order))]
    return _merged(function, blocks, lambda home, name: home in dominating[name])


def merge_equal(function: Function) -> Function:
    """The same within each block: what narrowing wrote twice, and hoisting brought together.

    Operations of different blocks stay apart: a word that lives from block to block costs more than
    an operation.
    """
    return _merged(function, function.blocks, lambda home, name: home == name)


def _merged(
    function: Function, blocks: Iterable[Block], serves: Callable[[str, str], bool]
) -> Function:
    """`serves`: whether an operation of the first block may stand for one of the second."""
    known: dict[int, Value] = {}
    first: dict[_Key, list[tuple[str, Instr]]] = {}
    for block in blocks:
        for instr in block.instrs:
            if instr.op in MEMORY:
                continue
            candidates = first.setdefault(_key(instr, known), [])
            kept = next((i for home, i in candidates if serves(home, block.name)), None)
            if kept is not None and (kept.exact or not instr.exact):
                known[instr.id] = Ref(kept.id)
            else:
                candidates.insert(0, (block.name, instr))
    return replaced(function, known)


def _key(instr: Instr, known: dict[int, Value]) -> _Key:
    operands = [known.get(v.id, v) if isinstance(v, Ref) else v for v in instr.operands]
    if OPCODES[instr.opcode].commutes:
        operands[:2] = sorted(operands[:2], key=_order)
    return instr.opcode, instr.type, tuple(operands)


def _order(value: Value) -> tuple[int, str]:
    """Operands that may be swapped come in this order."""
    return (value.id, "") if isinstance(value, Ref) else (-1, repr(value))
