"""How operations and operands of other tools' dataflow graphs are named here.

A foreign operation name is compared without regard to case:

==================================================================  =======================
load, ld, loadb, loadh, loadw, oload, oloadb, oloadh, oloadw        `load`
store, st, storeb, storeh, storew, ostore, ostoreb, ostoreh, ostorew  `store`
const, constant, cst, imm (without inputs)                          `const`, or `live_in`
anything else                                                       `generic`, named so
==================================================================  =======================

A constant whose word the file does not give becomes a `live_in` named after its id: the host
supplies it. Memory operations need a PE with a load/store unit, `generic` ones run on any PE.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from vividc.dfg.ir import Edge, EdgeKind, Node
from vividc.dfg.opcodes import BASE, ORDER, PRED, Opcode
from vividc.dfg.words import WORD_MASK, word_of

_WIDTHS: Final = ("", "b", "h", "w")
_LOADS: Final = {"ld", *(f"{o}load{w}" for o in ("", "o") for w in _WIDTHS)}
_STORES: Final = {"st", *(f"{o}store{w}" for o in ("", "o") for w in _WIDTHS)}
_CONSTANTS: Final = {"const", "constant", "cst", "imm"}


@dataclass(frozen=True, slots=True)
class ForeignEdge:
    """An edge as a foreign file gives it: `operand` is a port, or None where the file is silent."""

    src: int
    dst: int
    distance: int = 0
    operand: int | None = None
    order: bool = False


def foreign_node(node_id: int, op: str, label: str, word: str | None, *, has_inputs: bool) -> Node:
    """The node for a foreign operation.

    Parameters
    ----------
    label
        Name for a live-in, where a constant's word is unknown: the id in the file.
    word
        The constant in the file, if any: decimal, hexadecimal or floating point.
    has_inputs
        A "constant" that something feeds is an operation.
    """
    key = op.lower()
    if key in _LOADS:
        return Node(node_id, Opcode.LOAD)
    if key in _STORES:
        return Node(node_id, Opcode.STORE)
    if key not in _CONSTANTS or has_inputs:
        return Node(node_id, Opcode.GENERIC, name=op)
    const = None if word is None else parse_word(word)
    if const is None:
        return Node(node_id, Opcode.LIVE_IN, name=label)
    return Node(node_id, Opcode.CONST, const=const)


def parse_word(text: str) -> int | None:
    """Word of a number in a foreign file (integers modulo 2**32, floats as binary32), or None."""
    try:
        return int(text, 0) & WORD_MASK
    except ValueError:
        pass
    try:
        return word_of(float(text))
    except ValueError:
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
    return tuple(
        _edge(edge, port, taken[edge.dst]) for edge, port in zip(edges, ports, strict=True)
    )


def _edge(edge: ForeignEdge, port: int | None, used: set[int]) -> Edge:
    if edge.order:
        return Edge(edge.src, edge.dst, ORDER, edge.distance, kind=EdgeKind.ORDER)
    if port is None:
        port = 0
        while port in used or port in (PRED, BASE):
            port += 1
        used.add(port)
    return Edge(edge.src, edge.dst, port, edge.distance)
