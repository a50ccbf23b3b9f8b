"""Guards: tests under which iterations run masked instead of in branches of their own.

What a masked iteration computes counts only where its guard holds: it loads and stores under a
predicate, and the arithmetic between runs in any case. `Accessed`: what code loads and stores, and
under which guards.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from vividc.ssa.ir import Instr
from vividc.ssa.polyhedral.forms import Form
from vividc.ssa.polyhedral.loops import Code, For, If, Run, Test
from vividc.ssa.polyhedral.subscripts import Place

Guard = frozenset[Form]
"""All of these are at least 0; none follows from another one."""

ALWAYS: Guard = frozenset()
"""The guard that holds anywhere."""


def guard_of(test: Test) -> Guard | None:
    """The guard that holds where a test does; None if it is no conjunction."""
    left = test.left
    if test.relation == "and":
        guard: Guard | None = ALWAYS
        for part in test.parts:
            other = guard_of(part)
            guard = None if guard is None or other is None else both(guard, other)
        return guard
    less = left.times(-1)
    bounds = {
        ">=": (left,),
        ">": (left.plus(Form((), -1)),),
        "<=": (less,),
        "<": (less.plus(Form((), -1)),),
        "==": (left, less),
    }
    return frozenset(bounds[test.relation]) if test.relation in bounds else None


def both(one: Guard, other: Guard) -> Guard:
    """The guard that holds where two do."""
    least: dict[object, Form] = {}
    for form in (*one, *other):
        known = least.get(form.terms)
        if known is None or form.constant < known.constant:
            least[form.terms] = form
    return frozenset(least.values())


def implies(one: Guard, other: Guard) -> bool:
    """Whether the second is seen to hold where the first does."""
    return not other or one == other or both(one, other) == one


def moved(guard: Guard, at: Mapping[str, Form]) -> Guard | None:
    """The guard with forms in place of names; None if it is seen never to hold then."""
    forms = [form.substituted(at) for form in guard]
    if any(not form.terms and form.constant < 0 for form in forms):
        return None
    return both(frozenset(form for form in forms if form.terms), ALWAYS)


def names_of(guard: Guard) -> frozenset[str]:
    """What a guard is made of."""
    return frozenset(name for form in guard for name in form.names)


def is_maskable(item: Code) -> bool:
    """Whether it is iterations of statements without a branch that a guard cannot replace."""
    if isinstance(item, For):
        return False
    if isinstance(item, Run):
        return True
    return (
        not item.otherwise and guard_of(item.test) is not None and all(map(is_maskable, item.then))
    )


def masked(item: Code, guard: Guard = ALWAYS) -> Iterator[tuple[Run, Guard]]:
    """The iterations of what `is_maskable`, each with its guard."""
    if isinstance(item, Run):
        yield item, guard
    elif isinstance(item, If):
        inside = guard_of(item.test)
        assert inside is not None
        for child in item.then:
            yield from masked(child, both(guard, inside))


@dataclass
class Accessed:
    """What code accesses: whether it writes a place, a load of it if there is one, and the guards
    of its accesses.
    """

    written: dict[Place, bool] = field(default_factory=dict)
    loads: dict[Place, Instr] = field(default_factory=dict)
    guards: dict[Place, set[Guard]] = field(default_factory=dict)

    def add(self, place: Place, guard: Guard, *, written: bool) -> None:
        """One more access."""
        self.written[place] = self.written.get(place, False) or written
        self.guards.setdefault(place, set()).add(guard)

    def add_all(self, other: Accessed) -> None:
        """What other code accesses, too."""
        written, guards = self.written, self.guards
        for place, is_written in other.written.items():
            if place in written:
                written[place] = written[place] or is_written
                guards[place] |= other.guards[place]
            else:
                written[place] = is_written
                guards[place] = set(other.guards[place])
        for place, load in other.loads.items():
            self.loads.setdefault(place, load)

    def widest(self, place: Place) -> Guard | None:
        """The guard that holds wherever a place is accessed, if one of its accesses has it."""
        guards = self.guards[place]
        return next((one for one in guards if all(implies(other, one) for other in guards)), None)

    def is_sure(self, place: Place, guard: Guard) -> bool:
        """Whether a place is accessed wherever a guard holds."""
        return any(implies(guard, other) for other in self.guards.get(place, ()))
