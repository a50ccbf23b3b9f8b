"""What foreign graphs call the attributes of their nodes and edges: one table for JSON, DOT and
networkx, which `docs/dfg-formats.md` explains.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

from vividc.dfg.ir import EdgeKind
from vividc.machine.opcodes import BASE, PRED

NODE_ALIASES: Final[dict[str, tuple[str, ...]]] = {
    "op": ("op", "opcode", "operation"),
    "const": ("const", "constant", "value", "constVal"),
    "label": ("label", "name"),
    "array": ("array", "memName"),
}
EDGE_ALIASES: Final[dict[str, tuple[str, ...]]] = {
    "distance": ("distance", "dist"),
    "operand": ("operand", "port"),
}
OPERANDS: Final[dict[str, int | None]] = {
    "pred": PRED,
    "predicate": PRED,
    "base": BASE,
    "LHS": 0,
    "RHS": 1,
    "addr": 0,
    "address": 0,
    "data": 1,
    "branch_cond": 0,
    "branch_true": 1,
    "branch_false": 2,
    "any": None,
    "any2input": None,
    "any3input": None,
}
"""Port of each named operand; None: any that is free. The names are CGRA-ME's and ours; its
generator calls the condition of a branch `branch_cond`, and what follows it `branch_true` and
`branch_false`.
"""
KINDS: Final[dict[str, EdgeKind]] = {kind.value: kind for kind in EdgeKind} | {
    "alias": EdgeKind.ORDER
}
"""Kinds of edges; CGRA-ME's `alias` joins accesses to memory that must keep their order."""

_CGRA_ME: Final = frozenset({"argNo", "argType", "bitwidth", "cmpMode", "config"})
NODE_KEYS: Final = frozenset({"id", *NODE_ALIASES, *_CGRA_ME})
EDGE_KEYS: Final = frozenset({"src", "dst", "kind", "ctype", "bitwidth", *EDGE_ALIASES})
"""Keys that are read, or known to matter to other tools only; any other is warned of."""

_STYLE_NAMES: Final = (
    "URL area arrowhead arrowsize arrowtail class color colorscheme comment constraint decorate"
    " dir distortion edgeURL edgehref edgetarget edgetooltip fillcolor fixedsize fontcolor fontname"
    " fontsize gradientangle group headURL head_lp headclip headhref headlabel headport headtarget"
    " headtooltip height href id image imagepos imagescale key label labelURL labelangle"
    " labeldistance labelfloat labelfontcolor labelfontname labelfontsize labelhref labeljust"
    " labelloc labeltarget labeltooltip layer len lhead lp ltail margin minlen nojustify ordering"
    " orientation penwidth peripheries pin pos radius rects regular root samehead sametail"
    " samplepoints shape shapefile showboxes sides skew sortv style tailURL tail_lp tailclip"
    " tailhref taillabel tailport tailtarget tailtooltip target tooltip vertices weight width"
    " xlabel xlp z"
)
_STYLES: Final = frozenset(_STYLE_NAMES.split())
"""Attributes of nodes and edges that Graphviz draws by, and networkx's `key`."""
_MAX_DIGITS: Final = 18


def drawn_node(attributes: Mapping[str, object], name: str) -> dict[str, object]:
    """Attributes of a node in DOT or networkx as those of the JSON form, with `op` and `label`.

    The operation is the attribute of that name or an alias of it, else the first word of the
    ``label``, else the node's name without trailing digits.
    """
    entry = _renamed(_unstyled(attributes), NODE_ALIASES)
    if entry.get("op") in (None, ""):
        entry["op"] = _operation(attributes, name)
    return {**entry, "label": name}


def drawn_edge(attributes: Mapping[str, object]) -> dict[str, object]:
    """Attributes of an edge in DOT or networkx as those of the JSON form: texts may be numbers."""
    entry = _renamed(_unstyled(attributes), EDGE_ALIASES)
    return {key: _number(entry[key]) if key in EDGE_ALIASES else entry[key] for key in entry}


def node_entry(entry: Mapping[str, object]) -> dict[str, object]:
    """A node of a foreign graph with `op`, `const`, `label` and `array` under these names."""
    return _renamed(entry, NODE_ALIASES)


def edge_entry(entry: Mapping[str, object]) -> dict[str, object]:
    """An edge of a foreign graph with `distance` and `operand` under these names."""
    return _renamed(entry, EDGE_ALIASES)


def _renamed(
    entry: Mapping[str, object], aliases: Mapping[str, tuple[str, ...]]
) -> dict[str, object]:
    """The first alias that is there counts; the others of that meaning are dropped."""
    renamed = dict(entry)
    for key, names in aliases.items():
        given = [renamed.pop(name) for name in names if name in renamed]
        if given:
            renamed[key] = given[0]
    return renamed


def _unstyled(attributes: Mapping[str, object]) -> dict[str, object]:
    return {key: value for key, value in attributes.items() if key not in _STYLES}


def _operation(attributes: Mapping[str, object], name: str) -> str:
    label = attributes.get("label", "")
    words = re.findall(r"[A-Za-z_][\w.]*", label) if isinstance(label, str) else []
    if words:
        return str(words[0])
    return name.rstrip("0123456789").rstrip("_.") or "node"


def _number(value: object) -> object:
    """The integer of a text, or the value for the JSON reader to judge."""
    if isinstance(value, str) and re.fullmatch(rf"-?[0-9]{{1,{_MAX_DIGITS}}}", value):
        return int(value)
    return value
