"""The DOT form of a DFG: a picture for Graphviz that can also be read back.

The writer puts the complete JSON entry of each node and edge into its attributes, so that what it
writes is read as an equal graph. Foreign DOT is read too: a node's operation is its ``opcode``,
``op`` or ``operation`` attribute, else the first word of its label, else its name without trailing
digits; an edge may have ``distance`` (or ``dist``), ``operand`` (or ``port``) and ``kind``.
`vividc.dfg.dot_parser` says which subset of the language is understood.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Final

from vividc.dfg.dot_parser import DotEdge, DotGraph, DotNode, parse_graph
from vividc.dfg.ir import DFG, Edge, EdgeKind, Node
from vividc.dfg.json_form import SCHEMA, from_json, to_json
from vividc.dfg.opcodes import BASE, PRED, LatencyClass, Opcode
from vividc.errors import DFGError

_COLOURS: Final = {
    LatencyClass.SOURCE: "white",
    LatencyClass.SINK: "white",
    LatencyClass.LOAD: "palegreen",
    LatencyClass.STORE: "palegreen",
    LatencyClass.FADD: "lightblue",
    LatencyClass.FMUL: "lightblue",
    LatencyClass.FMA: "lightblue",
    LatencyClass.CONVERT: "lightblue",
    LatencyClass.SELECT: "khaki",
    LatencyClass.COMPARE: "khaki",
}
_OPERATION_KEYS: Final = ("opcode", "op", "operation")
_CONST_KEYS: Final = ("const", "constant", "value")
_DISTANCE_KEYS: Final = ("distance", "dist")
_OPERAND_KEYS: Final = ("operand", "port")
_PORT_LABELS: Final = {PRED: "p", BASE: "base"}
_KEY: Final = "vividc"


def to_dot(dfg: DFG) -> str:
    """The DOT text of `dfg`: colours by class, recurrences dashed with their distance."""
    form = to_json(dfg)
    nodes, edges = form["nodes"], form["edges"]
    assert isinstance(nodes, list)
    assert isinstance(edges, list)
    lines = [f"digraph {_quoted(dfg.name)} {{", f"  {_KEY}={_quoted(SCHEMA)};"]
    lines.append("  node [shape=box, style=filled, fillcolor=lightgrey];")
    for node, entry in zip(dfg.nodes, nodes, strict=True):
        lines.append(f"  {node.id} [{_attributes(_node_style(node), entry)}];")
    for edge, entry in zip(dfg.edges, edges, strict=True):
        lines.append(f"  {edge.src} -> {edge.dst} [{_attributes(_edge_style(edge), entry)}];")
    return "\n".join([*lines, "}"]) + "\n"


def parse_dot(text: str, file: str = "<dot>") -> DFG:
    """The graph in DOT text, written by `to_dot` or foreign.

    Raises
    ------
    DFGError
        The text is outside the subset that is understood (the line is named), or is no DFG.
    """
    graph = parse_graph(text, file)
    if _KEY in graph.attributes:
        return from_json(_own(graph, file), file=file)
    return from_json(_foreign(graph), file=file)


def _node_style(node: Node) -> dict[str, str]:
    label = f"{node.id}: {node.op.value}"
    if node.const is not None:
        label += f" {node.const:#x}"
    if node.name:
        label += f" {node.name}"
    style = {"label": label}
    colour = _COLOURS.get(node.latency_class)
    if colour is not None:
        style["fillcolor"] = colour
    if node.is_source or node.op is Opcode.LIVE_OUT:
        style["shape"] = "ellipse"
    if node.control is not None:
        style |= {"label": f"{label}\n({node.control.value})", "peripheries": "2"}
    if node.loc is not None:
        style["tooltip"] = str(node.loc)
    return style


def _edge_style(edge: Edge) -> dict[str, str]:
    style: dict[str, str] = {}
    if edge.is_data:
        style["taillabel" if edge.distance else "label"] = _PORT_LABELS.get(
            edge.port, str(edge.port)
        )
    if edge.distance:
        style |= {"style": "dashed", "label": str(edge.distance), "constraint": "false"}
    if edge.kind is not EdgeKind.DATA:
        style |= {"color": "red" if edge.kind is EdgeKind.CONTROL else "grey"}
    return style


def _attributes(style: Mapping[str, str], entry: object) -> str:
    pairs = {**style, _KEY: json.dumps(entry)}
    return ", ".join(f"{key}={_quoted(value)}" for key, value in pairs.items())


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'


def _own(graph: DotGraph, file: str) -> dict[str, object]:
    nodes = [_entry(node.attributes, node.line, file) for node in graph.nodes]
    edges = [_entry(edge.attributes, edge.line, file) for edge in graph.edges]
    schema = graph.attributes[_KEY]
    return {"schema": schema, "name": graph.name, "nodes": nodes, "edges": edges}


def _entry(attributes: Mapping[str, str], line: int, file: str) -> object:
    text = attributes.get(_KEY)
    try:
        entry: object = json.loads(text or "")
    except json.JSONDecodeError as error:
        raise DFGError(
            f"the attribute {_KEY} is missing or damaged",
            loc=f"{file}:{line}",
            hint=f"remove {_KEY} from the graph's attributes to read it as a foreign graph",
        ) from error
    return entry


def _foreign(graph: DotGraph) -> dict[str, object]:
    return {
        "name": graph.name or "dfg",
        "nodes": [_foreign_node(node) for node in graph.nodes],
        "edges": [_foreign_edge(edge) for edge in graph.edges],
    }


def _foreign_node(node: DotNode) -> dict[str, object]:
    entry: dict[str, object] = {"id": _identifier(node.name), "op": _operation(node)}
    const = _first(node.attributes, _CONST_KEYS)
    return entry if const is None else {**entry, "const": const}


def _operation(node: DotNode) -> str:
    given = _first(node.attributes, _OPERATION_KEYS)
    if given:
        return given
    words = re.findall(r"[A-Za-z_][\w.]*", node.attributes.get("label", ""))
    if words:
        return str(words[0])
    return node.name.rstrip("0123456789").rstrip("_.") or "node"


def _foreign_edge(edge: DotEdge) -> dict[str, object]:
    entry: dict[str, object] = {"src": _identifier(edge.src), "dst": _identifier(edge.dst)}
    distance = _first(edge.attributes, _DISTANCE_KEYS)
    operand = _first(edge.attributes, _OPERAND_KEYS)
    if distance is not None:
        entry["distance"] = _number(distance)
    if operand is not None:
        entry["operand"] = _number(operand)
    if "kind" in edge.attributes:
        entry["kind"] = edge.attributes["kind"]
    return entry


def _first(attributes: Mapping[str, str], keys: tuple[str, ...]) -> str | None:
    return next((attributes[key] for key in keys if key in attributes), None)


def _identifier(name: str) -> int | str:
    return int(name) if name.isdecimal() and str(int(name)) == name else name


def _number(text: str) -> int | str:
    """The integer, or the text for the JSON reader to judge."""
    return int(text) if re.fullmatch(r"-?[0-9]+", text) else text
