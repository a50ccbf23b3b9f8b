"""Moves loop-invariant operations in front of the loop."""

from __future__ import annotations

from dataclasses import replace

import networkx as nx

from vividc.machine.opcodes import MEMORY
from vividc.ssa.edit import defined_types
from vividc.ssa.flow import Loop, block_graph, find_loops
from vividc.ssa.ir import Function, Instr, Ref


def hoist_invariants(function: Function) -> Function:
    """Hoist loop-invariant operations into preheaders, out of as many loops as possible.

    Every operation but an access to memory may run speculatively. Accesses stay: the loop may not
    run at all, or may store to the same place. Loops without a preheader of their own are left
    alone.
    """
    graph = block_graph(function)
    order = list(reversed(list(nx.dfs_postorder_nodes(graph, function.blocks[0].name))))
    instrs = {block.name: list(block.instrs) for block in function.blocks}
    home = {ident: block.name for block in function.blocks for ident in defined_types(block)}
    moved = False
    for loop in find_loops(function):  # inner loops first: an operation leaves them first
        preheader = _preheader(graph, loop)
        if preheader is None:
            continue
        for name in order:
            if name in loop.blocks:
                moved |= _hoist_block(instrs, home, name, preheader, loop.blocks)
    if not moved:
        return function
    blocks = tuple(replace(b, instrs=tuple(instrs[b.name])) for b in function.blocks)
    return replace(function, blocks=blocks)


def _preheader(graph: nx.DiGraph[str], loop: Loop) -> str | None:
    outside: list[str] = [
        pred for pred in graph.predecessors(loop.header) if pred not in loop.blocks
    ]
    if len(outside) != 1 or graph.out_degree(outside[0]) != 1:
        return None
    return outside[0]


def _hoist_block(
    instrs: dict[str, list[Instr]],
    home: dict[int, str],
    name: str,
    preheader: str,
    body: frozenset[str],
) -> bool:
    kept = []
    for instr in instrs[name]:
        if instr.op in MEMORY or any(_inside(v, home, body) for v in instr.operands):
            kept.append(instr)
            continue
        instrs[preheader].append(instr)
        home[instr.id] = preheader
    moved = len(kept) < len(instrs[name])
    instrs[name] = kept
    return moved


def _inside(value: object, home: dict[int, str], body: frozenset[str]) -> bool:
    return isinstance(value, Ref) and home[value.id] in body
