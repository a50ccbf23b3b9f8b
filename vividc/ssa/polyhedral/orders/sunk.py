"""Parts in which inner loops compute what the source computes before them.

`w = alpha * a[i, k]`, then in a loop over j `c[i, j] += w * a[j, k]`: while w is a scalar between
two statements, the loop over k stays outside that over j. In the inner loop it is computed again
for each j, unless that loop stays the innermost one, and the loops may have any order.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from vividc.machine.opcodes import Opcode
from vividc.ssa.polyhedral.scop import Nest, Scop, Statement, with_scalars

_CHEAP: Final = frozenset(
    {Opcode.LOAD, Opcode.FADD, Opcode.FSUB, Opcode.FMUL, Opcode.ADD, Opcode.SUB, Opcode.MUL}
)
_MOST: Final = 6
"""Operations of a statement: more are dear to compute again."""


def sunk(scop: Scop) -> Scop | None:
    """The part with cheap statements in those inside loops behind them that alone read them; None
    if there are none. Nothing in the part may store to what they load.
    """
    stored = {a.array for s in scop.statements for a in s.accesses.values() if a.is_store}
    into: dict[str, Statement] = {}
    for statement in scop.statements:
        reader = _reader(scop, statement)
        arrays = {access.array for access in statement.accesses.values()}
        if reader is not None and _is_cheap(statement) and not arrays & stored:
            into[statement.name] = reader
    into = {name: reader for name, reader in into.items() if reader.name not in into}
    if not into:
        return None
    depth = dict(scop.depth)
    for name, reader in into.items():
        depth |= dict.fromkeys((i.id for i in scop.statement(name).instrs), len(reader.dims))
    nest = _rebuilt(scop.nest, scop, into)
    return replace(scop, nest=with_scalars(nest, depth, set()), depth=depth)


def _reader(scop: Scop, statement: Statement) -> Statement | None:
    """The only statement that reads what one leaves, if it is in a loop behind it."""
    left = set(statement.writes)
    readers = [other for other in scop.statements if left.intersection(other.reads)]
    if len(readers) != 1 or readers[0].shift:
        return None
    [reader], depth = readers, len(statement.dims)
    is_inside = len(reader.dims) > depth and reader.dims[:depth] == statement.dims
    return reader if is_inside else None


def _is_cheap(statement: Statement) -> bool:
    """Whether it may be computed again elsewhere."""
    if statement.copies or statement.reads or statement.shift or len(statement.instrs) > _MOST:
        return False
    return all(instr.op in _CHEAP for instr in statement.instrs)


def _rebuilt(node: Nest, scop: Scop, into: dict[str, Statement]) -> Nest:
    children: list[Nest | Statement] = []
    for child in node.children:
        if isinstance(child, Nest):
            children.append(_rebuilt(child, scop, into))
        elif child.name not in into:
            moved = [scop.statement(name) for name, reader in into.items() if reader == child]
            instrs = tuple(instr for one in moved for instr in one.instrs)
            accesses = {ident: a for one in moved for ident, a in one.accesses.items()}
            children.append(
                replace(
                    child, instrs=(*instrs, *child.instrs), accesses={**accesses, **child.accesses}
                )
            )
    return Nest(node.dim, tuple(children))
