"""Trees of loops, and which iterations of a part the loops of a tree run together."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

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
    in_order
        In a group, its own or of loops around it, the statements before its first loop and what
        all iterations run of that loop come first, jammed; then, an iteration after another in
        their order, what is left.
    skew
        What is added to the coordinate, by statement: a form of coordinates of loops around, so
        that it starts later in each of their iterations (Wolfe, "Loop skewing", 1986).
    rows
        Arrays of which each iteration of a group has a row of its own (`rows`).
    """

    over: Mapping[str, str]
    children: tuple[Tree, ...]
    factor: int = 1
    base: Form = ZERO
    masked: bool = False
    in_order: bool = False
    skew: Mapping[str, Form] = field(default_factory=dict)
    rows: frozenset[str] = frozenset()

    def counted(self, name: str) -> Form:
        """What it counts of a statement."""
        return symbol(self.over[name]).plus(self.skew.get(name, ZERO))


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


def is_in_order(tree: Tree) -> bool:
    """Whether groups of it, or of a loop in it, run in order."""
    return isinstance(tree, Loop) and (tree.in_order or any(map(is_in_order, tree.children)))


@dataclass(frozen=True)
class Site:
    """Where a tree stands.

    Attributes
    ----------
    domains
        What is left to run.
    around
        The loops around it.
    jammed
        Those of them of whose groups all iterations run together here.
    apart
        Those whose iterations run one after another here, inside the loops of their group.
    members
        What the loop around it runs.
    """

    domains: Mapping[str, isl.Set]
    around: tuple[Loop, ...]
    jammed: tuple[Loop, ...] = ()
    apart: tuple[Loop, ...] = ()
    members: Mapping[str, isl.Set] = field(default_factory=dict)

    @property
    def is_empty(self) -> bool:
        """Whether nothing is left."""
        return all(domain.is_empty() for domain in self.domains.values())


def is_bound_to(tree: Loop, other: Loop, name: str, around: tuple[Loop, ...], scop: Scop) -> bool:
    """Whether bounds of a statement tie what two loops count of it to each other."""
    both = {tree.over[name], other.over[name]}
    if len(both) == 1:
        return True
    unskewed = _unskewed(name, (*around, tree))
    statement = scop.statement(name)
    ties = [frozenset({dim.name}) for dim in statement.dims]

    def names(*forms: Form) -> frozenset[str]:
        return frozenset().union(*(form.substituted(unskewed).names for form in forms))

    for dim in statement.dims:
        first, limit = (symbol(dim.name).plus(bound, -1) for bound in dim.bounds)
        ties.append(names(first, limit))
    return any(both <= tie for tie in (*ties, *map(names, statement.guards)))


def _unskewed(name: str, loops: tuple[Loop, ...]) -> dict[str, Form]:
    """Coordinates of a statement by what loops count of it, each called as its coordinate."""
    found: dict[str, Form] = {}
    skewed = [loop for loop in loops if name in loop.skew]
    for loop in (*(one for one in loops if one not in skewed), *reversed(skewed)):
        counted = symbol(loop.over[name]).plus(loop.skew.get(name, ZERO).substituted(found), -1)
        found[loop.over[name]] = counted
    return found


def group_of(loop: Loop) -> str:
    """Where the group of iterations begins that a coordinate, {0}, belongs to."""
    base = f"({loop.base})"
    return f"{base} + {loop.factor}*floor((({{0}}) - {base})/{loop.factor})"


