"""Orders from dependences: which loop of each family may be outermost, and what follows inside.

The outermost loop counts one coordinate of each family, moved by a constant, so that no dependence
goes back; the constants are the longest paths along dependences. What it does not carry orders the
families inside: those that need each other share a loop again, others follow one another (Allen and
Kennedy, "Automatic translation of Fortran programs to vector form", 1987; Feautrier, "Some
efficient solutions to the affine scheduling problem", 1992: the more an outer loop carries, the
less orders those inside).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import islpy as isl
import networkx as nx

from vividc.host import time_limit
from vividc.ssa.polyhedral.forms import Form
from vividc.ssa.polyhedral.orders.families import Family, Member
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.trees import Loop, Tree
from vividc.ssa.polyhedral.values import integer

_MOST_STEPS = 300
"""Coordinates of families that are tried for one loop."""

_FARTHEST = 4
"""By so many iterations one statement may come before another that waits for it; dimensions have
a limit, too, and would be that far apart.
"""

Moved = tuple[str, int]
"""A coordinate of a family's first statement, and what is added to it."""


@dataclass(frozen=True)
class Band:
    """A loop over a coordinate of each of some families, by their numbers, around bands and
    families.
    """

    over: Mapping[int, Moved]
    children: tuple[Band | int, ...]

    def tree(self, families: Sequence[Family]) -> Loop:
        """The order as a tree over the source's statements."""
        over: dict[str, str] = {}
        skew: dict[str, Form] = {}
        for number, (name, moved) in self.over.items():
            for member in families[number]:
                own = member.at[name]
                [(over[member.statement.name], _)] = own.terms
                skew[member.statement.name] = Form((), own.constant + moved)
        children: list[Tree] = []
        for child in self.children:
            if isinstance(child, Band):
                children.append(child.tree(families))
            else:
                children += [member.statement.name for member in families[child]]
        return Loop(over, tuple(children), skew=skew)


@dataclass(frozen=True)
class _Need:
    """Iterations of a member of a family that wait for some of another's: pairs of the two."""

    source: int
    target: int
    one: Member
    other: Member
    pairs: isl.Map
    known: dict[tuple[str, str], int | None] = field(default_factory=dict, compare=False)

    def least(self, over: Mapping[int, str]) -> int | None:
        """By how much the coordinate of the later is more than that of the earlier, at least; None
        if that is far less.
        """
        names = over[self.source], over[self.target]
        if names not in self.known:
            gaps = self.pairs.apply_domain(self._to(self.one, names[0]))
            gaps = gaps.apply_range(self._to(self.other, names[1]))
            least = gaps.deltas().dim_min_val(0)
            is_near = least.is_int() and integer(least) >= -_FARTHEST
            self.known[names] = integer(least) if is_near else None
        return self.known[names]

    def _to(self, member: Member, name: str) -> isl.Map:
        statement = member.statement
        symbols = [str(name) for name in self.pairs.get_var_names(isl.dim_type.param)]
        source = f"{statement.name}[{', '.join(statement.coordinates)}]"
        return isl.Map(f"[{', '.join(symbols)}] -> {{ {source} -> [{member.at[name]}] }}")

    def within(self, over: Mapping[int, Moved]) -> _Need | None:
        """What is left of it inside a loop; None if the loop runs all that it waits for earlier."""
        (first, before), (second, after) = over[self.source], over[self.target]
        least = self.least({n: name for n, (name, _) in over.items()})
        assert least is not None
        if least + after - before > 0:
            return None
        times = [self._to(self.one, first), self._to(self.other, second)]
        shift = isl.Map(f"{{ [t] -> [t + ({before - after})] }}")
        together = times[0].apply_range(shift).apply_range(times[1].reverse())
        return _Need(self.source, self.target, self.one, self.other, self.pairs.intersect(together))


