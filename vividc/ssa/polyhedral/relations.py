"""A part's iterations and dependences as isl sets and relations."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property, partial
from operator import eq
from typing import Final

import islpy as isl

from vividc.ssa.analysis.counters import LONGEST
from vividc.ssa.analysis.polynomial import Polynomial
from vividc.ssa.ir import Value
from vividc.ssa.polyhedral.forms import Form, form, symbol
from vividc.ssa.polyhedral.scop import Nest, Scop, Statement
from vividc.ssa.polyhedral.subscripts import Access
from vividc.ssa.polyhedral.values import bounded, integer

LARGE = 1 << 28
"""No other symbol is larger in a loop that ends; smaller ones count as its negative: bounds of
skewed loops are sums of up to four of them, which must not wrap.
"""

_STRIKES: Final = 2
"""So often may it give up; then no more is asked about other trees of the part."""

_REDUCTION: Final = 2_000_000
"""Of isl's operations (about 1 s), to find the dependences from which others follow."""


@dataclass(frozen=True)
class Rows:
    """Rows of an array for iterations that run together, `factor` at a time from `base` on, of the
    coordinates `over`, by statement.
    """

    over: Mapping[str, str]
    factor: int
    base: Form


@dataclass(frozen=True)
class Relations:
    """Sets and relations of one part; statements are named tuples of their coordinates.

    `legal`: of orders of loops that were asked for, by name, whether they keep the dependences;
    `endless`: those for which isl has given up; `maps`: what was read of text, which many trees
    ask for.
    """

    scop: Scop
    legal: dict[str, bool] = field(default_factory=dict, compare=False)
    endless: set[str] = field(default_factory=set, compare=False)
    maps: dict[str, isl.Map] = field(default_factory=dict, compare=False)
    _domains: dict[str, tuple[Statement, isl.Set]] = field(default_factory=dict, compare=False)
    """By name, with the statement: another one may have its name."""
    _reduced: dict[str, isl.UnionMap] = field(default_factory=dict, compare=False)
    """By the rows that arrays have."""

    @property
    def is_endless(self) -> bool:
        """Whether isl has given up too often."""
        return len(self.endless) >= _STRIKES

    @contextmanager
    def asked(self, question: str) -> Iterator[None]:
        """Inside, isl gives up where the answer would take long: nothing is known then, and the
        question is one of those that are endless.
        """
        with bounded() as in_full:
            self.endless.update({question} if in_full else ())
            yield
            self.endless.discard(question)

    @cached_property
    def parameters(self) -> str:
        """isl's list of the symbols."""
        return f"[{', '.join(self.scop.symbols)}]"

    @cached_property
    def context(self) -> isl.Set:
        """What is known of the symbols."""
        limits = []
        for name in self.scop.symbols:
            least, most = (0, LONGEST) if name in self.scop.lengths else (-LARGE, LARGE)
            limits.append(f"{least} <= {name} <= {most}")
        return isl.Set(f"{self.parameters} -> {{ : {' and '.join(limits) or 'true'} }}")

    def domain(self, statement: Statement) -> isl.Set:
        """The iterations of a statement."""
        known, domain = self._domains.get(statement.name, (None, None))
        if known is not statement or domain is None:
            domain = self._domain(statement)
            self._domains[statement.name] = statement, domain
        return domain

    def _domain(self, statement: Statement) -> isl.Set:
        names = ", ".join(statement.coordinates)
        bounds = [f"{dim.bounds[0]} <= {dim.name} < {dim.bounds[1]}" for dim in statement.dims]
        bounds += [f"{guard} >= 0" for guard in statement.guards]
        text = f"{self.parameters} -> {{ {statement.name}[{names}] : {' and '.join(bounds)} }}"
        return isl.Set(text).intersect_params(self.context)

    def domains(self, names: Iterable[str]) -> dict[str, isl.Set]:
        """The iterations of statements, by name."""
        by_name = {statement.name: statement for statement in self.scop.statements}
        return {name: self.domain(by_name[name]) for name in names}

    def union(self, domains: Mapping[str, isl.Set]) -> isl.UnionSet:
        """All iterations of statements."""
        result = isl.UnionSet(f"{self.parameters} -> {{ }}")
        for domain in domains.values():
            result = result.union(isl.UnionSet.from_set(domain))
        return result

    @cached_property
    def dependences(self) -> isl.UnionMap:
        """Pairs of iterations that must keep their order."""
        return self._ordered(lambda _: True)

    def _ordered(self, takes: Callable[[str | int], bool]) -> isl.UnionMap:
        """As `dependences`, by what they access."""
        reads, writes = self.accesses(takes)
        before = self.written
        result = isl.UnionMap(f"{self.parameters} -> {{ }}")
        order = before.lex_lt_union_map(before)
        for first, second in ((writes, reads), (reads, writes), (writes, writes)):
            result = result.union(first.apply_range(second.reverse()).intersect(order))
        return result.coalesce()

    @cached_property
    def written(self) -> isl.UnionMap:
        """The schedule of the source: coordinates, and positions among what is beside."""
        length = 2 * max((len(s.dims) for s in self.scop.statements), default=0) + 1
        result = isl.UnionMap(f"{self.parameters} -> {{ }}")
        for statement, place in _places(self.scop):
            times: list[Form] = []
            for position, dim in zip(place, statement.dims, strict=False):
                times += [Form((), position), symbol(dim.name)]
            times.append(Form((), place[-1]))
            times += [Form()] * (length - len(times))
            result = result.union(self.map(statement, "", tuple(times)))
        return result

    def map(self, statement: Statement, target: str, forms: tuple[Form, ...]) -> isl.UnionMap:
        """Each iteration of a statement to a tuple of forms."""
        source = f"{statement.name}[{', '.join(statement.coordinates)}]"
        image = ", ".join(map(str, forms))
        made = isl.Map(f"{self.parameters} -> {{ {source} -> {target}[{image}] }}")
        return isl.UnionMap.from_map(made.intersect_domain(self.domain(statement)))

    @cached_property
    def _arrays(self) -> dict[str, int]:
        """A number of each array."""
        accesses = [a for s in self.scop.statements for a in s.accesses.values()]
        return {name: n for n, name in enumerate(dict.fromkeys(a.array for a in accesses))}

    def accesses(self, takes: Callable[[str | int], bool]) -> tuple[isl.UnionMap, isl.UnionMap]:
        """What is read and written of arrays and scalars (by their ids) that are taken."""
        reads = writes = isl.UnionMap(f"{self.parameters} -> {{ }}")
        for statement in self.scop.statements:
            for access in statement.accesses.values():
                if not takes(access.array):
                    continue
                made = self._touched(statement, access)
                reads, writes = (
                    (reads, writes.union(made)) if access.is_store else (reads.union(made), writes)
                )
            for ident in filter(takes, statement.reads):
                reads = reads.union(self._scalar(statement, ident))
            for ident in filter(takes, (*statement.writes, *(phi for phi, _ in statement.copies))):
                writes = writes.union(self._scalar(statement, ident))
        return reads, writes

    def _touched(self, statement: Statement, access: Access) -> isl.UnionMap:
        at = statement.placed({name: symbol(name) for name in statement.coordinates})
        where = tuple(one.substituted(at) for one in access.subscripts)
        return self.map(statement, f"A{self._arrays[access.array]}", where)

    def touched(self, array: str) -> isl.Set:
        """The elements of an array that the part accesses."""
        result = isl.UnionSet(f"{self.parameters} -> {{ }}")
        for statement in self.scop.statements:
            for access in statement.accesses.values():
                if access.array == array:
                    result = result.union(self._touched(statement, access).range())
        return isl.Set.from_union_set(result).coalesce()

    def stored(self, array: str, names: Mapping[Value, str]) -> isl.Set:
        """The elements of an array that the part stores to, with these names of what its symbols
        stand for.
        """
        result = isl.UnionSet(f"{self.parameters} -> {{ }}")
        for statement in self.scop.statements:
            for access in statement.accesses.values():
                if access.array == array and access.is_store:
                    result = result.union(self._touched(statement, access).range())
        return self.named(isl.Set.from_union_set(result).reset_tuple_id(), names)

    def named(self, found: isl.Set, names: Mapping[Value, str]) -> isl.Set:
        """A set with these names of what symbols stand for."""
        for own, value in self.scop.symbols.items():
            place = found.find_dim_by_name(isl.dim_type.param, own)
            if place >= 0:
                found = found.set_dim_name(isl.dim_type.param, place, names[value])
        return found

    def box(self, array: str) -> tuple[tuple[Form, Form], ...] | None:
        """The first and the last subscript along each dimension of what the part accesses of an
        array; None if they are no forms.
        """
        touched = self.touched(array)
        axes = range(touched.dim(isl.dim_type.set))
        ends = [(_form(touched.dim_min(n)), _form(touched.dim_max(n))) for n in axes]
        found = tuple((one, other) for one, other in ends if one is not None and other is not None)
        return found if len(found) == len(ends) else None

    def has_corner(self, array: str, box: tuple[tuple[Form, Form], ...]) -> bool:
        """Whether the part accesses the element at the last subscripts of an array's box."""
        touched = self.touched(array)
        place = f"{touched.get_tuple_name()}[{', '.join(str(last) for _, last in box)}]"
        corner = isl.Set(f"{self.parameters} -> {{ {place} }}")
        return bool(corner.intersect_params(touched.params()).is_subset(touched))

    def _scalar(self, statement: Statement, ident: int) -> isl.UnionMap:
        names = statement.coordinates[: self.scop.depth[ident]]
        return self.map(statement, f"V_{ident}", tuple(map(symbol, names)))

    def counted(self, over: Mapping[str, str], text: str) -> isl.UnionMap:
        """Each iteration of statements to a function of a coordinate, {0}, of it."""
        result = isl.UnionMap(f"{self.parameters} -> {{ }}")
        for name, coordinate in over.items():
            source = f"{name}[{', '.join(self.scop.statement(name).coordinates)}]"
            image = f"{self.parameters} -> {{ {source} -> [{text.format(coordinate)}] }}"
            result = result.union(isl.UnionMap(image))
        return result

    def _apart(self, rows: Mapping[str, Rows]) -> isl.UnionMap:
        """As `dependences`, if arrays have rows."""
        if not rows:
            return self.dependences
        result = self._ordered(lambda name: name not in rows)
        for array, one in rows.items():
            row = self.counted(one.over, f"(({{0}}) - ({one.base})) mod {one.factor}")
            same = row.apply_range(row.reverse())
            found = self._ordered(partial(eq, array))
            result = result.union(found.intersect(same))
        return result

    def respects(self, schedule: isl.UnionMap, rows: Mapping[str, Rows] | None = None) -> bool:
        """Whether a schedule keeps the order of all dependences, if arrays have rows."""
        timed = {one.get_tuple_name(isl.dim_type.in_) for one in _maps_of(schedule)}
        is_whole = len(timed) == len(self.scop.statements)  # else what is between has no time
        wanted = self.direct(rows or {}) if is_whole else self._apart(rows or {})
        times = wanted.apply_domain(schedule).apply_range(schedule)
        return all(_goes_on(one) for one in _maps_of(times))

    def direct(self, rows: Mapping[str, Rows]) -> isl.UnionMap:
        """The dependences from which all others follow, as the order of times is transitive: those
        that no two make up (Aho, Garey and Ullman, "The transitive reduction of a directed graph",
        1972). Each iteration depends on finitely many, so that nothing is lost. isl tells of half
        as many relations in half of the time whether a schedule keeps them. All of them, if it
        takes isl long to find these.
        """
        name = str(rows)
        if name not in self._reduced:
            wanted = self._apart(rows)
            self._reduced[name] = wanted
            with bounded(_REDUCTION):
                self._reduced[name] = wanted.subtract(wanted.apply_range(wanted)).coalesce()
        return self._reduced[name]

    def accesses_out_of_order(self, schedule: isl.UnionMap) -> tuple[Access, Access] | None:
        """Two accesses that meet and that a schedule runs in another order; None if it does so to
        none of an array.
        """
        broken = self.dependences.intersect(schedule.lex_ge_union_map(schedule))
        for first, second in itertools.product(self.scop.statements, repeat=2):
            for one, other in itertools.product(first.accesses.values(), second.accesses.values()):
                if one.array == other.array and (one.is_store or other.is_store):
                    met = self._touched(first, one).apply_range(
                        self._touched(second, other).reverse()
                    )
                    if not met.intersect(broken).is_empty():
                        return one, other
        return None


