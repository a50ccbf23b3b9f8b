"""Reading and writing a DFG file in the form that its ending names."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Final

from vividc.dfg.check import check
from vividc.dfg.dot import parse_dot
from vividc.dfg.ir import DFG
from vividc.dfg.json_fields import raise_problems
from vividc.dfg.json_form import from_json
from vividc.dfg.text import parse
from vividc.errors import DFGError, demand_type


def load(path: str | Path) -> DFG:
    """The graph in a `.json`, `.dot` (`.gv`) or `.dfg` (text form) file.

    Raises
    ------
    DFGError
        The file is missing or unreadable, its ending unknown, its text malformed (with the line),
        or the graph breaks an invariant of `check` (all of them are listed).
    """
    demand_type(path, (str, os.PathLike), "the path", "give a string or a pathlib.Path")
    file = Path(path)
    reader = _READERS.get(file.suffix.lower())
    if reader is None:
        raise DFGError(
            f"the ending {file.suffix!r} names no form of a DFG",
            loc=str(path),
            hint=f"use one of {', '.join(_READERS)}",
        )
    dfg = reader(_text_of(file), str(path))
    raise_problems(str(path), check(dfg))
    return dfg


def _text_of(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise DFGError("the file is not UTF-8 text", loc=str(file)) from error
    except OSError as error:
        raise DFGError(f"cannot read the file: {error.strerror}", loc=str(file)) from error


def _read_json(text: str, file: str) -> DFG:
    try:
        data = json.loads(text)
    except json.JSONDecodeError as error:
        raise DFGError(f"not JSON: {error.msg}", loc=f"{file}:{error.lineno}") from error
    except RecursionError as error:
        raise DFGError("not a DFG: the JSON is nested too deeply", loc=file) from error
    return from_json(data, file=file)


def _read_text(text: str, file: str) -> DFG:
    return parse(text, file=file)


def _read_dot(text: str, file: str) -> DFG:
    return parse_dot(text, file=file)


_READERS: Final[dict[str, Callable[[str, str], DFG]]] = {
    ".json": _read_json,
    ".dot": _read_dot,
    ".gv": _read_dot,
    ".dfg": _read_text,
}
