"""Orders of a part's iterations: trees of loops over statements, some of them unrolled and jammed.

A tree says in which order statements run; `schedule_of` gives it to isl. A loop with a factor runs
so many of its iterations together in the loops inside it (unroll-and-jam). What does not fill whole
groups of iterations follows behind; groups that the edge of a triangle cuts, always in the same
way, are jammed too. Of a loop inside whose bounds differ within a group, what only some iterations
run comes before and behind, where it belongs. Where rows of a group need each other (`in_order`),
what they have in common comes first, and the rest row by row.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace

import islpy as isl

from vividc.ssa.polyhedral.forms import Form
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.scop import Scop
from vividc.ssa.polyhedral.trees import (
    Loop,
    Site,
    Tiles,
    Tree,
    group_of,
    is_in_order,
    statements_in,
    without,
)


def schedule_of(tree: Loop, relations: Relations) -> isl.Schedule:
    """isl's schedule tree of all iterations."""
    domains = relations.domains(statements_in(tree))
    child = _Ordering(relations, Tiles(relations)).node(tree, Site(domains, ()))
    return _read(relations, domains, child)


@dataclass(frozen=True)
class Along:
    """Iterations of a group along a coordinate, by its place: those below `limit`, if there is one,
    a form of the statement's coordinates outside groups and of symbols.
    """

    coordinate: int
    factor: int
    limit: Form | None = None


@dataclass(frozen=True)
class Group:
    """The iterations that the first of a group stands for, the last of these changing first; then
    those of other statements with the same ones.
    """

    coordinates: tuple[str, ...]
    along: tuple[Along, ...]
    twins: tuple[str, ...] = ()


@dataclass
class Grouped:
    """What a schedule leaves to others that runs the first iteration of each group only, where all
    others run, or those up to a limit.

    Attributes
    ----------
    marks
        The group that a mark stands for.
    twins
        Statements that run right behind one, in the same iterations: isl is told of that one only.
    left
        The iterations that are run, by statement.
    """

    marks: dict[str, Group] = field(default_factory=dict)
    twins: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    left: dict[str, isl.Set] = field(default_factory=dict)

    def leaf(self, name: str, domain: isl.Set) -> None:
        """Iterations of a statement run at a leaf."""
        self.left[name] = self.left[name].union(domain) if name in self.left else domain

    def mark(self, group: Group) -> str:
        """The mark of such groups."""
        name = next((name for name, known in self.marks.items() if known == group), None)
        if name is None:
            name = f"group_{len(self.marks)}"
            self.marks[name] = group
        return name


def grouped_schedule_of(tree: Loop, relations: Relations) -> tuple[isl.Schedule, Grouped]:
    """isl's schedule tree, with one iteration for each group that is whole, or masked along loops
    with one limit, and one statement for several with the same iterations: writing out the others
    takes isl most of its time.
    """
    twins: dict[str, tuple[str, ...]] = {}
    if not _has_skews(tree):
        with suppress(_Apart):
            return _grouped(_without_twins(tree, (), relations.scop, twins), relations, twins)
    return _grouped(tree, relations, {})


def _grouped(
    tree: Loop, relations: Relations, twins: Mapping[str, tuple[str, ...]]
) -> tuple[isl.Schedule, Grouped]:
    grouped = Grouped(twins=twins)
    domains = relations.domains(statements_in(tree))
    child = _Ordering(relations, Tiles(relations), grouped).node(tree, Site(domains, ()))
    return _read(relations, grouped.left, child), grouped


class _Apart(Exception):
    """Statements with the same iterations do not run one right behind the other in each."""


def _without_twins(
    tree: Loop, around: tuple[Loop, ...], scop: Scop, twins: dict[str, tuple[str, ...]]
) -> Loop:
    """The tree without statements that have the iterations of the one before them."""
    children: list[Tree] = []
    loops = (*around, tree)
    for child in tree.children:
        before = children[-1] if children else None
        if not isinstance(child, str):
            children.append(_without_twins(child, loops, scop, twins))
        elif isinstance(before, str) and _are_twins(before, child, loops, scop):
            twins[before] = (*twins.get(before, ()), child)
        else:
            children.append(child)
    return replace(tree, children=tuple(children))


def _has_skews(tree: Tree) -> bool:
    return isinstance(tree, Loop) and (bool(tree.skew) or any(map(_has_skews, tree.children)))


def _are_twins(one: str, other: str, loops: tuple[Loop, ...], scop: Scop) -> bool:
    first, second = scop.statement(one), scop.statement(other)
    same = first.dims == second.dims and first.guards == second.guards
    return same and all(loop.over[one] == loop.over[other] for loop in loops)


def _read(relations: Relations, domains: Mapping[str, isl.Set], child: str) -> isl.Schedule:
    text = f'{{ domain: "{relations.union(domains)}"{_child(child)} }}'
    return isl.Schedule.read_from_str(isl.DEFAULT_CONTEXT, text)


