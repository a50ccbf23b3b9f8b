"""What code accesses: scalars and elements by their subscripts, and under which guards."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

from vividc.ssa.ir import Instr
from vividc.ssa.polyhedral.forms import Form
from vividc.ssa.polyhedral.guards import Guard, implies


@dataclass(frozen=True)
class Place:
    """A scalar (by the id of its value) or an element of an array (by name)."""

    owner: str | int
    subscripts: tuple[Form, ...]

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        return hash((self.owner, self.subscripts))

    @cached_property
    def is_scalar(self) -> bool:
        """Whether it has no place in memory."""
        return isinstance(self.owner, int)

    @cached_property
    def names(self) -> frozenset[str]:
        """What its subscripts are made of."""
        return frozenset(name for form in self.subscripts for name in form.names)

    def at(self, forms: Mapping[str, Form]) -> Place:
        """The place with forms in place of names."""
        return Place(self.owner, tuple(one.substituted(forms) for one in self.subscripts))


@dataclass
class Accessed:
    """What code accesses: whether it writes a place, a load of it if there is one, and the guards
    of its accesses.
    """

    written: dict[Place, bool] = field(default_factory=dict)
    loads: dict[Place, Instr] = field(default_factory=dict)
    guards: dict[Place, set[Guard]] = field(default_factory=dict)

    def add(self, place: Place, guard: Guard, *, written: bool) -> None:
        """One more access."""
        self.written[place] = self.written.get(place, False) or written
        self.guards.setdefault(place, set()).add(guard)

    def add_all(self, other: Accessed) -> None:
        """What other code accesses, too."""
        written, guards = self.written, self.guards
        for place, is_written in other.written.items():
            if place in written:
                written[place] = written[place] or is_written
                guards[place] |= other.guards[place]
            else:
                written[place] = is_written
                guards[place] = set(other.guards[place])
        for place, load in other.loads.items():
            self.loads.setdefault(place, load)

    def widest(self, place: Place) -> Guard | None:
        """The guard that holds wherever a place is accessed, if one of its accesses has it."""
        guards = self.guards[place]
        return next((one for one in guards if all(implies(other, one) for other in guards)), None)

    def is_sure(self, place: Place, guard: Guard) -> bool:
        """Whether a place is accessed wherever a guard holds."""
        return any(implies(guard, other) for other in self.guards.get(place, ()))
