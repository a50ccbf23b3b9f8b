"""What the constant stores of PEs hold while a kernel's regions are mapped, one after the other.

Where they have entries for all that loops read and write, each variable has its own. Else those
that no region needs at the same time may share one (`Lives`).
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG
from vividc.dfg.lives import Lives
from vividc.dfg.regions import Kernel
from vividc.mapper.mapping import Mapping as RegionMapping
from vividc.mapper.problem import ConstantKey, MapProblem
from vividc.program.encoder.constants import numbered_entries

Homes = Mapping[str, frozenset[int]]
"""By variable, the PEs whose constant stores hold it."""

Residents = Mapping[int, frozenset[ConstantKey]]
"""By PE, the words in its constant store."""


@dataclass(frozen=True)
class Stores:
    """`held`: what regions that are mapped have there; `lives`: of variables that may share
    entries, None if none do.
    """

    fabric: Fabric
    held: Residents
    lives: Lives | None = None

    @staticmethod
    def of(kernel: Kernel, fabric: Fabric) -> Stores:
        """Empty ones, whose entries are shared if one might not hold what all loops need."""
        loops = [region.dfg for region in kernel.regions if region.kind == "loop"]
        keys = {key for dfg in loops for key in _keys(dfg, fabric)}
        is_crowded = len(keys) > min(pe.constants for pe in fabric.pes)
        nothing = {pe.id: frozenset[ConstantKey]() for pe in fabric.pes}
        return Stores(fabric, nothing, Lives.of(kernel) if is_crowded else None)

    @property
    def are_crowded(self) -> bool:
        """Whether variables may share entries."""
        return self.lives is not None

    def with_regions(self, mapped: Iterable[tuple[DFG, RegionMapping]]) -> Stores:
        """With what these regions read and write."""
        held = {pe: set(keys) for pe, keys in self.held.items()}
        for dfg, mapping in mapped:
            problem = MapProblem(dfg, self.fabric)
            for node in dfg.placed:
                held[mapping.places[node.id].pe].update(problem.constants_of(node))
        return replace(self, held={pe: frozenset(keys) for pe, keys in held.items()})

    def with_homes(self, homes: Homes) -> Stores:
        """With the variables in their homes: a straight region that is mapped before a variable is
        written must leave room for it.
        """
        held = {pe: set(keys) for pe, keys in self.held.items()}
        for name, pes in homes.items():
            for pe in pes:
                held[pe].add(("live_in", name))
        return replace(self, held={pe: frozenset(keys) for pe, keys in held.items()})

    def beside(self, index: int) -> Iterator[Residents]:
        """What is in the way of a region, of these the first beside which its mapping `fits`: what
        is needed while it runs; while any of its variables is; as many words as there are entries
        taken.
        """
        if self.lives is None:
            yield self.held
            return
        seen: list[Residents] = []
        for needed in (1 << index, self.lives.together(1 << index)):
            near = {
                pe: frozenset(key for key in keys if self.lives.of_key(key) & needed)
                for pe, keys in self.held.items()
            }
            if near not in seen:
                yield near
            seen.append(near)
        taken = {pe: self._padded(pe, keys) for pe, keys in seen[0].items()}
        if taken not in seen:
            yield taken

    def load(self, pe: int, name: str) -> int:
        """Words in a store that a variable shares no entry with."""
        keys = self.held[pe]
        if self.lives is None:
            return len(keys)
        needed = self.lives.of_key(("live_in", name))
        return sum(bool(self.lives.of_key(key) & needed) for key in keys)

    def fit(self) -> bool:
        """Whether each store has entries for what it holds; if none are shared, that is known."""
        return self.lives is None or all(
            self._numbered(pe, keys) is not None for pe, keys in self.held.items()
        )

    def _padded(self, pe: int, near: Collection[ConstantKey]) -> frozenset[ConstantKey]:
        """With others, until they are as many as there are entries taken."""
        numbers = self._numbered(pe, self.held[pe])
        taken = len(self.held[pe]) if numbers is None else 1 + max(numbers.values(), default=-1)
        others = sorted(self.held[pe] - set(near), key=repr)
        return frozenset(near) | frozenset(others[: max(0, taken - len(near))])

    def _numbered(self, pe: int, keys: Collection[ConstantKey]) -> Mapping[ConstantKey, int] | None:
        assert self.lives is not None
        return numbered_entries(sorted(keys, key=repr), self.fabric.pes[pe].constants, self.lives)


def _keys(dfg: DFG, fabric: Fabric) -> set[ConstantKey]:
    problem = MapProblem(dfg, fabric)
    return {key for node in dfg.placed for key in problem.constants_of(node)}
