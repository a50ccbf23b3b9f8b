"""Words on the time-expanded array of a straight region: who is where when, and searches for ways.

There is no wrap-around: every (link, cycle) and (register, cycle) is a spot of its own. The routes
of one value form a tree (multicast): a new reader joins the tree where it costs least.

Every result that still has readers is *parked*: it keeps a register from some cycle on, without
end, until its last reader has been routed. So a word can always be fetched later, when links are
free again, and greedy scheduling cannot lose it.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, NamedTuple, TypeVar

from vividc.arch.fabric import Fabric
from vividc.mapper.mapping import Step

RES: Final = -1
"""Stands for the FU's result where the place of a word's driver is named."""

UNREACHABLE: Final = 1 << 20

LINK_COST: Final = 4
"""Of a cycle in which a word takes a link that it does not take already."""
_WRITE_COST: Final = 2
_HOLD_COST: Final = 1
_MAX_EXPANSIONS: Final = 3000
_NONE: Final = frozenset[int]()

_K = TypeVar("_K")
_V = TypeVar("_V")

Spot = tuple[int, int]
"""(place, cycle): link or register `place` holds a word that is readable in `cycle`."""


_Chain = tuple[Spot, "_Chain | None"]
"""Spots as a linked list, so that adding one costs the same however many there are."""


@dataclass(frozen=True, slots=True)
class Value:
    """A result on the array: its producer's PE and the first cycle in which it can be used."""

    node: int
    pe: int
    ready: int


class Path(NamedTuple):
    """A way for a word: its new spots in time order, the place that drives the first, its cost."""

    spots: tuple[Spot, ...]
    driver: int
    cost: int


class Places:
    """A numbering of links (first, by id) and registers, and the distances of PEs in hops."""

    def __init__(self, fabric: Fabric) -> None:
        self.fabric = fabric
        self.links = len(fabric.links)
        self.origin = [link.src for link in fabric.links]
        self.end = [link.dst for link in fabric.links]
        self.registers: list[range] = []
        for pe in fabric.pes:
            first = len(self.origin)
            self.origin += [pe.id] * pe.registers
            self.end += [pe.id] * pe.registers
            self.registers.append(range(first, first + pe.registers))
        self.into = [tuple(link.id for link in links) for links in fabric.links_to]
        self.out_of = [tuple(link.id for link in links) for links in fabric.links_from]
        self.distance = [self._distances(pe.id) for pe in fabric.pes]
        self.diameter = max((d for row in self.distance for d in row if d < UNREACHABLE), default=0)

    def step(self, spot: Spot) -> Step:
        """The spot as a step of a mapping."""
        place, time = spot
        if place < self.links:
            return Step("link", self.end[place], place, time)
        pe = self.end[place]
        return Step("reg", pe, place - self.registers[pe].start, time)

    def _distances(self, start: int) -> list[int]:
        distance = [UNREACHABLE] * len(self.registers)
        distance[start] = 0
        frontier = [start]
        while frontier:
            reached = dict.fromkeys(self.end[k] for pe in frontier for k in self.out_of[pe])
            hops = distance[frontier[0]] + 1
            frontier = [pe for pe in reached if distance[pe] == UNREACHABLE]
            for pe in frontier:
                distance[pe] = hops
        return distance


class Journal:
    """Changes of dicts, so that a trial placement can be taken back."""

    def __init__(self) -> None:
        self._undo: list[tuple[dict[object, object], object, object]] = []

    def set(self, table: dict[_K, _V], key: _K, value: _V) -> None:
        """`table[key] = value`, on record."""
        self._undo.append((table, key, table.get(key, self)))  # type: ignore[arg-type]
        table[key] = value

    def remove(self, table: dict[_K, _V], key: _K) -> None:
        """`del table[key]`, on record."""
        self._undo.append((table, key, table.pop(key)))  # type: ignore[arg-type]

    def mark(self) -> int:
        """The present, to return to."""
        return len(self._undo)

    def back_to(self, mark: int) -> None:
        """Take back all changes since `mark`."""
        while len(self._undo) > mark:
            table, key, old = self._undo.pop()
            if old is self:
                del table[key]
            else:
                table[key] = old


