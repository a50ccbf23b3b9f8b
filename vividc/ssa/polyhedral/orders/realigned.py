"""Parts written in another order: another loop outermost, and once what several statements do."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import islpy as isl

from vividc.ssa.polyhedral.forms import Form, form, symbol
from vividc.ssa.polyhedral.orders.bands import Band, Bands
from vividc.ssa.polyhedral.orders.families import Family, domain_in, families_of
from vividc.ssa.polyhedral.orders.in_memory import in_memory
from vividc.ssa.polyhedral.orders.search import is_legal
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.scop import Dimension, Nest, Scop, Statement
from vividc.ssa.polyhedral.values import integer

_Counted = tuple[str, str, int]
"""A loop's counter, the coordinate that it counts, and what is added to that."""

_MOST_TRIES = 8
"""Orders that are looked at for those that can be written."""


def realigned(relations: Relations, most: int) -> list[Scop]:
    """The part in orders whose outermost loop is that of a sum, which the source has further inside
    (lu, right-looking): `most` of them, the first those whose outermost loop carries the most
    dependences.
    """
    return list(itertools.islice(_written(relations, _is_of_sum), most))


def other_orders(relations: Relations) -> Iterator[Scop]:
    """The part in all orders that can be written, whatever their outermost loop is."""
    return _written(relations, lambda _, __: True)


def _written(
    relations: Relations, is_wanted: Callable[[Band, tuple[Family, ...]], bool]
) -> Iterator[Scop]:
    """Nothing if statements leave scalars for others, which would have to wait in memory, and for
    a single statement, whose loops an interchange finds.
    """
    relations = Relations(in_memory(relations.scop))
    statements = relations.scop.statements
    if len(statements) == 1 or any(s.reads or s.writes or s.copies for s in statements):
        return
    families = tuple(families_of(relations))
    bands = (b for b in Bands(relations, families).found() if is_wanted(b, families))
    for band in itertools.islice(bands, _MOST_TRIES):
        made = _Writer(relations, families).written(band)
        if made is not None:
            yield made


def _is_of_sum(band: Band, families: tuple[Family, ...]) -> bool:
    """Whether the outermost loop is one of a family whose stores it does not move."""
    for number, (name, _) in band.over.items():
        statement = families[number][0].statement
        at = statement.placed({one: symbol(one) for one in statement.coordinates})
        stores = [access for access in statement.accesses.values() if access.is_store]
        used = {n for one in stores for form in one.subscripts for n in form.substituted(at).names}
        if name not in used and name != statement.coordinates[0]:
            return True
    return False


@dataclass(frozen=True)
class _Writer:
    relations: Relations
    families: tuple[Family, ...]

    def written(self, band: Band) -> Scop | None:
        """The part in this order; None if a loop would need more than one form as a bound."""
        if not is_legal(band.tree(self.families), self.relations):
            return None
        scop = self.relations.scop
        first = sum(len(statement.dims) for statement in scop.statements)
        nest = self._nest(band, {n: () for n in band.over}, itertools.count(first))
        return None if nest is None else replace(scop, nest=nest)

    def _nest(
        self, band: Band, around: Mapping[int, tuple[_Counted, ...]], numbers: Iterator[int]
    ) -> Nest | None:
        """The loops of a band; `around`: what loops around count of each family."""
        name = f"i{next(numbers)}"
        loops = {n: (*around[n], (name, *moved)) for n, moved in band.over.items()}
        children: list[Nest | Statement] = []
        for child in band.children:
            made = (
                self._nest(child, loops, numbers)
                if isinstance(child, Band)
                else self._statement(self.families[child], loops[child])
            )
            if made is None:
                return None
            children.append(made)
        deepest = max(
            (s for c in children for s in ([c] if isinstance(c, Statement) else c.statements())),
            key=lambda statement: len(statement.dims),
        )
        dim = next(dim for dim in deepest.dims if dim.name == name)
        return Nest(dim, tuple(children))

    def _statement(self, family: Family, loops: tuple[_Counted, ...]) -> Statement | None:
        """A family as one statement of these loops."""
        host = family[0].statement
        forms = [symbol(old).plus(Form((), moved)) for _, old, moved in loops]
        domain = domain_in(family[0], forms, self.relations)
        for member in family[1:]:
            domain = domain.union(domain_in(member, forms, self.relations))
        names = [name for name, _, _ in loops]
        bounds = _bounds(domain.coalesce(), names, self.relations)
        if bounds is None:
            return None
        shift = {old: symbol(name).plus(Form((), -moved)) for name, old, moved in loops}
        by_name = {dim.name: dim for dim in host.dims}
        dims = [
            Dimension(
                by_name[old].header,
                by_name[old].counter,
                name,
                by_name[old].value.substituted(shift),
                limits,
            )
            for (name, old, _), limits in zip(loops, bounds, strict=True)
        ]
        guards = tuple(guard.substituted(shift) for guard in host.guards)
        shift |= {name: value.substituted(shift) for name, value in host.shift.items()}
        made = replace(host, dims=tuple(dims), guards=guards, shift=shift)
        same = self.relations.domain(made).reset_tuple_id().is_equal(domain)
        return made if same else None


def _bounds(
    domain: isl.Set, names: Sequence[str], relations: Relations
) -> list[tuple[Form, Form]] | None:
    """Of each coordinate of a set the first and the limit, by those before it; None if these are
    the largest or least of several, or not whole.
    """
    found = []
    outer = domain.project_out(isl.dim_type.set, 0, len(names)).intersect_params(relations.context)
    for place in range(len(names)):
        inner = domain.project_out(isl.dim_type.set, place + 1, len(names) - place - 1).coalesce()
        known = outer.insert_dims(isl.dim_type.set, place, 1)
        parts = inner.gist(known).coalesce().get_basic_sets()
        limits = _limits(parts[0], place, names) if len(parts) == 1 else None
        if limits is None:
            return None
        found.append(limits)
        outer = inner
    return found


def _limits(part: isl.BasicSet, place: int, names: Sequence[str]) -> tuple[Form, Form] | None:
    """The only first and limit of a coordinate."""
    firsts: list[Form] = []
    limits: list[Form] = []
    if part.dim(isl.dim_type.div):
        return None
    symbols = [str(name) for name in part.get_var_names(isl.dim_type.param)]
    for constraint in part.get_constraints():
        factor = integer(constraint.get_coefficient_val(isl.dim_type.set, place))
        if not factor:
            continue
        if abs(factor) != 1:
            return None
        terms = {
            name: integer(constraint.get_coefficient_val(kind, position))
            for kind, every in ((isl.dim_type.set, names[:place]), (isl.dim_type.param, symbols))
            for position, name in enumerate(every)
        }
        rest = form(terms, integer(constraint.get_constant_val()))
        both = constraint.is_equality()
        if factor > 0 or both:
            firsts.append(rest.times(-factor))
        if factor < 0 or both:
            limits.append(rest.times(-factor).plus(Form((), 1)))
    return (firsts[0], limits[0]) if len(firsts) == len(limits) == 1 else None
