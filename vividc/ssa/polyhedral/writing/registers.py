"""What is known of scalars and elements of arrays as code is written: values in registers.

What was loaded or stored is known; after a store to what may be the same element it is either that
or what it was, by a comparison of the subscripts. Stores wait until an iteration ends, or something
may meet them.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial, reduce

from vividc.machine.opcodes import Opcode, Type
from vividc.ssa.ir import Instr, Ref, Value
from vividc.ssa.polyhedral.forms import ZERO
from vividc.ssa.polyhedral.guards import Accessed, Guard, both, implies
from vividc.ssa.polyhedral.loops import Test
from vividc.ssa.polyhedral.places import Known, Places
from vividc.ssa.polyhedral.scop import Scop
from vividc.ssa.polyhedral.subscripts import Place
from vividc.ssa.polyhedral.writing.words import Words


class Unkept(Exception):
    """Code cannot be written; the text says why."""


class Registers:
    """Loads, stores and values of the places of a part, written to the end of `words`.

    Attributes
    ----------
    known
        What places are.
    predicates
        Words of guards.
    held
        Places that the open loops carry: what the iteration before has left in one may be in no
        memory, though `known` has no store of it.
    """

    def __init__(self, scop: Scop, places: Places, words: Words) -> None:
        self.scop = scop
        self.places = places
        self.words = words
        self.known: dict[Place, Known] = {}
        self.predicates: dict[Guard, Value] = {}
        self.held: frozenset[Place] = frozenset()
        self._types = {i.id: i.type for block in scop.function.blocks for i in block.items}

    @contextmanager
    def holding(self, places: Collection[Place]) -> Iterator[None]:
        """A loop's body is written that carries places."""
        before = self.held
        self.held |= frozenset(places)
        yield
        self.held = before

    def type_of(self, place: Place) -> Type:
        """Of its value."""
        kind = self._types[place.owner] if isinstance(place.owner, int) else None
        owner = str(place.owner)
        kind = kind or self.scop.elements[self.places.arrays.get(owner, owner)]
        assert isinstance(kind, Type)
        return kind

    def loaded(
        self, instr: Instr, place: Place, guard: Guard, beside: Accessed | None = None
    ) -> Value:
        """The value of an element where a guard holds; `beside`: what else may load it, too."""
        known = self.known.get(place)
        if known is None or not implies(guard, known.guard):
            self.drop(place)
            under = guard
            if beside is not None:
                under = self.places.shared(place, guard, beside, self.words.order)
            when = self.predicate(under)
            known = self.known[place] = Known(self.load(instr, place, when), None, when, under)
        return known.value

    def load(self, instr: Instr, place: Place, when: Value | None = None) -> Value:
        """The value of an element, loaded as by `instr`."""
        for other, known in list(self.known.items()):
            if known.store is not None and other != place and self.places.may_meet(place, other):
                self.flush(other)
        return self.words.access(instr, place, () if when is None else (when,))

    def store(self, instr: Instr, place: Place, value: Value, guard: Guard) -> None:
        """An element has a value from now on where the guard holds, to be stored as by `instr`."""
        load = self.scop.narrow.get(instr.array)
        kept = value if load is None else self.words.as_loaded(load, value)
        for other in [one for one in self.known if one.owner == place.owner and one != place]:
            there = both(guard, self.known[other].guard)
            if not self.places.may_meet(place, other, there):
                continue
            if self.places.carries:
                self.places.carried.add(other)
                self._meet(other, place, kept, guard)
            else:
                self.drop(other)
        before = self.known.get(place)
        apart = before is not None and not implies(before.guard, guard)
        if before is not None and apart and not implies(guard, before.guard):
            self.drop(place)
        self.put(place, kept, guard, instr)

    def _meet(self, place: Place, stored: Place, value: Value, guard: Guard) -> None:
        """What is known of a place is the value stored at another one where they are the same."""
        if self.known[place].store is not None:
            self.flush(place)
        known, when = self.known[place], self.same(place, stored)
        under = None if implies(known.guard, guard) else self.predicate(guard)
        if under is not None:
            when = self.words.emit(Opcode.AND, when, under)
        self.known[place] = replace(known, value=self._chosen(place, when, value, known.value))

    def same(self, one: Place, other: Place) -> Value:
        """Whether two places that may be one are."""
        gaps = (a.plus(b, -1) for a, b in zip(one.subscripts, other.subscripts, strict=True))
        tests = [
            self.words.emit(Opcode.ICMP_EQ, self.words.of(replace(gap, constant=0)), -gap.constant)
            for gap in gaps
            if gap != ZERO
        ]
        return reduce(partial(self.words.emit, Opcode.AND), tests)

    def _chosen(self, place: Place, when: Value, one: Value, other: Value) -> Value:
        """The first value where a predicate holds, else the second."""
        kind = self.type_of(place)
        made = Instr(self.words.ids(), Opcode.SELECT, kind, (when, one, other), loc=self.words.loc)
        self.words.instrs.append(made)
        return Ref(made.id)

    def put(self, place: Place, value: Value, guard: Guard, instr: Instr | None = None) -> None:
        """A place has a value from now on where the guard holds."""
        before = self.known.get(place)
        if before is None or implies(before.guard, guard):
            same = before is not None and before.guard == guard
            when = before.when if before is not None and same else self.predicate(guard)
            self.known[place] = Known(value, instr, None if place.is_scalar else when, guard)
            return
        when = self.predicate(guard)
        assert when is not None
        chosen = self._chosen(place, when, value, before.value)
        if before.store is not None and before.stored is not None:
            if implies(guard, before.stored):
                guard = before.stored
            elif not implies(before.stored, guard):
                self.flush(place)
        stored = guard if before.stored is not None or before.store is None else None
        self.known[place] = replace(before, value=chosen, store=instr, stored=stored)

    def predicate(self, guard: Guard) -> Value | None:
        """The word of a guard; None if it always holds."""
        if guard and guard not in self.predicates:
            order = {name: place for place, name in enumerate(self.words.order)}
            depths = {one: max((order.get(n, -1) for n in one.names), default=-1) for one in guard}
            tests = tuple(Test(">=", f) for f in sorted(guard, key=lambda f: (depths[f], str(f))))
            test = tests[0] if len(tests) == 1 else Test("and", parts=tests)
            self.predicates[guard] = self.words.test(test)
        return self.predicates.get(guard)

    def drop(self, place: Place) -> None:
        """Forgets the value of a place; it is in memory then.

        Raises
        ------
        Unkept
            If a loop carries it.
        """
        if place in self.held:
            raise Unkept("an element that a loop carries is changed where it is not known")
        known = self.known.get(place)
        if known is not None and known.store is not None:
            self.flush(place)
        self.known.pop(place, None)

    def flush(self, place: Place) -> None:
        known = self.known[place]
        assert known.store is not None
        self.known[place] = replace(known, store=None, stored=None)
        under = known.when if known.stored is None else self.predicate(known.stored)
        when = () if under is None else (under,)
        self.words.access(known.store, place, (known.value, *when))

    def store_all(self) -> None:
        for place, known in list(self.known.items()):
            if known.store is not None:
                self.flush(place)
