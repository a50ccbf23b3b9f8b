"""DFGs as networkx graphs and back."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from numbers import Real
from operator import index
from typing import Final

import networkx as nx

from vividc.dfg.check import check
from vividc.dfg.forms.attributes import drawn_edge, drawn_node
from vividc.dfg.forms.json_fields import raise_problems
from vividc.dfg.forms.json_form import SCHEMA, from_json, to_json
from vividc.dfg.ir import DFG
from vividc.errors import DFGError, demand_type

_OWN_EDGE_ENDS: Final = ("src", "dst")


def to_networkx(dfg: DFG) -> nx.MultiDiGraph:
    """A `MultiDiGraph` that `from_networkx` reads back as an equal graph.

    Nodes are the node ids; node and edge attributes are those of the JSON form, an edge's key is
    its number in `dfg.edges`. The graph's attribute ``schema`` says that operations are our own.
    """
    form = to_json(dfg)
    graph = nx.MultiDiGraph(name=dfg.name, schema=SCHEMA)
    nodes, edges = form["nodes"], form["edges"]
    assert isinstance(nodes, list)
    assert isinstance(edges, list)
    for entry in nodes:
        graph.add_node(entry["id"], **{key: entry[key] for key in entry if key != "id"})
    for number, entry in enumerate(edges):
        rest = {key: entry[key] for key in entry if key not in _OWN_EDGE_ENDS}
        graph.add_edge(entry["src"], entry["dst"], key=number, **rest)
    return graph


def from_networkx(graph: nx.DiGraph) -> DFG:
    """The DFG that a directed networkx graph describes.

    Parameters
    ----------
    graph
        A `MultiDiGraph` or `DiGraph`. Written by `to_networkx`, or foreign: nodes are anything
        hashable, with an attribute ``op`` (or ``opcode``, ``operation``, ``label``) and perhaps
        ``const``; edges may have ``distance`` (or ``dist``), ``operand`` (or ``port``) and
        ``kind``. Names of operations, operands and other attributes are read as in files.

    Raises
    ------
    DFGError
        The graph is undirected or empty, an attribute has a wrong type, or the graph breaks an
        invariant of `check`; all problems are listed.
    """
    hint = "build a networkx.MultiDiGraph"
    demand_type(graph, nx.Graph, "the graph", hint)
    if not graph.is_directed():
        raise DFGError("the networkx graph is undirected", loc="networkx", hint=hint)
    name = str(graph.graph.get("name") or "dfg")
    place = f"networkx graph {name!r}"
    if graph.number_of_nodes() == 0:
        raise DFGError("the graph has no nodes", loc=place, hint="there is nothing to map")
    own = graph.graph.get("schema") == SCHEMA
    data = _own(graph, name) if own else _foreign(graph, name)
    dfg = from_json(data, file=place)
    raise_problems(place, check(dfg))
    return dfg


def _own(graph: nx.DiGraph, name: str) -> dict[str, object]:
    edges = graph.edges(keys=True, data=True) if graph.is_multigraph() else ()
    ordered = sorted(edges, key=lambda edge: _edge_number(edge[2]))
    return {
        "schema": SCHEMA,
        "name": name,
        "nodes": [{"id": _plain(node), **_plain_all(of)} for node, of in graph.nodes(data=True)],
        "edges": [
            {"src": _plain(src), "dst": _plain(dst), **_plain_all(of)}
            for src, dst, _, of in ordered
        ],
    }


def _edge_number(key: object) -> float:
    return key if isinstance(key, int) else math.inf


def _foreign(graph: nx.DiGraph, name: str) -> dict[str, object]:
    numbers = _identifiers(list(graph.nodes))
    nodes: list[dict[str, object]] = []
    for node, attributes in graph.nodes(data=True):
        entry = drawn_node(_given(attributes), str(node))
        nodes.append({**entry, "id": numbers[node]})
    edges = [
        {**drawn_edge(_given(attributes)), "src": numbers[src], "dst": numbers[dst]}
        for src, dst, attributes in graph.edges(data=True)
    ]
    return {"name": name, "nodes": nodes, "edges": edges}


def _identifiers(nodes: list[Hashable]) -> dict[Hashable, int]:
    """The nodes' own numbers where all are such, else their places."""
    plain = [_plain(node) for node in nodes]
    whole = [n for n in plain if isinstance(n, int) and not isinstance(n, bool) and n >= 0]
    if len(whole) == len(nodes):
        return dict(zip(nodes, whole, strict=True))
    return {node: number for number, node in enumerate(nodes)}


def _given(attributes: Mapping[object, object]) -> dict[str, object]:
    """Attributes that are set: networkx has None for others."""
    return {key: value for key, value in _plain_all(attributes).items() if value is not None}


def _plain_all(attributes: Mapping[object, object]) -> dict[str, object]:
    return {str(key): _plain(value) for key, value in attributes.items()}


def _plain(value: object) -> object:
    """numpy's numbers and the like as Python's; everything else as it is."""
    if isinstance(value, bool | str):
        return value
    try:
        return index(value)  # type: ignore[arg-type]  # what has no index raises
    except TypeError:
        return float(value) if isinstance(value, Real) else value
