"""Orders of a part's iterations: trees of loops over statements, some of them unrolled and jammed.

A tree says in which order statements run; `schedule_of` gives it to isl. A loop with a factor runs
so many of its iterations together in the loops inside it (unroll-and-jam). What does not fill whole
groups of iterations follows behind; groups that the edge of a triangle cuts, always in the same
way, are jammed too. Of a loop inside whose bounds differ within a group, what only some iterations
run comes before and behind, where it belongs. Where rows of a group need each other (`in_order`),
what they have in common comes first, and the rest row by row.
"""

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
    """

    over: Mapping[str, str]
    children: tuple[Tree, ...]
    factor: int = 1
    base: Form = ZERO
    masked: bool = False
    in_order: bool = False


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
    """isl's schedule tree of all iterations."""
    domains = relations.domains(statements_in(tree))
    child = _Ordering(relations).node(tree, _Place(domains, ()))
    return _read(relations, domains, child)


@dataclass
class Grouped:
    """What a schedule leaves to others that runs the first iteration of each whole group only.

    Attributes
    ----------
    marks
        By mark: how many iterations along each coordinate of the marked statement a group has.
    left
        The iterations that are run, by statement.
    """

    marks: dict[str, tuple[int, ...]] = field(default_factory=dict)
    left: dict[str, isl.Set] = field(default_factory=dict)

    def leaf(self, name: str, domain: isl.Set) -> None:
        """Iterations of a statement run at a leaf."""
        self.left[name] = self.left[name].union(domain) if name in self.left else domain

    def mark(self, factors: tuple[int, ...]) -> str:
        """The mark of groups of this shape."""
        name = f"group_{'_'.join(map(str, factors))}"
        self.marks[name] = factors
        return name


def grouped_schedule_of(tree: Loop, relations: Relations) -> tuple[isl.Schedule, Grouped]:
    """isl's schedule tree, with one iteration for each whole group: writing out the others takes
    isl most of its time.
    """
    grouped = Grouped()
    domains = relations.domains(statements_in(tree))
    child = _Ordering(relations, grouped).node(tree, _Place(domains, ()))
    return _read(relations, grouped.left, child), grouped


def _read(relations: Relations, domains: Mapping[str, isl.Set], child: str) -> isl.Schedule:
    text = f'{{ domain: "{relations.union(domains)}"{_child(child)} }}'
    return isl.Schedule.read_from_str(isl.DEFAULT_CONTEXT, text)


@dataclass(frozen=True)
class _Place:
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


