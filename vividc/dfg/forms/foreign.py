"""How operations and operands of other tools' dataflow graphs become nodes and edges.

Names are looked up in `vividc.machine.foreign_names`. A constant whose word the file does not give
becomes a `live_in` named after its id: the host supplies it. Memory operations need a PE with a
load/store unit.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count

from vividc.dfg.ir import DFG, Edge, EdgeKind, Node
from vividc.machine.foreign_names import is_known, row_of
from vividc.machine.opcodes import BASE, MEMORY, ORDER, PRED, Opcode
from vividc.machine.words import WORD_MASK, word_of


@dataclass(frozen=True, slots=True)
class ForeignEdge:
    """An edge as a foreign file gives it: `operand` is a port, or None where the file is silent."""

    src: int
    dst: int
    distance: int = 0
    operand: int | None = None
    order: bool = False


@dataclass(frozen=True, slots=True)
class ForeignNode:
    """An operation as a foreign file gives it.

    Attributes
    ----------
    label
        Its id in the file.
    word
        The constant in the file, if any: decimal, hexadecimal or floating point.
    array
        What a memory operation accesses, if the file says so.
    """

    id: int
    op: str
    label: str
    word: str | None = None
    array: str = ""


def foreign_node(found: ForeignNode, *, has_inputs: bool) -> Node:
    """The node for a foreign operation; a "constant" that something feeds is an operation."""
    row = row_of(found.op)
    label = "" if found.label == str(found.id) else found.label
    if row is not None and row.opcode in MEMORY:
        return Node(found.id, row.opcode, name=found.array, width=row.width, label=label)
    if row is None or row.opcode is Opcode.GENERIC or has_inputs:
        return Node(found.id, Opcode.GENERIC, name=found.op, label=label)
    const = None if found.word is None else parse_word(found.word)
    if const is None:
        return Node(found.id, Opcode.LIVE_IN, name=found.label, label=label)
    return Node(found.id, Opcode.CONST, const=const, label=label)


def unknown_operations(dfg: DFG) -> dict[str, tuple[int, ...]]:
    """Nodes of each operation name that the table does not have."""
    unknown: dict[str, list[int]] = {}
    for node in dfg.nodes:
        if node.op is Opcode.GENERIC and not is_known(node.name):
            unknown.setdefault(node.name, []).append(node.id)
    return {name: tuple(nodes) for name, nodes in unknown.items()}


def parse_word(text: str) -> int | None:
    """Word of a number in a foreign file (integers modulo 2**32, floats as binary32), or None."""
    for base in (0, 10):  # 10: a decimal with leading zeros
        try:
            return int(text, base) & WORD_MASK
        except ValueError:
            continue
    try:
        return word_of(float(text))
    except (ValueError, OverflowError):
        return None


def foreign_edges(edges: Sequence[ForeignEdge]) -> tuple[Edge, ...]:
    """Edges with a port each.

    The first edge that names a port has it; one that names none, or a taken one (files describe a
    merge of several definitions so), gets the next free port. Beyond port 2 the ports go on at 5,
    as 3 and 4 are the predicate and the base.
    """
    taken: dict[int, set[int]] = {}
    ports: list[int | None] = []
    for edge in edges:
        used = taken.setdefault(edge.dst, set())
        named = None if edge.order or edge.operand in used else edge.operand
        ports.append(named)
        if named is not None:
            used.add(named)
    free = {node: _free(used) for node, used in taken.items()}
    return tuple(_edge(edge, port, free[edge.dst]) for edge, port in zip(edges, ports, strict=True))


def _free(used: set[int]) -> Iterator[int]:
    """The ports that nobody named, in order."""
    return (port for port in count() if port not in used and port not in (PRED, BASE))


def _edge(edge: ForeignEdge, port: int | None, free: Iterator[int]) -> Edge:
    if edge.order:
        return Edge(edge.src, edge.dst, ORDER, edge.distance, kind=EdgeKind.ORDER)
    if port is None:
        port = next(free)
    return Edge(edge.src, edge.dst, port, edge.distance)
