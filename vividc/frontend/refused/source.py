"""The source of a kernel as a tree: its functions, and what is on a line.

Asked for messages only: a file that is missing, or no longer what was compiled, gives none.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass

from vividc.errors import SourceLoc

AnyFunction = ast.FunctionDef | ast.AsyncFunctionDef
_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


@dataclass(frozen=True, slots=True)
class KernelSource:
    """The file that a kernel is defined in.

    Attributes
    ----------
    tree
        The whole file.
    kernel
        The kernel's definition, None if it is not there.
    """

    tree: ast.Module
    kernel: AnyFunction | None

    @property
    def functions(self) -> list[AnyFunction]:
        """All functions of the file, outer before inner ones."""
        return [node for node in ast.walk(self.tree) if isinstance(node, _FUNCTIONS)]

    def reached(self, lines: list[int]) -> list[AnyFunction]:
        """The kernel, the functions around `lines`, and those of the file that these call by a name
        which they can see.
        """
        homes = dict(_homes(self.tree, ()))
        reached = [] if self.kernel is None else [self.kernel]
        reached += [f for f in self.functions if any(line in span(f) for line in lines)]
        for function in reached:  # grows as it goes
            called = {
                node.func.id
                for node in ast.walk(function)
                if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
            }
            seen_from = (*homes[function], function)
            reached += [
                other
                for other in self.functions
                if other.name in called
                and other not in reached
                and homes[other] == seen_from[: len(homes[other])]
            ]
        return list(dict.fromkeys(reached))

    def on_line(self, line: int) -> Iterator[ast.AST]:
        """Expressions and statements that begin on a line or go over it, inner ones last."""
        for node in ast.walk(self.tree):
            first, last = getattr(node, "lineno", None), getattr(node, "end_lineno", None)
            if first is not None and last is not None and first <= line <= last:
                yield node

    def calls_on(self, line: int) -> list[ast.Call]:
        """Calls whose text goes over a line."""
        return [
            node
            for node in self.on_line(line)
            if isinstance(node, ast.Call) and line in range(node.lineno, (node.end_lineno or 0) + 1)
        ]

    def inner_at(self, line: int) -> AnyFunction | None:
        """The function in the kernel whose head is on a line."""
        nodes = () if self.kernel is None else ast.walk(self.kernel)
        inner = (n for n in nodes if isinstance(n, _FUNCTIONS) and n is not self.kernel)
        return next((f for f in inner if span(f)[0] <= line <= f.body[0].lineno), None)

    def trying(self, line: int) -> ast.Try | None:
        """The innermost `try` around a line."""
        around = [node for node in self.on_line(line) if isinstance(node, ast.Try)]
        return around[-1] if around else None

    def is_statement(self, line: int) -> bool:
        """Whether a line is not the head of a function, which numba names for want of a better."""
        return not any(
            span(function)[0] <= line < function.body[0].lineno for function in self.functions
        )


def source_of(loc: SourceLoc, name: str) -> KernelSource | None:
    """The source of the kernel of this name, defined at `loc`; None: there is none to read."""
    try:
        with open(loc.file, encoding="utf-8") as file:
            tree = ast.parse(file.read())
    except (OSError, SyntaxError, ValueError):
        return None
    kernels = (
        node
        for node in ast.walk(tree)
        if isinstance(node, _FUNCTIONS) and node.name == name and loc.line in span(node)
    )
    return KernelSource(tree, next(kernels, None))


def span(function: AnyFunction) -> range:
    """Lines of a function, its decorators included."""
    first = min([function.lineno, *(d.lineno for d in function.decorator_list)])
    return range(first, (function.end_lineno or function.lineno) + 1)


def _homes(
    node: ast.AST, around: tuple[AnyFunction, ...]
) -> Iterator[tuple[AnyFunction, tuple[AnyFunction, ...]]]:
    """Every function with those around it, the outermost first."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, _FUNCTIONS):
            yield child, around
            yield from _homes(child, (*around, child))
        else:
            yield from _homes(child, around)
