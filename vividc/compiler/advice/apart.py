"""A kernel that reads an array from another one than it writes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from vividc.dfg.ir import DFG, Edge, EdgeKind, Node
from vividc.dfg.regions import Kernel
from vividc.machine.opcodes import BASE, Opcode
from vividc.ssa.ir import Block, Function, Input, Instr

_COPY = ".read"
"""After an array's name: no parameter has such a name."""


def reading_apart(function: Function, array: str) -> Function:
    """The function with its loads of a parameter from another one, of the same shape."""
    name = f"{array}{_COPY}"
    [param] = [param for param in function.params if param.name == array]
    params = (*function.params, replace(param, name=name))

    def block(old: Block) -> Block:
        return replace(old, instrs=tuple(_read_from(i, array, name) for i in old.instrs))

    return replace(function, params=params, blocks=tuple(map(block, function.blocks)))


def _read_from(instr: Instr, array: str, name: str) -> Instr:
    if instr.op is not Opcode.LOAD or instr.array != array:
        return instr
    base = Input(f"&{name}") if instr.operands[0] == Input(f"&{array}") else instr.operands[0]
    return replace(instr, array=name, operands=(base, *instr.operands[1:]))


def separable(function: Function, kernel: Kernel) -> Iterator[tuple[str, Node]]:
    """Parameters that one loop alone reads and writes, at places that nothing proves to meet, each
    with a load that waits for stores.

    Parameters
    ----------
    kernel
        The function's regions, optimised: equal indices are one node.
    """
    for param in function.params:
        users = [r for r in kernel.regions if any(n.name == param.name for n in _memory(r.dfg))]
        if len(users) != 1 or users[0].kind != "loop":
            continue
        dfg = users[0].dfg
        between = [edge for edge in dfg.edges if _is_read_and_write(dfg, edge, param.name)]
        if not between or not all(edge.assumed for edge in between) or _updates(dfg, param.name):
            continue
        ends = (dfg.by_id[end] for edge in between for end in (edge.src, edge.dst))
        yield param.name, next(node for node in ends if node.op is Opcode.LOAD)


def _memory(dfg: DFG) -> Iterator[Node]:
    return (node for node in dfg.nodes if node.is_memory)


def _is_read_and_write(dfg: DFG, edge: Edge, array: str) -> bool:
    if edge.kind is not EdgeKind.ORDER:
        return False
    ends = [dfg.by_id[edge.src], dfg.by_id[edge.dst]]
    return all(end.name == array for end in ends) and ends[0].op is not ends[1].op


def _updates(dfg: DFG, array: str) -> bool:
    """Whether some store goes to where a load came from, as of a histogram: it would have to be
    read again.
    """
    places: dict[Opcode, set[tuple[object, ...]]] = {Opcode.LOAD: set(), Opcode.STORE: set()}
    for node in _memory(dfg):
        if node.name == array:
            sources = {e.port: e.src for e in dfg.in_edges[node.id] if e.is_data}
            places[node.op].add((sources.get(0), sources.get(BASE), node.shift, node.offset))
    return not places[Opcode.LOAD].isdisjoint(places[Opcode.STORE])
