"""Who uses which resource in which slot, and what one more word would pay: compiled functions.

Prices follow PathFinder (McMurchie and Ebeling 1995): a base, a history of crowding, and a pressure
on present crowding.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vividc.mapper.mrrg import MRRG, Ints, Kind
from vividc.mapper.negotiate.arrays import Floats, Task
from vividc.mapper.negotiate.compiled import compiled
from vividc.mapper.negotiate.places import Places

_BASE: Final[dict[Kind, float]] = {
    "link": 1.0,
    "registers": 0.25,
    "read ports": 0.15,
    "write ports": 0.15,
}
_FIRST_PRESSURE: Final = 0.6

PRESSURE, OVER, WIRE = 0, 1, 2
"""Positions in `Traffic.totals`: pressure of crowding; uses beyond capacity; sum of base prices."""


class Graph(NamedTuple):
    """The MRRG's arrays."""

    owner: Ints
    occupies: Ints
    entering: Ints
    leaving: Ints
    entry_begin: Ints
    entry_items: Ints
    move_begin: Ints
    move_items: Ints
    reader_begin: Ints
    reader_items: Ints


class Traffic(NamedTuple):
    """Uses, prices and the ways of all words. A node of the MRRG is resource * II + slot.

    Attributes
    ----------
    use, capacity, price, history
        By MRRG node. `base` by resource.
    size
        By producer: (cells of its tree, claims, cuts), int64 (producers, 3).
    cell
        (cycles since the result, location, location before or -1), int64 (producers, room, 3).
    claim
        MRRG nodes used, int64 (producers, 4 * room).
    cut
        (cycles since the result, location) from which on a word that stays is in another register.
    end
        By edge: location where it is read; `DIRECT`: from the output register; `LOST`: no way.
    """

    use: Ints
    capacity: Ints
    price: Floats
    history: Floats
    base: Floats
    totals: Floats
    size: Ints
    cell: Ints
    claim: Ints
    cut: Ints
    end: Ints


class Scratch(NamedTuple):
    """Work space of a search, by cycle since the result and location. `mark`: bits `IN_TREE`,
    `READ` (its leaving port is claimed); all 0 between searches.
    """

    cost: Floats
    before: Ints
    mark: NDArray[np.uint8]


DIRECT, LOST = -1, -2
IN_TREE, READ = 1, 2
NO_WAY, PART, WHOLE = 0, 1, 2


def new_graph(mrrg: MRRG) -> Graph:
    """Take an MRRG apart."""
    rows = [part for r in (mrrg.entries, mrrg.moves, mrrg.readers) for part in (r.begin, r.items)]
    return Graph(mrrg.owner, mrrg.occupies, mrrg.entering, mrrg.leaving, *rows)


def new_traffic(mrrg: MRRG, task: Task, room: int) -> Traffic:
    """No word has a way; `room`: cells of a tree, at most."""
    ii, producers = task.array.ii, len(task.nodes.latency)
    base = np.array([_BASE[resource.kind] for resource in mrrg.resources])
    capacity = np.array([resource.capacity for resource in mrrg.resources], dtype=np.int64)
    nodes = len(base) * ii
    return Traffic(
        use=np.zeros(nodes, dtype=np.int64),
        capacity=np.repeat(capacity, ii),
        price=np.repeat(base, ii),
        history=np.ones(nodes),
        base=base,
        totals=np.array([_FIRST_PRESSURE, 0.0, 0.0]),
        size=np.zeros((producers, 3), dtype=np.int64),
        cell=np.zeros((producers, room, 3), dtype=np.int64),
        claim=np.zeros((producers, 4 * room), dtype=np.int64),
        cut=np.zeros((producers, room, 2), dtype=np.int64),
        end=np.full(len(task.edges.src), LOST, dtype=np.int64),
    )