def _walk(chain: _Chain | None) -> Iterator[Spot]:
    while chain is not None:
        spot, chain = chain
        yield spot


class Router:
    """The words on the array, and searches for ways.

    Attributes
    ----------
    words
        (value's node, driver's place) of every occupied spot.
    parked
        (value's node, since) of every register that keeps a word without end.
    """

    def __init__(self, places: Places, journal: Journal) -> None:
        self.places = places
        self.journal = journal
        self.words: dict[Spot, tuple[int, int]] = {}
        self.parked: dict[int, tuple[int, int]] = {}
        self._reads: dict[Spot, frozenset[int]] = {}
        self._writes: dict[Spot, frozenset[int]] = {}
        self._spots: dict[int, _Chain | None] = {}
        self._read_spots: dict[int, _Chain | None] = {}
        self._pes: dict[int, tuple[int, ...]] = {}
        self._last: dict[int, int] = {}

    # --- searching ---

    def find(self, value: Value, pe: int, time: int) -> Path | None:
        """The cheapest way for `value` to be readable on `pe` in cycle `time`, or None.

        A* (Hart, Nilsson and Raphael 1968) backwards in time from the reader to the value's tree.
        """
        if time == value.ready and pe == value.pe:
            return Path((), RES, 0)
        search = _Search(self, value)
        for place in self._readable(value, pe, time):
            search.reach(place, time, None, 0)
        return search.run()

    def _readable(self, value: Value, pe: int, time: int) -> list[int]:
        """Links into `pe` and registers of it from which `value` could be read in cycle `time`."""
        found = self._links(value.node, pe, time)
        words, parked, node = self.words, self.parked, value.node
        reads = self._reads.get((pe, time), _NONE)
        is_full = len(reads) >= self.places.fabric.pes[pe].read_ports
        fresh: int | None = None
        has_older = False  # whether the cycle before is taken of the fresh one
        for register in self.places.registers[pe]:
            if is_full and register not in reads:
                continue
            holder = words.get((register, time))
            if holder is None:
                parking = parked.get(register)
                if parking is not None and time >= parking[1]:
                    holder = parking
            if holder is not None:
                if holder[0] == node:
                    found.append(register)
            elif fresh is None or has_older:
                is_older = (register, time - 1) in words
                if fresh is None or not is_older:
                    fresh, has_older = register, is_older
        if fresh is not None:
            found.append(fresh)
        return found

    def _links(self, node: int, pe: int, time: int) -> list[int]:
        """Links into `pe` that hold the result of `node` in cycle `time`, or nothing."""
        words = self.words
        return [
            link
            for link in self.places.into[pe]
            if (word := words.get((link, time))) is None or word[0] == node
        ]

    def is_taken(self, place: int, time: int) -> bool:
        """Whether the spot holds a word, or is kept for a parked one."""
        if (place, time) in self.words:
            return True
        parking = self.parked.get(place)
        return parking is not None and time >= parking[1]

    def holds(self, place: int, time: int, node: int) -> bool:
        """Whether the spot holds the result of `node`."""
        word = self.words.get((place, time))
        if word is not None:
            return word[0] == node
        parking = self.parked.get(place)
        return parking is not None and parking[0] == node and time >= parking[1]

    def may_hold(self, place: int, time: int, node: int) -> bool:
        """Whether the spot holds the result of `node` or is free."""
        return not self.is_taken(place, time) or self.holds(place, time, node)

    def can_write(self, register: int, time: int) -> bool:
        """Whether a write port is left for `register` to be written at the end of cycle `time`."""
        pe = self.places.end[register]
        return len(self._writes.get((pe, time), ())) < self.places.fabric.pes[pe].write_ports

    def drivers(self, value: Value, place: int, time: int) -> Iterator[tuple[int, int]]:
        """(place, added cost) from which the word could have come to the free spot."""
        pe = self.places.origin[place]
        if place < self.places.links:
            drivers = self._readable(value, pe, time - 1)
            yield from ((driver, 0) for driver in drivers if driver != place)
            return
        if self.may_hold(place, time - 1, value.node):
            yield place, 0
        if self.can_write(place, time - 1):  # from the FU or a link: registers are not copied
            yield from ((link, _WRITE_COST) for link in self._links(value.node, pe, time - 1))

    # --- entering and leaving ---

    def enter(self, value: Value, path: Path, pe: int, time: int) -> tuple[Spot, ...]:
        """Take a path for a reader on `pe` in cycle `time`; the route from the producer on."""
        driver = path.driver
        for spot in path.spots:
            if spot not in self.words:
                self._occupy(value.node, spot, self._materialise(value.node, driver, spot[1] - 1))
            driver = spot[0]
        if not path.spots and path.driver == RES:
            return ()
        last = path.spots[-1] if path.spots else (driver, time)
        self._materialise(value.node, last[0], time)
        self._read(value.node, last[0], time)
        return self._trace((last[0], time))

    def park(self, value: Value) -> bool:
        """Give the word a register without end, near its producer; False if none is left."""
        frontier: list[tuple[int, tuple[Spot, ...]]] = [(value.pe, ())]
        for time in range(value.ready, value.ready + 2 * self.places.diameter + 3):
            for pe, spots in frontier:
                register = self._endless(pe, time)
                if register is not None:
                    self._park(value, (*spots, (register, time)))
                    return True
            reached: dict[int, tuple[Spot, ...]] = {}
            for pe, spots in frontier:
                for link in self.places.out_of[pe]:
                    if not self.is_taken(link, time):
                        reached.setdefault(self.places.end[link], (*spots, (link, time)))
            frontier = sorted(reached.items())
        return False

    def settle(self, node: int, routes: list[tuple[Spot, ...]]) -> None:
        """All readers of `node` are routed: give back what it occupies beyond its routes."""
        for register in [r for r, parking in self.parked.items() if parking[0] == node]:
            self.journal.remove(self.parked, register)
        for spot in _walk(self._spots.get(node)):
            self._vacate(spot)
        for place, time in _walk(self._read_spots.get(node)):
            key = (self.places.end[place], time)
            self.journal.set(self._reads, key, self._reads[key] - {place})
        self.journal.set(self._spots, node, None)
        self.journal.set(self._read_spots, node, None)
        self.journal.set(self._pes, node, ())
        for route in routes:
            driver = RES
            for spot in route:
                if spot not in self.words:
                    self._occupy(node, spot, driver)
                driver = spot[0]
            if route:
                self._read(node, route[-1][0], route[-1][1])

    def _endless(self, pe: int, since: int) -> int | None:
        """A register of `pe` that nobody needs from `since` on and that can be written then."""
        best: int | None = None
        for register in self.places.registers[pe]:
            if register in self.parked or self._last.get(register, -1) >= since:
                continue
            if best is None or self._last.get(register, -1) > self._last.get(best, -1):
                best = register
        return best if best is not None and self.can_write(best, since - 1) else None

    def _park(self, value: Value, spots: tuple[Spot, ...]) -> None:
        driver = RES
        for spot in spots:
            self._occupy(value.node, spot, driver)
            driver = spot[0]
        register, since = spots[-1]
        self.journal.set(self.parked, register, (value.node, since))

    def _materialise(self, node: int, place: int, time: int) -> int:
        """Turn what a parked word has kept up to `time` into occupied spots."""
        parking = self.parked.get(place)
        if parking is not None and parking[0] == node:
            missing = time
            while missing > parking[1] and (place, missing) not in self.words:
                missing -= 1
            for cycle in range(missing + 1, time + 1):
                self._occupy(node, (place, cycle), place)
        return place

    def _occupy(self, node: int, spot: Spot, driver: int) -> None:
        place, time = spot
        self.journal.set(self.words, spot, (node, driver))
        self.journal.set(self._spots, node, (spot, self._spots.get(node)))
        pes = self._pes.get(node, ())
        if self.places.end[place] not in pes:
            self.journal.set(self._pes, node, (*pes, self.places.end[place]))
        if driver >= self.places.links and driver != place:
            self._read(node, driver, time - 1)
        if place < self.places.links:
            return
        self.journal.set(self._last, place, max(time, self._last.get(place, -1)))
        if driver != place:
            key = (self.places.end[place], time - 1)
            self.journal.set(self._writes, key, self._writes.get(key, frozenset()) | {place})

    def _vacate(self, spot: Spot) -> None:
        place, time = spot
        driver = self.words[spot][1]
        self.journal.remove(self.words, spot)
        if place < self.places.links:
            return
        if driver != place:
            key = (self.places.end[place], time - 1)
            self.journal.set(self._writes, key, self._writes[key] - {place})
        if self._last.get(place) == time:
            self.journal.set(self._last, place, self._last_before(place, time))

    def _last_before(self, place: int, time: int) -> int:
        while time >= 0 and (place, time) not in self.words:
            time -= 1
        return time

    def _read(self, node: int, place: int, time: int) -> None:
        if place < self.places.links:
            return
        key = (self.places.end[place], time)
        reads = self._reads.get(key, frozenset())
        if place not in reads:
            self.journal.set(self._reads, key, reads | {place})
            chain = ((place, time), self._read_spots.get(node))
            self.journal.set(self._read_spots, node, chain)

    def _trace(self, spot: Spot) -> tuple[Spot, ...]:
        """The route that leads from the producer to an occupied spot."""
        route = [spot]
        driver = self.words[spot][1]
        while driver != RES:
            spot = (driver, spot[1] - 1)
            route.append(spot)
            driver = self.words[spot][1]
        return tuple(reversed(route))

    def pes_of(self, value: Value) -> tuple[int, ...]:
        """PEs on which the word can be read at some time."""
        return (value.pe, *self._pes.get(value.node, ()))


