"""Annealing and negotiation: what they find is legal, and large graphs are mapped by them."""

from __future__ import annotations

import pytest

from tests.mapper.random_graphs import random_loop
from vividc import arch
from vividc.dfg.ir import DFG
from vividc.mapper import map_dfg
from vividc.mapper.bounds import all_bounds, mii
from vividc.mapper.cpsat import ScheduleOptions, Search, schedule
from vividc.mapper.deadline import Deadline
from vividc.mapper.mapping import Mapping
from vividc.mapper.negotiate import Effort, negotiate
from vividc.mapper.problem import MapProblem
from vividc.mapper.verify import verify

FABRIC = arch.load("vivid-tile")
QUICK = Effort(moves=300, rounds=20, trials=3)


def negotiated(dfg: DFG, ii: int, seed: int = 1) -> Mapping | None:
    task = MapProblem(dfg, FABRIC)
    search = Search(Deadline.after(60), 1, light=True)
    start = schedule(task, ii, ScheduleOptions(slack=2 * ii, carry=False), search).value
    assert start is not None
    return negotiate(task, ii, start, seed, Deadline.after(60), QUICK)


def relaxed(dfg: DFG) -> int:
    return 2 * mii(all_bounds(MapProblem(dfg, FABRIC))) + 2


@pytest.mark.parametrize("seed", range(8))
def test_what_it_finds_is_legal(seed: int) -> None:
    dfg = random_loop(seed, 30)
    mapping = negotiated(dfg, relaxed(dfg))
    assert mapping is not None
    assert verify(dfg, FABRIC, mapping) == []


def test_words_that_wait_longer_than_an_ii_change_registers() -> None:
    """At a small II nearly every word outlives its own iteration's slot."""
    found = 0
    for seed in range(12):
        dfg = random_loop(100 + seed, 16, (8, 1, 1))
        ii = mii(all_bounds(MapProblem(dfg, FABRIC)))
        mapping = negotiated(dfg, ii)
        if mapping is None:
            continue
        assert verify(dfg, FABRIC, mapping) == []
        found += any(len(route) > ii for route in mapping.routes.values())
    assert found


def test_the_same_seed_gives_the_same_mapping() -> None:
    dfg = random_loop(3, 24)
    ii = relaxed(dfg)
    assert negotiated(dfg, ii) == negotiated(dfg, ii)


def test_no_time_gives_no_mapping() -> None:
    dfg = random_loop(3, 24)
    task = MapProblem(dfg, FABRIC)
    start = {node.id: 0 for node in dfg.placed}
    assert negotiate(task, 8, start, 1, Deadline.after(0.0), QUICK) is None


@pytest.mark.slow
def test_a_graph_of_180_operations_is_mapped() -> None:
    dfg = random_loop(5, 180, (8, 1, 1))
    result = map_dfg(dfg, FABRIC, time_limit_s=120)
    assert result.mapping is not None
    assert verify(dfg, FABRIC, result.mapping) == []
