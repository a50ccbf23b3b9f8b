"""Functions that are written here, by a line or more of Python, in the name of a user's."""

from __future__ import annotations

import ast
from collections.abc import Callable, Container, Mapping, Sequence
from typing import Any


def function_like(
    written: Callable[..., Any], names: Sequence[str], value: str, known: Mapping[str, Any]
) -> Callable[..., Any]:
    """A function with the name, place and docstring of `written`, of parameters of these names,
    which returns the value of an expression of them and of what is `known`.
    """
    text = f"def {written.__name__}({', '.join(names)}): return {value}"
    return function_of(written, text, known)


def function_of(
    written: Callable[..., Any], text: str, known: Mapping[str, Any]
) -> Callable[..., Any]:
    """A function of the name of `written` with its place, all on one line, and docstring.

    Parameters
    ----------
    text
        Its definition.
    known
        What it reads of globals.
    """
    tree = ast.parse(text)
    line = written.__code__.co_firstlineno
    for node in ast.walk(tree):
        if hasattr(node, "lineno"):
            node.lineno = node.end_lineno = line  # type: ignore[attr-defined]
    made: dict[str, Any] = {**known, "__name__": written.__module__}
    exec(compile(tree, written.__code__.co_filename, "exec"), made)
    found: Callable[..., Any] = made[written.__name__]
    found.__doc__ = written.__doc__
    return found


def free_name(name: str, taken: Container[str]) -> str:
    """A name that is none of `taken`."""
    while name in taken:
        name += "_"
    return name
