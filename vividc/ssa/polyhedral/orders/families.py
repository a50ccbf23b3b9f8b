"""Statements that do the same at different iterations: parts of one, that the source keeps apart.

`a[i, j] -= a[i, k] * a[k, j]` for k < j below the diagonal, and for k < i above it (lu), is one
statement for all k < min(i, j); on the diagonal `a[i, i] -= a[i, k] * a[i, k]` is the one for j = i
of `a[i, j] -= a[i, k] * a[j, k]` (cholesky).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import islpy as isl

from vividc.machine.opcodes import MEMORY, Opcode
from vividc.ssa.ir import Instr, Ref, Value
from vividc.ssa.polyhedral.forms import Form, symbol
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.scop import Scop, Statement


@dataclass(frozen=True)
class Member:
    """A statement, and where it is among the iterations of another: `at` has that one's
    coordinates as forms of its own.
    """

    statement: Statement
    at: Mapping[str, Form]


Family = tuple[Member, ...]
"""The first has the most coordinates; each other does what the first would do there."""


def families_of(relations: Relations) -> list[Family]:
    """All statements, those that may be one together, in order of the first of each."""
    scop = relations.scop
    found: list[Family] = []
    for statement in sorted(scop.statements, key=lambda one: -len(one.dims)):
        for number, family in enumerate(found):
            at = _places(scop, family[0].statement, statement)
            if at is not None and _is_apart(family, made := Member(statement, at), relations):
                found[number] = (*family, made)
                break
        else:
            own = {name: symbol(name) for name in statement.coordinates}
            found.append((Member(statement, own),))
    order = [statement.name for statement in scop.statements]
    return sorted(found, key=lambda family: min(order.index(m.statement.name) for m in family))


def domain_in(member: Member, forms: Sequence[Form], relations: Relations) -> isl.Set:
    """A member's iterations at these forms of the first's coordinates."""
    statement = member.statement
    text = ", ".join(str(form.substituted(member.at)) for form in forms)
    source = f"{statement.name}[{', '.join(statement.coordinates)}]"
    moved = isl.Map(f"{relations.parameters} -> {{ {source} -> [{text}] }}")
    return relations.domain(statement).apply(moved)


def _is_apart(family: Family, added: Member, relations: Relations) -> bool:
    """Whether no iteration of the first is one of two members."""
    forms = [symbol(name) for name in family[0].statement.coordinates]
    own = domain_in(added, forms, relations)
    others = (domain_in(member, forms, relations) for member in family)
    return all(own.is_disjoint(other) for other in others)


def _places(scop: Scop, host: Statement, guest: Statement) -> dict[str, Form] | None:
    """The host's coordinates where it does what the guest does; None if it does something else."""
    pairs = _Matching(scop, host, guest).forms()
    if pairs is None:
        return None
    at: dict[str, Form] = {}
    for mine, theirs in pairs:
        if len(mine.terms) == 1 and mine.terms[0][1] == 1:
            at.setdefault(mine.terms[0][0], theirs.plus(Form((), -mine.constant)))
    terms = [form.terms for form in at.values()]
    is_plain = all(len(one) == 1 and one[0][1] == 1 for one in terms)
    if at.keys() != set(host.coordinates) or not is_plain:
        return None
    if {name for one in terms for name, _ in one} != set(guest.coordinates):
        return None
    return at if all(mine.substituted(at) == theirs for mine, theirs in pairs) else None


class _Different(Exception):
    pass


@dataclass(frozen=True)
class _Matching:
    """Instructions of a statement, each beside one of another that does the same: the other may do
    once what it does several times (of `a[i, k] * a[i, k]` one load).
    """

    scop: Scop
    host: Statement
    guest: Statement

    def forms(self) -> list[tuple[Form, Form]] | None:
        """Pairs of forms that must be equal; None if the statements differ otherwise.

        Each has one store, which comes last: when its loads are made does not matter.
        """
        one, other = _store_of(self.host), _store_of(self.guest)
        beside: dict[int, int] = {}
        pairs: list[tuple[Form, Form]] = []
        try:
            self._match(one, other, beside, pairs)
        except _Different:
            return None
        if len(beside) < len(self.host.instrs) or len({*beside.values()}) < len(self.guest.instrs):
            return None
        inside, there = (
            statement.placed({name: symbol(name) for name in statement.coordinates})
            for statement in (self.host, self.guest)
        )
        return [(mine.substituted(inside), theirs.substituted(there)) for mine, theirs in pairs]

    def _match(
        self,
        one: Instr | None,
        other: Instr | None,
        beside: dict[int, int],
        pairs: list[tuple[Form, Form]],
    ) -> None:
        if one is None or other is None or _kind(one) != _kind(other):
            raise _Different
        if one.id in beside:
            if beside[one.id] != other.id:
                raise _Different
            return
        beside[one.id] = other.id
        operands = [one.operands, other.operands]
        if one.op in MEMORY:
            accesses = self.host.accesses[one.id], self.guest.accesses[other.id]
            pairs += zip(*(access.subscripts for access in accesses), strict=True)
            operands = [values[2:] for values in operands]
        for mine, theirs in zip(*operands, strict=True):
            self._values(mine, theirs, beside, pairs)

    def _values(
        self, mine: Value, theirs: Value, beside: dict[int, int], pairs: list[tuple[Form, Form]]
    ) -> None:
        own = _instr(self.host, mine)
        if own is not None:
            self._match(own, _instr(self.guest, theirs), beside, pairs)
        elif isinstance(mine, Ref) and isinstance(theirs, Ref) and mine.id in self.scop.indices:
            if theirs.id not in self.scop.indices:
                raise _Different
            pairs.append((self.scop.indices[mine.id], self.scop.indices[theirs.id]))
        elif mine != theirs:
            raise _Different


def _store_of(statement: Statement) -> Instr | None:
    """Its only store, if it accesses nothing after it."""
    accesses = [instr for instr in statement.instrs if instr.op in MEMORY]
    ops = [instr.op for instr in accesses]
    return accesses[-1] if ops.count(Opcode.STORE) == 1 and ops[-1] is Opcode.STORE else None


def _instr(statement: Statement, value: Value) -> Instr | None:
    """The instruction of a statement that computes a value."""
    ident = value.id if isinstance(value, Ref) else None
    return next((instr for instr in statement.instrs if instr.id == ident), None)


def _kind(instr: Instr) -> Instr:
    """What it does, wherever it stands: its operands, and where it accesses what, aside."""
    operands = instr.operands[:1] if instr.op in MEMORY else ()
    return replace(instr, id=0, operands=operands, offset=0, subscript=(), distinct="")
