"""Negotiated routing of a placed modulo schedule (PathFinder: McMurchie and Ebeling 1995).

Every word finds its cheapest ways as if it were nearly alone; what more words want than there is of
it gets dearer from round to round, until nobody wants the same twice.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final

from vividc.mapper.deadline import Deadline
from vividc.mapper.distances import hop_distances
from vividc.mapper.mapping import Place
from vividc.mapper.negotiate.market import Market, Word
from vividc.mapper.problem import MapProblem
from vividc.mapper.registers import Stay

RES: Final = -1
"""Where a word is when its operation completes."""

Location = int
"""A link's id; the number of links + the PE for its register file."""

Way = tuple[tuple[int, Location], ...]
"""Where a word is in each cycle, from its result to its read."""


@dataclass
class Tree:
    """The ways of one word: from where it came to each location in each cycle.

    `reads`: (cycle, PE) in which an FU or a constant store takes it from a register. `moves`:
    (cycle, PE) from which on it is in another register of the file than before.
    """

    ready: int
    pe: int
    parent: dict[tuple[int, Location], Location] = field(default_factory=dict)
    reads: set[tuple[int, int]] = field(default_factory=set)
    moves: set[tuple[int, int]] = field(default_factory=set)


@dataclass(frozen=True, slots=True)
class _Sink:
    edge: int
    pe: int
    time: int


class Negotiator:
    """Routes all words of a schedule; `trees` by producer, `ways` by edge."""

    def __init__(self, task: MapProblem, ii: int, places: Mapping[int, Place]) -> None:
        self.task, self.ii, self.places = task, ii, places
        self.fabric = task.fabric
        self.hops = hop_distances(task.fabric)
        self.links = len(task.fabric.links)
        self.out_of = [tuple((k.id, k.dst) for k in links) for links in task.fabric.links_from]
        self.at = [k.dst for k in task.fabric.links] + [pe.id for pe in task.fabric.pes]
        self.sinks: dict[int, list[_Sink]] = defaultdict(list)
        for index, edge in task.dfg.routed_edges():
            read = places[edge.dst].time + ii * edge.distance
            self.sinks[edge.src].append(_Sink(index, places[edge.dst].pe, read))
        self.market = Market(task.fabric, ii)
        self.trees: dict[int, Tree] = {}
        self.ways: dict[int, Way] = {}

    def run(self, rounds: int, deadline: Deadline) -> bool:
        """Route; True when nothing is wanted twice."""
        pending: Iterable[int] = self._crowding() if self.trees else list(self.sinks)
        for _ in range(rounds):
            for node in pending:
                if deadline.passed or not self._route(node):
                    return False
            crowded = self.market.crowded()
            if not crowded:
                return True
            self.market.raise_prices(crowded)
            pending = self._crowding()
        return False

    def _crowding(self) -> list[int]:
        """Producers of the words that want what is crowded."""
        words = (word for r in self.market.crowded() for word in self.market.users[r])
        return sorted({node for node, _ in words})

    def pairs_without_way(self) -> list[tuple[int, int]]:
        """(producer, consumer) of the words that crowd each other."""
        pairs = []
        crowded = set(self.market.crowded())
        for index, edge in self.task.dfg.routed_edges():
            way = self.ways.get(index)
            if way is None or not crowded.isdisjoint(self._resources(way)):
                pairs.append((edge.src, edge.dst))
        return pairs

    def _resources(self, way: Way) -> Iterator[int]:
        for time, location in way:
            slot = time % self.ii
            if location < self.links:
                yield self.market.link + location * self.ii + slot
            else:
                yield self.market.file + self.at[location] * self.ii + slot

    def _route(self, node: int) -> bool:
        old = self.trees.get(node)
        if old is not None:
            self.market.leave(self._wants(node, old))
        place = self.places[node]
        tree = Tree(place.time + self.fabric.latency(self.task.dfg.by_id[node]), place.pe)
        for sink in sorted(self.sinks[node], key=lambda s: (s.time, s.pe, s.edge)):
            way = _Search(self, tree, sink).run()
            if way is None:
                return False
            self.ways[sink.edge] = way
            self._graft(tree, way)
        self.trees[node] = tree
        self.market.enter(self._wants(node, tree))
        return True

    def _graft(self, tree: Tree, way: Way) -> None:
        before = RES
        for time, location in way:
            tree.parent.setdefault((time, location), before)
            before = location
        if way and way[-1][1] >= self.links:
            tree.reads.add((way[-1][0], self.at[way[-1][1]]))

    def _wants(self, node: int, tree: Tree) -> Iterator[tuple[int, Word]]:
        ii, links, market = self.ii, self.links, self.market
        for (time, location), parent in tree.parent.items():
            if location < links:
                yield market.link + location * ii + time % ii, (node, time)
            else:
                row = self.at[location] * ii
                yield market.file + row + time % ii, (node, time)
                if parent != location:
                    yield market.write + row + (time - 1) % ii, (node, time)
            if parent >= links and parent != location:
                yield market.read + self.at[parent] * ii + (time - 1) % ii, (node, time - 1)
        for time, pe in tree.reads:
            yield market.read + pe * ii + time % ii, (node, time)
        for time, pe in tree.moves:
            yield from self._move(node, time, pe)

    def _move(self, node: int, time: int, pe: int) -> Iterator[tuple[int, Word]]:
        market, port = self.market, pe * self.ii + (time - 1) % self.ii
        yield market.read + port, (node, time - 1)
        yield market.write + port, (node, time)

    # --- stays in register files ---

    def stays(self) -> Iterator[tuple[int, Stay]]:
        """(PE, stay) of every word in a register; a move ends one stay and begins the next."""
        for node, tree in sorted(self.trees.items()):
            yield from self._stays(node, tree)

    def _stays(self, node: int, tree: Tree) -> list[tuple[int, Stay]]:
        found: list[tuple[int, Stay]] = []
        held = sorted((loc, time) for time, loc in tree.parent if loc >= self.links)
        for location, time in held:
            pe = self.at[location]
            goes_on = tree.parent[time, location] == location and (time, pe) not in tree.moves
            if goes_on:
                found[-1] = (pe, Stay(node, found[-1][1].first, time))
            else:
                found.append((pe, Stay(node, time, time)))
        return found

    def cut_long_stays(self) -> bool:
        """Words that stay longer than II cycles change registers before their successors come.

        False if the ports do not suffice for that.
        """
        for node, tree in sorted(self.trees.items()):
            for pe, stay in self._stays(node, tree):
                first = stay.first
                while stay.last - first >= self.ii:
                    first = self._best_cut(node, pe, first)
                    tree.moves.add((first, pe))
                    self.market.enter(self._move(node, first, pe))
        crowded = self.market.crowded()
        self.market.raise_prices(crowded)
        return not crowded

    def _best_cut(self, node: int, pe: int, first: int) -> int:
        """The cheapest cycle for the move, the latest of these."""

        def price(time: int) -> float:
            wants = self._move(node, time, pe)
            market = self.market
            return sum(market.price[r] for r, word in wants if word not in market.users[r])

        return min(range(first + self.ii, first, -1), key=price)


