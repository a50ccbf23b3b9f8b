"""The DOT form of a DFG: a picture for Graphviz that can also be read back.

The writer puts the complete JSON entry of each node and edge into its attributes, so that what it
writes is read as an equal graph. Foreign DOT is read too, CGRA-ME's and what networkx writes among
it; `vividc.dfg.forms.attributes` says which attributes mean what.
`vividc.dfg.forms.dot_parser` says which subset of the language is understood.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Final

import networkx as nx

from vividc.dfg.forms.attributes import drawn_edge, drawn_node
from vividc.dfg.forms.dot_parser import DotGraph, parse_graph
from vividc.dfg.forms.json_form import SCHEMA, from_json, to_json
from vividc.dfg.ir import DFG, Edge, EdgeKind, Node
from vividc.errors import DFGError, printable, warn
from vividc.machine.opcodes import BASE, PRED, LatencyClass, Opcode

_COLOURS: Final = {
    LatencyClass.SOURCE: "white",
    LatencyClass.SINK: "white",
    LatencyClass.LOAD: "palegreen",
    LatencyClass.STORE: "palegreen",
    LatencyClass.FADD: "lightblue",
    LatencyClass.FMUL: "lightblue",
    LatencyClass.FMA: "lightblue",
    LatencyClass.DOT: "lightblue",
    LatencyClass.CONVERT: "lightblue",
    LatencyClass.SELECT: "khaki",
    LatencyClass.COMPARE: "khaki",
}
_PORT_LABELS: Final = {PRED: "p", BASE: "base"}
_KEY: Final = "vividc"
_SHOWN: Final = 6
_MAX_DIGITS: Final = 18


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
        return from_json(_own(graph, file), file=file, lines=_lines(graph))
    return from_json(_foreign(graph, file), file=file, lines=_lines(graph))


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
    except (ValueError, RecursionError) as error:
        raise DFGError(
            f"the attribute {_KEY} is missing or damaged",
            loc=f"{file}:{line}",
            hint=f"remove {_KEY} from the graph's attributes to read it as a foreign graph",
        ) from error
    return entry


def _foreign(graph: DotGraph, file: str) -> dict[str, object]:
    edges: list[dict[str, object]] = [
        {**drawn_edge(edge.attributes), "src": _identifier(edge.src), "dst": _identifier(edge.dst)}
        for edge in graph.edges
    ]
    nodes: list[dict[str, object]] = [
        {**drawn_node(node.attributes, node.name), "id": _identifier(node.name)}
        for node in graph.nodes
    ]
    if not any("distance" in edge for edge in edges):
        _infer_distances(nodes, edges, file)
    return {"name": graph.name or "dfg", "nodes": nodes, "edges": edges}


def _infer_distances(
    nodes: list[dict[str, object]], edges: list[dict[str, object]], file: str
) -> None:
    """Most of CGRA-ME's files have no distances: a value that a node feeds to itself, or to a phi
    before it, is of the iteration before. Any other cycle is left for the check to refuse.
    """
    phis = {node["id"] for node in nodes if str(node["op"]).lower() == "phi"}
    graph = nx.DiGraph((edge["src"], edge["dst"]) for edge in edges)
    loops = {
        node: n for n, part in enumerate(nx.strongly_connected_components(graph)) for node in part
    }
    carried = [
        edge
        for edge in edges
        if edge["src"] == edge["dst"]
        or (edge["dst"] in phis and loops[edge["src"]] == loops[edge["dst"]])
    ]
    for edge in carried:
        edge["distance"] = 1
    if carried:
        shown = ", ".join(printable(f"{edge['src']} -> {edge['dst']}") for edge in carried[:_SHOWN])
        warn(
            f"{file}: no edge has a distance; 1 iteration is taken for {shown}"
            + (f" and {len(carried) - _SHOWN} more" if len(carried) > _SHOWN else "")
        )


def _lines(graph: DotGraph) -> dict[str, int]:
    nodes = {f"nodes[{index}]": node.line for index, node in enumerate(graph.nodes)}
    return nodes | {f"edges[{index}]": edge.line for index, edge in enumerate(graph.edges)}


def _identifier(name: str) -> int | str:
    small = name.isascii() and name.isdecimal() and len(name) <= _MAX_DIGITS
    return int(name) if small and str(int(name)) == name else name
