"""Ways of words through the MRRG: a dynamic program over cycles, and the tree that its ways form.

A word has one tree, from its result to all its reads; what is in the tree costs nothing more.
"""

from __future__ import annotations

from typing import NamedTuple

from vividc.mapper.engines.negotiate.arrays import FU, Task
from vividc.mapper.engines.negotiate.compiled import compiled, inlined
from vividc.mapper.engines.negotiate.places import Places
from vividc.mapper.engines.negotiate.traffic import (
    DIRECT,
    FREELY,
    IN_TREE,
    NEVER,
    READ,
    Graph,
    Scratch,
    Traffic,
    claim,
    crowds,
    rip_up,
)
from vividc.mapper.engines.negotiate.words import Words, is_popular

_FAR = 1e30
_NO_WAY, _PART, _WHOLE = 0, 1, 2


class Router(NamedTuple):
    """All that routing reads and writes."""

    graph: Graph
    task: Task
    places: Places
    traffic: Traffic
    scratch: Scratch


class Aim(NamedTuple):
    """One read of a word: `ready`: cycle of the result; `cycles`: from then to the read, on PE
    `target`.
    """

    producer: int
    ready: int
    edge: int
    cycles: int
    target: int


@compiled
def route_round(router: Router, everything: bool) -> int:
    """Rip up and route all words, or those that crowd others; returns how many have no way."""
    lost = 0
    for producer in range(len(router.task.nodes.latency)):
        if everything or crowds(router.traffic, producer):
            rip_up(router.traffic, router.task.array.ii, producer)
            if not route(router, producer):
                lost += 1
    return lost


@compiled
def route_as_shown(router: Router, words: Words) -> int:
    """Route all words, none of which has a way, with no other moves than those that show them and
    with registers to wait in; words for whose reads not all moves are claimed with any; returns how
    many have no way.
    """
    lost = 0
    for producer in range(len(router.task.nodes.latency)):
        if is_popular(router.task.edges, producer) or not _route_as_shown(router, words, producer):
            lost += not route(router, producer)
    return lost


@inlined
def _route_as_shown(router: Router, words: Words, producer: int) -> bool:
    _bar_outputs(router, words, producer, 1)
    routed = route(router, producer)
    _bar_outputs(router, words, producer, 0)
    if not routed:
        rip_up(router.traffic, router.task.array.ii, producer)
    return bool(routed)


@inlined
def _bar_outputs(router: Router, words: Words, producer: int, bar: int) -> None:
    """Bar all output registers in all cycles but those that show a word, or (0) none."""
    graph, barred = router.graph, router.scratch.barred
    for location in range(graph.outs, graph.files):
        for cycle in range(barred.shape[0]):
            barred[cycle, location] = bar
    for at in range(words.size[producer]):
        fresh = graph.fresh[words.pe[producer, at]]
        barred[words.cycle[producer, at], fresh] = 0


@inlined
def route(router: Router, producer: int) -> bool:
    """Find ways for a word that has none, read by read in order of time; False: there are none."""
    edges, places, scratch = router.task.edges, router.places, router.scratch
    ready = places.time[producer] + router.task.nodes.latency[producer]
    begin, stop = edges.sink_begin[producer], edges.sink_begin[producer + 1]
    edge, cycles, routed = -1, -1, True
    fresh = router.graph.fresh[places.pe[producer]]
    if fresh >= 0 and router.task.nodes.kind[producer] & FU:
        _take_output(router, producer, fresh, ready)
    for _ in range(begin, stop):
        edge = _next_read(router, producer, edge, cycles)
        cycles = places.time[edges.dst[edge]] + edges.ahead[edge] - ready
        aim = Aim(producer, ready, edge, cycles, places.pe[edges.dst[edge]])
        if cycles == 0 and fresh < 0 and aim.target == places.pe[producer]:
            router.traffic.end[edge] = DIRECT
        elif cycles < 0 or cycles >= scratch.cost.shape[0] or not _reach(router, aim):
            routed = False
            break
    if routed:
        routed = _cut_lifetimes(router, producer, ready)
    for at in range(router.traffic.size[producer, 0]):
        cell = router.traffic.cell[producer, at]
        scratch.mark[cell[0], cell[1]] = 0
    return routed


