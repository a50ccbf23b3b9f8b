"""What clang's debug information (`-g`) adds to a function's LLVM type: names, types of words."""

from __future__ import annotations

import re
from dataclasses import dataclass

_NODE = re.compile(r"^(!\d+) = (?:distinct )?(!\w*)[({](.*)[)}]$", re.MULTILINE)
_FIELD = re.compile(r'(\w+): (?:"((?:[^"\\]|\\.)*)"|([^,]+))')
_SCOPE = re.compile(r"!dbg (!\d+)")
_MAX_DEPTH = 32
_DTYPES = {
    ("DW_ATE_float", "32"): "float32",
    ("DW_ATE_boolean", "8"): "bool",
    ("DW_ATE_signed_char", "8"): "int8",
    ("DW_ATE_unsigned_char", "8"): "uint8",
    **{("DW_ATE_signed", str(bits)): f"int{bits}" for bits in (16, 32, 64)},
    **{("DW_ATE_unsigned", str(bits)): f"uint{bits}" for bits in (16, 32, 64)},
}


@dataclass(frozen=True, slots=True)
class Declared:
    """How C declares a function.

    Attributes
    ----------
    names
        Of the parameters.
    dtypes
        numpy's name of the type of each parameter, or of the element it points to; "" if it is
        none of the array's.
    returns
        The same of the returned value.
    """

    names: tuple[str, ...]
    dtypes: tuple[str, ...]
    returns: str


def declared(text: str, header: str) -> Declared | None:
    """The C declaration of the function whose `define` line is `header`; None without `-g`."""
    scope = _SCOPE.search(header)
    if scope is None:
        return None
    nodes = {match[1]: (match[2], match[3]) for match in _NODE.finditer(text)}
    found = _Declarations(nodes)
    types = found.parameter_types(scope[1])
    names = found.parameter_names(scope[1])
    if not names or len(types) != len(names) + 1 or sorted(names) != [*range(1, len(types))]:
        return None
    return Declared(
        tuple(names[number] for number in sorted(names)),
        tuple(found.dtype(type_) for type_ in types[1:]),
        found.dtype(types[0]),
    )


class _Declarations:
    """A module's metadata nodes, by number: kind ("!" for lists) and text of the fields."""

    def __init__(self, nodes: dict[str, tuple[str, str]]) -> None:
        self._nodes = nodes

    def _fields(self, node: str) -> dict[str, str]:
        _, text = self._nodes.get(node, ("", ""))
        return {match[1]: match[2] or match[3] or "" for match in _FIELD.finditer(text)}

    def parameter_types(self, subprogram: str) -> list[str]:
        """Nodes of the returned type, then of the parameters'."""
        kind = self._fields(subprogram).get("type", "")
        listed = self._fields(kind).get("types", "")
        return re.findall(r"null|!\d+", self._nodes.get(listed, ("", ""))[1])

    def parameter_names(self, subprogram: str) -> dict[int, str]:
        """Name of each parameter, by position from 1."""
        found: dict[int, str] = {}
        for node, (kind, _) in self._nodes.items():
            fields = self._fields(node) if kind == "!DILocalVariable" else {}
            if fields.get("scope") == subprogram and "arg" in fields:
                found[int(fields["arg"])] = fields["name"]
        return found

    def dtype(self, node: str) -> str:
        """Type of a word, or of the word that is pointed to."""
        for _ in range(_MAX_DEPTH):
            fields = self._fields(node)
            if "encoding" in fields:
                return _DTYPES.get((fields["encoding"], fields.get("size", "")), "")
            node = fields.get("baseType", "")
        return ""
