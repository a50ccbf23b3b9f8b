"""Makes a kernel smaller while it still fails: fewer statements, simpler expressions."""

from __future__ import annotations

import ast
import copy
import time
from collections.abc import Callable, Iterator

FUEL = "k_"


def shrink(source: str, fails: Callable[[str], bool], limit_s: float = 60.0) -> str:
    """The smallest module found whose `program` still fails.

    Parameters
    ----------
    fails
        Whether a candidate shows the same find; False for what is no kernel.
    limit_s
        Seconds after which the smallest so far is returned.
    """
    deadline = time.monotonic() + limit_s
    best = ast.unparse(ast.parse(source))
    smaller = True
    while smaller:
        smaller = False
        for candidate in _smaller(best):
            if time.monotonic() > deadline:
                return best
            if len(candidate) < len(best) and fails(candidate):
                best, smaller = candidate, True
                break
    return best


def _smaller(source: str) -> Iterator[str]:
    tree = ast.parse(source)
    count = sum(1 for _ in ast.walk(_program(tree)))
    for edits in (_statement_edits, _expression_edits):
        for number in range(count):
            for choice in range(4):
                changed = copy.deepcopy(tree)
                node = list(ast.walk(_program(changed)))[number]
                if edits(node, _program(changed), choice):
                    yield ast.unparse(ast.fix_missing_locations(changed))


def _program(tree: ast.Module) -> ast.FunctionDef:
    return next(n for n in tree.body if isinstance(n, ast.FunctionDef) and n.name == "program")


def _statement_edits(node: ast.AST, program: ast.FunctionDef, choice: int) -> bool:
    """Deletes the statement, or replaces it by its body; fuel stays."""
    if not isinstance(node, ast.stmt) or node is program or choice > 1 or _is_fuel(node):
        return False
    body = getattr(node, "body", None)
    if choice and (not body or not isinstance(node, ast.If)):
        return False
    for owner in ast.walk(program):
        for field in ("body", "orelse"):
            block = getattr(owner, field, None)
            if isinstance(block, list) and node in block:
                place = block.index(node)
                block[place : place + 1] = body if choice else []
                if not block and field == "body":
                    block.append(ast.Pass())
                return True
    return False


def _is_fuel(node: ast.stmt) -> bool:
    """The statement counts or tests fuel, on which a loop's end depends."""
    heads = [node.test] if isinstance(node, ast.If) else [node]
    if isinstance(node, ast.While):
        return False
    return any(
        isinstance(n, ast.Name) and n.id.startswith(FUEL) for h in heads for n in ast.walk(h)
    )


def _expression_edits(node: ast.AST, _program: ast.FunctionDef, choice: int) -> bool:
    """Replaces an operand by one of its own operands; masks, divisors and places stay."""
    if isinstance(node, ast.Subscript | ast.While):
        return False
    for field in ("value", "left", "test", "args", "body", "orelse", "operand", "right"):
        part = getattr(node, field, None)
        if field == "right" and isinstance(node, ast.BinOp) and _guarded(node.op):
            continue
        parts = part if isinstance(part, list) else [part]
        for place, old in enumerate(parts):
            for new in _operands(old) if isinstance(old, ast.expr) else ():
                if choice == 0:
                    _put(node, field, place, new)
                    return True
                choice -= 1
    return False


def _guarded(op: ast.operator) -> bool:
    return isinstance(op, ast.FloorDiv | ast.Mod | ast.Div | ast.LShift | ast.RShift)


def _operands(node: ast.expr) -> list[ast.expr]:
    """What may stand for `node`: not the value of a mask or of a subscript."""
    if isinstance(node, ast.BinOp):
        return [node.left, node.right]
    if isinstance(node, ast.IfExp):
        return [node.body, node.orelse]
    if isinstance(node, ast.UnaryOp):
        return [node.operand]
    return list(node.args) if isinstance(node, ast.Call) else []


def _put(node: ast.AST, field: str, place: int, new: ast.expr) -> None:
    part = getattr(node, field)
    if isinstance(part, list):
        part[place] = new
    else:
        setattr(node, field, new)