class _Search:
    """One A* search; the spots reached are its states, all of them free but the joint."""

    def __init__(self, router: Router, value: Value) -> None:
        self.router = router
        self.value = value
        places = router.places
        sources = router.pes_of(value)
        rows = [places.distance[source] for source in sources]
        self.hops = list(map(min, *rows)) if len(rows) > 1 else rows[0]
        self.from_producer = places.distance[value.pe]
        self.queue: list[tuple[int, int, int, int]] = []
        self.cost: dict[Spot, int] = {}
        self.next: dict[Spot, Spot | None] = {}

    def reach(self, place: int, time: int, to: Spot | None, cost: int) -> None:
        """Add the spot to the frontier if the word can be there, unless known at this cost."""
        router, spot = self.router, (place, time)
        pe = router.places.origin[place]
        joins = router.holds(place, time, self.value.node)
        if not joins:
            if time < self.value.ready + self.from_producer[pe]:
                return
            cost += LINK_COST if place < router.places.links else _HOLD_COST
        if spot in self.cost and self.cost[spot] <= cost:
            return
        self.cost[spot] = cost
        self.next[spot] = to
        estimate = 0 if joins else LINK_COST * self.hops[pe]
        heapq.heappush(self.queue, (cost + estimate, time, place, cost))

    def run(self) -> Path | None:
        """Expand spots until one is driven by the value's tree or by its producer."""
        value, router = self.value, self.router
        for _ in range(_MAX_EXPANSIONS):
            if not self.queue:
                return None
            _, time, place, cost = heapq.heappop(self.queue)
            if cost > self.cost[place, time]:
                continue
            if router.holds(place, time, value.node):
                return self._path((place, time), cost)
            if time == value.ready:
                if self._starts_here(place, time):
                    return self._path((place, time), cost)
                continue
            for driver, added in router.drivers(value, place, time):
                self.reach(driver, time - 1, (place, time), cost + added)
        return None

    def _starts_here(self, place: int, time: int) -> bool:
        if self.router.places.origin[place] != self.value.pe:
            return False
        return place < self.router.places.links or self.router.can_write(place, time - 1)

    def _path(self, first: Spot, cost: int) -> Path:
        spots = [first]
        following = self.next[first]
        while following is not None:
            spots.append(following)
            following = self.next[following]
        if not self.router.holds(*first, self.value.node):
            return Path(tuple(spots), RES, cost)
        return Path(tuple(spots[1:]), first[0], cost)
