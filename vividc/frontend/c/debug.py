"""What clang's debug information (`-g`) adds to a function's LLVM type: names, types of words."""

from __future__ import annotations

import re
from dataclasses import dataclass

from vividc.frontend.llvm.metadata import Metadata, debug_node

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
    scope = debug_node(header)
    if not scope:
        return None
    metadata = Metadata(text)
    types = _parameter_types(metadata, scope)
    names = _parameter_names(metadata, scope)
    if not names or len(types) != len(names) + 1 or sorted(names) != [*range(1, len(types))]:
        return None
    return Declared(
        tuple(names[number] for number in sorted(names)),
        tuple(_dtype(metadata, type_) for type_ in types[1:]),
        _dtype(metadata, types[0]),
    )


def _parameter_types(metadata: Metadata, subprogram: str) -> list[str]:
    """Nodes of the returned type, then of the parameters'."""
    kind = metadata.fields(subprogram).get("type", "")
    listed = metadata.fields(kind).get("types", "")
    return re.findall(r"null|!\d+", metadata.listed(listed))


def _parameter_names(metadata: Metadata, subprogram: str) -> dict[int, str]:
    """Name of each parameter, by position from 1."""
    variables = map(metadata.fields, metadata.of_kind("!DILocalVariable"))
    return {
        int(fields["arg"]): fields["name"]
        for fields in variables
        if fields.get("scope") == subprogram and "arg" in fields
    }


def _dtype(metadata: Metadata, node: str) -> str:
    """Type of a word, or of the word that is pointed to."""
    for fields in metadata.path(node, "baseType"):
        if "encoding" in fields:
            return _DTYPES.get((fields["encoding"], fields.get("size", "")), "")
    return ""
