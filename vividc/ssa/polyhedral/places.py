"""Which scalars and elements of arrays a part accesses, and which of them may be one place."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import islpy as isl

from vividc.ssa.ir import Instr, Value
from vividc.ssa.polyhedral.forms import Form, symbol, zeros
from vividc.ssa.polyhedral.guards import (
    ALWAYS,
    Accessed,
    Guard,
    both,
    implies,
    is_maskable,
    masked,
    moved,
    names_of,
)
from vividc.ssa.polyhedral.loops import Code, For, Loops, Quotient, Run, fors_in, runs_in
from vividc.ssa.polyhedral.relations import Relations, Rows
from vividc.ssa.polyhedral.rows import names_of_rows
from vividc.ssa.polyhedral.scop import Scop, Statement
from vividc.ssa.polyhedral.subscripts import Access, Place

_KEPT = 1 << 14
"""So many sets of which it is known whether they are empty: a text of 200 bytes each."""


@dataclass(frozen=True)
class Known:
    """The value of a place. `store`: what has not been stored yet, by the store that it comes
    from; `when`: the value was loaded under this predicate, and is stored under it; `guard`: where
    it is the value; `stored`: where it is stored, if not wherever it is the value.
    """

    value: Value
    store: Instr | None = None
    when: Value | None = None
    guard: Guard = ALWAYS
    stored: Guard | None = None


@dataclass(frozen=True)
class Rotated:
    """A place that is, under a guard, what `source` was in the iteration before; a load of it.

    `streamed`: the value of `source` is known where the next iteration has the guard.
    """

    place: Place
    source: Place
    guard: Guard
    load: Instr
    streamed: bool = False


@dataclass(frozen=True)
class Stream:
    """Elements that iterations of a loop access one after another, each at several places (at j + 1
    first, then at j and at j - 1), some of which only some iterations access.

    Attributes
    ----------
    places
        The first is where an iteration may be the first to access an element; each other is what
        the one before it was an iteration earlier.
    guards
        Where each place is an element between those that the part accesses.
    load
        A load of one of them.
    """

    places: tuple[Place, ...]
    guards: tuple[Guard, ...]
    load: Instr

    def rotated(self) -> Iterator[Rotated]:
        """All but the first."""
        pairs = zip(self.places, self.places[1:], self.guards[1:], strict=False)
        for source, place, guard in pairs:
            yield Rotated(place, source, guard, self.load, streamed=True)


@dataclass(frozen=True)
class Places:
    """The places of a part's statements in the loops of a schedule.

    `masks`: branches are guards where `is_maskable` says so. `rows`: of arrays that have some.
    `carries`: whether registers carry elements from one iteration to the next. `shares`: whether
    what is loaded under several guards is loaded once.
    """

    scop: Scop
    loops: Loops
    masks: bool = False
    rows: Mapping[str, Rows] = field(default_factory=dict)
    carries: bool = True
    shares: bool = False
    carried: set[Place] = field(default_factory=set)
    """Places that are something else, or known for longer, as registers carry elements."""
    _runs: dict[int, tuple[tuple[Run, Guard], ...] | None] = field(default_factory=dict)
    _elements: dict[tuple[int, int], Place] = field(default_factory=dict)
    _touched: dict[int, Accessed] = field(default_factory=dict)
    """By the identities of accesses and of code, which live as long."""
    _met: dict[tuple[Place, Place, Guard], bool] = field(default_factory=dict)
    _meet: dict[tuple[tuple[Form, ...], Guard], bool] = field(default_factory=dict)
    _accessed: dict[tuple[str, frozenset[str]], bool] = field(default_factory=dict)
    _row: dict[tuple[str, Form], int | None] = field(default_factory=dict)
    _boxes: dict[str, tuple[tuple[Form, Form], ...] | None] = field(default_factory=dict)

    @cached_property
    def statements(self) -> Mapping[str, Statement]:
        """By name."""
        return {statement.name: statement for statement in self.scop.statements}

    @cached_property
    def every(self) -> Mapping[str, For]:
        """All loops, by name."""
        return {loop.name: loop for loop in fors_in(self.loops.code)}

    def at(self, run: Run) -> Mapping[str, Form]:
        """The coordinates of an iteration."""
        statement = self.statements[run.statement]
        return statement.placed(dict(zip(statement.coordinates, run.coordinates, strict=True)))

    @cached_property
    def row_names(self) -> Mapping[tuple[str, int], str]:
        """The array that each iteration of a group uses, by array and place in the group."""
        return names_of_rows(self.scop.function, self.rows)

    @cached_property
    def arrays(self) -> Mapping[str, str]:
        """The arrays of which others are rows."""
        return {name: array for (array, _), name in self.row_names.items()}

    def element(self, access: Access, run: Run) -> Place:
        """The element that an access of a statement touches in an iteration."""
        key = id(access), id(run)
        if key not in self._elements:
            self._elements[key] = self._element(access, run)
        return self._elements[key]

    def _element(self, access: Access, run: Run) -> Place:
        at = self.at(run)
        subscripts = tuple(one.substituted(at) for one in access.subscripts)
        if access.array not in self.rows:
            return Place(access.array, subscripts)
        row = self._row_of(access.array, run)
        assert row is not None
        return Place(self.row_names[access.array, row], subscripts)

    def are_rows_known(self) -> bool:
        """Whether the place of each iteration in its group is the same each time."""
        return all(
            self._row_of(access.array, run) is not None
            for run in runs_in(self.loops.code)
            for access in self.statements[run.statement].accesses.values()
            if access.array in self.rows
        )

    def _row_of(self, array: str, run: Run) -> int | None:
        """Where in its group of iterations with rows of an array one is."""
        rows = self.rows[array]
        statement = self.statements[run.statement]
        position = statement.coordinates.index(rows.over[run.statement])
        ahead = run.coordinates[position].plus(rows.base, -1)
        if (array, ahead) not in self._row:
            symbols, chosen, conditions = self._reached([ahead], quotients=True)
            left = f"[{symbols}] -> {{ [{chosen}] : {''.join(f'{c} and ' for c in conditions)}"
            self._row[array, ahead] = next(
                (
                    place
                    for place in range(rows.factor)
                    if _is_empty(f"{left} ({ahead}) mod {rows.factor} != {place} }}")
                ),
                None,
            )
        return self._row[array, ahead]

    def scalar(self, ident: int, run: Run) -> Place:
        """The scalar that a value is in an iteration of a statement."""
        return Place(ident, run.coordinates[: self.scop.depth[ident]])

    def is_masked(self, item: Code) -> bool:
        """Whether it runs without a branch, under guards; a statement by itself does."""
        return isinstance(item, Run) or (self.masks and self.runs(item) is not None)

    def runs(self, item: Code) -> tuple[tuple[Run, Guard], ...] | None:
        """The iterations of statements in it, each with its guard, if it `is_maskable`."""
        if id(item) not in self._runs:
            self._runs[id(item)] = tuple(masked(item)) if is_maskable(item) else None
        return self._runs[id(item)]

    def accessed(self, code: Iterable[Code]) -> Accessed:
        """What code accesses, loops and branches in it included; what is in a branch may run
        anywhere.
        """
        result = Accessed()
        for item in code:
            result.add_all(self.accessed_in(item))
        return result

    def accessed_in(self, item: Code) -> Accessed:
        """As `accessed`, of one loop, branch or statement: nobody may change it."""
        if id(item) not in self._touched:
            if self.is_masked(item):
                self._touched[id(item)] = self._accessed_by(self.runs(item) or ())
            elif not isinstance(item, Run):
                inside = item.body if isinstance(item, For) else (*item.then, *item.otherwise)
                self._touched[id(item)] = self.accessed(inside)
        return self._touched[id(item)]

    def _accessed_by(self, runs: Iterable[tuple[Run, Guard]]) -> Accessed:
        result = Accessed()
        for run, guard in runs:
            statement = self.statements[run.statement]
            for access in statement.accesses.values():
                place = self.element(access, run)
                result.add(place, guard, written=access.is_store)
                if not access.is_store:
                    result.loads.setdefault(place, access.instr)
            for ident in statement.reads:
                result.add(self.scalar(ident, run), guard, written=False)
            for ident in (*statement.writes, *(phi for phi, _ in statement.copies)):
                result.add(self.scalar(ident, run), guard, written=True)
        return result

    def varying(self, loop: For) -> frozenset[str]:
        """Names that change within a run of the loop."""
        names = {loop.name, *(inner.name for inner in fors_in(loop.body))}
        quotients = self.loops.quotients.items()
        return frozenset(names | {n for n, q in quotients if q.dividend.names & names})

    def fixed(self, loop: For, accessed: Accessed) -> dict[Place, Guard]:
        """Places that are the same in all iterations of a loop, which each iteration accesses under
        the same guard at least, and which no other access of the loop may meet, unless it only
        loads them and stores to what it may meet in no loop or branch inside.
        """
        inner = self.varying(loop)
        own = self.accessed(item for item in loop.body if self.is_masked(item))
        direct = own.guards
        within = self.accessed(item for item in loop.body if not self.is_masked(item))
        result = {}
        for place, written in accessed.written.items():
            if place.names & inner:
                continue
            others = (other for other in accessed.written.items() if other[0] != place)
            wanted = accessed.guards[place]
            guards = [
                guard
                for guard in direct.get(place, ())
                if not names_of(guard) & inner and all(implies(one, guard) for one in wanted)
            ]
            if place.is_scalar:
                result[place] = ALWAYS
            elif not guards:
                continue
            elif self.carries and not written:
                if not self.is_met(place, within):
                    result[place] = guards[0]
                    self.carried.update([place] if self.is_met(place, own) else [])
            elif not any((written or w) and self.may_meet(place, p) for p, w in others):
                result[place] = guards[0]
        return result

    def is_met(self, place: Place, accessed: Accessed) -> bool:
        """Whether a store to a place, or to what may be the same element, is among accesses."""
        return any(w and self.may_meet(place, p) for p, w in accessed.written.items())

    def rotated(self, loop: For, accessed: Accessed) -> Iterator[Rotated]:
        """Places that an iteration of an innermost loop loads, and the one before it accesses too,
        if nothing else that the loop writes may meet them.
        """
        if not (self.carries and all(map(self.is_masked, loop.body))):
            return
        inner, written = self.varying(loop), [p for p, is_w in accessed.written.items() if is_w]
        following = {loop.name: symbol(loop.name).plus(Form((), loop.step))}
        for place, load in accessed.loads.items():
            source = place.at(following)
            if place.names & inner != {loop.name} or source not in accessed.written:
                continue
            guard, other = accessed.widest(place), accessed.widest(source)
            if guard is None or other is None or names_of(guard) & inner:
                continue  # it may be of a stream
            others = (p for p in written if p not in (place, source))
            if implies(guard, other) and not any(
                self.may_meet(place, p) or self.may_meet(source, p) for p in others
            ):
                self.carried.add(place)
                yield Rotated(place, source, guard, load)

    def streams(self, loop: For, accessed: Accessed) -> Iterator[Stream]:
        """Streams of an innermost loop under guards that change with its iterations, if nothing
        else that the loop writes may meet them.
        """
        if not (self.carries and all(map(self.is_masked, loop.body))):
            return
        inner = self.varying(loop)
        ahead, back = (
            {loop.name: symbol(loop.name).plus(Form((), step))} for step in (loop.step, -loop.step)
        )
        for top in accessed.written:
            if top.names & inner != {loop.name} or top.at(ahead) in accessed.written:
                continue
            if top.is_scalar or top.owner not in self.scop.elements:
                continue  # rows are of iterations, which share nothing
            chain = [top]
            while (behind := chain[-1].at(back)) in accessed.written:
                chain.append(behind)
            made = self._stream(loop, accessed, tuple(chain))
            if made is not None:
                self.carried.add(top)
                yield made

    def _stream(self, loop: For, accessed: Accessed, chain: tuple[Place, ...]) -> Stream | None:
        tests = (guard for place in chain for guard in accessed.guards[place])
        names = frozenset(name for guard in tests for name in names_of(guard))
        loads = [accessed.loads[place] for place in chain if place in accessed.loads]
        is_carried = any(place in accessed.loads for place in chain[1:])
        if not is_carried or names & self.varying(loop) != {loop.name}:
            return None
        others = (p for p, is_w in accessed.written.items() if is_w and p not in chain)
        if any(self.may_meet(place, other) for other in others for place in chain):
            return None
        guards = [self._inside(place) for place in chain]
        known = tuple(guard for guard in guards if guard is not None)
        return Stream(chain, known, loads[0]) if len(known) == len(chain) else None

    def _inside(self, place: Place) -> Guard | None:
        """Where a place is an element between those that the part accesses, which the array has;
        None if that is not known.
        """
        array = str(place.owner)
        if array not in self._boxes:
            self._boxes[array] = self._box(array, len(place.subscripts))
        box = self._boxes[array]
        if box is None:
            return None
        tests = []
        for subscript, (first, last) in zip(place.subscripts, box, strict=True):
            for test in (subscript.plus(first, -1), last.plus(subscript, -1)):
                symbols, chosen, conditions = self._reached([test])
                below = " and ".join((*conditions, f"{test} < 0"))
                if not _is_empty(f"[{symbols}] -> {{ [{chosen}] : {below} }}"):
                    tests.append(test)
        return both(frozenset(tests), ALWAYS)

    def _box(self, array: str, axes: int) -> tuple[tuple[Form, Form], ...] | None:
        """As of `Relations`, if all subscripts between are of elements: of flat indices that were
        taken apart, if the last of them is accessed. Columns are none of another row.
        """
        relations = Relations(self.scop)
        params = self.scop.function.params
        if axes == 1 or any(p.name == array and p.ndim == axes and not p.flat for p in params):
            return relations.box(array)
        box = relations.box(array) if array in self.scop.rows else None
        return box if box is not None and relations.has_corner(array, box) else None

    def origin(self, loop: For) -> str | None:
        """The header of the loop that a statement counts by this one."""
        for run in runs_in(loop.body):
            dims = self.statements[run.statement].dims
            for dim, coordinate in zip(dims, run.coordinates, strict=True):
                if loop.name in coordinate.names:
                    return dim.header
        return None

    def shared(
        self, place: Place, guard: Guard, accessed: Accessed, around: Collection[str]
    ) -> Guard:
        """Under which guard an element is loaded that is needed where this one holds, and in
        other iterations of the group under others: once for all of them, if that is possible.

        Parameters
        ----------
        accessed
            What the group accesses.
        around
            Names of the loops around it.
        """
        guards = accessed.guards.get(place, set())
        if not self.shares or len(guards) <= 1 or place.owner not in self.scop.elements:
            return guard
        widest = accessed.widest(place)
        if widest is not None:
            return widest
        inside = self._inside(place)
        if inside is None or not all(implies(one, inside) for one in guards):
            return guard
        return inside if self._is_accessed(str(place.owner), frozenset(around)) else guard

    def _is_accessed(self, array: str, around: frozenset[str]) -> bool:
        """Whether the part accesses elements of an array for all lengths for which loops run, so
        that it has those between them.
        """
        if (array, around) not in self._accessed:
            relations = Relations(self.scop)
            symbols, chosen, conditions = self._reached(map(symbol, sorted(around)), quotients=True)
            where = f" : {' and '.join(conditions)}" if conditions else ""
            runs = isl.Set(f"[{symbols}] -> {{ [{chosen}]{where} }}").params()
            runs = runs.intersect(relations.context)
            found = bool(runs.is_subset(relations.touched(array).params()))
            self._accessed[array, around] = found
        return self._accessed[array, around]

    def may_meet(self, one: Place, other: Place, guard: Guard = ALWAYS) -> bool:
        """Whether two places may be one where a guard holds, as loops go through all their
        iterations.
        """
        if one.owner != other.owner:
            return False
        key = one, other, guard
        if key not in self._met:
            self._met[key] = self._may_meet(one, other, guard)
        return self._met[key]

    def _may_meet(self, one: Place, other: Place, guard: Guard) -> bool:
        pairs = tuple(zip(one.subscripts, other.subscripts, strict=True))
        if any(a.terms == b.terms and a.constant != b.constant for a, b in pairs):
            return False
        if one.subscripts == other.subscripts:
            return True
        if one.is_scalar:
            return False
        met = zeros(a.plus(b, -1) for a, b in pairs)
        tests = None if met is None else moved(guard if self.shares else ALWAYS, met.solved)
        if met is None or tests is None:
            return False
        if (met.forms, tests) not in self._meet:
            self._meet[met.forms, tests] = self._has_solution(met.forms, tests)
        return self._meet[met.forms, tests]

    def _has_solution(self, gaps: tuple[Form, ...], guard: Guard) -> bool:
        tests = sorted(guard, key=str)
        symbols, chosen, conditions = self._reached((*gaps, *tests))
        conditions += [f"{gap} = 0" for gap in gaps]
        conditions += [f"{test} >= 0" for test in tests]
        inside = f"[{chosen}] : {' and '.join(conditions)}"
        return not _is_empty(f"[{symbols}] -> {{ {inside} }}")

    def _reached(
        self, forms: Iterable[Form], *, quotients: bool = False
    ) -> tuple[str, str, list[str]]:
        """isl's lists of the symbols and counters that forms are made of, and what is known of
        these; of quotients too where asked for.
        """
        chosen: dict[str, For] = {}
        known: dict[str, Quotient] = {}
        named: set[str] = set()
        work = [name for form in forms for name, _ in form.terms]
        while work:
            name = work.pop()
            named.add(name)
            if name in self.every and name not in chosen:
                loop = chosen[name] = self.every[name]
                work += [n for bound in (*loop.first, *loop.limit) for n, _ in bound.terms]
            elif quotients and name in self.loops.quotients and name not in known:
                known[name] = self.loops.quotients[name]
                work += [n for n, _ in known[name].dividend.terms]
        conditions = []
        for loop in chosen.values():
            conditions += [f"{loop.name} >= {one}" for one in loop.first]
            conditions += [f"{loop.name} < {one}" for one in loop.limit]
            if loop.step > 1 and len(loop.first) == 1:
                conditions.append(f"({loop.name} - ({loop.first[0]})) mod {loop.step} = 0")
        for name, one in known.items():
            value = f"floor(({one.dividend})/{one.divisor})"
            if one.remainder:
                value = f"({one.dividend}) mod {one.divisor}"
            conditions.append(f"{name} = {value}")
        symbols = (one for one in (*self.scop.symbols, *self.loops.quotients) if one in named)
        return ", ".join(symbols), ", ".join(chosen), conditions


@lru_cache(maxsize=_KEPT)
def _is_empty(text: str) -> bool:
    """Whether a set has no element, as isl says: forms of a nest that differ in a factor or a mask
    ask the same of many places.
    """
    return bool(isl.Set(text).is_empty())
