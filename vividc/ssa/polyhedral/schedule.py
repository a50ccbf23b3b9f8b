"""Orders of a part's iterations: trees of loops over statements, some of them unrolled and jammed.

A tree says in which order statements run; `schedule_of` gives it to isl. A loop with a factor runs
so many of its iterations together in the loops inside it (unroll-and-jam). What does not fill whole
groups of iterations follows behind; of a loop inside whose bounds differ within a group, what only
some iterations run comes before and behind, where it belongs.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import islpy as isl

from vividc.ssa.polyhedral.forms import ZERO, Form, symbol
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.scop import Dimension, Nest, Scop, Statement


@dataclass(frozen=True)
class Loop:
    """A loop over a coordinate of each statement in it.

    Attributes
    ----------
    over
        What it counts, by statement: one of the statement's coordinates.
    factor
        So many iterations run together.
    base
        Where groups of iterations begin.
    masked
        Whether groups that are not full run as the others do, what is missing masked out; else
        they follow behind, an iteration at a time.
    """

    over: Mapping[str, str]
    children: tuple[Tree, ...]
    factor: int = 1
    base: Form = ZERO
    masked: bool = False


Tree = Loop | str
"""A loop, or a statement by its name."""


def tree_of(scop: Scop) -> Loop:
    """The order of the source."""

    def convert(node: Nest | Statement) -> Tree:
        if isinstance(node, Statement):
            return node.name
        children = tuple(map(convert, node.children))
        over = {statement.name: node.dim.name for statement in node.statements()}
        first = node.dim.bounds[0]
        base = first if first.names <= scop.symbols.keys() else ZERO
        return Loop(over, children, base=base)

    tree = convert(scop.nest)
    assert isinstance(tree, Loop)
    return tree


def statements_in(tree: Tree) -> Iterator[str]:
    """Names of the statements of a tree, in order."""
    if isinstance(tree, str):
        yield tree
    else:
        for child in tree.children:
            yield from statements_in(child)


def schedule_of(tree: Loop, relations: Relations) -> isl.Schedule:
    """isl's schedule tree."""
    by_name = {statement.name: statement for statement in relations.scop.statements}
    domains = {name: relations.domain(by_name[name]) for name in statements_in(tree)}
    ordering = _Ordering(relations)
    child = ordering.node(tree, _Place(domains, ()))
    text = f'{{ domain: "{ordering.union(domains)}"{_child(child)} }}'
    return isl.Schedule.read_from_str(isl.DEFAULT_CONTEXT, text)


@dataclass(frozen=True)
class _Place:
    """Where a tree stands: what is left to run, and the loops around it."""

    domains: Mapping[str, isl.Set]
    around: tuple[Loop, ...]
    jammed: tuple[Loop, ...] = ()

    @property
    def is_empty(self) -> bool:
        """Whether nothing is left."""
        return all(domain.is_empty() for domain in self.domains.values())