@inlined
def _take_output(router: Router, producer: int, fresh: int, ready: int) -> None:
    """Where outputs take part in routes, an operation has its FU and its output register, whether
    its word is read or not.
    """
    traffic, ii, nodes = router.traffic, router.task.array.ii, router.task.nodes
    for cycle in range(nodes.busy[producer]):
        claim(
            traffic,
            ii,
            producer,
            router.graph.entering[fresh],
            ready - nodes.latency[producer] + cycle,
        )
    claim(traffic, ii, producer, router.graph.occupies[fresh], ready)
    router.scratch.mark[0, fresh] |= IN_TREE
    cell = traffic.cell[producer, traffic.size[producer, 0]]
    cell[0], cell[1], cell[2] = 0, fresh, -1
    traffic.size[producer, 0] += 1


@inlined
def _next_read(router: Router, producer: int, edge: int, cycles: int) -> int:
    """The read after `edge`, which is `cycles` after the result, by time and number."""
    edges, places = router.task.edges, router.places
    ready = places.time[producer] + router.task.nodes.latency[producer]
    best, best_cycles = -1, 1 << 30
    for at in range(edges.sink_begin[producer], edges.sink_begin[producer + 1]):
        other = edges.sink_items[at]
        read = places.time[edges.dst[other]] + edges.ahead[other] - ready
        later = edge < 0 or read > cycles or (read == cycles and other > edge)
        if later and read < best_cycles:
            best, best_cycles = other, read
    return best


@inlined
def _reach(router: Router, aim: Aim) -> bool:
    """Add a way to one read to the tree; False: there is none, or the tree has no room."""
    outcome = _PART
    while outcome == _PART:
        _begin(router, aim)
        for cycle in range(aim.cycles):
            _spread_aside(router, aim, cycle)
            _spread(router, aim, cycle)
        _spread_aside(router, aim, aim.cycles)
        best = _arrival(router, aim)
        if best < 0:
            return False
        outcome = _graft(router, aim, best)
    return outcome == _WHOLE


@inlined
def _begin(router: Router, aim: Aim) -> None:
    """What is in the tree costs nothing, what the result can enter its price."""
    graph, scratch, price = router.graph, router.scratch, router.traffic.price
    ii = router.task.array.ii
    for cycle in range(aim.cycles + 1):
        for location in range(len(graph.owner)):
            in_tree = scratch.mark[cycle, location] & IN_TREE
            scratch.cost[cycle, location] = 0.0 if in_tree else _FAR
    pe = router.places.pe[aim.producer]
    for at in range(graph.entry_begin[pe], graph.entry_begin[pe + 1]):
        to = graph.entry_items[at]
        total = price[graph.occupies[to] * ii + aim.ready % ii]
        if graph.entering[to] >= 0:
            total += price[graph.entering[to] * ii + (aim.ready - 1) % ii]
        if total < scratch.cost[0, to]:
            scratch.cost[0, to] = total
            scratch.before[0, to] = -1


@inlined
def _spread_aside(router: Router, aim: Aim, cycle: int) -> None:
    """From locations of a cycle to others of the same cycle, which have higher numbers."""
    graph, price = router.graph, router.traffic.price
    cost, before, ii = router.scratch.cost, router.scratch.before, router.task.array.ii
    if len(graph.side_items) == 0:
        return
    slot, earlier = (aim.ready + cycle) % ii, (aim.ready + cycle - 1) % ii
    for location in range(len(graph.owner)):
        so_far = cost[cycle, location]
        if so_far >= _FAR or graph.away[location, aim.target] > aim.cycles - cycle:
            continue
        for at in range(graph.side_begin[location], graph.side_begin[location + 1]):
            to = graph.side_items[at]
            if router.scratch.barred[cycle, to]:
                continue
            total = so_far + price[graph.occupies[to] * ii + slot]
            if graph.entering[to] >= 0:
                total += price[graph.entering[to] * ii + earlier]
            if total < cost[cycle, to]:
                cost[cycle, to] = total
                before[cycle, to] = location


