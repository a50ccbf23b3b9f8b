"""The JSON form of a DFG, and the reading of foreign graphs in the same shape.

``{"name", "nodes": [{"id", "op"}], "edges": [{"src", "dst", "distance", "operand"?, "kind"?}]}``

With ``"schema": "vividc.dfg/1"`` the operations are our own (`Opcode` values) and the graph is
complete: nodes also have ``const``, ``name``, ``shift``, ``offset``, ``width``, ``signed``,
``control``, ``unless_exit``, ``loc`` and ``label``, edges ``init``. Without it the graph is foreign
and its names are read as `vividc.dfg.forms.foreign` and `vividc.dfg.forms.attributes` say; ids may
be strings, which are numbered in file order; nodes may have ``const``, ``label`` and ``array``.
``operand`` is a port number, ``"pred"`` or ``"base"``; ``kind`` is ``"data"``, ``"order"`` or
``"control"``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from vividc.dfg.forms.attributes import edge_entry, node_entry
from vividc.dfg.forms.foreign_json import (
    foreign_graph,
    shown_id,
    warn_of_shared_ids,
    warn_of_unknown_keys,
)
from vividc.dfg.forms.json_fields import Fields, Problems, fields_of, parse_loc, raise_problems
from vividc.dfg.ir import DFG, Control, Edge, EdgeKind, Node
from vividc.errors import DFGError, quoted
from vividc.machine.opcodes import BASE, ORDER, PRED, Opcode
from vividc.machine.words import WORD_BYTES

SCHEMA: Final = "vividc.dfg/1"
_PORT_NAMES: Final = {"pred": PRED, "base": BASE}
_NODE_KEYS: Final = frozenset(
    {"id", "op", "const", "name", "shift", "offset", "width", "signed"}
    | {"control", "unless_exit", "loc", "label"}
)
_EDGE_KEYS: Final = frozenset({"src", "dst", "distance", "operand", "kind", "init"})


def to_json(dfg: DFG) -> dict[str, object]:
    """The complete JSON object of `dfg`; `from_json` gives an equal graph."""
    return {
        "schema": SCHEMA,
        "name": dfg.name,
        "nodes": [_node_to_json(node) for node in dfg.nodes],
        "edges": [_edge_to_json(edge) for edge in dfg.edges],
    }


def from_json(data: object, *, file: str = "<json>", lines: Mapping[str, int] | None = None) -> DFG:
    """The graph in a JSON object.

    Parameters
    ----------
    data
        What `json.loads` returned.
    file
        Named in errors.
    lines
        Line in the file of each "nodes[i]" and "edges[i]", for errors.

    Raises
    ------
    DFGError
        A key is missing or has the wrong type, an id is used twice or not at all, a distance is
        negative, two edges feed one operand, or our own form has a key or operation that is
        unknown. All problems are reported at once.

    Warns
    -----
    VividcWarning
        A graph with a `source` (a published one) uses an id for two operations: they become one.
        Nodes or edges of a foreign graph have keys that mean nothing.
    """
    if not isinstance(data, dict):
        raise DFGError(f"expected an object with nodes and edges, not {_kind(data)}", loc=file)
    problems = Problems()
    top = Fields(data, "", problems)
    name = top.text("name", file)
    nodes = fields_of(data, "nodes", problems)
    edges = fields_of(data, "edges", problems)
    schema = data.get("schema")
    own = schema == SCHEMA
    if not own:
        nodes = [replace(fields, data=node_entry(fields.data)) for fields in nodes]
        edges = [replace(fields, data=edge_entry(fields.data)) for fields in edges]
    numbers = _numbers(nodes, problems, repeated=_is_published(data))
    if schema not in (None, SCHEMA):
        problems.append(f'schema {quoted(schema)} is unknown; it is "{SCHEMA}" or absent')
    raise_problems(file, problems, lines)
    if own:
        dfg = _own(name, nodes, edges, numbers)
    else:
        dfg = foreign_graph(name, nodes, edges, numbers, merges=_is_published(data))
    raise_problems(file, problems, lines)
    if not own:
        warn_of_shared_ids(file, nodes)
        warn_of_unknown_keys(file, nodes, edges, {} if lines is None else lines)
    return dfg


def original_ids(data: Mapping[str, object]) -> dict[int, int | str]:
    """Id in the file of each node id that `from_json` gave."""
    numbers = _numbers(fields_of(data, "nodes", []), [], repeated=True)
    return {number: node_id for node_id, number in numbers.items()}


def _node_to_json(node: Node) -> dict[str, object]:
    entry: dict[str, object] = {"id": node.id, "op": node.op.value}
    optional: dict[str, object] = {
        "const": node.const,
        "name": node.name or None,
        "shift": node.shift or None,
        "offset": node.offset or None,
        "width": node.width if node.width != WORD_BYTES else None,
        "signed": node.signed or None,
        "control": node.control.value if node.control is not None else None,
        "unless_exit": node.unless_exit or None,
        "loc": str(node.loc) if node.loc is not None else None,
        "label": node.label or None,
    }
    return entry | {key: value for key, value in optional.items() if value is not None}


def _edge_to_json(edge: Edge) -> dict[str, object]:
    entry: dict[str, object] = {"src": edge.src, "dst": edge.dst, "distance": edge.distance}
    if edge.is_data:
        names = {port: name for name, port in _PORT_NAMES.items()}
        entry["operand"] = names.get(edge.port, edge.port)
    else:
        entry["kind"] = edge.kind.value
    if edge.init is not None:
        entry["init"] = edge.init
    return entry


def _is_published(data: Mapping[str, object]) -> bool:
    """A graph converted from another tool's collection: those files use some ids twice."""
    return "schema" not in data and isinstance(data.get("source"), str)


