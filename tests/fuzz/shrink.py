"""Makes a failing kernel small: deletes statements and replaces expressions by parts of them."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from copy import deepcopy
from time import monotonic

Fails = Callable[[str], bool]


def shrink(source: str, fails: Fails, budget_s: float = 120.0) -> str:
    """A smaller module whose kernel `program` still fails.

    Only what keeps a kernel terminating and within its arrays is tried: indices, shift amounts,
    divisors and the counters of while loops stay, or become constants.

    Parameters
    ----------
    fails
        Whether a module still shows the failure.
    budget_s
        Seconds after which the smallest one so far is returned.
    """
    deadline = monotonic() + budget_s
    smallest = source
    again = True
    while again:
        again = False
        for candidate in _candidates(smallest):
            if monotonic() > deadline:
                return smallest
            if len(candidate) < len(smallest) and fails(candidate):
                smallest, again = candidate, True
                break
    return smallest


def _candidates(source: str) -> Iterator[str]:
    """Every module one step smaller, the larger steps first."""
    tree = ast.parse(source)
    places = [*_deletions(tree), *_replacements(tree)]
    for path, replacement in places:
        yield ast.unparse(_with(tree, path, replacement))


Path = tuple[tuple[str, int | None], ...]
Place = tuple[Path, list[ast.stmt] | ast.expr]


def _program(tree: ast.Module) -> tuple[Path, ast.FunctionDef]:
    """The kernel's function and the way to it: it may lie in another that makes it."""
    for number, node in enumerate(tree.body):
        if isinstance(node, ast.FunctionDef) and node.name == "program":
            return (("body", number),), node
    for number, node in enumerate(tree.body):
        for inner, child in enumerate(getattr(node, "body", [])):
            if isinstance(child, ast.FunctionDef) and child.name == "program":
                return (("body", number), ("body", inner)), child
    raise ValueError("the module has no function `program`")


def _deletions(tree: ast.Module) -> Iterator[Place]:
    root, function = _program(tree)
    for path, node in _statements(function, root):
        if isinstance(node, ast.Return) and len(path) == len(root) + 1:
            continue
        if not _counts(node):
            yield path, []
        if isinstance(node, (ast.If, ast.For)):
            yield path, [*node.body]
        if isinstance(node, ast.If) and node.orelse:
            yield path, [*node.orelse]


def _counts(node: ast.stmt) -> bool:
    """Whether a while loop ends by it: it moves the counter, or leaves at its limit."""
    if isinstance(node, ast.If):
        return isinstance(node.body[0], ast.Break) and _is_counter(getattr(node.test, "left", None))
    targets = [node.target] if isinstance(node, ast.AugAssign) else getattr(node, "targets", [])
    return any(_is_counter(target) for target in targets)


def _is_counter(node: object) -> bool:
    return isinstance(node, ast.Name) and node.id[0] in "wv" and node.id[1:].isdecimal()


def _statements(node: ast.AST, path: Path) -> Iterator[tuple[Path, ast.stmt]]:
    for field in ("body", "orelse"):
        inner = getattr(node, field, None)
        for number, child in enumerate(inner if isinstance(inner, list) else []):
            here = (*path, (field, number))
            yield here, child
            yield from _statements(child, here)


def _replacements(tree: ast.Module) -> Iterator[Place]:
    root, function = _program(tree)
    for path, node in _statements(function, root):
        if _counts(node):
            continue
        for field in ("value", "test", "iter"):
            child = getattr(node, field, None)
            is_while = isinstance(node, ast.While)
            if isinstance(child, ast.expr) and not is_while:
                yield from _parts(child, (*path, (field, None)), field == "iter")


def _parts(node: ast.expr, path: Path, fixed: bool = False) -> Iterator[Place]:
    """Smaller expressions for `node` and what is in it; `fixed`: constants only."""
    if isinstance(node, ast.Constant):
        return
    if not fixed:
        yield from ((path, child) for child in _operands(node))
        yield from ((path, number) for number in _constants(node))
    elif not isinstance(node, ast.Call):
        yield path, ast.Constant(1)
    for field, value in ast.iter_fields(node):
        inner = fixed or _is_guarded(node, field)
        if isinstance(value, ast.expr) and field != "func":
            yield from _parts(value, (*path, (field, None)), inner)
        for number, child in enumerate(value if isinstance(value, list) else []):
            if isinstance(child, ast.expr):
                yield from _parts(child, (*path, (field, number)), inner)


def _constants(node: ast.expr) -> Iterator[ast.expr]:
    """What is of the type of a cast, or else an integer."""
    for value in (0, 1):
        number = ast.Constant(value)
        if _is_cast(node):
            assert isinstance(node, ast.Call)
            if ast.dump(node.args[0]) != ast.dump(number):
                yield ast.Call(node.func, [number], [])
        else:
            yield number


def _is_cast(node: ast.expr) -> bool:
    """Such as np.float32(1), whose operand has another type."""
    function = node.func if isinstance(node, ast.Call) else None
    return isinstance(function, ast.Attribute) and function.attr[-1].isdigit()


def _operands(node: ast.expr) -> Iterator[ast.expr]:
    if _is_cast(node):
        return
    for field, value in ast.iter_fields(node):
        if field in ("func", "slice") or _is_guarded(node, field):
            continue
        yield from (c for c in (value if isinstance(value, list) else [value]) if _is_value(c))


def _is_value(node: object) -> bool:
    return isinstance(node, ast.expr)


def _is_guarded(node: ast.expr, field: str) -> bool:
    """Whether a bound, a divisor or a shift amount depends on it."""
    if isinstance(node, ast.Subscript):
        return True
    guarded = (ast.FloorDiv, ast.Mod, ast.LShift, ast.RShift)
    return isinstance(node, ast.BinOp) and isinstance(node.op, guarded) and field == "right"


def _with(tree: ast.Module, path: Path, replacement: list[ast.stmt] | ast.expr) -> ast.Module:
    copy = deepcopy(tree)
    parent: object = copy
    for field, number in path[:-1]:
        value = getattr(parent, field)
        parent = value if number is None else value[number]
    field, number = path[-1]
    if number is None:
        setattr(parent, field, replacement)
    elif isinstance(replacement, list):
        statements = getattr(parent, field)
        statements[number : number + 1] = replacement
        if not statements and field == "body":
            statements.append(ast.Pass())
    else:
        getattr(parent, field)[number] = replacement
    return ast.fix_missing_locations(copy)
