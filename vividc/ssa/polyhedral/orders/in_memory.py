"""Parts whose sums wait in memory where the source keeps them in scalars until they are stored.

`w = a[i, j]`, in a loop `w -= ...`, then `a[i, j] = w / ...`: if nothing else touches `a[i, j]`
meanwhile, the sum may wait there, and its terms need not be added without a break.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import islpy as isl

from vividc.machine.opcodes import MEMORY, Opcode, Type
from vividc.machine.words import WORD_BYTES
from vividc.ssa.edit import FreshIds
from vividc.ssa.ir import Instr, Ref, Value
from vividc.ssa.polyhedral.forms import symbol
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.scop import Nest, Scop, Statement
from vividc.ssa.polyhedral.subscripts import Access


def in_memory(scop: Scop) -> Scop:
    """The part with the scalars of sums in the elements that they are stored in."""
    ids = FreshIds(scop.function)
    phis = {phi.id for block in scop.function.blocks for phi in block.phis}
    for ident in sorted(scop.depth.keys() & phis):
        home = _home(scop, ident)
        if home is not None and _is_free(scop, home):
            scop = _moved(scop, home, ids)
    return scop


@dataclass(frozen=True)
class _Home:
    """Where a scalar may wait: `span` goes from the statement that begins it to the one that stores
    what becomes of it, by `access`.
    """

    ident: int
    span: tuple[Statement, ...]
    access: Access

    @property
    def names(self) -> tuple[str, ...]:
        """The coordinates of the element."""
        return self.span[-1].coordinates

    def holds(self, access: Access) -> bool:
        """Whether an access is to the element, by the same subscripts."""
        mine = (self.access.array, self.access.subscripts)
        return (access.array, access.subscripts) == mine

    def is_idle(self, statement: Statement, instr: Instr) -> bool:
        """Whether an access does nothing where the scalar waits in the element."""
        if instr.op not in MEMORY or not self.holds(statement.accesses[instr.id]):
            return False
        if instr.op is Opcode.STORE:
            return instr.operands[2] == Ref(self.ident)
        return statement is self.span[0] and (self.ident, Ref(instr.id)) in statement.copies


def _home(scop: Scop, ident: int) -> _Home | None:
    """The element that a scalar ends in; None if there is none."""
    about = [
        statement
        for statement in scop.statements
        if ident in statement.reads or any(phi == ident for phi, _ in statement.copies)
    ]
    if len(about) < 2 or about[0].dims != about[-1].dims or not scop.depth[ident]:  # noqa: PLR2004
        return None
    first, last = about[0], about[-1]
    stores = [access for access in last.accesses.values() if access.is_store]
    values = [value for one in about for phi, value in one.copies if phi == ident]
    is_begun = first.copies and ident not in first.reads and not last.copies
    if not stores or not is_begun or len(first.dims) != scop.depth[ident]:
        return None
    own = {Ref(instr.id) for one in about for instr in one.instrs}
    if any(isinstance(v, Ref) and v.id in scop.depth and v not in own for v in values):
        return None
    siblings = _siblings(scop.nest, first)
    if last not in siblings:
        return None
    begin, end = siblings.index(first), siblings.index(last)
    span = tuple(s for one in siblings[begin : end + 1] for s in _statements(one))
    is_alike = scop.elements[stores[-1].array] is _type(scop, ident)
    is_alike = is_alike and stores[-1].instr.width == WORD_BYTES
    is_plain = not any(one.shift.keys() & set(one.coordinates) for one in (first, last))
    if not is_alike or not is_plain or any(one not in span for one in about):
        return None
    return _Home(ident, span, stores[-1])


def _type(scop: Scop, ident: int) -> object:
    items = (item for block in scop.function.blocks for item in block.items)
    return next(item.type for item in items if item.id == ident)


def _siblings(nest: Nest, statement: Statement) -> list[Nest | Statement]:
    """What is in the same loop as a statement."""
    if statement in nest.children:
        return list(nest.children)
    inside = (_siblings(c, statement) for c in nest.children if isinstance(c, Nest))
    return next((found for found in inside if found), [])


def _statements(node: Nest | Statement) -> Iterator[Statement]:
    if isinstance(node, Statement):
        yield node
    else:
        yield from node.statements()


def _is_free(scop: Scop, home: _Home) -> bool:
    """Whether nothing else touches the element between the first and the last statement."""
    relations = Relations(scop)
    for statement in home.span:
        for instr in statement.instrs:
            access = statement.accesses.get(instr.id)
            if access is None or access.array != home.access.array:
                continue
            is_last = statement is home.span[-1] and access is home.access
            if is_last or home.is_idle(statement, instr):
                continue
            at = statement.placed({name: symbol(name) for name in statement.coordinates})
            meets = " and ".join(
                f"{mine.substituted(at)} = {other}"
                for mine, other in zip(access.subscripts, home.access.subscripts, strict=True)
            )
            names = ", ".join(statement.coordinates)
            same = isl.Set(f"{relations.parameters} -> {{ {statement.name}[{names}] : {meets} }}")
            if not same.is_disjoint(relations.domain(statement)):
                return False
    return True


def _moved(scop: Scop, home: _Home, ids: FreshIds) -> Scop:
    """The part with the scalar in its element."""
    kind = scop.elements[home.access.array]

    def rebuilt(node: Nest) -> Nest:
        children: list[Nest | Statement] = []
        for child in node.children:
            if isinstance(child, Nest):
                children.append(rebuilt(child))
            elif child not in home.span:
                children.append(child)
            else:
                made = _rewritten(child, home, kind, ids)
                children += [made] if made.instrs or made.copies else []
        return Nest(node.dim, tuple(children))

    depth = {ident: count for ident, count in scop.depth.items() if ident != home.ident}
    return replace(scop, nest=rebuilt(scop.nest), depth=depth)


def _rewritten(statement: Statement, home: _Home, kind: Type, ids: FreshIds) -> Statement:
    """A statement that loads the scalar where it reads it, and stores what it becomes."""
    store = home.access.instr
    instrs = list(statement.instrs)
    copies = tuple(copy for copy in statement.copies if copy[0] != home.ident)
    become = [value for ident, value in statement.copies if ident == home.ident]
    accesses = dict(statement.accesses)
    for instr in statement.instrs:
        if home.is_idle(statement, instr):
            if instr.op is Opcode.LOAD:
                become = []
                if any(Ref(instr.id) in other.operands for other in instrs):
                    continue
            instrs.remove(instr)
            del accesses[instr.id]
    reads = tuple(ident for ident in statement.reads if ident != home.ident)
    if any(Ref(home.ident) in instr.operands for instr in instrs):
        load = replace(store, id=ids(), op=Opcode.LOAD, type=kind, operands=store.operands[:2])
        accesses[load.id] = replace(home.access, instr=load)
        instrs = [load, *(_reading(instr, home.ident, Ref(load.id)) for instr in instrs)]
    for value in become:
        made = replace(store, id=ids(), operands=(*store.operands[:2], value))
        accesses[made.id] = replace(home.access, instr=made)
        instrs.append(made)
    return replace(statement, instrs=tuple(instrs), accesses=accesses, reads=reads, copies=copies)


def _reading(instr: Instr, ident: int, value: Value) -> Instr:
    """An instruction that reads a value in place of a scalar."""
    operands = tuple(value if one == Ref(ident) else one for one in instr.operands)
    return replace(instr, operands=operands)