def _numbers(nodes: list[Fields], problems: list[str], *, repeated: bool) -> dict[int | str, int]:
    """Number of each id in the file: the id itself if all are integers, else its place."""
    ids = [node.identifier("id") for node in nodes]
    seen: dict[int | str, Fields] = {}
    for node, node_id in zip(nodes, ids, strict=True):
        if node_id is None:
            continue
        first = seen.setdefault(node_id, node)
        same_op = first.data.get("op") == node.data.get("op")
        if first is not node and (same_op or not repeated):
            node.problem(f"two nodes have id {shown_id(node_id)}: the other is {first.place}")
    integers = all(isinstance(node_id, int) for node_id in ids)
    numbers: dict[int | str, int] = {}
    for place, node_id in enumerate(ids):
        if node_id is not None:
            numbers.setdefault(node_id, node_id if integers and isinstance(node_id, int) else place)
    return numbers


def _own(
    name: str, nodes: list[Fields], edges: list[Fields], numbers: Mapping[int | str, int]
) -> DFG:
    return DFG(
        name,
        tuple(_own_node(fields, numbers) for fields in nodes),
        tuple(_own_edge(fields, numbers) for fields in edges),
    )


def _own_node(fields: Fields, numbers: Mapping[int | str, int]) -> Node:
    fields.only(_NODE_KEYS)
    marks: dict[str, Control | None] = {mark.value: mark for mark in Control}
    loc = fields.text("loc", "")
    if "op" not in fields.data:
        fields.problem("op is missing")
    return Node(
        id=fields.reference("id", numbers),
        op=fields.choice("op", {op.value: op for op in Opcode}, Opcode.GENERIC),
        const=fields.integer("const", 0) if "const" in fields.data else None,
        name=fields.text("name", ""),
        shift=fields.integer("shift", 0),
        offset=fields.integer("offset", 0),
        width=fields.integer("width", WORD_BYTES),
        signed=fields.flag("signed"),
        control=fields.choice("control", marks, None),
        unless_exit=fields.flag("unless_exit"),
        loc=parse_loc(loc) if loc else None,
        label=fields.text("label", ""),
    )


def _own_edge(fields: Fields, numbers: Mapping[int | str, int]) -> Edge:
    fields.only(_EDGE_KEYS)
    kind = _edge_kind(fields)
    port = fields.port("operand", _PORT_NAMES)
    if port is None and kind is EdgeKind.DATA:
        fields.problem("operand is missing")
    return Edge(
        src=fields.reference("src", numbers),
        dst=fields.reference("dst", numbers),
        port=port if port is not None and kind is EdgeKind.DATA else ORDER,
        distance=fields.distance("distance"),
        init=fields.reference("init", numbers) if "init" in fields.data else None,
        kind=kind,
    )


def _edge_kind(fields: Fields) -> EdgeKind:
    kinds = {kind.value: kind for kind in EdgeKind}
    return fields.choice("kind", kinds, EdgeKind.DATA)


def _kind(value: object) -> str:
    return "an array" if isinstance(value, list) else quoted(value)