class _Search:
    """Cheapest way for one word to one sink: a dynamic program, cycle by cycle."""

    def __init__(self, router: Negotiator, tree: Tree, sink: _Sink) -> None:
        self.router, self.tree, self.sink = router, tree, sink
        self.best: dict[tuple[int, Location], Location] = {}
        self.layers: dict[int, dict[Location, float]] = defaultdict(dict)
        self.to_sink = [row[sink.pe] for row in router.hops]

    def run(self) -> Way | None:
        """The steps from the producer on; None if there is no way."""
        tree, sink = self.tree, self.sink
        if sink.time == tree.ready and sink.pe == tree.pe:
            return ()
        for (time, location), parent in tree.parent.items():
            if time <= sink.time and self._in_reach(time, location):
                self._reach(time, location, parent, 0.0)
        self._leave_result()
        for time in range(tree.ready, sink.time):
            for location, cost in list(self.layers[time].items()):
                self._move_on(time, location, cost)
        return self._way()

    def _in_reach(self, time: int, location: Location) -> bool:
        return self.to_sink[self.router.at[location]] <= self.sink.time - time

    def _reach(self, time: int, location: Location, parent: Location, cost: float) -> None:
        known = self.layers[time].get(location)
        if known is None or cost < known:
            self.layers[time][location] = cost
            self.best[time, location] = parent

    def _leave_result(self) -> None:
        router, tree = self.router, self.tree
        left = self.sink.time - tree.ready
        slot = tree.ready % router.ii
        for link, pe in router.out_of[tree.pe]:
            if self.to_sink[pe] <= left:
                price = router.market.price[router.market.link + link * router.ii + slot]
                self._reach(tree.ready, link, RES, price)
        if self.to_sink[tree.pe] <= left:
            price = self._writing(tree.pe, tree.ready)
            self._reach(tree.ready, router.links + tree.pe, RES, price)

    def _move_on(self, time: int, location: Location, cost: float) -> None:
        router = self.router
        ii, price, layer = router.ii, router.market.price, self.layers[time + 1]
        pe = router.at[location]
        left = self.sink.time - time - 1
        is_file = location >= router.links
        leaving = cost + self._reading(pe, time) if is_file else cost
        slot = (time + 1) % ii
        for link, end in router.out_of[pe]:
            if self.to_sink[end] <= left:
                total = leaving + price[link * ii + slot]
                known = layer.get(link)
                if known is None or total < known:
                    layer[link] = total
                    self.best[time + 1, link] = location
        if self.to_sink[pe] > left:
            return
        if is_file:
            held = price[router.market.file + pe * ii + slot]
            self._reach(time + 1, location, location, cost + held)
        else:
            file = router.links + pe
            self._reach(time + 1, file, location, cost + self._writing(pe, time + 1))

    def _writing(self, pe: int, time: int) -> float:
        market, ii = self.router.market, self.router.ii
        held = market.price[market.file + pe * ii + time % ii]
        return held + market.price[market.write + pe * ii + (time - 1) % ii]

    def _reading(self, pe: int, time: int) -> float:
        if (time, pe) in self.tree.reads:
            return 0.0
        market, ii = self.router.market, self.router.ii
        return market.price[market.read + pe * ii + time % ii]

    def _way(self) -> Way | None:
        router, sink = self.router, self.sink
        arrivals = [
            (cost + (self._reading(sink.pe, sink.time) if loc >= router.links else 0.0), loc)
            for loc, cost in self.layers[sink.time].items()
            if router.at[loc] == sink.pe
        ]
        if not arrivals:
            return None
        location = min(arrivals)[1]
        way = []
        for time in range(sink.time, self.tree.ready - 1, -1):
            way.append((time, location))
            location = self.best[time, location]
        return tuple(reversed(way))
