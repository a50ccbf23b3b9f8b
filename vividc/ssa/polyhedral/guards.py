"""Guards: tests under which iterations run masked instead of in branches of their own.

What a masked iteration computes counts only where its guard holds: it loads and stores under a
predicate, and the arithmetic between runs in any case.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from vividc.ssa.polyhedral.forms import Form
from vividc.ssa.polyhedral.loops import Code, For, If, Run, Test

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
