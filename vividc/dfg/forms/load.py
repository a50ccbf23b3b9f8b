"""Reads a DFG file in the form that its content indicates."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Final, Literal, get_args

from vividc.dfg.check import check
from vividc.dfg.forms.dot import parse_dot
from vividc.dfg.forms.foreign import unknown_operations
from vividc.dfg.forms.json_fields import raise_problems
from vividc.dfg.forms.json_form import from_json
from vividc.dfg.forms.json_lines import ElementLines, too_long_number
from vividc.dfg.forms.morpher_xml import parse_morpher_xml
from vividc.dfg.forms.text import parse
from vividc.dfg.ir import DFG
from vividc.errors import DFGError, demand_type, printable, quoted, warn
from vividc.host.inputs import GRAPH_BYTES, demand_few_values, read_text

UnknownOps = Literal["generic", "refuse"]
_SHOWN: Final = 8


def load(path: str | Path, *, unknown_ops: UnknownOps = "generic") -> DFG:
    """The graph in a file: JSON, DOT, Morpher's XML, or the text form.

    The content decides which form it is; the ending (`.json`, `.dot`, `.gv`, `.xml`, `.dfg`) only
    where the content does not.

    Parameters
    ----------
    unknown_ops
        What becomes of an operation whose name the table (`vividc.machine.foreign_names`) does not
        have. "generic": it runs on any PE that has generic operations, and one warning names all
        such operations. "refuse": an error.

    Raises
    ------
    DFGError
        The file is missing, unreadable or of no known form, its text malformed (with the line),
        it has no nodes, or the graph breaks an invariant of `check` (all of them are listed).

    Warns
    -----
    VividcWarning
        There are unknown operations, ids used twice by a published graph, or distances inferred.
    """
    demand_type(path, (str, os.PathLike), "the path", "give a string or a pathlib.Path")
    if unknown_ops not in get_args(UnknownOps):
        choices = " and ".join(get_args(UnknownOps))
        raise DFGError(f"{unknown_ops!r} is none of {choices}", loc="unknown_ops")
    file = Path(path)
    text = read_text(file, GRAPH_BYTES, DFGError, "a DFG file is text: is it this one?")
    dfg = _reader_of(text, file)(text, str(path))
    if not dfg.nodes:
        raise DFGError(
            "the graph has no nodes: there is nothing to map",
            loc=str(path),
            hint="check that this is the file you mean",
        )
    raise_problems(str(path), check(dfg))
    _judge_unknown(dfg, str(path), unknown_ops)
    return dfg


def _judge_unknown(dfg: DFG, file: str, unknown_ops: UnknownOps) -> None:
    unknown = unknown_operations(dfg)
    if not unknown:
        return
    shown = [
        f"{quoted(name, 40)} (node {_label(dfg, nodes[0])})" for name, nodes in unknown.items()
    ]
    names = ", ".join(shown[:_SHOWN])
    if len(shown) > _SHOWN:
        names += f" and {len(shown) - _SHOWN} more"
    if unknown_ops == "refuse":
        raise DFGError(
            f"unknown operation {names}",
            loc=file,
            hint="rename it as in docs/dfg-formats.md, or let it run on any PE: "
            '--unknown-ops generic, unknown_ops="generic"',
        )
    warn(
        f"{file}: unknown operation {names}: taken as generic, which any PE may run; "
        "--unknown-ops refuse makes this an error"
    )


def _label(dfg: DFG, node: int) -> str:
    return printable(dfg.by_id[node].label) or str(node)


def _reader_of(text: str, file: Path) -> Callable[[str, str], DFG]:
    for begins, reader in _BY_CONTENT:
        if begins.match(text):
            return reader
    reader_of_ending = _BY_ENDING.get(file.suffix.lower())
    if reader_of_ending is None:
        raise DFGError(
            f"neither the content nor the ending {file.suffix!r} names a form of a DFG",
            loc=str(file),
            hint=f"docs/dfg-formats.md lists the forms; the endings are {', '.join(_BY_ENDING)}",
        )
    return reader_of_ending


def _read_json(text: str, file: str) -> DFG:
    demand_few_values(text, GRAPH_BYTES, file, DFGError)
    try:
        data = json.loads(text)
    except json.JSONDecodeError as error:
        raise DFGError(f"not JSON: {error.msg}", loc=f"{file}:{error.lineno}") from error
    except ValueError as error:  # an integer of thousands of digits
        raise too_long_number(text, file) from error
    except RecursionError as error:
        raise DFGError("not a DFG: the JSON is nested too deeply", loc=file) from error
    return from_json(data, file=file, lines=ElementLines(text))


def _read_text(text: str, file: str) -> DFG:
    return parse(text, file=file)


def _read_dot(text: str, file: str) -> DFG:
    return parse_dot(text, file=file)


def _read_xml(text: str, file: str) -> DFG:
    return parse_morpher_xml(text, file=file)


# No group is possessive: before Python 3.11.5 some of those do not match (gh-106052).
_BY_CONTENT: Final = (
    (re.compile(r"\s*[{\[]"), _read_json),
    (re.compile(r"\s*<"), _read_xml),
    (re.compile(r"(?:\s|#[^\n]*+)*dfg\b"), _read_text),
    (
        re.compile(
            r"(?:\s|//[^\n]*+|\#[^\n]*+|/\*[^*]*+(?:\*(?!/)[^*]*+)*\*/)*(?:strict|digraph|graph)\b",
            re.I,
        ),
        _read_dot,
    ),
)
_BY_ENDING: Final[dict[str, Callable[[str, str], DFG]]] = {
    ".json": _read_json,
    ".dot": _read_dot,
    ".gv": _read_dot,
    ".xml": _read_xml,
    ".dfg": _read_text,
}
