"""Simulated annealing of places and times (Kirkpatrick et al. 1983; for CGRAs Mei et al. 2002).

The cost of a state is what it breaks (claims beyond capacity, words that cannot be there in time)
and, far less, what words take: over links the cycles that each word lives, counted once however
many read it, and the hops of its ways; over output registers the moves that show it (`words`).
Which link or register is the router's part. Where a caller counts them, accesses that meet in banks
cost, too.

A node moves alone, changes places with another, or pushes in time all that its move makes too
early: where a schedule has no slack, none of its nodes can move alone.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vividc.mapper.engines.negotiate.arrays import FU, LEAVES, ROUTED, Task
from vividc.mapper.engines.negotiate.compiled import compiled, inlined
from vividc.mapper.engines.negotiate.motion import (
    BROKEN,
    CLASH,
    LATES,
    MOVE,
    NODES,
    Motion,
    begin,
    claims_cost,
    clashes,
    cost_all,
    edges_change,
    excess_of_all,
    exchange,
    hide_words,
    keep_costs,
    meeting_cost,
    moves,
    occupant,
    put,
    restore_words,
    show_words,
    swap,
    withdraw_words,
    words_change,
    words_cost,
    words_may_change,
)
from vividc.mapper.engines.negotiate.places import Places, draw, excess, window, wrapped
from vividc.mapper.engines.negotiate.words import Words
from vividc.mapper.resources.arrays import Floats, Ints

_FOCUS, _LOOKS = 60, 8
"""Of 100 moves, which look for a node that breaks something, and at how many: of 153 annealings of
17 loops, with half of the moves, 82 come to nothing broken; 63 without, 65 with 30 and 4, and no
more than 87 with 90 and 24, which take a third longer.
"""
_PUSH_BELOW = 8
"""Of 100 moves, which push others in time."""
_MOVE_PE_BELOW, _MOVE_TIME_FROM = 65, 45
"""Of 100 other moves, which change the PE and which the time."""
_ANY, _LEAST_ANY, _SMALL_ARRAY = 50, 5, 16
"""Of 100 PEs that are proposed, how many are any, on an array of so many; on larger ones fewer."""
_BY_GRAPH_BELOW = 70
"""Of 100, below which number the others are near a neighbour in the graph and not near its own."""
_DEAREST = 24.0 * math.log(2.0) + 0.001
"""What is drawn for a move costs no more, at a heat of 1."""
_ROUNDED = 1e-6
"""More than sums of costs may be off by."""
_FEW = 2
"""Nodes of a move up to which each is held against each."""
_MOST_TURNS = 16
"""Rounds over the nodes of a push: around a recurrence some are pushed again and again."""


class Heat(NamedTuple):
    """`value[0]`: temperature; each move multiplies it with `cooling`."""

    value: Floats
    cooling: float
    scratch: Ints


class State(NamedTuple):
    """What moves change, and their work space."""

    places: Places
    words: Words
    motion: Motion


def new_heat(hot: float, cold: float, moves: int) -> Heat:
    """From hot to cold within so many moves."""
    cooling = (cold / hot) ** (1.0 / max(moves, 1))
    return Heat(np.array([hot]), cooling, np.zeros(2, dtype=np.int64))


@compiled
def anneal(task: Task, state: State, heat: Heat, moves: int) -> None:
    """Make `moves` moves."""
    places, motion = state.places, state.motion
    nodes = len(task.nodes.latency)
    cost_all(task, places, motion)
    for _ in range(moves):
        begin(motion)
        node = draw(places.random, nodes)
        if draw(places.random, 100) < _FOCUS:
            node = _focused(task, places, motion, node)
        if draw(places.random, 100) < _PUSH_BELOW:
            possible = _propose_push(task, places, motion, node)
        else:
            possible = _propose_one(task, places, motion, node, heat.scratch)
        if possible:
            _consider(task, state, heat.value[0])
        heat.value[0] *= heat.cooling


@inlined
def _focused(task: Task, places: Places, motion: Motion, node: int) -> int:
    """A node that breaks something, of some that are drawn, else the last of them: what is left to
    mend when it is cold hardly any node has a part in.
    """
    nodes = task.nodes
    if places.over[0] == 0 and motion.listed[LATES] == 0:
        return node
    for _ in range(_LOOKS):
        if motion.late[node] > 0:
            return node
        if places.over[0] > 0 and excess(nodes, task.array, places, node) > 0:
            return node
        node = draw(places.random, len(nodes.latency))
    return node


@inlined
def _consider(task: Task, state: State, heat: float) -> None:
    """Make the proposed move, unless it costs more than what is drawn for it first (Metropolis et
    al. 1953).

    Most moves are refused by what places and times alone cost, before anything is claimed, and
    many whatever is drawn.
    """
    places, words, motion = state
    drawn = draw(places.random, 1 << 24)
    met = meeting_cost(task, places, motion)
    swap(task, places, motion)
    change, most = edges_change(task, places, motion), _DEAREST * heat + met
    if words_may_change(task, places, motion):
        dearest = BROKEN * places.over[0] + most + _ROUNDED
        if not task.array.moves and change - words_cost(task, motion) > dearest:
            swap(task, places, motion)
            return
        change = words_change(task, places, motion, change)
    claims = claims_cost(task, places, words, motion)
    if change > claims + most:
        swap(task, places, motion)
        return
    most = claims - heat * math.log((1 + drawn) / (1 << 24)) + met
    if change <= most:  # else no stalls make up for it
        change += meeting_cost(task, places, motion)
    most -= change
    swap(task, places, motion)
    if most < 0:
        return
    if task.array.moves:
        _claim_with_words(task, state, most)
    else:
        _claim(task, places, motion, most)


@inlined
def _claim(task: Task, places: Places, motion: Motion, most: float) -> None:
    """Make the move if what is beyond capacity then costs at most `most`. No more of it can go than
    what the nodes that move are part of.
    """
    over = places.over[0]
    least = over - excess_of_all(task, places, motion) if over > 0 else 0
    if BROKEN * least > most:
        return
    if BROKEN * (least + arriving_excess(task, places, motion)) > most:
        touch(task, places, motion)
        return
    exchange(task, places, motion)
    if BROKEN * places.over[0] <= most:
        keep_costs(task, motion)
    else:
        exchange(task, places, motion)


@inlined
def arriving_excess(task: Task, places: Places, motion: Motion) -> int:
    """Claims beyond capacity where the nodes that move go, at least: in slots of their FUs."""
    over, few = 0, motion.listed[NODES] <= _FEW
    for at in range(motion.listed[NODES]):
        node = motion.nodes[at]
        if not task.nodes.kind[node] & FU:
            continue
        if few:
            over += _meets_others(task, places, motion, node, at)
        else:
            other = places.at[motion.pe[node] * task.array.ii + motion.slot[node]]
            over += int(other >= 0 and not moves(motion, other))
    return over


@inlined
def _meets_others(task: Task, places: Places, motion: Motion, node: int, before: int) -> int:
    """The slots of its FU, of two, in which `node` meets nodes that stay where they are, or some of
    the `before` nodes of the list.
    """
    nodes, array = task.nodes, task.array
    ii, pe, slot = array.ii, motion.pe[node], motion.slot[node]
    done = wrapped(slot + nodes.done[node], ii)
    issued = places.counts[pe * ii + slot]
    ended = places.counts[(array.pes + pe) * ii + done]
    for at in range(motion.listed[NODES]):
        other = motion.nodes[at]
        if not nodes.kind[other] & FU:
            continue
        its = places.slot[other]
        if places.pe[other] == pe:
            issued -= int(its == slot or nodes.busy[other] > 1)
            ended -= int(wrapped(its + nodes.done[other], ii) == done)
        if at < before and motion.pe[other] == pe:
            issued += int(motion.slot[other] == slot)
    return int(issued > 0) + int(ended > 0)


@inlined
def touch(task: Task, places: Places, motion: Motion) -> None:
    """Leave behind what a move that is made and taken back does: nobody is known in slots where its
    nodes went.
    """
    array = task.array
    for at in range(motion.listed[NODES]):
        node = motion.nodes[at]
        if task.nodes.kind[node] & FU:
            places.at[motion.pe[node] * array.ii + motion.slot[node]] = -1
    for at in range(motion.listed[NODES]):
        node = motion.nodes[at]
        if task.nodes.kind[node] & FU:
            places.at[places.pe[node] * array.ii + places.slot[node]] = node


@inlined
def _claim_with_words(task: Task, state: State, most: float) -> None:
    """The same where FUs move words on: what words claim anew costs, too."""
    places, words, motion = state
    exchange(task, places, motion)
    swap(task, places, motion)
    relief = clashes(task, places, words, motion)
    if CLASH * (places.over[0] - relief) > most:
        swap(task, places, motion)
        exchange(task, places, motion)
        return
    hide_words(task, places, words, motion)
    swap(task, places, motion)
    if show_words(task, places, words, motion, most):
        keep_costs(task, motion)
        return
    withdraw_words(task, places, words, motion)
    exchange(task, places, motion)
    restore_words(task, places, words, motion)


@inlined
def _propose_one(task: Task, places: Places, motion: Motion, node: int, scratch: Ints) -> bool:
    """One node goes elsewhere; who is there takes its PE, and its slot there where FUs move words:
    arrays are fuller there, while elsewhere fewer tries come out free of clashes so.
    """
    pe, time = propose(task, places, node, scratch)
    if pe == places.pe[node] and time == places.time[node]:
        return False
    other = occupant(task, places, node, pe, time)
    if other >= 0:
        its_time = places.time[other]
        if task.array.moves:
            its_time += places.time[node] - time
        last = task.nodes.last[other]
        if not task.nodes.can[other, places.pe[node]] or not 0 <= its_time <= last:
            return False
        put(task.array, motion, other, places.pe[node], its_time)
    put(task.array, motion, node, pe, time)
    return True


@inlined
def _propose_push(task: Task, places: Places, motion: Motion, node: int) -> bool:
    """A node goes some cycles later, or to another PE when it can be there, or earlier, and pushes
    others as far as it must. False: something would leave the schedule.
    """
    array, random = task.array, places.random
    sign = 1 if draw(random, 2) == 0 else -1
    pe, time = places.pe[node], places.time[node]
    if draw(random, 2) == 0:
        pe = draw_pe(task, places, node)
        time = _next_to_those_before(task, places, node, pe, sign)
    if pe == places.pe[node]:
        time = places.time[node] + sign * (1 + draw(random, max(1, array.ii // 2)))
    if time < 0 or time > task.nodes.last[node]:
        return False
    put(task.array, motion, node, pe, time)
    return push(task, places, motion, sign)


@inlined
def _next_to_those_before(task: Task, places: Places, node: int, pe: int, sign: int) -> int:
    """The time nearest to its own at which a node can follow (sign 1) or precede (-1) its
    neighbours from another PE.
    """
    edges = task.edges
    time = places.time[node]
    for at in range(edges.of_begin[node], edges.of_begin[node + 1]):
        other, leaves = edges.of_other[at], edges.of_kind[at] & LEAVES
        if sign > 0 and not leaves:
            apart = _apart(task, at, places.pe[other], pe)
            time = max(time, places.time[other] + apart)
        elif sign < 0 and leaves:
            apart = _apart(task, at, pe, places.pe[other])
            time = min(time, places.time[other] - apart)
    return int(min(max(time, -1), task.nodes.last[node] + 1))


@inlined
def _apart(task: Task, at: int, src_pe: int, dst_pe: int) -> int:
    """Least cycles between the ends of an edge on these PEs, by what lies beside it."""
    edges = task.edges
    if edges.of_kind[at] & ROUTED:
        return int(edges.of_lag[at] + task.array.reach[src_pe, dst_pe])
    return int(edges.of_lag[at])


@inlined
def push(task: Task, places: Places, motion: Motion, sign: int) -> bool:
    """Push what follows (sign 1) or precedes (-1) the nodes of a move out of their way; False: out
    of the schedule, or around a recurrence without end.

    A node that was not pushed since it pushed others would push none: they only went farther.
    """
    turns, clean = 0, False
    motion.due[motion.nodes[0]] = motion.listed[MOVE]
    while not clean:
        clean = True
        listed = 0
        while listed < motion.listed[NODES]:
            node = motion.nodes[listed]
            if motion.due[node] == motion.listed[MOVE]:
                motion.due[node] = 0
                pushed = _push_from(task, places, motion, node, sign)
                if pushed < 0:
                    return False
                clean = clean and pushed == 0
            listed += 1
        turns += 1
        if turns > _MOST_TURNS:
            return False
    return True


@inlined
def _push_from(task: Task, places: Places, motion: Motion, node: int, sign: int) -> int:
    """How many nodes one that moves pushes; negative: one leaves the schedule, or the first would
    push itself, round after round.
    """
    edges = task.edges
    leaves = LEAVES if sign > 0 else 0
    pe, time, count = motion.pe[node], motion.time[node], 0
    for at in range(edges.of_begin[node], edges.of_begin[node + 1]):
        if edges.of_kind[at] & LEAVES != leaves:
            continue
        other = edges.of_other[at]
        its_pe, its_time = _where(places, motion, other)
        apart = _apart(task, at, pe, its_pe) if sign > 0 else _apart(task, at, its_pe, pe)
        pushed = time + sign * apart
        if sign * (pushed - its_time) <= 0:
            continue
        if pushed < 0 or pushed > task.nodes.last[other] or other == motion.nodes[0]:
            return -1
        put(task.array, motion, other, its_pe, pushed)
        motion.due[other] = motion.listed[MOVE]
        count += 1
    return count


@inlined
def _where(places: Places, motion: Motion, node: int) -> tuple[int, int]:
    """PE and time of a node after the move so far."""
    if moves(motion, node):
        return int(motion.pe[node]), int(motion.time[node])
    return int(places.pe[node]), int(places.time[node])


@inlined
def draw_pe(task: Task, places: Places, node: int) -> int:
    """A PE for `node`: any, or one near a neighbour in the graph, or near its own."""
    nodes, edges, array = task.nodes, task.edges, task.array
    random = places.random
    first, end = nodes.pe_begin[node], nodes.pe_begin[node + 1]
    pe = nodes.pe_items[first + draw(random, end - first)]
    others = edges.of_begin[node + 1] - edges.of_begin[node]
    kind = draw(random, 100)
    if others == 0 or kind < max(_LEAST_ANY, _ANY * _SMALL_ARRAY // max(array.pes, _SMALL_ARRAY)):
        return int(pe)
    beside = places.pe[node]
    if array.pes <= _SMALL_ARRAY or kind < _BY_GRAPH_BELOW:
        at = edges.of_begin[node] + draw(random, others)
        beside = places.pe[edges.of_other[at]]
    row = array.near_begin[beside]
    near = array.near_items[row + draw(random, array.near_begin[beside + 1] - row)]
    return int(near if nodes.can[node, near] else pe)


@inlined
def propose(task: Task, places: Places, node: int, scratch: Ints) -> tuple[int, int]:
    """A PE (`draw_pe`) or a time, or both, for `node`."""
    nodes = task.nodes
    random = places.random
    pe, time = places.pe[node], places.time[node]
    kind = draw(random, 100)
    if kind < _MOVE_PE_BELOW:
        pe = draw_pe(task, places, node)
    if kind >= _MOVE_TIME_FROM:
        window(task, places, node, scratch)
        first, last = scratch[0], scratch[1]
        if first <= last:
            time = first + draw(random, last - first + 1)
        else:
            time = max(0, min(nodes.last[node], last + draw(random, first - last + 1)))
    return pe, time
