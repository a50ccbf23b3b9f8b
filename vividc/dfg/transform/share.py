"""Common subexpressions of a function: what an operation before has already computed."""

from __future__ import annotations

from dataclasses import replace

import networkx as nx

from vividc.dfg.cfg import Function, Instr, Ref, Value
from vividc.dfg.cfg_edit import map_values, substitute
from vividc.dfg.loops import block_graph
from vividc.dfg.opcodes import MEMORY, Opcode, Type


def share(function: Function) -> Function:
    """Drops each operation on the same operands as one that dominates it; loads stay.

    Dominator-based value numbering (Briggs, Cooper and Simpson 1997, section 4).
    """
    entry = function.blocks[0].name
    children: dict[str, list[str]] = {}
    for name, parent in nx.immediate_dominators(block_graph(function), entry).items():
        if name != entry:
            children.setdefault(parent, []).append(name)
    blocks = {block.name: block for block in function.blocks}
    known: dict[int, Value] = {}

    def resolved(value: Value) -> Value:
        return known.get(value.id, value) if isinstance(value, Ref) else value

    work: list[tuple[str, dict[object, int]]] = [(entry, {})]
    while work:
        name, seen = work.pop()
        seen = dict(seen)
        kept = []
        for instr in map_values(replace(blocks[name], phis=()), resolved).instrs:
            key = _key(instr)
            if key is not None and key in seen:
                known[instr.id] = Ref(seen[key])
                continue
            kept.append(instr)
            if key is not None:
                seen[key] = instr.id
        blocks[name] = replace(blocks[name], instrs=tuple(kept))
        work += [(child, seen) for child in children.get(name, ())]
    if not known:
        return function
    changed = tuple(blocks[block.name] for block in function.blocks)
    return substitute(replace(function, blocks=changed), known)


def _key(instr: Instr) -> tuple[Opcode, Type, tuple[Value, ...], bool] | None:
    """Equal for operations with equal results; `exact` ones are not mixed with others."""
    if instr.op in MEMORY:
        return None
    return instr.op, instr.type, instr.operands, instr.exact