@dataclass(frozen=True)
class Rectangle:
    """Elements of a matrix: those of the first rows, as many as a polynomial without products says,
    each with as many as `columns`.
    """

    rows: Polynomial
    columns: Value


def overwrite(array: str, others: Sequence[Scop], first: Scop | Rectangle) -> bool:
    """Whether parts store to all elements of an array that another one stores to, or to those of a
    rectangle. They are of one function, and no value from outside changes between them; those that
    see other rows in the array than the last one are not asked.
    """
    length = others[-1].rows.get(array)
    parts = [Relations(one) for one in others if one.rows.get(array) == length]
    values = {value: None for one in parts for value in one.scop.symbols.values()}
    if isinstance(first, Scop):
        values |= {value: None for value in first.symbols.values()}
    else:
        values |= {value: None for value in (*first.rows.linear(), first.columns)}
    names = {value: f"q{place}" for place, value in enumerate(values)}
    with bounded():
        if isinstance(first, Scop):
            wanted = Relations(first).stored(array, names)
        else:
            wanted = _elements(first, names)
        for one in parts:
            wanted = wanted.intersect_params(one.named(one.context, names))
            wanted = wanted.subtract(one.stored(array, names))
        return bool(wanted.is_empty())
    return False


def _elements(rectangle: Rectangle, names: Mapping[Value, str]) -> isl.Set:
    factors = {names[value]: factor for value, factor in rectangle.rows.linear().items()}
    rows = form(factors, rectangle.rows.coefficient())
    inside = f"0 <= row < {rows} and 0 <= column < {names[rectangle.columns]}"
    return isl.Set(f"[{', '.join(names.values())}] -> {{ [row, column] : {inside} }}")


