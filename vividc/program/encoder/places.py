"""Where the contexts of a long program lie, so that few are brought while it runs.

Only regions whose places in the configuration memory others have as well are ever brought again
(docs/machine.md, "Long programs"). What is hardly ever run, as the version of a kernel for sizes
that do not agree, is put behind the memory's end, and at its beginning, where those contexts go,
what is run rarely besides.
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass

from vividc.arch.fabric import Fabric


@dataclass(frozen=True, slots=True)
class Turns:
    """How the regions of a program are expected to come by turns, each by its index.

    Attributes
    ----------
    entries
        How often a run enters it.
    reached
        How often a run comes to it, or to the nest that it is in: at most once.
    around
        Loops around it, the outermost first: a name, and its iterations in a run.
    rare
        Those that hardly any run comes to.
    """

    entries: Sequence[float]
    reached: Sequence[float]
    around: Sequence[tuple[tuple[str, float], ...]]
    rare: Set[int] = frozenset()

    def held(self, lengths: Sequence[int]) -> int:
        """Return how many contexts those take that are not rare."""
        return sum(length for index, length in enumerate(lengths) if index not in self.rare)

    def layout(self, lengths: Sequence[int], fabric: Fabric) -> Layout:
        """The order of regions of such lengths with which fewest cycles go by as contexts are
        brought: their own, or the one in which rare ones share places. Of what is expected too
        little is known if they are not most of what is too long (contour_integral of NPBench takes
        twice its cycles).
        """
        own = tuple(range(len(lengths)))
        most = fabric.controller.contexts
        excess = sum(lengths) - most
        if excess <= 0:
            return Layout(own, frozenset(own), 0.0)
        ways = [own]
        if 2 * sum(lengths[index] for index in self.rare) >= excess:
            ways.append(self._with_rare_ones_apart(lengths, excess))
        made = (self._laid_out(order, lengths, fabric) for order in ways)
        return min(made, key=lambda one: one.cycles)

    def _with_rare_ones_apart(self, lengths: Sequence[int], excess: int) -> tuple[int, ...]:
        """Regions that are ranked as the least often needed at both ends: behind the end of the
        memory as many as are too long for it, at the beginning those that these overwrite.
        """

        def rank(index: int) -> tuple[float, int]:
            return 0.0 if index in self.rare else self.entries[index], -index

        left = sorted(range(len(lengths)), key=rank)
        parts: list[list[int]] = []
        for _ in range(2):
            taken = 0
            while taken < len(left) and sum(lengths[i] for i in left[:taken]) < excess:
                taken += 1
            parts.append(sorted(left[:taken]))
            left = left[taken:]
        last, first = parts
        return (*first, *sorted(left), *last)

    def _laid_out(self, order: Sequence[int], lengths: Sequence[int], fabric: Fabric) -> Layout:
        most = fabric.controller.contexts
        places: dict[int, range] = {}
        begin = 0
        for index in order:
            places[index] = range(begin, begin + lengths[index])
            begin += lengths[index]
        users: list[list[int]] = [[] for _ in range(most)]
        for index, contexts in places.items():
            for context in contexts:
                users[context % most].append(index)
        cycles, stays = 0.0, set()
        for index, contexts in places.items():
            others = {one for context in contexts for one in users[context % most]} - {index}
            if not others:
                stays.add(index)
                continue
            is_there = contexts.stop <= most
            times = self._brought(index, sorted(others), is_there)
            cycles += len(fabric.pes) * len(contexts) * times
        return Layout(tuple(order), frozenset(stays), cycles)

    def _brought(self, index: int, others: Sequence[int], is_there: bool) -> float:
        """How often the contexts of a region are brought at most: once in each iteration of the
        innermost loop around it in which others take its places, and once for each of these.
        """
        for name, iterations in reversed(self.around[index]):
            inside = [one for one in others if any(loop == name for loop, _ in self.around[one])]
            if inside:
                evictions = _sum(self.entries, inside)
                return min(self.entries[index], iterations, evictions + self.reached[index])
        evictions = _sum(self.reached, others)
        return min(self.reached[index], evictions) if is_there else self.reached[index]


def _sum(shares: Sequence[float], indices: Sequence[int]) -> float:
    return sum(shares[index] for index in indices)


@dataclass(frozen=True, slots=True)
class Layout:
    """The order of regions in the contexts of a program.

    Attributes
    ----------
    order
        Indices of regions.
    stays
        Those whose contexts are there all the time: only these may overlap.
    cycles
        Of a run, expected, in which contexts are brought.
    """

    order: tuple[int, ...]
    stays: frozenset[int]
    cycles: float