@dataclass(frozen=True)
class _Ordering:
    relations: Relations
    tiles: Tiles
    grouped: Grouped | None = None

    def node(self, tree: Tree, place: Site) -> str:
        """The tree as isl writes it; "" for a statement by itself."""
        if isinstance(tree, str):
            return self._points(tree, place)
        if tree.factor == 1:
            return self._once(tree, place)
        if tree.masked:
            whole, rest = place, replace(place, domains={})
        else:
            whole, rest = self.tiles.split(place, tree)
        tiles = self.tiles.ragged(place, rest, tree) if self.tiles.differ(place, tree) else []
        for tile in tiles:
            rest = without(rest, tile)
        first = self.tiles.before(rest, whole, tree)
        ahead = [whole.is_empty or not self.tiles.before(t, whole, tree).is_empty for t in tiles]
        behind = itertools.compress(tiles, (not one for one in ahead))
        tiles = list(itertools.compress(tiles, ahead))
        single = replace(tree, factor=1)
        nodes = [(part, self.node(single, part)) for part in [first] if not part.is_empty]
        for part in (*tiles, whole, *behind):
            if not part.is_empty:
                nodes.append((part, self._groups(tree, part)))
        last = without(rest, first)
        if not last.is_empty:
            nodes.append((last, self.node(single, last)))
        return self._sequence(nodes)

    def _groups(self, tree: Loop, place: Site) -> str:
        """A jammed loop over groups of iterations."""
        around, jammed = (*place.around, tree), (*place.jammed, tree)
        inside = self._inside(tree, replace(place, around=around, jammed=jammed))
        option = "separate" if is_in_order(tree) and not tree.masked else ""
        return self._band([(tree, group_of(tree))], place, inside, option)

    def _once(self, tree: Loop, place: Site) -> str:
        """A loop that is not jammed: what only some iterations of a group around it run comes
        before and after what all of them run, in its order.
        """
        inside = replace(place, around=(*place.around, tree))
        if not self.tiles.differ(place, tree):
            short = place.apart and self.tiles.is_short(place, inside.around)
            option = "unroll" if short else "separate"
            return self._band([(tree, "{0}")], place, self._inside(tree, inside), option)
        nodes = []
        for part, option in self._in_order(place, inside.around):
            inner = self._inside(tree, replace(inside, domains=part.domains))
            nodes.append((part, self._band([(tree, "{0}")], part, inner, option)))
        return self._sequence(nodes)

    def _inside(self, tree: Loop, place: Site) -> str:
        """The children of a loop, jammed, or in the order of the iterations of the groups."""
        place = replace(place, members=place.domains)
        if not (tree.in_order and place.jammed):
            return self._children(tree, place)
        whole = self.tiles.together(tree, place)
        rest = without(place, whole)
        nodes = [] if whole.is_empty else [(whole, self._children(tree, whole))]
        if not rest.is_empty:
            single = replace(rest, jammed=(), apart=(*rest.apart, *rest.jammed))
            forms = [(loop, f"({{0}}) - ({group_of(loop)})") for loop in rest.jammed]
            nodes.append((rest, self._band(forms, rest, self._children(tree, single), "unroll")))
        return self._sequence(nodes)

    def _in_order(self, place: Site, loops: tuple[Loop, ...]) -> Iterator[tuple[Site, str]]:
        """What some iterations of a group run first, what all run, and what some run last, each
        with isl's option for its loop: few iterations are written out.
        """
        common = self.tiles.common(place, loops)
        last = self.tiles.behind(loops).intersect_domain(common).range()
        whole = self.tiles.within(place, loops, common)
        rest = without(place, whole)
        after = self.tiles.within(rest, loops, last)
        for part, is_whole in ((without(rest, after), False), (whole, True), (after, False)):
            if not part.is_empty:
                few = not is_whole and self.tiles.is_short(part, loops)
                yield part, "unroll" if few else "separate"

    def _children(self, tree: Loop, place: Site) -> str:
        nodes = []
        for child in tree.children:
            names = set(statements_in(child))
            domains = {name: d for name, d in place.domains.items() if name in names}
            inside = replace(place, domains=domains)
            if not inside.is_empty:
                every = "; ".join(map(self.tiles.named, domains))  # what is around says which
                text = f"{self.relations.parameters} -> {{ {every} }}"
                nodes.append((text, self.node(child, inside)))
        return _sequence(nodes)

    def _sequence(self, nodes: list[tuple[Site, str]]) -> str:
        """Parts of what a loop runs, one after the other."""
        if len(nodes) <= 1:
            return "".join(node for _, node in nodes)
        return _sequence([(str(self.relations.union(place.domains)), n) for place, n in nodes])

    def _points(self, name: str, place: Site) -> str:
        """The iterations of a group, one after another."""
        partly = place.jammed
        leaf = ""
        if self.grouped is not None:
            partly, along = self._along(name, place)
            leaf = self._first_of(name, place, place.jammed[len(partly) :], along, self.grouped)
        if not partly:
            return leaf
        if self.grouped is not None and name in self.grouped.twins:
            raise _Apart
        forms = [(loop, f"({{0}}) - ({group_of(loop)})") for loop in partly]
        return self._band(forms, place, leaf, "unroll")

    def _first_of(
        self,
        name: str,
        place: Site,
        loops: tuple[Loop, ...],
        along: tuple[Along, ...],
        grouped: Grouped,
    ) -> str:
        """The first iteration of each group along loops, marked."""
        domain = place.domains[name]
        if not loops:
            grouped.leaf(name, domain)
            return ""
        firsts = [f"{loop.over[name]} = {group_of(loop).format(loop.over[name])}" for loop in loops]
        text = f"{{ {self.tiles.named(name)} : {' and '.join(firsts)} }}"
        grouped.leaf(name, domain.intersect(isl.Set(f"{self.relations.parameters} -> {text}")))
        coordinates = self.relations.scop.statement(name).coordinates
        group = Group(coordinates, along, grouped.twins.get(name, ()))
        return f'{{ mark: "{grouped.mark(group)}", child: {{ leaf }} }}'

    def _along(self, name: str, place: Site) -> tuple[tuple[Loop, ...], tuple[Along, ...]]:
        """Jammed loops, and what groups have along the innermost of them of which one iteration
        says which others run: of loops whose groups are all full, or end at one limit.
        """
        jammed = place.jammed
        if any(loop.skew for loop in place.around):
            return jammed, ()  # its other iterations are not beside the first
        statement = self.relations.scop.statement(name)
        coordinates = statement.coordinates
        is_whole = place.domains[name].plain_is_equal(self.relations.domain(statement))
        found: list[Along] = []
        for loop in reversed(jammed):
            limit = self._limit(name, place, loop)
            if limit is None and not is_whole and any(one.limit is not None for one in found):
                break  # isl ends a loop over the first iterations of full groups otherwise
            if limit is None and not self._are_full(name, place, loop):
                break
            found.append(Along(coordinates.index(loop.over[name]), loop.factor, limit))
        partly = jammed[: len(jammed) - len(found)]
        whole = list(itertools.takewhile(lambda one: one.limit is None, found))
        along = (*reversed(found[len(whole) :]), *sorted(whole, key=lambda one: one.coordinate))
        return partly, along

    def _are_full(self, name: str, place: Site, loop: Loop) -> bool:
        """Whether all groups along a loop are full."""
        band = self.tiles.reached({name: place.domains[name]}, place.around)
        return bool(band.is_subset(self.tiles.filled(band, place.around, loop)))

    def _limit(self, name: str, place: Site, loop: Loop) -> Form | None:
        """Where masked groups along a loop end, if that is one form whatever runs beside, and in
        the middle of some groups.
        """
        scop = self.relations.scop
        statement = scop.statement(name)
        own = scop.dimension(name, loop.over[name])
        first, limit = own.bounds
        jammed = {other.over[name] for other in place.jammed}
        beside = [bound for dim in statement.dims if dim is not own for bound in dim.bounds]
        ends_inside = any(factor % loop.factor for _, factor in limit.plus(first, -1).terms)
        grows = any(factor > 0 and one in scop.symbols for one, factor in limit.terms)
        if not (loop.masked and first == loop.base and ends_inside and grows):
            return None
        if any(scop.dimension(*one).bounds != own.bounds for one in loop.over.items()):
            return None  # isl tells what runs beside what by all limits at once
        if any(own.name in form.names for form in (*beside, *statement.guards)):
            return None
        if limit.names & jammed:
            return None
        position = statement.coordinates.index(own.name)
        is_all = self._is_all(place.domains[name], self.relations.domain(statement), position)
        return limit if is_all else None

    def _is_all(self, part: isl.Set, domain: isl.Set, position: int) -> bool:
        """Whether what is left of a statement's iterations has along a coordinate all that they
        have.
        """
        if part.plain_is_equal(domain):
            return True
        anywhere = part.eliminate(isl.dim_type.set, position, 1)
        return bool(anywhere.intersect(domain).is_subset(part))

    def _band(self, members: list[tuple[Loop, str]], place: Site, child: str, option: str) -> str:
        maps = []
        for loop, text in members:
            images = [
                f"{self.tiles.named(name)} -> [({text.format(loop.counted(name))})]"
                for name, domain in place.domains.items()
                if not domain.is_empty()
            ]
            maps.append(f"{{ {'; '.join(images)} }}")
        schedule = f"[{', '.join(maps)}]"
        if self.relations.scop.symbols:  # isl would read `[]` before the arrow as all of it
            schedule = f"{self.relations.parameters} -> {schedule}"
        options = f', options: "{{ {option}[x] }}"' if option else ""
        return f'{{ schedule: "{schedule}"{options}{_child(child)} }}'


def _child(node: str) -> str:
    return f", child: {node}" if node else ""


def _sequence(nodes: list[tuple[str, str]]) -> str:
    """Nodes one after the other, each of what is in a set."""
    if len(nodes) <= 1:
        return "".join(node for _, node in nodes)
    filters = [f'{{ filter: "{taken}"{_child(node)} }}' for taken, node in nodes]
    return f"{{ sequence: [ {', '.join(filters)} ] }}"