def _maps_of(relation: isl.UnionMap) -> Iterator[isl.Map]:
    """The maps of a relation, one for each two spaces."""
    maps = relation.get_map_list()
    yield from (maps.get_at(position) for position in range(maps.n_map()))


def _goes_on(times: isl.Map) -> bool:
    """Whether each time leads to later ones only. It is asked of times and not of iterations, of
    which isl takes several times as long.
    """
    back = isl.Map.lex_ge(times.get_space().domain())
    return bool(times.intersect(back).is_empty())


def _form(bound: isl.PwAff) -> Form | None:
    """A bound of symbols as a form; None if it is several, or no sum of them."""
    pieces = bound.coalesce().get_pieces()
    if len(pieces) != 1:
        return None
    [(_, one)] = pieces
    if one.dim(isl.dim_type.div) or integer(one.get_denominator_val()) != 1:
        return None
    kind = isl.dim_type.param
    names = [str(one.get_dim_name(kind, place)) for place in range(one.dim(kind))]
    factors = (integer(one.get_coefficient_val(kind, place)) for place in range(len(names)))
    constant = integer(one.get_constant_val())
    return form(dict(zip(names, factors, strict=True)), constant)


def _places(scop: Scop) -> Iterator[tuple[Statement, tuple[int, ...]]]:
    """Statements with their positions among siblings, from the outside in."""

    def walk(
        node: Nest | Statement, place: tuple[int, ...]
    ) -> Iterator[tuple[Statement, tuple[int, ...]]]:
        if isinstance(node, Statement):
            yield node, place
            return
        for position, child in enumerate(node.children):
            yield from walk(child, (*place, position))

    yield from walk(scop.nest, (0,))
