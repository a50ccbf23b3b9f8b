"""What is in a program, read from its source as it was run: counts of the search rest on it."""

from __future__ import annotations

import ast
import re

_METHODS = frozenset({"sum", "min", "max", "argmin", "argmax", "any", "all"})
_OWN = re.compile(r"[a-eg]|own|tiny|half|flag|sums|[ux]\d+")
"""Names of arrays; `u` and `x` with a number are views and arrays made on the way."""

_LAYOUTS = re.compile(r"(constant array, [^,\n]*|constant array of a closure)")


def features(source: str) -> set[str]:
    """Names of the features of a module whose `program` is a random kernel.

    The first line may name the layouts of constants.
    """
    finder = _Finder()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef) and node.name == "program":
            finder.visit(node)
    first = source.partition("\n")[0]
    return finder.found | set(_LAYOUTS.findall(first if first.startswith("#") else ""))


class _Finder(ast.NodeVisitor):
    """Collects features; `loops` is the number of loops around."""

    def __init__(self) -> None:
        self.found: set[str] = set()
        self.loops = 0

    def visit_For(self, node: ast.For | ast.While) -> None:
        self.loops += 1
        self.generic_visit(node)
        self.loops -= 1

    visit_While = visit_For

    def visit_Return(self, node: ast.Return) -> None:
        if self.loops > 1:
            self.found.add("return from nested loops")
        self.generic_visit(node)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        if _is_array(node.target) or _is_slice(node.target):
            self.found.add("operator in place")
            if _is_slice(node.target):
                self.found.add("operator in place, slice")
            if isinstance(node.op, ast.Pow):
                self.found.add("operator in place, power")
        self.generic_visit(node)

    def visit_Assign(self, node: ast.Assign) -> None:
        target, value = node.targets[0], node.value
        if _is_slice(target):
            self.found.add("assignment of a whole array or slice")
        if isinstance(target, ast.Name) and re.fullmatch(r"x\d+", target.id):
            self.found.add("array made in a loop" if self.loops else "array made")
        if isinstance(target, ast.Name) and re.fullmatch(r"u\d+", target.id):
            self.found.add("view under a name")
        pairs = [getattr(side, "elts", [None]) for side in (target, value)]
        if isinstance(target, ast.Tuple) and all(map(_is_array, pairs[0] + pairs[1])):
            self.found.add("swapped arrays")
        self.generic_visit(node)

    def visit_Subscript(self, node: ast.Subscript) -> None:
        inner = node.value
        if isinstance(inner, ast.Tuple) and all(map(_is_array, inner.elts)):
            self.found.add("tuple of arrays")
        elif isinstance(inner, ast.Tuple):
            is_nested = isinstance(inner.elts[0], ast.Tuple)
            self.found.add("nested tuple" if is_nested else "tuple")
        elif isinstance(inner, ast.Call) and getattr(inner.func, "id", "") == "pair":
            self.found.add("tuple that a function returns")
        self.generic_visit(node)

    def visit_Slice(self, node: ast.Slice) -> None:
        parts = [part for part in (node.lower, node.upper) if part is not None]
        if any(isinstance(inner, ast.Name) for part in parts for inner in ast.walk(part)):
            self.found.add("slice with bounds of runtime values")
        if node.lower is None and isinstance(node.upper, ast.Constant) and node.upper.value == 1:
            self.found.add("broadcasting of one element of an axis")
        if isinstance(node.step, ast.UnaryOp):
            self.found.add("slice that goes backwards")
        self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> None:
        function = node.func
        if isinstance(function, ast.Attribute):
            name, of = function.attr, function.value
            if name in _METHODS and not (isinstance(of, ast.Name) and of.id == "np"):
                self.found.add("method of a slice" if _is_slice(of) else "method of an array")
            if name == "array" and node.args:
                items = getattr(node.args[0], "elts", [None])
                is_nested = isinstance(items[0], ast.Tuple)
                self.found.add("np.array of " + ("nested tuples" if is_nested else "values"))
            if name == "where":
                self.found.add("np.where")
            if name == "sort":
                self.found.add("sort")
            if getattr(of, "id", "") == "made":
                self.found.add("list that grows")
        self.generic_visit(node)


def _is_array(node: object) -> bool:
    return isinstance(node, ast.Name) and _OWN.fullmatch(node.id) is not None


def _is_slice(node: ast.expr) -> bool:
    if not isinstance(node, ast.Subscript):
        return False
    parts = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
    return any(isinstance(part, ast.Slice) for part in parts)
