"""The source lines that the IR of our target carries, and no more of numba's debug information:
nobody debugs the code, and variables and their types take a tenth of numba's time.
"""

from __future__ import annotations

import ast
import functools
import os
from collections.abc import Iterator
from typing import Any

import numba
from numba.core import debuginfo, lowering

_NO_SOURCE_OF_A_USER = (
    os.path.dirname(numba.__file__) + os.sep,
    os.path.dirname(os.path.abspath(__file__)) + os.sep,
)
"""Where functions are of which no line is shown: numba's own, and those that stand in for them."""
_numba_first_line = lowering.get_func_body_first_lineno


class Lines(debuginfo.DIBuilder):  # type: ignore[misc]
    """Numba's builder without variables and types, and with each line of a function made once."""

    def __init__(self, *args: Any, **named: Any) -> None:
        super().__init__(*args, **named)
        self._made: dict[tuple[int, int], Any] = {}

    def _di_subroutine_type(self, *_: Any) -> Any:
        nothing = self.module.add_metadata([])
        return self.module.add_debug_info("DISubroutineType", {"types": nothing})

    def mark_variable(self, *_: Any, **__: Any) -> None:
        """No variable is shown."""

    def _add_location(self, line: int) -> Any:
        key = len(self.subprograms), line
        if key not in self._made:
            self._made[key] = super()._add_location(line)
        return self._made[key]


def first_line(function: Any) -> int | None:
    """Line of a function's first statement, as numba's `get_func_body_first_lineno`, which parses
    the function's file each time.
    """
    code = function.__code__
    first: int | None = code.co_firstlineno
    if code.co_filename.startswith(_NO_SOURCE_OF_A_USER):
        return first
    try:
        with open(code.co_filename) as file:
            statements = _first_statements(file.read())
    except (OSError, ValueError, SyntaxError):  # a cell of a notebook; a file that was changed
        first = _numba_first_line(function)
        return first
    return statements.get((code.co_name, code.co_firstlineno))


@functools.lru_cache(maxsize=16)
def _first_statements(source: str) -> dict[tuple[str, int], int]:
    """Lines of first statements, by a function's name and the line that it begins in, which is
    that of `def` or of the first decorator.
    """
    found: dict[tuple[str, int], int] = {}
    for node in _functions(ast.parse(source)):
        has_docstring = ast.get_docstring(node, clean=False) is not None
        for statement in node.body[has_docstring:][:1]:
            for begin in (node.lineno, *(one.lineno for one in node.decorator_list[:1])):
                found[node.name, begin] = statement.lineno
    return found


def _functions(tree: ast.AST) -> Iterator[ast.FunctionDef]:
    return (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))
