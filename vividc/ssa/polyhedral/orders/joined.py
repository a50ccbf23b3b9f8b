"""Orders in which two nests that run one after the other are one.

One that goes through a matrix by rows and one by columns (`r @ a` and `a @ p`) load each element
once if they are one nest. Where a nest begins sums before its inner loop, and they wait in memory
(`in_memory`), these beginnings are a loop of their own, so that the others may be interchanged.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TypeVar

from vividc.ssa.polyhedral.forms import Form, symbol
from vividc.ssa.polyhedral.orders.search import fused, interchanged, is_legal, loops_in
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.scop import Scop
from vividc.ssa.polyhedral.trees import Loop, Tree, statements_in

_Way = TypeVar("_Way")


def together(tree: Loop, relations: Relations) -> Iterator[Loop]:
    """Legal orders in which the two nests of a loop that runs once are one, interchanged or not."""
    for pair in _pairs([one, *interchanged(one)] for one in _two_nests(tree)):
        for both in fused(replace(tree, children=pair)):
            [made] = both.children
            if isinstance(made, Loop) and is_legal(made, relations):
                yield made


def divided(tree: Loop, relations: Relations) -> Iterator[Loop]:
    """As `together`, of nests whose statements before and behind their inner loops have loops of
    their own: those in which each iteration needs an element of a matrix once.
    """
    for first, second in _pairs(map(_divided, _two_nests(tree))):
        for both in fused(replace(tree, children=(first.inner, second.inner))):
            if not _shares(both, relations.scop):
                continue
            before, behind = (*first.before, *second.before), (*first.behind, *second.behind)
            made = replace(tree, children=(*before, *both.children, *behind))
            if is_legal(made, relations):
                yield made


def _pairs(ways: Iterable[Iterable[_Way]]) -> Iterator[tuple[_Way, ...]]:
    """One way of each of two nests; none of no nests."""
    return (pair for pair in itertools.product(*ways) if pair)


def _two_nests(tree: Loop) -> tuple[Loop, ...]:
    """What is in a loop, if that is two nests."""
    nests = tuple(child for child in tree.children if isinstance(child, Loop))
    return nests if len(nests) == len(tree.children) == 2 else ()  # noqa: PLR2004 - nests


@dataclass(frozen=True)
class _Divided:
    """A nest as loops in a row: what is before its inner loop, this loop, and what follows."""

    before: tuple[Loop, ...]
    inner: Loop
    behind: tuple[Loop, ...]


def _divided(nest: Loop) -> Iterator[_Divided]:
    """A nest of two loops, divided if there are statements; the loops interchanged or not."""
    places = [n for n, child in enumerate(nest.children) if isinstance(child, Loop)]
    if len(places) != 1:
        return
    [place] = places
    before, behind = nest.children[:place], nest.children[place + 1 :]
    inner = _part(nest, nest.children[place : place + 1])
    for one in (inner, *interchanged(inner)):
        yield _Divided(_loop(nest, before), one, _loop(nest, behind))


def _loop(nest: Loop, children: tuple[Tree, ...]) -> tuple[Loop, ...]:
    """A loop over some of what a nest runs; none for nothing."""
    return (_part(nest, children),) if children else ()


def _part(nest: Loop, children: tuple[Tree, ...]) -> Loop:
    """The nest with some of its children only."""
    over = {name: nest.over[name] for child in children for name in statements_in(child)}
    return replace(nest, over=over, children=children)


def _shares(tree: Loop, scop: Scop) -> bool:
    """Whether two statements access one element of a matrix in the same iteration of all loops."""
    counters: dict[str, dict[str, Form]] = {name: {} for name in statements_in(tree)}
    for path, loop in loops_in(tree):
        for name in statements_in(loop):
            counters[name][loop.over[name]] = symbol(str(path))
    readers: dict[tuple[str, tuple[Form, ...]], str] = {}
    for name, given in counters.items():
        statement = scop.statement(name)
        at = statement.placed(given)
        for access in statement.accesses.values():
            places = tuple(one.substituted(at) for one in access.subscripts)
            reader = readers.setdefault((access.array, places), name)
            if len(places) > 1 and reader != name:
                return True
    return False