@dataclass(frozen=True)
class Tiles:
    """Sets of iterations, by what groups of jammed loops have of them."""

    relations: Relations

    def differ(self, place: Site, tree: Loop) -> bool:
        """Whether jammed loops around a loop change its bounds."""
        loops = [loop for loop in place.jammed if not loop.masked]
        scop = self.relations.scop
        return any(
            is_bound_to(tree, loop, name, place.around, scop)
            for name in place.domains
            for loop in loops
        )

    def split(self, place: Site, tree: Loop) -> tuple[Site, Site]:
        """What fills whole groups of iterations, equally in all jammed iterations, and the rest."""
        if not place.domains:
            return place, place  # loops without statements
        limits = self._limits(place, tree)
        whole, rest = {}, {}
        loops = (*place.around, tree)
        band = None if limits else self._filled_by(place.domains, loops, (*place.jammed, tree))
        for name, domain in place.domains.items():
            if band is None:
                inside = isl.Set(
                    f"{self.relations.parameters} -> {{ {self.named(name)} : "
                    f"{tree.over[name]} < {limits[name]} }}"
                )
            else:
                inside = self._to_loops(name, loops).intersect_range(band).domain()
                inside = inside.gist(domain).coalesce()
            whole[name] = domain.intersect(inside).coalesce()
            rest[name] = domain.subtract(inside).coalesce()
        return replace(place, domains=whole), replace(place, domains=rest)

    def _limits(self, place: Site, tree: Loop) -> dict[str, str]:
        """Where the whole groups end, by statement, if all of them have the same bounds, jammed
        loops do not change these, and no loop around has bounds by what this one counts.
        """
        if self.differ(place, tree) or any(loop.skew for loop in (*place.around, tree)):
            return {}
        seen = set()
        limits = {}
        for name in place.domains:
            dim = self._dim(name, tree)
            around = (self._dim(name, loop) for loop in place.around)
            if any(dim.name in {o.name, *o.bounds[0].names, *o.bounds[1].names} for o in around):
                return {}
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

    def together(self, tree: Loop, place: Site) -> Site:
        """What comes first, jammed, of a loop whose groups run in order."""
        domains = {name: domain.subtract(domain) for name, domain in place.domains.items()}
        for child in tree.children:
            names = [name for name in statements_in(child) if name in domains]
            if isinstance(child, str):
                domains |= {name: place.domains[name] for name in names}
                continue
            loops = (*place.around, child)
            own = replace(place, domains={name: place.domains[name] for name in names})
            if not own.is_empty:
                common = self.common(own, loops)
                domains |= self.within(own, loops, common).domains
            break
        return replace(place, domains=domains)

    def common(self, place: Site, loops: tuple[Loop, ...]) -> isl.Set:
        """The iterations of the innermost of loops that all iterations of a group around it run."""
        mates, own = self._begin(loops[:-1]), self.reached(place.domains, loops)
        mates = mates.apply_range(mates.reverse())
        for position, loop in enumerate(loops[:-1]):
            if loop not in place.jammed:
                mates = mates.equate(isl.dim_type.in_, position, isl.dim_type.out, position)
        there = self.reached(place.members, loops[:-1])
        every = mates.intersect_domain(there).intersect_range(there)
        every = every.add_dims(isl.dim_type.in_, 1).add_dims(isl.dim_type.out, 1)
        last = len(loops) - 1
        every = every.equate(isl.dim_type.in_, last, isl.dim_type.out, last)
        missing = every.intersect_domain(own).subtract_range(own).domain()
        return own.subtract(missing).coalesce()

    def ragged(self, place: Site, rest: Site, tree: Loop) -> list[Site]:
        """Groups of which only some iterations run, the same beside each group of a jammed loop
        around them: the tiles that the edge of a triangle cuts.
        """
        if rest.is_empty:
            return []
        loops, outer = (*rest.around, tree), rest.jammed[-1]
        names = _coordinates(loops)
        start = group_of(outer).format(names[loops.index(outer)])
        offset = f"[{', '.join(names)}] -> [{group_of(tree).format(names[-1])} - ({start})]"
        to_offset = self._map(offset)
        reached = self.reached(rest.domains, loops)
        found = []
        for number in range(-max(outer.factor, tree.factor), outer.factor + tree.factor):
            at_number = to_offset.intersect_range(isl.Set(f"{{ [{number}] }}")).domain()
            tile = reached.intersect(at_number)
            if tile.is_empty():
                continue
            cut = self.within(rest, loops, tile)
            outer_groups = self._begin(rest.around)
            every = self.reached(place.domains, rest.around).apply(outer_groups)
            here = self.reached(cut.domains, rest.around).apply(outer_groups)
            if every.is_subset(here) and self._is_rigid(tile, loops, (*rest.jammed, tree)):
                found.append(cut)
        return found

    def _is_rigid(self, tile: isl.Set, loops: tuple[Loop, ...], jammed: tuple[Loop, ...]) -> bool:
        """Whether the same iterations of all groups are there."""
        begin = self._begin(loops).intersect_domain(tile)
        names = _coordinates(loops)
        beside = [
            f"{n} - ({group_of(loop).format(n)})"
            for n, loop in zip(names, loops, strict=True)
            if loop in jammed
        ]
        shape = begin.reverse().apply_range(
            self._map(f"[{', '.join(names)}] -> [{', '.join(beside)}]")
        )
        points = shape.range()
        points = points.project_out(isl.dim_type.param, 0, points.dim(isl.dim_type.param))
        points = points.align_params(shape.get_space())
        every = isl.Map.from_domain_and_range(shape.domain(), points)
        return bool(every.is_subset(shape))

    def before(self, rest: Site, whole: Site, tree: Loop) -> Site:
        """What comes before whole groups of a loop."""
        if rest.is_empty or whole.is_empty:
            return replace(rest, domains={name: d.subtract(d) for name, d in rest.domains.items()})
        loops = (*rest.around, tree)
        groups = self.reached(whole.domains, loops)
        earlier = self.behind(loops).intersect_range(groups).domain()
        return self.within(rest, loops, earlier)

    def is_short(self, place: Site, loops: tuple[Loop, ...]) -> bool:
        """Whether the innermost loop has fewer iterations than two groups, each time."""
        most = max(loop.factor for loop in (*place.jammed, *place.apart))
        reached = self.reached(place.domains, loops).apply(self._begin(loops))
        names = ", ".join(_coordinates(loops[:-1]))
        far = self._map(f"[{names}, a] -> [{names}, b] : b >= a + {2 * most}")
        return bool(far.intersect_domain(reached).intersect_range(reached).is_empty())

    def within(self, place: Site, loops: tuple[Loop, ...], band: isl.Set) -> Site:
        """What is run in these iterations of loops."""
        domains = {
            name: domain.intersect(
                self._to_loops(name, loops).intersect_range(band).domain()
            ).coalesce()
            for name, domain in place.domains.items()
        }
        return replace(place, domains=domains)

    def _filled_by(
        self, domains: Mapping[str, isl.Set], loops: tuple[Loop, ...], jammed: tuple[Loop, ...]
    ) -> isl.Set:
        """The iterations of loops whose whole group runs, of each that is jammed."""
        band = self.reached(domains, loops)
        for loop in jammed:
            band = self.filled(band, loops, loop)
        return band

    def filled(self, band: isl.Set, loops: tuple[Loop, ...], loop: Loop) -> isl.Set:
        """The iterations whose whole group, along one loop, is in the band."""
        names = _coordinates(loops)
        where = loops.index(loop)
        result = band
        for ahead in range(loop.factor):
            image = list(names)
            image[where] = f"{group_of(loop).format(names[where])} + {ahead}"
            move = self._map(f"[{', '.join(names)}] -> [{', '.join(image)}]")
            result = result.intersect(move.intersect_range(band).domain())
        return result.remove_redundancies().coalesce()

    def reached(self, domains: Mapping[str, isl.Set], loops: tuple[Loop, ...]) -> isl.Set:
        """All iterations of loops that some statement runs."""
        reached = [
            self._to_loops(name, loops).intersect_domain(domain).range()
            for name, domain in domains.items()
        ]
        band = reached[0]
        for other in reached[1:]:
            band = band.union(other)
        return band

    def _begin(self, loops: tuple[Loop, ...]) -> isl.Map:
        """Each iteration of loops to where its groups begin."""
        names = _coordinates(loops)
        starts = [group_of(loop).format(n) for n, loop in zip(names, loops, strict=True)]
        return self._map(f"[{', '.join(names)}] -> [{', '.join(starts)}]")

    def behind(self, loops: tuple[Loop, ...]) -> isl.Map:
        """Each iteration of loops to those in later groups of the innermost."""
        names, begin = _coordinates(loops), self._begin(loops)
        later = f"[{', '.join(names)}] -> [{', '.join((*names[:-1], 'u'))}] : u > {names[-1]}"
        return begin.apply_range(self._map(later)).apply_range(begin.reverse())

    def _map(self, text: str) -> isl.Map:
        known = self.relations.maps
        if text not in known:
            known[text] = isl.Map(f"{self.relations.parameters} -> {{ {text} }}")
        return known[text]

    def _to_loops(self, name: str, loops: tuple[Loop, ...]) -> isl.Map:
        image = ", ".join(str(loop.counted(name)) for loop in loops)
        return self._map(f"{self.named(name)} -> [{image}]")

    def named(self, name: str) -> str:
        """A statement with its coordinates, as isl reads it."""
        return f"{name}[{', '.join(self.relations.scop.statement(name).coordinates)}]"

    def _dim(self, name: str, tree: Loop) -> Dimension:
        """What a loop counts of a statement."""
        return self.relations.scop.dimension(name, tree.over[name])


def without(place: Site, taken: Site) -> Site:
    """What is left to run without what is taken."""
    domains = {
        name: domain.subtract(taken.domains[name]).coalesce()
        for name, domain in place.domains.items()
    }
    return replace(place, domains=domains)


def _coordinates(loops: tuple[Loop, ...]) -> list[str]:
    """Names of the counters of loops."""
    return [f"t{position}" for position in range(len(loops))]
