"""The text form of a DFG: complete, readable, and read back to an equal graph.

One node a line, with the edges that enter it; full lines that start with ``#`` are comments::

    dfg "dot"
    %0 = const 0x00000000
    %1 = live_in "&x"
    %2 = iv
    %3 = load "x" %2 shift 2 base %1 !dot.py:4
    %4 = fma %3, %3, %4@1(init=%0) if %7 !dot.py:4
    %5 = live_out "%s" %4 control %8 unless_exit
    %6 = store "y" %2, %4 shift 2 base %1 after %3, %6@1

``%4@1(init=%0)`` is the word of node 4 one iteration ago, of node 0 in the first. Operands fill
ports 0, 1, ...; ``5: %3`` names another port. An access of less than a word says ``width 1`` or
``width 2``, and ``signed`` if it sign-extends. ``if`` is the predicate, ``after`` lists ORDER
edges, ``control`` CONTROL edges, and ``exit``, ``branch``, ``trip`` and ``unless_exit`` are the
marks of the node. A last line ``edges 2 0 1`` gives the creation order of the edges where it is not
the order of the text.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Final

from vividc.dfg.forms.text_parser import parse
from vividc.dfg.ir import DFG, Edge, EdgeKind, Node
from vividc.machine.opcodes import BASE, PRED
from vividc.machine.text_line import location_text
from vividc.machine.words import WORD_BYTES

__all__ = ["parse", "to_text"]

_KIND_RANK: Final = {EdgeKind.DATA: 0, EdgeKind.ORDER: 1, EdgeKind.CONTROL: 2}
_PORT_RANK: Final = {PRED: 1, BASE: 2}


def to_text(dfg: DFG) -> str:
    """The text form of `dfg`, one line a node, with a final newline."""
    order = _text_order(dfg)
    into: dict[int, list[Edge]] = {node.id: [] for node in dfg.nodes}
    for index in order:
        into.setdefault(dfg.edges[index].dst, []).append(dfg.edges[index])
    lines = [f"dfg {json.dumps(dfg.name)}"]
    lines.extend(_node_text(node, into[node.id]) for node in dfg.nodes)
    if order != sorted(order):
        place = {index: place for place, index in enumerate(order)}
        lines.append("edges " + " ".join(str(place[index]) for index in range(len(order))))
    return "\n".join(lines) + "\n"


def _text_order(dfg: DFG) -> list[int]:
    """Indices of the edges in the order of the text: by destination, kind, and port."""
    position = {node.id: index for index, node in enumerate(dfg.nodes)}

    def key(index: int) -> tuple[int, ...]:
        edge = dfg.edges[index]
        at = position.get(edge.dst, len(position))
        kind = _KIND_RANK[edge.kind]
        return at, kind, _PORT_RANK.get(edge.port, 0), edge.port if edge.is_data else 0, index

    return sorted(range(len(dfg.edges)), key=key)


def _node_text(node: Node, edges: Iterable[Edge]) -> str:
    edges = list(edges)
    data = [edge for edge in edges if edge.is_data]
    parts = [f"%{node.id} = {node.op.value}"]
    if node.name:
        parts.append(json.dumps(node.name))
    if node.const is not None:
        parts.append(f"{node.const:#010x}")
    operands = _operands_text([edge for edge in data if edge.port not in _PORT_RANK])
    if operands:
        parts.append(operands)
    parts.extend(_address_text(node))
    clauses = (
        ("if", [edge for edge in data if edge.port == PRED]),
        ("base", [edge for edge in data if edge.port == BASE]),
        ("after", [edge for edge in edges if edge.kind is EdgeKind.ORDER]),
        ("control", [edge for edge in edges if edge.kind is EdgeKind.CONTROL]),
    )
    parts.extend(f"{word} {', '.join(map(_edge_text, of))}" for word, of in clauses if of)
    if node.control is not None:
        parts.append(node.control.value)
    if node.unless_exit:
        parts.append("unless_exit")
    if node.loc is not None:
        parts.append(location_text(node.loc))
    return " ".join(parts)


def _operands_text(edges: list[Edge]) -> str:
    texts: list[str] = []
    expected = 0
    for edge in edges:
        texts.append(
            _edge_text(edge) if edge.port == expected else f"{edge.port}: {_edge_text(edge)}"
        )
        expected = edge.port + 1
    return ", ".join(texts)


def _address_text(node: Node) -> Iterable[str]:
    if node.shift:
        yield f"shift {node.shift}"
    if node.offset:
        yield f"offset {node.offset}"
    if node.width != WORD_BYTES:
        yield f"width {node.width}"
    if node.signed:
        yield "signed"


def _edge_text(edge: Edge) -> str:
    if edge.init is not None:
        return f"%{edge.src}@{edge.distance}(init=%{edge.init})"
    return f"%{edge.src}@{edge.distance}" if edge.distance else f"%{edge.src}"
