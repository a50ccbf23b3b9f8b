"""Foreign graphs in the shape of the JSON form: their entries become nodes and edges."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from vividc.dfg.forms.attributes import (
    EDGE_ALIASES,
    EDGE_KEYS,
    KINDS,
    NODE_ALIASES,
    NODE_KEYS,
    OPERANDS,
)
from vividc.dfg.forms.foreign import ForeignEdge, ForeignNode, foreign_edges, foreign_node
from vividc.dfg.forms.json_fields import Fields, place_of
from vividc.dfg.ir import DFG, EdgeKind, Node
from vividc.errors import quoted, warn
from vividc.machine.opcodes import BASE, PRED
from vividc.machine.words import WORD_MASK

_SHOWN: Final = 8
_NAMED_PORTS: Final = frozenset({PRED, BASE})
_PORT_BY_NAME: Final = {"": None, **{name.lower(): port for name, port in OPERANDS.items()}}


def foreign_graph(
    name: str,
    nodes: Sequence[Fields],
    edges: Sequence[Fields],
    numbers: Mapping[int | str, int],
    *,
    merges: bool,
) -> DFG:
    """The graph of entries under the names of `attributes`; `merges`: an operand may be fed twice.

    What is wrong is recorded with the entries.
    """
    found = [_edge(fields, numbers) for fields in edges]
    if not merges:
        _operands_have_one_producer(edges, found)
    fed = {edge.dst for edge in found}
    made: dict[int, Node] = {}
    for fields in nodes:
        node = _node(fields, numbers, fed)
        # Entries with one id are one node, as no edge tells them apart; it can do what each needs.
        if node.id not in made or node.is_memory:
            made[node.id] = node
    return DFG(name, tuple(made.values()), foreign_edges(found))


def warn_of_shared_ids(file: str, nodes: Sequence[Fields]) -> None:
    """Name the ids that several operations have."""
    counts = Counter(node.data["id"] for node in nodes)
    shared = [quoted(str(node_id))[1:-1] for node_id, count in counts.items() if count > 1]
    if shared:
        more = f" and {len(shared) - _SHOWN} more" if len(shared) > _SHOWN else ""
        ids = ", ".join(shared[:_SHOWN]) + more
        warn(
            f"{file}: no edge tells the operations apart that share the ids {ids}; "
            "each id is taken as one node"
        )


def warn_of_unknown_keys(
    file: str, nodes: Sequence[Fields], edges: Sequence[Fields], lines: Mapping[str, int]
) -> None:
    """Name each key that means nothing here once, where it comes first."""
    of_nodes = list(_unknown_keys(nodes, NODE_KEYS, file, lines))
    of_edges = list(_unknown_keys(edges, EDGE_KEYS, file, lines))
    shown = [*of_nodes, *of_edges]
    if not shown:
        return
    known = "; ".join(
        text
        for text, wanted in (
            (f"a node has {_spellings('id', NODE_ALIASES)}", of_nodes),
            (f"an edge has {_spellings('src, dst, kind', EDGE_ALIASES)}", of_edges),
        )
        if wanted
    )
    more = f", and {len(shown) - _SHOWN} more" if len(shown) > _SHOWN else ""
    warn(f"{', '.join(shown[:_SHOWN])}{more}: ignored; {known}")


def _unknown_keys(
    entries: Sequence[Fields], known: frozenset[str], file: str, lines: Mapping[str, int]
) -> Iterator[str]:
    first: dict[str, Fields] = {}
    for fields in entries:
        for key in fields.data:
            if key not in known:
                first.setdefault(key, fields)
    for key, fields in first.items():
        yield f"{place_of(file, fields.place, lines)}: unknown key {quoted(key)} of {fields.place}"


def _spellings(first: str, aliases: Mapping[str, tuple[str, ...]]) -> str:
    others = [
        f"{key} ({', '.join(names[1:])})" if names[1:] else key for key, names in aliases.items()
    ]
    return ", ".join([first, *others])


def _edge(fields: Fields, numbers: Mapping[int | str, int]) -> ForeignEdge:
    return ForeignEdge(
        src=fields.reference("src", numbers),
        dst=fields.reference("dst", numbers),
        distance=fields.distance("distance"),
        operand=_port(fields),
        order=fields.choice("kind", KINDS, EdgeKind.DATA) is not EdgeKind.DATA,
    )


def _port(fields: Fields) -> int | None:
    operand = fields.data.get("operand")
    if isinstance(operand, str) and operand.lower() in _PORT_BY_NAME:
        return _PORT_BY_NAME[operand.lower()]
    port = fields.port("operand", {name: number or 0 for name, number in OPERANDS.items()})
    # Operands past the third lie behind the named ports.
    return port + len(_NAMED_PORTS) if port is not None and port >= PRED else port


def _node(fields: Fields, numbers: Mapping[int | str, int], fed: set[int]) -> Node:
    number = fields.reference("id", numbers)
    node_id = fields.data.get("id")
    # Some files name a constant by its word: the id "255".
    word = fields.data.get("const", node_id if isinstance(node_id, str) else None)
    if word is not None and (isinstance(word, bool) or not isinstance(word, str | int | float)):
        fields.problem(f"const {quoted(word)} is neither a number nor text")
    op = fields.text("op", None)
    if op == "" and isinstance(fields.data.get("op"), str):
        fields.problem("op is empty")
    node = ForeignNode(
        number,
        op,
        fields.text("label", str(node_id)) or str(node_id),
        _word_text(word),
        fields.text("array", ""),
    )
    return foreign_node(node, has_inputs=number in fed)


def _word_text(word: object) -> str | None:
    if isinstance(word, int) and not isinstance(word, bool):
        return str(word & WORD_MASK)  # not all of a very long integer can be written out
    return str(word) if isinstance(word, str | float) else None


def _operands_have_one_producer(edges: Sequence[Fields], found: Sequence[ForeignEdge]) -> None:
    """Published graphs feed an operand from several merged definitions; others do so by mistake."""
    feeds: dict[tuple[int, int], Fields] = {}
    for fields, edge in zip(edges, found, strict=True):
        if edge.order or edge.operand is None or edge.dst < 0:
            continue
        first = feeds.setdefault((edge.dst, edge.operand), fields)
        if first is not fields:
            operand, dst = fields.data["operand"], fields.data["dst"]
            fed = f"operand {operand} of node {shown_id(dst)}"
            fields.problem(f"{fed} is fed by {first.place} already")


def shown_id(node_id: object) -> str:
    """An id as messages show it: texts in quotes."""
    return quoted(node_id)