def new_scratch(mrrg: MRRG, cycles: int) -> Scratch:
    """For words that live `cycles` at most."""
    shape = (cycles + 1, mrrg.locations)
    return Scratch(
        np.zeros(shape), np.zeros(shape, dtype=np.int64), np.zeros(shape, dtype=np.uint8)
    )


@compiled
def reprice(traffic: Traffic, ii: int, node: int) -> None:
    over = traffic.use[node] + 1 - traffic.capacity[node]
    price = traffic.base[node // ii] * traffic.history[node]
    traffic.price[node] = price * (1.0 + traffic.totals[0] * over) if over > 0 else price


@compiled
def reprice_all(traffic: Traffic, ii: int) -> None:
    """After pressure, history or capacity have changed."""
    over = 0
    for node in range(len(traffic.use)):
        over += max(0, traffic.use[node] - traffic.capacity[node])
        reprice(traffic, ii, node)
    traffic.totals[1] = over


@compiled
def _use(traffic: Traffic, ii: int, node: int, by: int) -> None:
    old = traffic.use[node]
    traffic.use[node] = old + by
    room = traffic.capacity[node]
    traffic.totals[1] += max(0, old + by - room) - max(0, old - room)
    traffic.totals[2] += traffic.base[node // ii] * by
    reprice(traffic, ii, node)


@compiled
def _claim(traffic: Traffic, ii: int, producer: int, resource: int, time: int) -> None:
    node = resource * ii + time % ii
    traffic.claim[producer, traffic.size[producer, 1]] = node
    traffic.size[producer, 1] += 1
    _use(traffic, ii, node, 1)


@compiled
def count_claims(traffic: Traffic, ii: int, producer: int, by: int) -> None:
    """Enter (1) or withdraw (-1) all claims on record for a word."""
    for at in range(traffic.size[producer, 1]):
        _use(traffic, ii, traffic.claim[producer, at], by)


@compiled
def rip_up(traffic: Traffic, ii: int, producer: int) -> None:
    """Forget the ways of a word."""
    count_claims(traffic, ii, producer, -1)
    for part in range(3):
        traffic.size[producer, part] = 0


@compiled
def crowds(traffic: Traffic, producer: int) -> bool:
    """Whether the word uses anything that is used beyond its capacity."""
    for at in range(traffic.size[producer, 1]):
        node = traffic.claim[producer, at]
        if traffic.use[node] > traffic.capacity[node]:
            return True
    return False


@compiled
def route(
    graph: Graph, task: Task, places: Places, traffic: Traffic, scratch: Scratch, producer: int
) -> bool:
    """Find ways for a word that has none, sink by sink in order of time; False: there are none."""
    edges, ii = task.edges, task.array.ii
    ready = places.time[producer] + task.nodes.latency[producer]
    begin, stop = edges.sink_begin[producer], edges.sink_begin[producer + 1]
    done_until, done_edge, found = -1, -1, True
    for _ in range(begin, stop):
        best, best_read = -1, 1 << 30
        for at in range(begin, stop):
            edge = edges.sink_items[at]
            read = places.time[edges.dst[edge]] + edges.ahead[edge] - ready
            later = read > done_until or (read == done_until and edge > done_edge)
            if later and (read < best_read or (read == best_read and edge < best)):
                best, best_read = edge, read
        done_until, done_edge = best_read, best
        target = places.pe[edges.dst[best]]
        if best_read == 0 and target == places.pe[producer]:
            traffic.end[best] = DIRECT
            continue
        if best_read < 0 or best_read >= scratch.cost.shape[0]:
            found = False
            break
        outcome = PART
        while outcome == PART:
            _search(graph, task, places, traffic, scratch, producer, best_read, target, ready)
            outcome = _graft(graph, traffic, scratch, ii, producer, best, best_read, target, ready)
        if outcome == NO_WAY:
            found = False
            break
    if found:
        found = _cut_stays(graph, traffic, scratch, ii, producer, ready)
    for at in range(traffic.size[producer, 0]):
        cell = traffic.cell[producer, at]
        scratch.mark[cell[0], cell[1]] = 0
    return found


@compiled
def _search(
    graph: Graph,
    task: Task,
    places: Places,
    traffic: Traffic,
    scratch: Scratch,
    producer: int,
    cycles: int,
    target: int,
    ready: int,
) -> None:
    """Costs of the cheapest ways from the tree, or the result, to all locations from which the
    target is in reach, cycle by cycle.
    """
    hop, ii = task.array.hop, task.array.ii
    cost, before, mark, price = scratch.cost, scratch.before, scratch.mark, traffic.price
    far = 1e30
    locations = len(graph.owner)
    for cycle in range(cycles + 1):
        for location in range(locations):
            cost[cycle, location] = 0.0 if mark[cycle, location] & IN_TREE else far
    pe = places.pe[producer]
    slot, earlier = ready % ii, (ready - 1) % ii
    for at in range(graph.entry_begin[pe], graph.entry_begin[pe + 1]):
        to = graph.entry_items[at]
        total = price[graph.occupies[to] * ii + slot]
        if graph.entering[to] >= 0:
            total += price[graph.entering[to] * ii + earlier]
        if total < cost[0, to]:
            cost[0, to] = total
            before[0, to] = -1
    for cycle in range(cycles):
        left = cycles - cycle
        earlier, slot = slot, (slot + 1) % ii
        for location in range(locations):
            so_far = cost[cycle, location]
            if so_far >= far or hop[graph.owner[location], target] > left:
                continue
            leaving = so_far
            if graph.leaving[location] >= 0 and not mark[cycle, location] & READ:
                leaving += price[graph.leaving[location] * ii + earlier]
            for at in range(graph.move_begin[location], graph.move_begin[location + 1]):
                to = graph.move_items[at]
                if to == location:
                    total = so_far
                else:
                    total = leaving
                    if graph.entering[to] >= 0:
                        total += price[graph.entering[to] * ii + earlier]
                total += price[graph.occupies[to] * ii + slot]
                if total < cost[cycle + 1, to]:
                    cost[cycle + 1, to] = total
                    before[cycle + 1, to] = location


@compiled
def _graft(
    graph: Graph,
    traffic: Traffic,
    scratch: Scratch,
    ii: int,
    producer: int,
    edge: int,
    cycles: int,
    target: int,
    ready: int,
) -> int:
    """Add the cheapest way to the tree, or its first II cycles only: then the price of the rest
    counts what those took, since a word that lives longer crowds its own successors.
    """
    best, best_cost = -1, 1e30
    for location in range(len(graph.owner)):
        total = scratch.cost[cycles, location]
        if total >= best_cost:
            continue
        for at in range(graph.reader_begin[location], graph.reader_begin[location + 1]):
            if graph.reader_items[at] == target:
                port = graph.leaving[location]
                if port >= 0 and not scratch.mark[cycles, location] & READ:
                    total += traffic.price[port * ii + (ready + cycles) % ii]
                if total < best_cost:
                    best, best_cost = location, total
    if best < 0 or traffic.size[producer, 0] + cycles + 1 > traffic.cell.shape[1]:
        return NO_WAY
    location, cycle = best, cycles
    while location >= 0 and not scratch.mark[cycle, location] & IN_TREE:
        location, cycle = scratch.before[cycle, location], cycle - 1
    outcome, upto, joins = WHOLE, cycle + ii, cycle
    location, cycle = best, cycles
    if cycles - joins > 2 * ii:
        outcome = PART
        while cycle > upto:
            location, cycle = scratch.before[cycle, location], cycle - 1
    else:
        traffic.end[edge] = best
        _leave(graph, traffic, scratch, ii, producer, best, cycles, ready)
    while location >= 0 and not scratch.mark[cycle, location] & IN_TREE:
        before = scratch.before[cycle, location]
        scratch.mark[cycle, location] |= IN_TREE
        cell = traffic.cell[producer, traffic.size[producer, 0]]
        cell[0], cell[1], cell[2] = cycle, location, before
        traffic.size[producer, 0] += 1
        _claim(traffic, ii, producer, graph.occupies[location], ready + cycle)
        if before != location:
            if graph.entering[location] >= 0:
                _claim(traffic, ii, producer, graph.entering[location], ready + cycle - 1)
            if before >= 0:
                _leave(graph, traffic, scratch, ii, producer, before, cycle - 1, ready)
        location, cycle = before, cycle - 1
    return outcome


@compiled
def _leave(
    graph: Graph,
    traffic: Traffic,
    scratch: Scratch,
    ii: int,
    producer: int,
    location: int,
    cycle: int,
    ready: int,
) -> None:
    """Claim the port through which a word is read, once a cycle."""
    if graph.leaving[location] >= 0 and not scratch.mark[cycle, location] & READ:
        scratch.mark[cycle, location] |= READ
        _claim(traffic, ii, producer, graph.leaving[location], ready + cycle)


@compiled
def _cut_stays(
    graph: Graph, traffic: Traffic, scratch: Scratch, ii: int, producer: int, ready: int
) -> bool:
    """A word that stays in a file for more than II cycles changes registers before its successor
    comes. False if there is no room.
    """
    for at in range(traffic.size[producer, 0]):
        cell = traffic.cell[producer, at]
        scratch.before[cell[0], cell[1]] = cell[2]
    for at in range(traffic.size[producer, 0]):
        cell = traffic.cell[producer, at]
        first, location = cell[0], cell[1]
        if cell[2] == location or graph.leaving[location] < 0:
            continue
        last = first
        while (
            last + 1 < scratch.mark.shape[0]
            and scratch.mark[last + 1, location] & IN_TREE
            and scratch.before[last + 1, location] == location
        ):
            last += 1
        while last - first >= ii:
            first = _best_cut(graph, traffic, ii, location, first, ready)
            if traffic.size[producer, 2] >= traffic.cut.shape[1]:
                return False
            cut = traffic.cut[producer, traffic.size[producer, 2]]
            cut[0], cut[1] = first, location
            traffic.size[producer, 2] += 1
            _leave(graph, traffic, scratch, ii, producer, location, first - 1, ready)
            _claim(traffic, ii, producer, graph.entering[location], ready + first - 1)
    return True


@compiled
def _best_cut(
    graph: Graph, traffic: Traffic, ii: int, location: int, first: int, ready: int
) -> int:
    """The latest of the cheapest cycles at which the word can be in another register."""
    best, best_price = first + ii, 1e30
    for cycle in range(first + ii, first, -1):
        slot = (ready + cycle - 1) % ii
        price = traffic.price[graph.leaving[location] * ii + slot]
        price += traffic.price[graph.entering[location] * ii + slot]
        if price < best_price:
            best, best_price = cycle, price
    return best


@compiled
def route_round(
    graph: Graph, task: Task, places: Places, traffic: Traffic, scratch: Scratch, everything: bool
) -> int:
    """Rip up and route all words, or those that crowd others; returns how many have no way."""
    lost = 0
    for producer in range(len(task.nodes.latency)):
        if everything or crowds(traffic, producer):
            rip_up(traffic, task.array.ii, producer)
            if not route(graph, task, places, traffic, scratch, producer):
                lost += 1
    return lost


@compiled
def raise_prices(traffic: Traffic, ii: int, history: float, growth: float, most: float) -> None:
    """After a round: what is crowded now stays dear, and crowding costs more."""
    for node in range(len(traffic.use)):
        over = traffic.use[node] - traffic.capacity[node]
        if over > 0:
            traffic.history[node] += history * over
    traffic.totals[0] = min(traffic.totals[0] * growth, most)
    reprice_all(traffic, ii)
