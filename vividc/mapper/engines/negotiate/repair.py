"""Annealing with routes: nodes move, the words they make and read are ripped up and routed again.

A move costs a hundred times what it does without routes, but sees the true crowding (as in DRESC,
Mei et al. 2002); so it starts from places that are nearly right and moves mostly nodes at the ends
of words that crowd others.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vividc.mapper.engines.negotiate.anneal import Heat, propose
from vividc.mapper.engines.negotiate.arrays import Task
from vividc.mapper.engines.negotiate.compiled import compiled, inlined
from vividc.mapper.engines.negotiate.motion import occupant
from vividc.mapper.engines.negotiate.places import Places, draw, early, enter, excess, lie
from vividc.mapper.engines.negotiate.traffic import (
    OVER,
    WIRE,
    Traffic,
    count_claims,
    crowds,
    rip_up,
)
from vividc.mapper.engines.negotiate.ways import Router, route
from vividc.mapper.resources.arrays import Ints, Ints2, Ints3

_CROWDED = 3.0
_AT_CROWDED_PERCENT = 80
_REFRESH = 16


class Undo(NamedTuple):
    """What a move changes, to take it back: `words` (first their number) and their ways; `crowded`:
    words that crowd others, first their number.
    """

    words: Ints
    crowded: Ints
    size: Ints2
    cell: Ints3
    claim: Ints2
    cut: Ints3
    end: Ints


def new_undo(task: Task, traffic: Traffic) -> Undo:
    """Room for the words of two nodes."""
    most = 2 * (1 + int(np.diff(task.edges.fed_begin).max(initial=0)))

    def like(array: Ints) -> Ints:
        return np.zeros((most, *array.shape[1:]), dtype=np.int64)

    return Undo(
        np.zeros(most + 1, dtype=np.int64),
        np.zeros(len(task.nodes.latency) + 1, dtype=np.int64),
        like(traffic.size),
        like(traffic.cell),
        like(traffic.claim),
        like(traffic.cut),
        np.zeros_like(traffic.end),
    )


@compiled
def repair(router: Router, undo: Undo, heat: Heat, moves: int, trades: bool) -> int:
    """Make up to `moves` moves; returns how many were left when nothing was crowded any more.

    `trades`: nodes trade slots, too, where one cannot keep its own on the other's PE; of a full
    array no node changes its slot without that.
    """
    task, places, traffic = router.task, router.places, router.traffic
    for move in range(moves):
        if traffic.totals[OVER] == 0:
            return moves - move
        if move % _REFRESH == 0:
            _list_crowded(traffic, undo)
        node = _pick(task, places, undo)
        _try_move(router, undo, node, heat, trades)
        heat.value[0] *= heat.cooling
    return 0


@inlined
def _list_crowded(traffic: Traffic, undo: Undo) -> None:
    count = 0
    for producer in range(traffic.size.shape[0]):
        if crowds(traffic, producer):
            count += 1
            undo.crowded[count] = producer
    undo.crowded[0] = count


@inlined
def _pick(task: Task, places: Places, undo: Undo) -> int:
    """A node at an end of a crowded word, sometimes any."""
    random, edges = places.random, task.edges
    if undo.crowded[0] == 0 or draw(random, 100) >= _AT_CROWDED_PERCENT:
        return draw(random, len(task.nodes.latency))
    word = undo.crowded[1 + draw(random, undo.crowded[0])]
    first = edges.sink_begin[word]
    which = draw(random, edges.sink_begin[word + 1] - first + 1)
    return int(word if which == 0 else edges.dst[edges.sink_items[first + which - 1]])


@inlined
def _try_move(router: Router, undo: Undo, node: int, heat: Heat, trades: bool) -> None:
    task, places, traffic = router.task, router.places, router.traffic
    old_pe, old_time = places.pe[node], places.time[node]
    pe, time = propose(task, places, node, heat.scratch)
    other = occupant(task, places, node, pe, time)
    its_time, its_new_time = old_time, old_time
    if other >= 0:
        its_time = places.time[other]
        its_new_time = _new_time(task, places, node, time, other, trades)
        if its_new_time < 0:
            return
    _shift(task, places, node, pe, time, other, old_pe, its_new_time)
    if not (_is_legal(task, places, node) and (other < 0 or _is_legal(task, places, other))):
        _shift(task, places, node, old_pe, old_time, other, pe, its_time)
        return
    undo.words[0] = 0
    _add_words(task, undo, node)
    if other >= 0:
        _add_words(task, undo, other)
    before = traffic.totals[WIRE] + _CROWDED * traffic.totals[OVER]
    _save(task, traffic, undo)
    for at in range(1, undo.words[0] + 1):
        rip_up(traffic, task.array.ii, undo.words[at])
    routed = True
    for at in range(1, undo.words[0] + 1):
        if routed:
            routed = route(router, undo.words[at])
    change = traffic.totals[WIRE] + _CROWDED * traffic.totals[OVER] - before
    if routed and (
        change <= 0 or draw(places.random, 1 << 24) < math.exp(-change / heat.value[0]) * (1 << 24)
    ):
        return
    _restore(task, traffic, undo)
    _shift(task, places, node, old_pe, old_time, other, pe, its_time)


@inlined
def _new_time(task: Task, places: Places, node: int, time: int, other: int, trades: bool) -> int:
    """When `other` starts on the PE of `node`, which takes its slot; negative: it cannot."""
    nodes, pe, its_time = task.nodes, places.pe[node], places.time[other]
    if not nodes.can[other, pe]:
        return -1
    third = occupant(task, places, other, pe, its_time)
    if not trades or third == node or (third < 0 and pe != places.pe[other]):
        return int(its_time)
    its_time += places.time[node] - time
    return int(its_time) if its_time <= nodes.last[other] else -1


@inlined
def _shift(
    task: Task,
    places: Places,
    node: int,
    pe: int,
    time: int,
    other: int,
    other_pe: int,
    other_time: int,
) -> None:
    nodes, array = task.nodes, task.array
    enter(nodes, array, places, node, -1)
    if other >= 0:
        enter(nodes, array, places, other, -1)
        lie(task, places, other, other_pe, other_time)
    lie(task, places, node, pe, time)
    enter(nodes, array, places, node, 1)
    if other >= 0:
        enter(nodes, array, places, other, 1)


@inlined
def _is_legal(task: Task, places: Places, node: int) -> bool:
    if excess(task.nodes, task.array, places, node) > 0:
        return False
    edges = task.edges
    for at in range(edges.of_begin[node], edges.of_begin[node + 1]):
        if early(edges, task.array, places, edges.of_items[at]) > 0:
            return False
    return True


@inlined
def _add_words(task: Task, undo: Undo, node: int) -> None:
    """Enter the word that `node` makes and those that it reads, each once."""
    edges = task.edges
    begin, end = edges.fed_begin[node], edges.fed_begin[node + 1]
    for at in range(begin, end + 1):
        word = node if at == end else edges.fed_items[at]
        known = False
        for other in range(1, undo.words[0] + 1):
            known = known or undo.words[other] == word
        if not known:
            undo.words[0] += 1
            undo.words[undo.words[0]] = word


@inlined
def _save(task: Task, traffic: Traffic, undo: Undo) -> None:
    edges = task.edges
    for at in range(undo.words[0]):
        word = undo.words[at + 1]
        for part in range(3):
            undo.size[at, part] = traffic.size[word, part]
        for row in range(traffic.size[word, 0]):
            for part in range(3):
                undo.cell[at, row, part] = traffic.cell[word, row, part]
        for row in range(traffic.size[word, 1]):
            undo.claim[at, row] = traffic.claim[word, row]
        for row in range(traffic.size[word, 2]):
            undo.cut[at, row, 0] = traffic.cut[word, row, 0]
            undo.cut[at, row, 1] = traffic.cut[word, row, 1]
        for sink in range(edges.sink_begin[word], edges.sink_begin[word + 1]):
            undo.end[edges.sink_items[sink]] = traffic.end[edges.sink_items[sink]]


@inlined
def _restore(task: Task, traffic: Traffic, undo: Undo) -> None:
    edges, ii = task.edges, task.array.ii
    for at in range(undo.words[0]):
        word = undo.words[at + 1]
        rip_up(traffic, ii, word)
        for part in range(3):
            traffic.size[word, part] = undo.size[at, part]
        for row in range(undo.size[at, 0]):
            for part in range(3):
                traffic.cell[word, row, part] = undo.cell[at, row, part]
        for row in range(undo.size[at, 1]):
            traffic.claim[word, row] = undo.claim[at, row]
        for row in range(undo.size[at, 2]):
            traffic.cut[word, row, 0] = undo.cut[at, row, 0]
            traffic.cut[word, row, 1] = undo.cut[at, row, 1]
        for sink in range(edges.sink_begin[word], edges.sink_begin[word + 1]):
            traffic.end[edges.sink_items[sink]] = undo.end[edges.sink_items[sink]]
        count_claims(traffic, ii, word, 1)
