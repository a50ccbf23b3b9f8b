"""Who uses which resource in which slot, and what one more word would pay: compiled functions.

Prices follow PathFinder (McMurchie and Ebeling 1995): a base, a history of crowding, and a pressure
on present crowding.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from vividc.arch.fabric import Fabric
from vividc.mapper.engines.negotiate.arrays import Task
from vividc.mapper.engines.negotiate.compiled import compiled, inlined
from vividc.mapper.resources.arrays import Bytes, Bytes2, Floats, Floats2, Ints, Ints2, Ints3
from vividc.mapper.resources.mrrg import MRRG, Kind

_BASE: Final[dict[Kind, float]] = {
    "link": 1.0,
    "registers": 0.25,
    "read ports": 0.15,
    "write ports": 0.15,
    "output": 0.6,
    "FU": 0.4,
}
_FIRST_PRESSURE: Final = 0.6

PRESSURE, OVER, WIRE = 0, 1, 2
"""Positions in `Traffic.totals`: pressure of crowding; uses beyond capacity; sum of base prices."""


class Graph(NamedTuple):
    """The MRRG's arrays; `away`: cycles from a location to a PE; `renew`: by register file the
    location through which a word comes that is to change registers, `FREELY`: through none, or
    `NEVER`. Output registers are the locations `outs` .. `files` - 1.
    """

    outs: int
    files: int
    owner: Ints
    occupies: Ints
    entering: Ints
    leaving: Ints
    keeps: Bytes
    aside: Bytes
    fresh: Ints
    away: Ints2
    renew: Ints
    entry_begin: Ints
    entry_items: Ints
    move_begin: Ints
    move_items: Ints
    reader_begin: Ints
    reader_items: Ints
    side_begin: Ints
    side_items: Ints


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
        MRRG nodes used, int64 (producers, 6 * room).
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
    size: Ints2
    cell: Ints3
    claim: Ints2
    cut: Ints3
    end: Ints


class Scratch(NamedTuple):
    """Work space of a search, by cycle since the result and location. `mark`: bits `IN_TREE`,
    `READ` (its leaving port is claimed); all 0 between searches. `barred`: 1 where a word must not
    come to a location.
    """

    cost: Floats2
    before: Ints2
    mark: Bytes2
    barred: Bytes2


DIRECT, LOST = -1, -2
FREELY, NEVER = -1, -2
IN_TREE, READ = 1, 2


def new_graph(mrrg: MRRG, fabric: Fabric) -> Graph:
    """Take an MRRG apart."""
    lists = (mrrg.entries, mrrg.moves, mrrg.readers, mrrg.sides)
    rows = [part for r in lists for part in (r.begin, r.items)]
    renew = np.full(mrrg.locations, FREELY, dtype=np.int64)
    for location in range(mrrg.links, mrrg.locations):
        if mrrg.aside[location]:
            fresh = mrrg.fresh[mrrg.owner[location]]
            renew[location] = fresh if fabric.routing.moves else NEVER
    files = mrrg.locations - sum(spot.kind == "reg" for spot in mrrg.spots)
    return Graph(
        mrrg.links,
        files,
        mrrg.owner,
        mrrg.occupies,
        mrrg.entering,
        mrrg.leaving,
        mrrg.keeps,
        mrrg.aside,
        mrrg.fresh,
        mrrg.away,
        renew,
        *rows,
    )


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
        claim=np.zeros((producers, 6 * room), dtype=np.int64),
        cut=np.zeros((producers, room, 2), dtype=np.int64),
        end=np.full(len(task.edges.src), LOST, dtype=np.int64),
    )


def new_scratch(mrrg: MRRG, cycles: int) -> Scratch:
    """For words that live `cycles` at most."""
    shape = (cycles + 1, mrrg.locations)
    marks = [np.zeros(shape, dtype=np.uint8) for _ in range(2)]
    return Scratch(np.zeros(shape), np.zeros(shape, dtype=np.int64), *marks)


@inlined
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


@inlined
def _use(traffic: Traffic, ii: int, node: int, by: int) -> None:
    old = traffic.use[node]
    traffic.use[node] = old + by
    room = traffic.capacity[node]
    traffic.totals[1] += max(0, old + by - room) - max(0, old - room)
    traffic.totals[2] += traffic.base[node // ii] * by
    reprice(traffic, ii, node)


@inlined
def claim(traffic: Traffic, ii: int, producer: int, resource: int, time: int) -> None:
    node = resource * ii + time % ii
    traffic.claim[producer, traffic.size[producer, 1]] = node
    traffic.size[producer, 1] += 1
    _use(traffic, ii, node, 1)


@inlined
def count_claims(traffic: Traffic, ii: int, producer: int, by: int) -> None:
    """Enter (1) or withdraw (-1) all claims on record for a word."""
    for at in range(traffic.size[producer, 1]):
        _use(traffic, ii, traffic.claim[producer, at], by)


@inlined
def rip_up(traffic: Traffic, ii: int, producer: int) -> None:
    """Forget the ways of a word."""
    count_claims(traffic, ii, producer, -1)
    for part in range(3):
        traffic.size[producer, part] = 0


@inlined
def crowds(traffic: Traffic, producer: int) -> bool:
    """Whether the word uses anything that is used beyond its capacity."""
    for at in range(traffic.size[producer, 1]):
        node = traffic.claim[producer, at]
        if traffic.use[node] > traffic.capacity[node]:
            return True
    return False


@compiled
def raise_prices(traffic: Traffic, ii: int, history: float, growth: float, most: float) -> None:
    """After a round: what is crowded now stays dear, and crowding costs more."""
    for node in range(len(traffic.use)):
        over = traffic.use[node] - traffic.capacity[node]
        if over > 0:
            traffic.history[node] += history * over
    traffic.totals[0] = min(traffic.totals[0] * growth, most)
    reprice_all(traffic, ii)
