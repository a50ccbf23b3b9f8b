"""Attributes of foreign nodes and edges, as DOT files and networkx graphs spell them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

_OPERATION_KEYS: Final = ("opcode", "op", "operation")
_CONST_KEYS: Final = ("const", "constant", "value")
_DISTANCE_KEYS: Final = ("distance", "dist")
_OPERAND_KEYS: Final = ("operand", "port")
_OPERAND_NAMES: Final[dict[str, int | str]] = {
    "lhs": 0,
    "rhs": 1,
    "addr": 0,
    "address": 0,
    "data": 1,
    "pred": "pred",
    "predicate": "pred",
}
_MAX_DIGITS: Final = 18


def node_entry(attributes: Mapping[str, object], name: str) -> dict[str, object]:
    """`op` and `const` of the JSON form.

    The operation is the attribute ``opcode``, ``op`` or ``operation``, else the first word of the
    ``label``, else the node's name without trailing digits.
    """
    entry: dict[str, object] = {"op": _operation(attributes, name)}
    const = _first(attributes, _CONST_KEYS)
    return entry if const is None else {**entry, "const": const}


def edge_entry(attributes: Mapping[str, object]) -> dict[str, object]:
    """`distance`, `operand` and `kind` of the JSON form, as far as the edge has them."""
    entry: dict[str, object] = {}
    distance = _first(attributes, _DISTANCE_KEYS)
    operand = _first(attributes, _OPERAND_KEYS)
    if distance is not None:
        entry["distance"] = _number(distance)
    if operand is not None:
        entry["operand"] = _operand(operand)
    if "kind" in attributes:
        entry["kind"] = attributes["kind"]
    return entry


def has_distance(attributes: Mapping[str, object]) -> bool:
    """Whether the edge says how many iterations it spans."""
    return _first(attributes, _DISTANCE_KEYS) is not None


def _operation(attributes: Mapping[str, object], name: str) -> object:
    given = _first(attributes, _OPERATION_KEYS)
    if given is not None and given != "":
        return given
    label = attributes.get("label", "")
    words = re.findall(r"[A-Za-z_][\w.]*", label) if isinstance(label, str) else []
    if words:
        return str(words[0])
    return name.rstrip("0123456789").rstrip("_.") or "node"


def _operand(value: object) -> object:
    named = _OPERAND_NAMES.get(value.lower()) if isinstance(value, str) else None
    return _number(value) if named is None else named


def _first(attributes: Mapping[str, object], keys: tuple[str, ...]) -> object:
    return next((attributes[key] for key in keys if key in attributes), None)


def _number(value: object) -> object:
    """The integer of a text, or the value for the JSON reader to judge."""
    if isinstance(value, str) and re.fullmatch(rf"-?[0-9]{{1,{_MAX_DIGITS}}}", value):
        return int(value)
    return value