@dataclass(frozen=True)
class _Ordering:
    relations: Relations

    def node(self, tree: Tree, place: _Place) -> str:
        """The tree as isl writes it; "" for a statement by itself."""
        if isinstance(tree, str):
            return self._points(tree, place)
        if tree.factor == 1:
            return self._once(tree, place)
        if tree.masked:
            whole, rest = place, replace(place, domains={})
        else:
            whole, rest = self._split(place, tree)
        nodes = []
        if not whole.is_empty:
            inside = replace(whole, around=(*whole.around, tree), jammed=(*whole.jammed, tree))
            band = self._band([(tree, _group(tree))], whole, self._children(tree, inside), "")
            nodes.append((whole, band))
        if not rest.is_empty:
            nodes.append((rest, self.node(replace(tree, factor=1), rest)))
        return self._sequence(nodes)

    def _once(self, tree: Loop, place: _Place) -> str:
        """A loop that is not jammed: what only some iterations of a group around it run comes
        before and after what all of them run, in its order.
        """
        inside = replace(place, around=(*place.around, tree))
        if not self._differ(place, tree):
            return self._band([(tree, "{0}")], place, self._children(tree, inside), "separate")
        nodes = []
        for part, option in self._in_order(place, inside.around):
            inner = self._children(tree, replace(inside, domains=part.domains))
            nodes.append((part, self._band([(tree, "{0}")], part, inner, option)))
        return self._sequence(nodes)

    def _differ(self, place: _Place, tree: Loop) -> bool:
        """Whether jammed loops around a loop change its bounds."""
        return any(
            loop.over[name] in bound.names
            for name in place.domains
            for bound in self._dim(name, tree).bounds
            for loop in place.jammed
            if not loop.masked
        )

    def _in_order(self, place: _Place, loops: tuple[Loop, ...]) -> Iterator[tuple[_Place, str]]:
        """What some iterations of a group run first, what all run, and what some run last, each
        with isl's option for its loop: few iterations are written out.
        """
        band = self._filled_by(place.domains, loops, place.jammed)
        names = [f"t{position}" for position in range(len(loops))]
        starts = [_group(loop).format(n) for n, loop in zip(names, loops, strict=True)]
        own = f"{{ [{', '.join(names)}] -> [{', '.join(starts)}] }}"
        begin = isl.Map(f"{self.relations.parameters} -> {own}")
        later = f"[{', '.join(names)}] -> [{', '.join((*names[:-1], 'u'))}] : u > {names[-1]}"
        behind = begin.apply_range(isl.Map(f"{self.relations.parameters} -> {{ {later} }}"))
        last = behind.apply_range(begin.reverse()).intersect_domain(band).range()
        whole, first, after = {}, {}, {}
        for name, domain in place.domains.items():
            to_loops = self._to_loops(name, loops)
            inside = to_loops.intersect_range(band).domain()
            ends = to_loops.intersect_range(last).domain()
            whole[name] = domain.intersect(inside).coalesce()
            rest = domain.subtract(inside)
            after[name] = rest.intersect(ends).coalesce()
            first[name] = rest.subtract(ends).coalesce()
        for domains, is_whole in ((first, False), (whole, True), (after, False)):
            part = replace(place, domains=domains)
            if not part.is_empty:
                few = not is_whole and self._is_short(part, loops, begin)
                yield part, "unroll" if few else "separate"

    def _is_short(self, place: _Place, loops: tuple[Loop, ...], begin: isl.Map) -> bool:
        """Whether the innermost loop has fewer iterations than two groups, each time."""
        most = max(loop.factor for loop in place.jammed)
        reached = self._reached(place.domains, loops).apply(begin)
        names = ", ".join(f"t{position}" for position in range(len(loops) - 1))
        around = f"[{names}, a] -> [{names}, b] : b >= a + {2 * most}"
        far = isl.Map(f"{self.relations.parameters} -> {{ {around} }}")
        return bool(far.intersect_domain(reached).intersect_range(reached).is_empty())

    def _children(self, tree: Loop, place: _Place) -> str:
        nodes = []
        for child in tree.children:
            names = set(statements_in(child))
            domains = {name: d for name, d in place.domains.items() if name in names}
            inside = replace(place, domains=domains)
            if not inside.is_empty:
                nodes.append((inside, self.node(child, inside)))
        return self._sequence(nodes)

    def _sequence(self, nodes: list[tuple[_Place, str]]) -> str:
        if len(nodes) <= 1:
            return "".join(node for _, node in nodes)
        filters = [
            f'{{ filter: "{self.union(place.domains)}"{_child(node)} }}' for place, node in nodes
        ]
        return f"{{ sequence: [ {', '.join(filters)} ] }}"

    def _points(self, name: str, place: _Place) -> str:
        """The iterations of a group, one after another."""
        if not place.jammed:
            return ""
        forms = [(loop, f"{{0}} - ({_group(loop)})") for loop in place.jammed]
        return self._band(forms, place, "", "unroll")

    def _band(self, members: list[tuple[Loop, str]], place: _Place, child: str, option: str) -> str:
        maps = []
        for loop, text in members:
            images = [
                f"{self._tuple(name)} -> [({text.format(loop.over[name])})]"
                for name, domain in place.domains.items()
                if not domain.is_empty()
            ]
            maps.append(f"{{ {'; '.join(images)} }}")
        schedule = f"[{', '.join(maps)}]"
        if self.relations.scop.symbols:  # isl would read `[]` before the arrow as all of it
            schedule = f"{self.relations.parameters} -> {schedule}"
        options = f', options: "{{ {option}[x] }}"' if option else ""
        return f'{{ schedule: "{schedule}"{options}{_child(child)} }}'

    def union(self, domains: Mapping[str, isl.Set]) -> isl.UnionSet:
        """All iterations of statements."""
        result = isl.UnionSet(f"{self.relations.parameters} -> {{ }}")
        for domain in domains.values():
            result = result.union(isl.UnionSet.from_set(domain))
        return result

    def _tuple(self, name: str) -> str:
        return f"{name}[{', '.join(self._statement(name).coordinates)}]"

    def _split(self, place: _Place, tree: Loop) -> tuple[_Place, _Place]:
        """What fills whole groups of iterations, equally in all jammed iterations, and the rest."""
        limits = self._limits(place, tree)
        whole, rest = {}, {}
        loops = (*place.around, tree)
        band = None if limits else self._whole_groups(place, loops)
        for name, domain in place.domains.items():
            if band is None:
                inside = isl.Set(
                    f"{self.relations.parameters} -> {{ {self._tuple(name)} : "
                    f"{tree.over[name]} < {limits[name]} }}"
                )
            else:
                inside = self._to_loops(name, loops).intersect_range(band).domain()
                inside = inside.gist(domain).coalesce()
            whole[name] = domain.intersect(inside).coalesce()
            rest[name] = domain.subtract(inside).coalesce()
        return replace(place, domains=whole), replace(place, domains=rest)

    def _limits(self, place: _Place, tree: Loop) -> dict[str, str]:
        """Where the whole groups end, by statement, if all of them have the same bounds and jammed
        loops do not change these.
        """
        if self._differ(place, tree):
            return {}
        seen = set()
        limits = {}
        for name in place.domains:
            dim = self._dim(name, tree)
            shared = {loop.over[name]: symbol(f"t{n}") for n, loop in enumerate(place.around)}
            first, limit = dim.bounds
            names = first.names | limit.names
            if not names <= self.relations.scop.symbols.keys() | shared.keys():
                return {}
            seen.add((first.substituted(shared), limit.substituted(shared)))
            first = tree.base
            groups = f"{tree.factor}*floor(({limit} - ({first}))/{tree.factor})"
            limits[name] = f"{first} + {groups}"
            if dim.bounds[0] != tree.base:
                return {}
        return limits if len(seen) == 1 else {}

    def _whole_groups(self, place: _Place, loops: tuple[Loop, ...]) -> isl.Set:
        return self._filled_by(place.domains, loops, (*place.jammed, loops[-1]))

    def _filled_by(
        self, domains: Mapping[str, isl.Set], loops: tuple[Loop, ...], jammed: tuple[Loop, ...]
    ) -> isl.Set:
        """The iterations of loops whose whole group runs, of each that is jammed."""
        band = self._reached(domains, loops)
        for loop in jammed:
            band = self._filled(band, loops, loop)
        return band

    def _reached(self, domains: Mapping[str, isl.Set], loops: tuple[Loop, ...]) -> isl.Set:
        """All iterations of loops that some statement runs."""
        reached = [
            self._to_loops(name, loops).intersect_domain(domain).range()
            for name, domain in domains.items()
        ]
        band = reached[0]
        for other in reached[1:]:
            band = band.union(other)
        return band

    def _dim(self, name: str, tree: Loop) -> Dimension:
        """What a loop counts of a statement."""
        dims = self._statement(name).dims
        return next(dim for dim in dims if dim.name == tree.over[name])

    def _statement(self, name: str) -> Statement:
        return next(s for s in self.relations.scop.statements if s.name == name)

    def _to_loops(self, name: str, loops: tuple[Loop, ...]) -> isl.Map:
        image = ", ".join(loop.over[name] for loop in loops)
        return isl.Map(f"{self.relations.parameters} -> {{ {self._tuple(name)} -> [{image}] }}")

    def _filled(self, band: isl.Set, loops: tuple[Loop, ...], loop: Loop) -> isl.Set:
        """The iterations whose whole group, along one loop, is in the band."""
        names = [f"t{position}" for position in range(len(loops))]
        where = loops.index(loop)
        result = band
        for ahead in range(loop.factor):
            image = list(names)
            image[where] = f"{_group(loop).format(names[where])} + {ahead}"
            text = f"{{ [{', '.join(names)}] -> [{', '.join(image)}] }}"
            move = isl.Map(f"{self.relations.parameters} -> {text}")
            result = result.intersect(move.intersect_range(band).domain())
        return result.remove_redundancies().coalesce()


def _child(node: str) -> str:
    return f", child: {node}" if node else ""


def _group(loop: Loop) -> str:
    """Where the group of iterations begins that a coordinate, {0}, belongs to."""
    base = f"({loop.base})"
    return f"{base} + {loop.factor}*floor(({{0}} - {base})/{loop.factor})"
