"""Where a kernel's source has loops over `numba.prange`."""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Callable, Iterator
from typing import Any

import numba


def prange_lines(py_func: Callable[..., Any]) -> frozenset[int]:
    """Lines of the function's file in which a loop over `prange` begins; none without source."""
    try:
        lines, first = inspect.getsourcelines(py_func)
    except (OSError, TypeError):
        return frozenset()
    tree = ast.parse(textwrap.dedent("".join(lines)))
    names = inspect.getclosurevars(py_func)
    known = {**names.builtins, **names.globals, **names.nonlocals}
    return frozenset(first + node.lineno - 1 for node in _loops(tree) if _is_prange(node, known))


def _loops(tree: ast.AST) -> Iterator[ast.For]:
    return (node for node in ast.walk(tree) if isinstance(node, ast.For))


def _is_prange(loop: ast.For, known: dict[str, Any]) -> bool:
    return isinstance(loop.iter, ast.Call) and _value(loop.iter.func, known) is numba.prange


def _value(expression: ast.expr, known: dict[str, Any]) -> Any:
    """What a name, or an attribute of one, means to the kernel."""
    if isinstance(expression, ast.Name):
        return known.get(expression.id)
    if isinstance(expression, ast.Attribute):
        return getattr(_value(expression.value, known), expression.attr, None)
    return None
