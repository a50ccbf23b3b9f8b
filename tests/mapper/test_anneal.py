"""What the annealer keeps account of: claims of nodes and of the moves that show words."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from tests.mapper.random_graphs import random_loop
from vividc import arch
from vividc.arch.fabric import Fabric
from vividc.mapper.bounds.bounds import all_bounds, mii
from vividc.mapper.engines.negotiate.anneal import State, anneal, new_heat
from vividc.mapper.engines.negotiate.arrays import Task, build_task
from vividc.mapper.engines.negotiate.frame import Frame
from vividc.mapper.engines.negotiate.motion import LATES, cost_all, new_motion
from vividc.mapper.engines.negotiate.places import (
    Places,
    early,
    enter,
    excess,
    lie,
    new_places,
)
from vividc.mapper.engines.negotiate.traffic import OVER, new_graph, new_scratch, new_traffic
from vividc.mapper.engines.negotiate.ways import Router, route_as_shown
from vividc.mapper.engines.negotiate.words import (
    claim_again,
    clashes_of,
    hide_all,
    new_words,
    show_all,
    withdraw,
)
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.dependences import dependences, earliest_starts
from vividc.mapper.resources.mrrg import build_mrrg

MOVES = 60_000


def annealed(name: str, seed: int, more: int, moves: int = MOVES) -> tuple[MapProblem, Task, State]:
    """A state in the middle of annealing, all words shown."""
    fabric = arch.load(name)
    assert isinstance(fabric, Fabric)
    problem = MapProblem(random_loop(seed, 24, (8, 2, 0)), fabric)
    ii = mii(all_bounds(problem)) + more
    placed = [node.id for node in problem.dfg.placed]
    start = earliest_starts(placed, dependences(problem.dfg, fabric), ii)
    assert start is not None
    frame = Frame(start, dict.fromkeys(placed, max(start.values()) + 2 * ii))
    task, ids = build_task(problem, ii, frame, build_mrrg(fabric))
    places, words = new_places(task, seed + 1), new_words(task)
    for node, number in enumerate(ids):
        lie(places, ii, node, int(task.nodes.pe_items[task.nodes.pe_begin[node]]), start[number])
        enter(task.nodes, task.array, places, node, 1)
    state = State(places, words, new_motion(task, words))
    show_all(task, places, words)
    anneal(task, state, new_heat(20.0, 0.2, moves), moves)
    return problem, task, state


def counted_anew(task: Task, state: State) -> Places:
    fresh = new_places(task, 1)
    for node in range(len(task.nodes.latency)):
        lie(fresh, task.array.ii, node, state.places.pe[node], state.places.time[node])
        enter(task.nodes, task.array, fresh, node, 1)
    if task.array.moves:
        for word in range(len(state.words.size)):
            claim_again(task, fresh, state.words, word)
    return fresh


@pytest.mark.parametrize("name", ["openedge-3x3", "mesh-3x3"])
@pytest.mark.parametrize("seed", range(3))
def test_what_is_claimed_is_what_lies_there(name: str, seed: int) -> None:
    _, task, state = annealed(name, seed, 0)
    fresh = counted_anew(task, state)
    for part in ("slot", "counts", "over", "held", "stored"):
        assert np.array_equal(getattr(state.places, part), getattr(fresh, part)), part


@pytest.mark.parametrize("name", ["openedge-3x3", "mesh-3x3"])
def test_kept_costs_are_those_of_what_lies_there(name: str) -> None:
    _, task, state = annealed(name, 4, 0)
    fresh = new_motion(task, state.words)
    cost_all(task, state.places, fresh)
    assert np.array_equal(state.motion.edge_cost, fresh.edge_cost)
    assert np.array_equal(state.motion.word_cost, fresh.word_cost)
    assert fresh.word_cost.any()
    assert state.motion.listed[LATES] == fresh.listed[LATES]


@pytest.mark.parametrize("name", ["adres-3x3", "mesh-3x3"])
@pytest.mark.parametrize("seed", range(3))
def test_no_more_goes_with_nodes_than_they_have_a_part_in(name: str, seed: int) -> None:
    """What refuses a move before it is made: pairs of nodes, which may share a slot or a store."""
    _, task, state = annealed(name, seed, 0, moves=20)
    places, freed = state.places, 0
    assert places.over[0] > 0
    for pair in combinations(range(len(task.nodes.latency)), 2):
        most = sum(excess(task.nodes, task.array, places, node) for node in pair)
        before = int(places.over[0])
        for node in pair:
            enter(task.nodes, task.array, places, node, -1)
        freed += before - int(places.over[0])
        assert before - places.over[0] <= most
        for node in pair:
            enter(task.nodes, task.array, places, node, 1)
    assert freed


def test_every_claim_is_taken_back() -> None:
    _, task, state = annealed("openedge-3x3", 5, 0)
    hide_all(task, state.places, state.words)
    for node in range(len(task.nodes.latency)):
        enter(task.nodes, task.array, state.places, node, -1)
    assert not state.places.counts.any()
    assert state.places.over[0] == 0


def test_words_have_the_ways_that_were_claimed() -> None:
    """Nothing crowded by the annealer's account: nothing crowded by the router's but registers."""
    routed = 0
    for seed in range(6):
        problem, task, state = annealed("openedge-3x3", seed, 3)
        edges = range(len(task.edges.src))
        if state.places.over[0] or any(
            early(task.edges, task.array, state.places, edge) for edge in edges
        ):
            continue
        mrrg = build_mrrg(problem.fabric)
        cycles = int(task.nodes.last.max()) + int(task.edges.ahead.max(initial=0)) + 1
        traffic = new_traffic(mrrg, task, 4 * cycles)
        scratch = new_scratch(mrrg, cycles)
        router = Router(new_graph(mrrg, problem.fabric), task, state.places, traffic, scratch)
        assert route_as_shown(router, state.words) == 0
        crowded = np.flatnonzero(traffic.use > traffic.capacity) // task.array.ii
        kinds = {mrrg.resources[resource].kind for resource in crowded}
        assert not kinds & {"output", "FU"}
        assert (traffic.totals[OVER] == 0) == (not kinds)
        routed += 1
    assert routed


@pytest.mark.parametrize("seed", range(4))
def test_a_word_frees_no_more_than_it_clashes(seed: int) -> None:
    """The annealer refuses moves before it takes words away, by what these free at most."""
    _, task, state = annealed("openedge-3x3", seed, 0)
    anneal(task, state, new_heat(30.0, 29.0, 2000), 2000)
    freed_any = False
    for word in range(len(state.words.size)):
        before = int(state.places.over[0])
        most = clashes_of(task, state.places, state.words, word)
        withdraw(task, state.places, state.words, word)
        freed = before - int(state.places.over[0])
        assert 0 <= freed <= most
        freed_any = freed_any or freed > 0
    assert freed_any