@inlined
def _spread(router: Router, aim: Aim, cycle: int) -> None:
    """From all locations of a cycle from which the target is in reach to those of the next."""
    graph, price = router.graph, router.traffic.price
    cost, before, mark = router.scratch.cost, router.scratch.before, router.scratch.mark
    ii = router.task.array.ii
    slot, after = (aim.ready + cycle) % ii, (aim.ready + cycle + 1) % ii
    for location in range(len(graph.owner)):
        so_far = cost[cycle, location]
        if so_far >= _FAR or graph.away[location, aim.target] > aim.cycles - cycle:
            continue
        leaving = so_far
        if graph.leaving[location] >= 0 and not mark[cycle, location] & READ:
            leaving += price[graph.leaving[location] * ii + slot]
        for at in range(graph.move_begin[location], graph.move_begin[location + 1]):
            to = graph.move_items[at]
            if router.scratch.barred[cycle + 1, to]:
                continue
            stays = to == location and graph.keeps[to]
            total = so_far if stays else leaving
            if not stays and graph.entering[to] >= 0:
                total += price[graph.entering[to] * ii + slot]
            total += price[graph.occupies[to] * ii + after]
            if total < cost[cycle + 1, to]:
                cost[cycle + 1, to] = total
                before[cycle + 1, to] = location


@inlined
def _arrival(router: Router, aim: Aim) -> int:
    """The cheapest location at the time of the read from which the target reads, or -1."""
    graph, ii = router.graph, router.task.array.ii
    best, best_cost = -1, _FAR
    for location in range(len(graph.owner)):
        total = router.scratch.cost[aim.cycles, location]
        if total >= best_cost:
            continue
        port = graph.leaving[location]
        if port >= 0 and not router.scratch.mark[aim.cycles, location] & READ:
            total += router.traffic.price[port * ii + (aim.ready + aim.cycles) % ii]
        for at in range(graph.reader_begin[location], graph.reader_begin[location + 1]):
            if graph.reader_items[at] == aim.target and total < best_cost:
                best, best_cost = location, total
    return best


@inlined
def _graft(router: Router, aim: Aim, best: int) -> int:
    """Add the way that ends at `best` to the tree, or its first II cycles only: then the price of
    the rest counts what those took, since a word that lives longer crowds its own successors.
    """
    graph, traffic, scratch = router.graph, router.traffic, router.scratch
    producer, ii = aim.producer, router.task.array.ii
    joins, cells = _joins(router, best, aim.cycles)
    if traffic.size[producer, 0] + cells > traffic.cell.shape[1]:
        return _NO_WAY
    location, cycle, outcome = best, aim.cycles, _WHOLE
    if aim.cycles - joins > 2 * ii:
        outcome = _PART
        while cycle > joins + ii:
            before = scratch.before[cycle, location]
            cycle -= _takes_a_cycle(router.graph, before, location)
            location = before
    else:
        traffic.end[aim.edge] = best
        _leave(router, producer, best, cycle, aim.ready)
    while location >= 0 and not scratch.mark[cycle, location] & IN_TREE:
        before = scratch.before[cycle, location]
        scratch.mark[cycle, location] |= IN_TREE
        cell = traffic.cell[producer, traffic.size[producer, 0]]
        cell[0], cell[1], cell[2] = cycle, location, before
        traffic.size[producer, 0] += 1
        claim(traffic, ii, producer, graph.occupies[location], aim.ready + cycle)
        stays = before == location and graph.keeps[location]
        if not stays and graph.entering[location] >= 0:
            claim(traffic, ii, producer, graph.entering[location], aim.ready + cycle - 1)
        if not stays and before >= 0:
            _leave(router, producer, before, cycle - 1, aim.ready)
        cycle -= _takes_a_cycle(router.graph, before, location)
        location = before
    return outcome


