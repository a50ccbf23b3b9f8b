"""Routes of words on the MRRG with claims per slot: shortest paths through what is free."""

from __future__ import annotations

import heapq
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from vividc.mapper.deadline import Deadline
from vividc.mapper.mapping import Step
from vividc.mapper.resources.mrrg import MRRG, NONE
from vividc.mapper.resources.registers import Lifetime, allocate

Cell = tuple[int, int]
"""(location, cycle of the producer's iteration)."""
Way = tuple[Cell, ...]

_WAIT, _MOVE = 1, 2
_CELL_S: Final = 1e-5
"""Effort of a cell that a search visits."""


@dataclass(frozen=True, slots=True)
class Result:
    """A word as its producer makes it: on PE `pe`, readable from cycle `ready` on."""

    word: int
    pe: int
    ready: int


class Words:
    """The words on the array. The ways of one word form a tree; what is in it is claimed once.

    Attributes
    ----------
    ways
        (word, cells) of each routed edge, by edge index.
    crowded
        Register files whose words `steps` found no names for, as locations.
    """

    def __init__(self, graph: MRRG, ii: int, less: Mapping[int, int], deadline: Deadline) -> None:
        """`less`: registers to leave alone, by location; no way is found after the deadline."""
        self.graph, self.ii, self.deadline = graph, ii, deadline
        self.crowded: list[int] = []
        self._room = [resource.capacity for resource in graph.resources]
        for location, count in less.items():
            self._room[int(graph.occupies[location])] -= count
        self.ways: dict[int, tuple[int, Way]] = {}
        self._tree: dict[int, dict[Cell, Cell | None]] = defaultdict(dict)
        self._claimed: dict[int, frozenset[Cell]] = defaultdict(frozenset)
        self._uses: Counter[Cell] = Counter()

    def route(self, edge: int, result: Result, pe: int, time: int) -> bool:
        """Route an edge along a shortest path to `pe` in cycle `time`, if there is one."""
        if time == result.ready and pe == result.pe:
            way: Way | None = ()
        else:
            way = self._search(result, pe, time) if time >= result.ready else None
        if way is None:
            return False
        self.ways[edge] = (result.word, way)
        self._refresh(result.word)
        return True

    def remove(self, edge: int) -> None:
        """Remove an edge's route; what other edges of its word use stays."""
        if edge in self.ways:
            self._refresh(self.ways.pop(edge)[0])

    def steps(self) -> dict[int, tuple[Step, ...]] | None:
        """Routes with names for the registers, or None if the words of some file have none."""
        names = self._register_names()
        if names is None:
            return None
        return {
            edge: tuple(self._step(word, cell, names) for cell in way)
            for edge, (word, way) in self.ways.items()
        }

    def _refresh(self, word: int) -> None:
        """The word's tree and claims anew from its ways."""
        ways = [way for other, way in self.ways.values() if other == word]
        self._tree[word] = {
            cell: before for way in ways for before, cell in zip((None, *way), way, strict=False)
        }
        claims = frozenset(claim for way in ways for claim in self._claims(way))
        for resource, cycle in self._claimed[word]:
            self._uses[resource, cycle % self.ii] -= 1
        for resource, cycle in claims:
            self._uses[resource, cycle % self.ii] += 1
        self._claimed[word] = claims

    def _claims(self, way: Way) -> Iterator[Cell]:
        """(resource, cycle) of a way, its last read included."""
        yield from self._moves(way)
        for location, cycle in way[-1:]:
            yield from self._read(location, cycle)

    def _moves(self, way: Way) -> Iterator[Cell]:
        waited = 0
        for before, cell in zip((None, *way), way, strict=False):
            waited = _waited(waited, before, cell)
            yield from self._move(before, cell, waited)

    def _move(self, before: Cell | None, cell: Cell, waited: int) -> Iterator[Cell]:
        """Claims of one move; a word that has stayed for II cycles is written to another register:
        then the next iteration's word wants the place.
        """
        location, cycle = cell
        origin = NONE if before is None else before[0]
        for resource, after in self.graph.claims(origin, location):
            yield resource, cycle - 1 + after
        if waited and waited % self.ii == 0:
            yield int(self.graph.entering[location]), cycle - 1
            yield from self._read(location, cycle - 1)

    def _read(self, location: int, cycle: int) -> Iterator[Cell]:
        port = int(self.graph.leaving[location])
        if port != NONE:
            yield port, cycle

    def _are_free(self, word: int, claims: Iterable[Cell], way: Way = ()) -> bool:
        """Whether there is room for claims beside all others and those of the way so far: a word
        that is under way for II cycles meets itself.
        """
        own: Counter[Cell] = Counter()
        if len(way) >= self.ii:
            new = {claim for claim in self._moves(way) if claim not in self._claimed[word]}
            own.update((resource, cycle % self.ii) for resource, cycle in new)
        return all(
            claim in self._claimed[word] or self._uses[spot] + own[spot] < self._room[claim[0]]
            for claim in claims
            for spot in ((claim[0], claim[1] % self.ii),)
        )

    def _search(self, result: Result, pe: int, time: int) -> Way | None:
        """Dijkstra (1959) forward in time; cells of the word's tree cost nothing."""
        tree = self._tree[result.word]
        heap: list[tuple[int, Cell, Cell]] = []
        for location in self.graph.entries[result.pe]:
            self._push(heap, result.word, 0, None, (location, result.ready), 0)
        origin: dict[Cell, Cell | None] = {}
        waited_in: dict[Cell, int] = {}
        while heap and not self.deadline.passed:
            cost, cell, sender = heapq.heappop(heap)
            self.deadline.charge(_CELL_S)
            if cell in origin:
                continue
            origin[cell] = None if sender == cell else sender
            waited_in[cell] = _waited(waited_in.get(sender, 0), origin[cell], cell)
            location, cycle = cell
            if cycle == time:
                way = _back(origin, cell)
                last = self._read(location, cycle)
                if pe in self.graph.readers[location] and self._are_free(result.word, last, way):
                    return way
                continue
            way = _back(origin, cell) if cycle - result.ready + 1 >= self.ii else ()
            for onward in self.graph.moves[location]:
                after = (onward, cycle + 1)
                if after not in origin and tree.get(after, cell) == cell:
                    waited = _waited(waited_in[cell], cell, after)
                    self._push(heap, result.word, cost, cell, after, waited, way)
        return None

    def _push(
        self,
        heap: list[tuple[int, Cell, Cell]],
        word: int,
        cost: int,
        before: Cell | None,
        cell: Cell,
        waited: int,
        way: Way = (),
    ) -> None:
        """Offer a cell, if its claims are free and nothing else drives it for this word."""
        tree = self._tree[word]
        if cell in tree:
            if tree[cell] == before:
                heapq.heappush(heap, (cost, cell, before or cell))
            return
        if not self._are_free(word, self._move(before, cell, waited), way):
            return
        heapq.heappush(heap, (cost + (_WAIT if waited else _MOVE), cell, before or cell))

    def _register_names(self) -> dict[tuple[int, Cell], int] | None:
        names: dict[tuple[int, Cell], int] = {}
        lifetimes: dict[int, list[Lifetime]] = defaultdict(list)
        for word, tree in self._tree.items():
            for location, lifetime in self._lifetimes(word, tree):
                lifetimes[location].append(lifetime)
        for location, here in lifetimes.items():
            room = self.graph.resources[int(self.graph.occupies[location])].capacity
            chosen = allocate(here, self.ii, room)
            if chosen is None:
                self.crowded.append(location)
                continue
            for lifetime, name in zip(here, chosen, strict=True):
                for cycle in range(lifetime.first, lifetime.last + 1):
                    names[lifetime.word, (location, cycle)] = name
        return None if self.crowded else names

    def _lifetimes(
        self, word: int, tree: dict[Cell, Cell | None]
    ) -> Iterator[tuple[int, Lifetime]]:
        """Runs of cycles in one register file, cut after II cycles: then the word of the next
        iteration wants the place, and it moves to another.
        """
        files = sorted(cell for cell in tree if cell[0] >= self.graph.links)
        for at, (location, first) in enumerate(files):
            if tree[location, first] == (location, first - 1):
                continue
            last = first
            while (location, last + 1) in files[at:] and (
                tree[location, last + 1] == (location, last)
            ):
                last += 1
            for begin in range(first, last + 1, self.ii):
                yield location, Lifetime(word, begin, min(begin + self.ii - 1, last))

    def _step(self, word: int, cell: Cell, names: dict[tuple[int, Cell], int]) -> Step:
        location, cycle = cell
        pe = int(self.graph.owner[location])
        if location < self.graph.links:
            return Step("link", pe, location, cycle)
        return Step("reg", pe, names[word, cell], cycle)


def _waited(waited: int, before: Cell | None, cell: Cell) -> int:
    """Cycles for which a word has been in the register file of `cell`, 0 on a link."""
    return waited + 1 if before is not None and before[0] == cell[0] else 0


def _back(origin: dict[Cell, Cell | None], cell: Cell) -> Way:
    way = [cell]
    while (before := origin[way[-1]]) is not None:
        way.append(before)
    return tuple(reversed(way))
