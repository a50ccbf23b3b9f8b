"""Common subexpressions of a function: one instruction for each value that dominates its uses."""

from __future__ import annotations

from dataclasses import replace

import networkx as nx

from vividc.machine.opcodes import MEMORY, OPCODES, Opcode
from vividc.ssa.edit import substitute
from vividc.ssa.flow import block_graph, dominators
from vividc.ssa.ir import Function, Instr, Ref, Value

_Key = tuple[Opcode, tuple[Value, ...]]


def number_values(function: Function) -> Function:
    """Merges operations, accesses to memory aside, that have equal operands and where one is
    computed on every path to the other.

    Two additions of which one is proved not to wrap count as that one's equal only if the proof
    holds for the one that stays.
    """
    graph = block_graph(function)
    entry = function.blocks[0].name
    dominating = dominators(graph, entry)
    by_name = {block.name: block for block in function.blocks}
    known: dict[int, Value] = {}
    first: dict[_Key, list[tuple[str, Instr]]] = {}
    for name in reversed(list(nx.dfs_postorder_nodes(graph, entry))):
        for instr in by_name[name].instrs:
            if instr.op in MEMORY:
                continue
            key = _key(instr, known)
            candidates = first.setdefault(key, [])
            kept = next((i for home, i in candidates if home in dominating[name]), None)
            if kept is not None and (kept.exact or not instr.exact):
                known[instr.id] = Ref(kept.id)
            else:
                candidates.insert(0, (name, instr))
    if not known:
        return function
    blocks = tuple(
        replace(block, instrs=tuple(i for i in block.instrs if i.id not in known))
        for block in function.blocks
    )
    return substitute(replace(function, blocks=blocks), known)


def _key(instr: Instr, known: dict[int, Value]) -> _Key:
    operands = [known.get(v.id, v) if isinstance(v, Ref) else v for v in instr.operands]
    if OPCODES[instr.opcode].commutes:
        operands[:2] = sorted(operands[:2], key=repr)
    return instr.opcode, tuple(operands)