@inlined
def _joins(router: Router, location: int, cycle: int) -> tuple[int, int]:
    """The last cycle of a way that is in the tree already, -1 where it begins at the result; and
    how many cells it adds.
    """
    scratch, cells = router.scratch, 0
    while location >= 0 and not scratch.mark[cycle, location] & IN_TREE:
        before = scratch.before[cycle, location]
        cycle -= _takes_a_cycle(router.graph, before, location)
        location = before
        cells += 1
    return cycle, cells


@inlined
def _takes_a_cycle(graph: Graph, before: int, location: int) -> int:
    """1, but 0 where a word goes on within a cycle."""
    return 0 if graph.aside[location] and before >= 0 and before != location else 1


@inlined
def _leave(router: Router, producer: int, location: int, cycle: int, ready: int) -> None:
    """Claim the port through which a word is read, once a cycle."""
    port, mark = router.graph.leaving[location], router.scratch.mark
    if port >= 0 and not mark[cycle, location] & READ:
        mark[cycle, location] |= READ
        claim(router.traffic, router.task.array.ii, producer, port, ready + cycle)


@inlined
def _cut_lifetimes(router: Router, producer: int, ready: int) -> bool:
    """A word that stays in a file for more than II cycles changes registers before its successor
    comes. False if there is no room.
    """
    traffic, scratch, ii = router.traffic, router.scratch, router.task.array.ii
    for at in range(traffic.size[producer, 0]):
        cell = traffic.cell[producer, at]
        scratch.before[cell[0], cell[1]] = cell[2]
    for at in range(traffic.size[producer, 0]):
        cell = traffic.cell[producer, at]
        first, location = cell[0], cell[1]
        if cell[2] == location or router.graph.leaving[location] < 0:
            continue
        last = _last_cycle(scratch, location, first)
        while last - first >= ii:
            renew = router.graph.renew[location]
            if renew == NEVER:
                return False
            first = _best_cut(router, location, first, ready)
            if renew != FREELY and not scratch.mark[first, renew] & IN_TREE:
                claim(traffic, ii, producer, router.graph.entering[renew], ready + first - 1)
                claim(traffic, ii, producer, router.graph.occupies[renew], ready + first)
            if traffic.size[producer, 2] >= traffic.cut.shape[1]:
                return False
            cut = traffic.cut[producer, traffic.size[producer, 2]]
            cut[0], cut[1] = first, location
            traffic.size[producer, 2] += 1
            _leave(router, producer, location, first - 1, ready)
            claim(traffic, ii, producer, router.graph.entering[location], ready + first - 1)
    return True


@inlined
def _last_cycle(scratch: Scratch, location: int, cycle: int) -> int:
    """The last of the cycles from `cycle` on in which a word holds out at a location."""
    while (
        cycle + 1 < scratch.mark.shape[0]
        and scratch.mark[cycle + 1, location] & IN_TREE
        and scratch.before[cycle + 1, location] == location
    ):
        cycle += 1
    return cycle


@inlined
def _best_cut(router: Router, location: int, first: int, ready: int) -> int:
    """The latest of the cheapest cycles at which the word can be in another register."""
    graph, price, ii = router.graph, router.traffic.price, router.task.array.ii
    best, best_price = first + ii, _FAR
    for cycle in range(first + ii, first, -1):
        slot = (ready + cycle - 1) % ii
        total = price[graph.leaving[location] * ii + slot]
        total += price[graph.entering[location] * ii + slot]
        renew = graph.renew[location]
        if renew >= 0 and router.scratch.barred[cycle, renew]:
            continue
        if renew >= 0 and not router.scratch.mark[cycle, renew] & IN_TREE:
            total += price[graph.entering[renew] * ii + slot]
            total += price[graph.occupies[renew] * ii + (slot + 1) % ii]
        if total < best_price:
            best, best_price = cycle, total
    return best