@dataclass(frozen=True)
class Bands:
    """Orders of a part's families."""

    relations: Relations
    families: tuple[Family, ...]

    def found(self) -> Iterator[Band]:
        """All families in one loop, those first whose loop carries the most dependences."""
        every = tuple(range(len(self.families)))
        free = {n: self.families[n][0].statement.coordinates for n in every}
        ways: list[tuple[int, int, dict[int, Moved], list[_Need]]] = []
        for over in self._loops(every, free, self.needs):
            left = _within(self.needs, over)
            ways.append((len(left), len(ways), over, left))
        for _, _, over, left in sorted(ways, key=lambda way: way[:2]):
            children = self._inside(every, _without(free, over), left)
            if children is not None:
                yield Band(over, children)

    @cached_property
    def needs(self) -> tuple[_Need, ...]:
        """All dependences."""
        members = {m.statement.name: (n, m) for n, f in enumerate(self.families) for m in f}
        found = []
        dependences = self.relations.dependences.get_map_list()
        for place in range(dependences.n_map()):
            pairs = dependences.get_at(place)
            ends = [
                members[pairs.get_tuple_name(end)] for end in (isl.dim_type.in_, isl.dim_type.out)
            ]
            [(source, one), (target, other)] = ends
            found.append(_Need(source, target, one, other, pairs))
        return tuple(found)

    def _inside(
        self,
        families: tuple[int, ...],
        free: Mapping[int, tuple[str, ...]],
        needs: list[_Need],
    ) -> tuple[Band | int, ...] | None:
        """What follows one another inside a loop; None if no loop keeps some dependence."""
        graph = nx.DiGraph()
        graph.add_nodes_from(families)
        graph.add_edges_from((need.source, need.target) for need in needs)
        whole = nx.condensation(graph)
        children: list[Band | int] = []
        for node in nx.lexicographical_topological_sort(
            whole, key=lambda node: min(whole.nodes[node]["members"])
        ):
            members = tuple(sorted(whole.nodes[node]["members"]))
            own = [n for n in needs if n.source in members and n.target in members]
            if not any(free[member] for member in members):
                if own or len(members) > 1:
                    return None
                children.append(members[0])
                continue
            band = self._band(members, free, own)
            if band is None:
                return None
            children.append(band)
        return tuple(children)

    def _band(
        self,
        families: tuple[int, ...],
        free: Mapping[int, tuple[str, ...]],
        needs: list[_Need],
    ) -> Band | None:
        """The first loop, by the source's order of coordinates, inside which an order is found."""
        for over in self._loops(families, free, needs):
            left = _within(needs, over)
            children = self._inside(families, _without(free, over), left)
            if children is not None:
                return Band(over, children)
        return None

    def _loops(
        self,
        families: tuple[int, ...],
        free: Mapping[int, tuple[str, ...]],
        needs: Iterable[_Need],
    ) -> Iterator[dict[int, Moved]]:
        """Coordinates of families, and constants, by which no dependence goes back."""
        needs = list(needs)
        chosen: dict[int, str] = {}
        steps = itertools.count()

        def choose(place: int) -> Iterator[dict[int, Moved]]:
            if place == len(families):
                moved = self._moved(families, chosen, needs)
                if moved is not None:
                    yield {n: (chosen[n], moved[n]) for n in families}
                return
            family = families[place]
            for name in free[family]:
                if next(steps) >= _MOST_STEPS:
                    return
                time_limit.step("outermost loops were tried")
                chosen[family] = name
                if all(
                    need.least(chosen) is not None
                    for need in needs
                    if family in (need.source, need.target)
                    and {need.source, need.target} <= chosen.keys()
                ):
                    yield from choose(place + 1)
                del chosen[family]

        yield from choose(0)

    def _moved(
        self, families: tuple[int, ...], chosen: Mapping[int, str], needs: list[_Need]
    ) -> dict[int, int] | None:
        """The least constants that keep dependences, as longest paths; None if there are none."""
        moved = dict.fromkeys(families, 0)
        for _ in families:
            changed = False
            for need in needs:
                least = need.least(chosen)
                assert least is not None
                wanted = moved[need.source] - least
                if wanted > moved[need.target]:
                    moved[need.target], changed = wanted, True
            if not changed:
                return moved
        return None


def _within(needs: Iterable[_Need], over: Mapping[int, Moved]) -> list[_Need]:
    """What is left of dependences inside a loop."""
    inside = (need.within(over) for need in needs)
    return [need for need in inside if need is not None]


def _without(
    free: Mapping[int, tuple[str, ...]], over: Mapping[int, Moved]
) -> dict[int, tuple[str, ...]]:
    """The coordinates that a loop does not count."""
    return {n: tuple(name for name in free[n] if name != over[n][0]) for n in over}
