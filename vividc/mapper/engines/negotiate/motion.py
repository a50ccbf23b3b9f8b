"""One move of some nodes and of what their words take, done and taken back: compiled functions."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vividc.mapper.engines.negotiate.arrays import FU, LEAVES, ROUTED, Array, Edges, Task
from vividc.mapper.engines.negotiate.compiled import inlined
from vividc.mapper.engines.negotiate.places import (
    MET,
    Places,
    early,
    enter,
    excess,
    keep_slot,
)
from vividc.mapper.engines.negotiate.words import (
    MOST_HOPS,
    Words,
    claim_again,
    clashes_of,
    is_popular,
    show,
    withdraw,
)
from vividc.mapper.resources.arrays import Floats, Ints, Ints2

BROKEN, LATE, HOP, CYCLE, TIGHT = 30.0, 15.0, 1.0, 0.5, 0.7
CELL, WAIT = 1.0, 0.1
CLASH, LATE_READ = 15.0, 40.0
"""The same as `BROKEN` and `LATE` where moves are claimed, each twice: with its FU and its output.
A read that comes too early claims none, and so must be dearer than any.
"""
FAR_HOP, POPULAR_HOP = 4.0, 0.4
"""A link of a way that is too long for moves to be claimed: dearer than those; and one of a
word with too many reads, which share most of it.
"""

STALL = 8.0
"""An expected cycle of an iteration in which the tile stands still, where such are counted."""

NODES, EDGES, WORDS, LATES, MOVE = 0, 1, 2, 3, 4
"""Positions in `Motion.listed`; the last ones: edges whose ends come too early, by their costs, and
the number of the move.
"""


class Motion(NamedTuple):
    """A move. `listed`: nodes, edges and words in the lists `nodes`, `edges`, `words`; in `*_in`
    the last move for which each was. `pe`, `time`, `slot`: by node what it has when the move is not
    made, or made; `due`: the last move for which it may still push others.
    `shown`: by word what `Words` had of it: number, PEs, cycles. `edge_cost`, `word_cost`: of what
    lies there; `*_next`, with the move; `late`: by node its edges whose ends come too early.
    """

    listed: Ints
    nodes: Ints
    edges: Ints
    words: Ints
    node_in: Ints
    edge_in: Ints
    word_in: Ints
    pe: Ints
    time: Ints
    slot: Ints
    due: Ints
    shown_size: Ints
    shown_pe: Ints2
    shown_cycle: Ints2
    edge_cost: Floats
    word_cost: Floats
    edge_next: Floats
    word_next: Floats
    late: Ints


def new_motion(task: Task, words: Words) -> Motion:
    """No node moves."""
    nodes, edges = len(task.nodes.latency), len(task.edges.src)
    return Motion(
        listed=np.zeros(5, dtype=np.int64),
        nodes=np.zeros(nodes, dtype=np.int64),
        edges=np.zeros(edges, dtype=np.int64),
        words=np.zeros(nodes, dtype=np.int64),
        node_in=np.zeros(nodes, dtype=np.int64),
        edge_in=np.zeros(edges, dtype=np.int64),
        word_in=np.zeros(nodes, dtype=np.int64),
        pe=np.zeros(nodes, dtype=np.int64),
        time=np.zeros(nodes, dtype=np.int64),
        slot=np.zeros(nodes, dtype=np.int64),
        due=np.zeros(nodes, dtype=np.int64),
        shown_size=np.zeros_like(words.size),
        shown_pe=np.zeros_like(words.pe),
        shown_cycle=np.zeros_like(words.cycle),
        edge_cost=np.zeros(edges),
        word_cost=np.zeros(nodes),
        edge_next=np.zeros(edges),
        word_next=np.zeros(nodes),
        late=np.zeros(nodes, dtype=np.int64),
    )


@inlined
def begin(motion: Motion) -> None:
    """No node moves."""
    for part in range(3):
        motion.listed[part] = 0
    motion.listed[MOVE] += 1


@inlined
def moves(motion: Motion, node: int) -> bool:
    """Whether a node moves."""
    return bool(motion.node_in[node] == motion.listed[MOVE])


@inlined
def put(array: Array, motion: Motion, node: int, pe: int, time: int) -> None:
    """Have `node` go to a PE and a time."""
    if not moves(motion, node):
        motion.node_in[node] = motion.listed[MOVE]
        motion.nodes[motion.listed[NODES]] = node
        motion.listed[NODES] += 1
    motion.pe[node], motion.time[node], motion.slot[node] = pe, time, array.slots[time]


@inlined
def cost_all(task: Task, places: Places, motion: Motion) -> None:
    """Enter the costs of all edges and words as they lie."""
    motion.listed[LATES] = 0
    for node in range(len(motion.late)):
        motion.late[node] = 0
    for edge in range(len(motion.edge_cost)):
        motion.edge_cost[edge] = _edge_cost(task.edges, task.array, places, edge)
        _count_late(task.edges, motion, edge, int(motion.edge_cost[edge] >= LATE))
    for word in range(len(motion.word_cost)):
        motion.word_cost[word] = _word_cost(task, places, word)


@inlined
def edges_change(task: Task, places: Places, motion: Motion) -> float:
    """By how much the move, which is made, changes the costs of edges, which are listed."""
    total = 0.0
    for at in range(motion.listed[NODES]):
        total = _edges_change(task, places, motion, motion.nodes[at], total)
    return total


@inlined
def words_may_change(task: Task, places: Places, motion: Motion) -> bool:
    """Whether words may cost something else after the move, which is made: over links they cost
    what they live, which depends on times only.
    """
    may = bool(task.array.outputs)
    for at in range(motion.listed[NODES]):
        node = motion.nodes[at]
        may = may or motion.time[node] != places.time[node]
    return may


@inlined
def words_cost(task: Task, motion: Motion) -> float:
    """What words at the nodes that move cost before the move, at least: they are cheaper by no more
    afterwards.
    """
    edges, total = task.edges, 0.0
    for at in range(motion.listed[NODES]):
        node = motion.nodes[at]
        total += motion.word_cost[node]
        for item in range(edges.fed_begin[node], edges.fed_begin[node + 1]):
            total += motion.word_cost[edges.fed_items[item]]
    return total


@inlined
def words_change(task: Task, places: Places, motion: Motion, total: float) -> float:
    """Add to `total` by how much the move, which is made, changes what words cost by places and
    times alone; they are listed.
    """
    edges = task.edges
    for at in range(motion.listed[NODES]):
        node = motion.nodes[at]
        total = _word_change(task, places, motion, node, total)
        for item in range(edges.fed_begin[node], edges.fed_begin[node + 1]):
            total = _word_change(task, places, motion, edges.fed_items[item], total)
    return total


@inlined
def _edges_change(task: Task, places: Places, motion: Motion, node: int, total: float) -> float:
    """Add to `total` what edges of a node change that are not listed yet."""
    edges, move, listed = task.edges, motion.listed[MOVE], motion.listed[EDGES]
    for item in range(edges.of_begin[node], edges.of_begin[node + 1]):
        edge = edges.of_items[item]
        if motion.edge_in[edge] == move:
            continue
        motion.edge_in[edge] = move
        motion.edges[listed] = edge
        listed += 1
        if task.array.moves:
            after = _edge_cost(task.edges, task.array, places, edge)
        else:
            after = _cost_beside(task.edges, task.array, places, node, item)
        motion.edge_next[edge] = after
        total += after - motion.edge_cost[edge]
    motion.listed[EDGES] = listed
    return total


@inlined
def _word_change(task: Task, places: Places, motion: Motion, word: int, total: float) -> float:
    """Add to `total` what a word changes, if it is not listed yet."""
    if motion.word_in[word] != motion.listed[MOVE]:
        motion.word_in[word] = motion.listed[MOVE]
        motion.words[motion.listed[WORDS]] = word
        motion.listed[WORDS] += 1
        motion.word_next[word] = _word_cost(task, places, word)
        total += motion.word_next[word] - motion.word_cost[word]
    return total


@inlined
def meeting_cost(task: Task, places: Places, motion: Motion) -> float:
    """Of what the nodes that move meet in banks where they are."""
    meets, stages = task.meets, task.array.stages
    stalls = 0.0
    for at in range(motion.listed[NODES]):
        node = motion.nodes[at]
        one = meets.access[node]
        if one < 0:
            continue
        slot = places.slot[node]
        for word in range(places.met.shape[1]):
            left = places.met[slot, word]
            while left != 0:
                lowest = left & -left
                left -= lowest
                other = MET * word + int(lowest).bit_length() - 1
                its = meets.node[other]
                if other == one or (other < one and moves(motion, its)):
                    continue
                apart = stages[places.time[node]] - stages[places.time[its]]
                apart = min(max(apart, -meets.far), meets.far)
                stalls += meets.stalls[one, other, meets.far + apart]
    return STALL * stalls


@inlined
def _count_late(edges: Edges, motion: Motion, edge: int, by: int) -> None:
    motion.listed[LATES] += by
    if edges.src[edge] != edges.dst[edge]:
        motion.late[edges.src[edge]] += by
        motion.late[edges.dst[edge]] += by


@inlined
def keep_costs(task: Task, motion: Motion) -> None:
    """The move stays made."""
    for at in range(motion.listed[EDGES]):
        edge = motion.edges[at]
        before, after = motion.edge_cost[edge], motion.edge_next[edge]
        by = int(after >= LATE) - int(before >= LATE)
        if by != 0:
            _count_late(task.edges, motion, edge, by)
        motion.edge_cost[edge] = after
    for at in range(motion.listed[WORDS]):
        word = motion.words[at]
        motion.word_cost[word] = motion.word_next[word]


@inlined
def claims_cost(task: Task, places: Places, words: Words, motion: Motion) -> float:
    """Of everything beyond capacity, and of the moves claimed for the words that are listed."""
    if not task.array.moves:
        return float(BROKEN * places.over[0])
    cells = 0
    for at in range(motion.listed[WORDS]):
        cells += max(0, words.size[motion.words[at]] - 1)
    return float(CLASH * places.over[0] + CELL * cells)


@inlined
def clashes(task: Task, places: Places, words: Words, motion: Motion) -> int:
    """Claims of the listed words that meet others: as many, at most, are beyond capacity for their
    sake.
    """
    met = 0
    for at in range(motion.listed[WORDS]):
        met += clashes_of(task, places, words, motion.words[at])
    return met


@inlined
def swap(task: Task, places: Places, motion: Motion) -> None:
    """Exchange where nodes are with where they go, in name only: what they claim stays."""
    for at in range(motion.listed[NODES]):
        node = motion.nodes[at]
        pe, time, slot = places.pe[node], places.time[node], places.slot[node]
        places.pe[node], places.time[node] = motion.pe[node], motion.time[node]
        keep_slot(task.meets, places, node, motion.slot[node])
        motion.pe[node], motion.time[node], motion.slot[node] = pe, time, slot


@inlined
def exchange(task: Task, places: Places, motion: Motion) -> None:
    """Make the move; a second time: take it back."""
    for at in range(motion.listed[NODES]):
        enter(task.nodes, task.array, places, motion.nodes[at], -1)
    swap(task, places, motion)
    for at in range(motion.listed[NODES]):
        enter(task.nodes, task.array, places, motion.nodes[at], 1)


@inlined
def excess_of_all(task: Task, places: Places, motion: Motion) -> int:
    """Claims beyond capacity where the nodes that move are: no fewer than go when they leave."""
    over = 0
    for at in range(motion.listed[NODES]):
        over += excess(task.nodes, task.array, places, motion.nodes[at])
    return over


@inlined
def hide_words(task: Task, places: Places, words: Words, motion: Motion) -> None:
    """Withdraw the listed words, and keep what they had."""
    for at in range(motion.listed[WORDS]):
        word = motion.words[at]
        motion.shown_size[word] = words.size[word]
        for cell in range(words.size[word]):
            motion.shown_pe[word, cell] = words.pe[word, cell]
            motion.shown_cycle[word, cell] = words.cycle[word, cell]
        withdraw(task, places, words, word)


@inlined
def show_words(task: Task, places: Places, words: Words, motion: Motion, most: float) -> bool:
    """Claim for the listed words anew; False, with some left out, once that costs more than
    `most`: claims only add to it.
    """
    cells = 0
    for at in range(motion.listed[WORDS]):
        if CLASH * places.over[0] + CELL * cells > most:
            return False
        word = motion.words[at]
        show(task, places, words, word)
        cells += words.size[word] - 1
    return bool(CLASH * places.over[0] + CELL * cells <= most)


@inlined
def withdraw_words(task: Task, places: Places, words: Words, motion: Motion) -> None:
    """Withdraw the listed words."""
    for at in range(motion.listed[WORDS]):
        withdraw(task, places, words, motion.words[at])


@inlined
def restore_words(task: Task, places: Places, words: Words, motion: Motion) -> None:
    """Claim for the listed words what they had."""
    for at in range(motion.listed[WORDS]):
        word = motion.words[at]
        words.size[word] = motion.shown_size[word]
        for cell in range(words.size[word]):
            words.pe[word, cell] = motion.shown_pe[word, cell]
            words.cycle[word, cell] = motion.shown_cycle[word, cell]
        claim_again(task, places, words, word)


@inlined
def occupant(task: Task, places: Places, node: int, pe: int, time: int) -> int:
    """Another node that issues on the FU that `node` would use, or -1."""
    if not task.nodes.kind[node] & FU:
        return -1
    other = places.at[pe * task.array.ii + task.array.slots[time]]
    return -1 if other == node else int(other)


@inlined
def _cost_beside(edges: Edges, array: Array, places: Places, node: int, item: int) -> float:
    """What an edge of a node costs where no moves are claimed, by what lies beside it."""
    kind, other = edges.of_kind[item], edges.of_other[item]
    src, dst = other, node
    if kind & LEAVES:
        src, dst = node, other
    life = places.time[dst] - places.time[src] - edges.of_lag[item]
    if not kind & ROUTED:
        return float(LATE * max(0, -life))
    src_pe, dst_pe = places.pe[src], places.pe[dst]
    hops = array.hop[src_pe, dst_pe]
    late = array.reach[src_pe, dst_pe] - life
    if array.outputs:  # the first link is free: neighbours read the output register
        hops = max(0, hops - 1)
    if late > 0:
        return float(HOP * hops + LATE * late)
    return float(HOP * hops + TIGHT * max(0, hops - life))


@inlined
def _edge_cost(edges: Edges, array: Array, places: Places, edge: int) -> float:
    late = early(edges, array, places, edge)
    if array.moves:
        if not edges.routed[edge]:
            return float(LATE_READ * late)
        far = array.hop[places.pe[edges.src[edge]], places.pe[edges.dst[edge]]]
        per_hop = FAR_HOP if far > MOST_HOPS else 0.0
        if is_popular(edges, edges.src[edge]):
            per_hop = POPULAR_HOP
        return float(LATE_READ * late + per_hop * far)
    if not edges.routed[edge]:
        return float(LATE * late)
    src, dst = edges.src[edge], edges.dst[edge]
    hops = array.hop[places.pe[src], places.pe[dst]]
    if array.outputs:  # the first link is free: neighbours read the output register
        hops = max(0, hops - 1)
    total = HOP * hops
    if late > 0:
        return float(total + LATE * late)
    life = places.time[dst] - places.time[src] - edges.ready[edge]
    return float(total + TIGHT * max(0, hops - life))


@inlined
def _word_cost(task: Task, places: Places, node: int) -> float:
    if task.array.moves:
        return float(_life_cost(task.edges, places, node) * (WAIT / CYCLE))
    if task.array.outputs:
        return _output_cost(task.edges, places, node)
    return _life_cost(task.edges, places, node)


@inlined
def _output_cost(edges: Edges, places: Places, node: int) -> float:
    """Of the word that `node` makes: the cycles after the first in which another PE reads it, since
    each takes an output register. Its own registers are many.
    """
    cells, first = 0, edges.sink_begin[node]
    for at in range(first, edges.sink_begin[node + 1]):
        gap = _remote_gap(edges, places, node, edges.sink_items[at])
        known = gap <= 0
        for other in range(first, at):
            known = known or _remote_gap(edges, places, node, edges.sink_items[other]) == gap
        cells += not known
    return CELL * cells


@inlined
def _remote_gap(edges: Edges, places: Places, node: int, edge: int) -> int:
    """Cycles from the result to a read on another PE; 0 on its own."""
    dst = edges.dst[edge]
    if places.pe[dst] == places.pe[node]:
        return 0
    return int(places.time[dst] - places.time[node] - edges.ready[edge])


@inlined
def _life_cost(edges: Edges, places: Places, node: int) -> float:
    """Of the word that `node` makes: the cycles until its last read."""
    life = 0
    for at in range(edges.sink_begin[node], edges.sink_begin[node + 1]):
        edge = edges.sink_items[at]
        gap = places.time[edges.dst[edge]] - places.time[node] - edges.ready[edge]
        life = max(life, gap)
    return CYCLE * life
