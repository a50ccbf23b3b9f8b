"""Simulated annealing of places and times (Kirkpatrick et al. 1983; for CGRAs Mei et al. 2002).

The cost of a state is what it breaks (claims beyond capacity, words that cannot be there in time)
and, far less, what words take of links and registers: the cycles that each word lives, counted once
however many read it, and the hops of its ways. Which link or register is the router's part.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from vividc.mapper.mrrg import Ints
from vividc.mapper.negotiate.arrays import FU, Array, Edges, Floats, Task
from vividc.mapper.negotiate.compiled import compiled
from vividc.mapper.negotiate.places import Places, draw, early, enter, excess, window

_BROKEN, _LATE, _HOP, _CYCLE, _TIGHT = 30.0, 15.0, 1.0, 0.5, 0.7
_CELL = 1.0
_MOVE_KNOT_BELOW = 15
_MOVE_PE_BELOW, _MOVE_TIME_FROM = 65, 45
"""Of 100 moves, which change the PE and which the time."""


class Heat(NamedTuple):
    """`value[0]`: temperature; each move multiplies it with `cooling`."""

    value: Floats
    cooling: float
    scratch: Ints


@compiled
def anneal(task: Task, places: Places, heat: Heat, moves: int) -> None:
    """Make `moves` moves."""
    scratch = heat.scratch
    count = len(task.nodes.latency)
    for _ in range(moves):
        _step(task, places, heat.value[0], draw(places.random, count), scratch)
        heat.value[0] *= heat.cooling


@compiled
def _step(task: Task, places: Places, heat: float, node: int, scratch: Ints) -> None:
    nodes, edges, array = task
    knot = edges.knot_begin[node + 1] - edges.knot_begin[node]
    if knot > 1 and draw(places.random, 100) < _MOVE_KNOT_BELOW:
        _shift_knot(task, places, heat, node)
        return
    old_pe, old_time = places.pe[node], places.time[node]
    pe, time = propose(task, places, node, scratch)
    if pe == old_pe and time == old_time:
        return
    other = occupant(task, places, node, pe, time)
    if other >= 0 and not nodes.can[other, old_pe]:
        return
    before = _cost(task, places, node)
    if other >= 0:
        before += _cost(task, places, other)
        enter(nodes, array, places, other, -1)
    enter(nodes, array, places, node, -1)
    places.pe[node], places.time[node] = pe, time
    enter(nodes, array, places, node, 1)
    if other >= 0:
        places.pe[other] = old_pe
        enter(nodes, array, places, other, 1)
    change = _cost(task, places, node) - before
    if other >= 0:
        change += _cost(task, places, other)
    if change <= 0 or draw(places.random, 1 << 24) < math.exp(-change / heat) * (1 << 24):
        return
    enter(nodes, array, places, node, -1)
    if other >= 0:
        enter(nodes, array, places, other, -1)
        places.pe[other] = pe
    places.pe[node], places.time[node] = old_pe, old_time
    enter(nodes, array, places, node, 1)
    if other >= 0:
        enter(nodes, array, places, other, 1)


@compiled
def _shift_knot(task: Task, places: Places, heat: float, node: int) -> None:
    """Move all nodes of a recurrence in time: where it has no slack, none can move alone."""
    ii = task.array.ii
    by = 1 + draw(places.random, max(1, ii // 2))
    if draw(places.random, 2) == 0:
        by = -by
    begin, end = task.edges.knot_begin[node], task.edges.knot_begin[node + 1]
    for at in range(begin, end):
        time = places.time[task.edges.knot_items[at]] + by
        if time < 0 or time > task.array.latest:
            return
    before = _knot_cost(task, places, begin, end)
    _delay(task, places, begin, end, by)
    change = _knot_cost(task, places, begin, end) - before
    if change > 0 and draw(places.random, 1 << 24) >= math.exp(-change / heat) * (1 << 24):
        _delay(task, places, begin, end, -by)


@compiled
def _knot_cost(task: Task, places: Places, begin: int, end: int) -> float:
    total = 0.0
    for at in range(begin, end):
        total += _cost(task, places, task.edges.knot_items[at])
    return total


@compiled
def _delay(task: Task, places: Places, begin: int, end: int, by: int) -> None:
    for at in range(begin, end):
        node = task.edges.knot_items[at]
        enter(task.nodes, task.array, places, node, -1)
        places.time[node] += by
        enter(task.nodes, task.array, places, node, 1)


@compiled
def occupant(task: Task, places: Places, node: int, pe: int, time: int) -> int:
    """Another node that issues on the FU that `node` would use, or -1."""
    if not task.nodes.kind[node] & FU:
        return -1
    other = places.at[pe * task.array.ii + time % task.array.ii]
    return -1 if other == node else other


@compiled
def propose(task: Task, places: Places, node: int, scratch: Ints) -> tuple[int, int]:
    """A PE (any, or one near a neighbour in the graph) and a time for `node`."""
    nodes, edges, array = task
    random = places.random
    pe, time = places.pe[node], places.time[node]
    kind = draw(random, 100)
    if kind < _MOVE_PE_BELOW:
        begin, end = nodes.pe_begin[node], nodes.pe_begin[node + 1]
        pe = nodes.pe_items[begin + draw(random, end - begin)]
        count = edges.of_begin[node + 1] - edges.of_begin[node]
        if count > 0 and draw(random, 2) == 0:
            edge = edges.of_items[edges.of_begin[node] + draw(random, count)]
            other = edges.src[edge] + edges.dst[edge] - node
            row = array.near_begin[places.pe[other]]
            near = array.near_items[
                row + draw(random, array.near_begin[places.pe[other] + 1] - row)
            ]
            if nodes.can[node, near]:
                pe = near
    if kind >= _MOVE_TIME_FROM:
        window(edges, array, places, node, scratch)
        first, last = scratch[0], scratch[1]
        if first <= last:
            time = first + draw(random, last - first + 1)
        else:
            time = max(0, min(array.latest, last + draw(random, first - last + 1)))
    return pe, time


@compiled
def _cost(task: Task, places: Places, node: int) -> float:
    """What `node` breaks and what the words it makes and reads take."""
    nodes, edges, array = task
    total = _BROKEN * excess(nodes, array, places, node)
    for at in range(edges.of_begin[node], edges.of_begin[node + 1]):
        edge = edges.of_items[at]
        total += _edge_cost(edges, array, places, edge)
    total += _word_cost(edges, array, places, node)
    for at in range(edges.fed_begin[node], edges.fed_begin[node + 1]):
        total += _word_cost(edges, array, places, edges.fed_items[at])
    return total


@compiled
def _edge_cost(edges: Edges, array: Array, places: Places, edge: int) -> float:
    late = early(edges, array, places, edge)
    if not edges.routed[edge]:
        return _LATE * late
    src, dst = edges.src[edge], edges.dst[edge]
    hops = array.hop[places.pe[src], places.pe[dst]]
    if array.outputs:  # the first link is free: neighbours read the output register
        hops = max(0, hops - 1)
    cost = _HOP * hops
    if late > 0:
        return float(cost + _LATE * late)
    life = places.time[dst] - places.time[src] - edges.ready[edge]
    return float(cost + _TIGHT * max(0, hops - life))


@compiled
def _word_cost(edges: Edges, array: Array, places: Places, node: int) -> float:
    if array.outputs:
        return _output_cost(edges, places, node)
    return _life_cost(edges, places, node)


@compiled
def _output_cost(edges: Edges, places: Places, node: int) -> float:
    """Of the word that `node` makes: the cycles after the first in which another PE reads it, since
    each takes an output register and the FU that fills it. Its own registers are many.
    """
    cells, begin = 0, edges.sink_begin[node]
    for at in range(begin, edges.sink_begin[node + 1]):
        gap = _remote_gap(edges, places, node, edges.sink_items[at])
        known = gap <= 0
        for other in range(begin, at):
            known = known or _remote_gap(edges, places, node, edges.sink_items[other]) == gap
        cells += not known
    return _CELL * cells


@compiled
def _remote_gap(edges: Edges, places: Places, node: int, edge: int) -> int:
    """Cycles from the result to a read on another PE; 0 on its own."""
    dst = edges.dst[edge]
    if places.pe[dst] == places.pe[node]:
        return 0
    return int(places.time[dst] - places.time[node] - edges.ready[edge])


@compiled
def _life_cost(edges: Edges, places: Places, node: int) -> float:
    """Of the word that `node` makes: the cycles until its last read."""
    life = 0
    for at in range(edges.sink_begin[node], edges.sink_begin[node + 1]):
        edge = edges.sink_items[at]
        gap = places.time[edges.dst[edge]] - places.time[node] - edges.ready[edge]
        life = max(life, gap)
    return _CYCLE * life