@dataclass(frozen=True)
class _Ordering:
    relations: Relations
    grouped: Grouped | None = None

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
        tiles = self._ragged(place, rest, tree) if self._differ(place, tree) else []
        for tile in tiles:
            rest = _without(rest, tile)
        ahead = [self._comes_before(tile, whole, tree) for tile in tiles]
        earlier = [tile for tile, is_ahead in zip(tiles, ahead, strict=True) if is_ahead]
        later = [tile for tile, is_ahead in zip(tiles, ahead, strict=True) if not is_ahead]
        option = "separate" if _is_in_order(tree) and not tree.masked else ""
        nodes = [
            (part, self._band([(tree, _group(tree))], part, self._jammed(tree, part), option))
            for part in (*earlier, whole, *later)
            if not part.is_empty
        ]
        if not rest.is_empty:
            nodes.append((rest, self.node(replace(tree, factor=1), rest)))
        return self._sequence(nodes)

    def _jammed(self, tree: Loop, place: _Place) -> str:
        """What is in a jammed loop."""
        loops = (*place.around, tree)
        return self._inside(tree, replace(place, around=loops, jammed=(*place.jammed, tree)))

    def _once(self, tree: Loop, place: _Place) -> str:
        """A loop that is not jammed: what only some iterations of a group around it run comes
        before and after what all of them run, in its order.
        """
        inside = replace(place, around=(*place.around, tree))
        if not self._differ(place, tree):
            short = place.apart and self._is_short(place, inside.around)
            option = "unroll" if short else "separate"
            return self._band([(tree, "{0}")], place, self._inside(tree, inside), option)
        nodes = []
        for part, option in self._in_order(place, inside.around):
            inner = self._inside(tree, replace(inside, domains=part.domains))
            nodes.append((part, self._band([(tree, "{0}")], part, inner, option)))
        return self._sequence(nodes)

    def _inside(self, tree: Loop, place: _Place) -> str:
        """The children of a loop, jammed, or in the order of the iterations of the groups."""
        place = replace(place, members=place.domains)
        if not (tree.in_order and place.jammed):
            return self._children(tree, place)
        whole = self._together(tree, place)
        rest = _without(place, whole)
        nodes = [] if whole.is_empty else [(whole, self._children(tree, whole))]
        if not rest.is_empty:
            single = replace(rest, jammed=(), apart=(*rest.apart, *rest.jammed))
            forms = [(loop, f"{{0}} - ({_group(loop)})") for loop in rest.jammed]
            nodes.append((rest, self._band(forms, rest, self._children(tree, single), "unroll")))
        return self._sequence(nodes)

    def _together(self, tree: Loop, place: _Place) -> _Place:
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
                common = self._common(own, loops)
                for name, domain in own.domains.items():
                    inside = self._to_loops(name, loops).intersect_range(common).domain()
                    domains[name] = domain.intersect(inside).coalesce()
            break
        return replace(place, domains=domains)

    def _differ(self, place: _Place, tree: Loop) -> bool:
        """Whether jammed loops around a loop change its bounds."""
        loops = [loop for loop in place.jammed if not loop.masked]
        return any(self._is_bound_to(tree, loop, n) for n in place.domains for loop in loops)

    def _is_bound_to(self, tree: Loop, other: Loop, name: str) -> bool:
        """Whether bounds of a statement tie what two loops count of it to each other."""
        both = {tree.over[name], other.over[name]}
        dims = self.relations.scop.statement(name).dims
        return len(both) == 1 or any(
            both <= {dim.name, *dim.bounds[0].names, *dim.bounds[1].names} for dim in dims
        )

    def _in_order(self, place: _Place, loops: tuple[Loop, ...]) -> Iterator[tuple[_Place, str]]:
        """What some iterations of a group run first, what all run, and what some run last, each
        with isl's option for its loop: few iterations are written out.
        """
        band = self._common(place, loops)
        last = self._behind(loops).intersect_domain(band).range()
        whole, first, after = {}, {}, {}
        for name, domain in place.domains.items():
            to_loops = self._to_loops(name, loops)
            inside = to_loops.intersect_range(band).domain().gist(domain)
            ends = to_loops.intersect_range(last).domain()
            whole[name] = domain.intersect(inside).coalesce()
            rest = domain.subtract(inside)
            after[name] = rest.intersect(ends).coalesce()
            first[name] = rest.subtract(ends).coalesce()
        for domains, is_whole in ((first, False), (whole, True), (after, False)):
            part = replace(place, domains=domains)
            if not part.is_empty:
                few = not is_whole and self._is_short(part, loops)
                yield part, "unroll" if few else "separate"

    def _begin(self, loops: tuple[Loop, ...]) -> isl.Map:
        """Each iteration of loops to where its groups begin."""
        names = _coordinates(loops)
        starts = [_group(loop).format(n) for n, loop in zip(names, loops, strict=True)]
        return self._map(f"[{', '.join(names)}] -> [{', '.join(starts)}]")

    def _behind(self, loops: tuple[Loop, ...]) -> isl.Map:
        """Each iteration of loops to those in later groups of the innermost."""
        names, begin = _coordinates(loops), self._begin(loops)
        later = f"[{', '.join(names)}] -> [{', '.join((*names[:-1], 'u'))}] : u > {names[-1]}"
        return begin.apply_range(self._map(later)).apply_range(begin.reverse())

    def _map(self, text: str) -> isl.Map:
        return isl.Map(f"{self.relations.parameters} -> {{ {text} }}")

    def _common(self, place: _Place, loops: tuple[Loop, ...]) -> isl.Set:
        """The iterations of the innermost of loops that all iterations of a group around it run."""
        mates, own = self._begin(loops[:-1]), self._reached(place.domains, loops)
        mates = mates.apply_range(mates.reverse())
        for position, loop in enumerate(loops[:-1]):
            if loop not in place.jammed:
                mates = mates.equate(isl.dim_type.in_, position, isl.dim_type.out, position)
        there = self._reached(place.members, loops[:-1])
        every = mates.intersect_domain(there).intersect_range(there)
        every = every.add_dims(isl.dim_type.in_, 1).add_dims(isl.dim_type.out, 1)
        last = len(loops) - 1
        every = every.equate(isl.dim_type.in_, last, isl.dim_type.out, last)
        missing = every.intersect_domain(own).subtract_range(own).domain()
        return own.subtract(missing).coalesce()

    def _is_short(self, place: _Place, loops: tuple[Loop, ...]) -> bool:
        """Whether the innermost loop has fewer iterations than two groups, each time."""
        most = max(loop.factor for loop in (*place.jammed, *place.apart))
        reached = self._reached(place.domains, loops).apply(self._begin(loops))
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
            f'{{ filter: "{self.relations.union(place.domains)}"{_child(node)} }}'
            for place, node in nodes
        ]
        return f"{{ sequence: [ {', '.join(filters)} ] }}"

    def _points(self, name: str, place: _Place) -> str:
        """The iterations of a group, one after another."""
        partly = place.jammed
        leaf = ""
        if self.grouped is not None:
            partly, full = self._full(name, place)
            leaf = self._first_of(name, place.domains[name], full, self.grouped)
        if not partly:
            return leaf
        forms = [(loop, f"{{0}} - ({_group(loop)})") for loop in partly]
        return self._band(forms, place, leaf, "unroll")

    def _first_of(
        self, name: str, domain: isl.Set, full: tuple[Loop, ...], grouped: Grouped
    ) -> str:
        """The first iteration of each group along loops whose groups are all full, marked."""
        if not full:
            grouped.leaf(name, domain)
            return ""
        firsts = [f"{loop.over[name]} = {_group(loop).format(loop.over[name])}" for loop in full]
        text = f"{{ {self._tuple(name)} : {' and '.join(firsts)} }}"
        grouped.leaf(name, domain.intersect(isl.Set(f"{self.relations.parameters} -> {text}")))
        factors = {loop.over[name]: loop.factor for loop in full}
        shape = tuple(factors.get(c, 1) for c in self._statement(name).coordinates)
        return f'{{ mark: "{grouped.mark(shape)}", child: {{ leaf }} }}'

    def _full(self, name: str, place: _Place) -> tuple[tuple[Loop, ...], tuple[Loop, ...]]:
        """Jammed loops, and the innermost of them whose groups are all full, apart."""
        jammed = place.jammed
        if not jammed:
            return (), ()
        band = self._reached({name: place.domains[name]}, place.around)
        first = len(jammed)
        while first and band.is_subset(self._filled(band, place.around, jammed[first - 1])):
            first -= 1
        return jammed[:first], jammed[first:]

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

    def _ragged(self, place: _Place, rest: _Place, tree: Loop) -> list[_Place]:
        """Groups of which only some iterations run, the same beside each group of a jammed loop
        around them: the tiles that the edge of a triangle cuts.
        """
        if rest.is_empty:
            return []
        loops, outer = (*rest.around, tree), rest.jammed[-1]
        names = _coordinates(loops)
        start = _group(outer).format(names[loops.index(outer)])
        offset = f"[{', '.join(names)}] -> [{_group(tree).format(names[-1])} - ({start})]"
        to_offset = self._map(offset)
        reached = self._reached(rest.domains, loops)
        found = []
        for number in range(-max(outer.factor, tree.factor), outer.factor + tree.factor):
            at_number = to_offset.intersect_range(isl.Set(f"{{ [{number}] }}")).domain()
            tile = reached.intersect(at_number)
            if tile.is_empty():
                continue
            domains = {}
            for name, domain in rest.domains.items():
                inside = self._to_loops(name, loops).intersect_range(tile).domain()
                domains[name] = domain.intersect(inside).coalesce()
            outer_groups = self._begin(rest.around)
            every = self._reached(place.domains, rest.around).apply(outer_groups)
            here = self._reached(domains, rest.around).apply(outer_groups)
            if every.is_subset(here) and self._is_rigid(tile, loops, (*rest.jammed, tree)):
                found.append(replace(rest, domains=domains))
        return found

    def _is_rigid(self, tile: isl.Set, loops: tuple[Loop, ...], jammed: tuple[Loop, ...]) -> bool:
        """Whether the same iterations of all groups are there."""
        begin = self._begin(loops).intersect_domain(tile)
        names = _coordinates(loops)
        beside = [
            f"{n} - ({_group(loop).format(n)})"
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

    def _comes_before(self, tile: _Place, whole: _Place, tree: Loop) -> bool:
        """Whether groups of a tile come before whole ones."""
        if whole.is_empty:
            return True
        loops = (*tile.around, tree)
        later = self._reached(tile.domains, loops).apply(self._behind(loops))
        return not later.intersect(self._reached(whole.domains, loops)).is_empty()

    def _limits(self, place: _Place, tree: Loop) -> dict[str, str]:
        """Where the whole groups end, by statement, if all of them have the same bounds, jammed
        loops do not change these, and no loop around has bounds by what this one counts.
        """
        if self._differ(place, tree):
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
        return self.relations.scop.dimension(name, tree.over[name])

    def _statement(self, name: str) -> Statement:
        return self.relations.scop.statement(name)

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


def _without(place: _Place, taken: _Place) -> _Place:
    """What is left to run without what is taken."""
    domains = {
        name: domain.subtract(taken.domains[name]).coalesce()
        for name, domain in place.domains.items()
    }
    return replace(place, domains=domains)


def _coordinates(loops: tuple[Loop, ...]) -> list[str]:
    """Names of the counters of loops."""
    return [f"t{position}" for position in range(len(loops))]


def _is_in_order(tree: Tree) -> bool:
    """Whether groups of it, or of a loop in it, run in order."""
    return isinstance(tree, Loop) and (tree.in_order or any(map(_is_in_order, tree.children)))


def _child(node: str) -> str:
    return f", child: {node}" if node else ""


def _group(loop: Loop) -> str:
    """Where the group of iterations begins that a coordinate, {0}, belongs to."""
    base = f"({loop.base})"
    return f"{base} + {loop.factor}*floor(({{0}} - {base})/{loop.factor})"
