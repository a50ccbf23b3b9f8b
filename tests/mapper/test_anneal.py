"""What the annealer keeps account of: claims of nodes and of the moves that show words."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from tests.mapper.random_graphs import random_loop
from vividc import arch
from vividc.arch.fabric import Fabric
from vividc.mapper.bounds.bounds import all_bounds, mii
from vividc.mapper.engines.negotiate.anneal import (
    State,
    anneal,
    arriving_excess,
    new_heat,
    push,
    touch,
)
from vividc.mapper.engines.negotiate.arrays import Task, build_task
from vividc.mapper.engines.negotiate.frame import Frame
from vividc.mapper.engines.negotiate.motion import (
    LATES,
    NODES,
    STALL,
    Motion,
    begin,
    cost_all,
    edges_change,
    excess_of_all,
    exchange,
    meeting_cost,
    new_motion,
    put,
    swap,
    words_change,
    words_cost,
    words_may_change,
)
from vividc.mapper.engines.negotiate.places import (
    MET,
    Places,
    early,
    enter,
    excess,
    lie_all,
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
from vividc.mapper.resources.arrays import Ints, ints
from vividc.mapper.resources.banks import NO_MEETINGS, Meetings
from vividc.mapper.resources.dependences import dependences, earliest_starts
from vividc.mapper.resources.mrrg import build_mrrg

MOVES = 60_000


def annealed(
    name: str, seed: int, more: int, moves: int = MOVES, *, meets: bool = False
) -> tuple[MapProblem, Task, State]:
    """A state in the middle of annealing, all words shown; `meets`: some nodes that start in one
    slot meet in a bank, more of them than one number has bits for.
    """
    fabric = arch.load(name)
    assert isinstance(fabric, Fabric)
    problem = MapProblem(random_loop(seed, 44 if meets else 24, (8, 2, 0)), fabric)
    ii = mii(all_bounds(problem)) + more
    placed = [node.id for node in problem.dfg.placed]
    start = earliest_starts(placed, dependences(problem.dfg, fabric), ii)
    assert start is not None
    latest = dict.fromkeys(placed, max(start.values()) + 2 * ii)
    frame = Frame(start, latest, _meetings(placed) if meets else NO_MEETINGS)
    task, ids = build_task(problem, ii, frame, build_mrrg(fabric))
    places, words = new_places(task, seed + 1), new_words(task)
    pes = task.nodes.pe_items[task.nodes.pe_begin[:-1]]
    lie_all(task, places, pes, ints(start[number] for number in ids))
    state = State(places, words, new_motion(task, words))
    show_all(task, places, words)
    anneal(task, state, new_heat(20.0, 0.2, moves), moves)
    return problem, task, state


def _meetings(placed: list[int]) -> Meetings:
    accesses = tuple(placed[:40])
    drawn = np.random.default_rng(5).random((len(accesses), len(accesses), 3))
    return Meetings(accesses, 0.1 * drawn)


def counted_anew(task: Task, state: State) -> Places:
    fresh = new_places(task, 1)
    lie_all(task, fresh, state.places.pe, state.places.time)
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


def test_accesses_that_meet_are_those_of_one_slot() -> None:
    _, task, state = annealed("mesh-3x3", 2, 0, meets=True)
    nodes, slots = task.meets.node.tolist(), state.places.slot.tolist()
    assert len(nodes) > MET
    for slot, words in enumerate(state.places.met.tolist()):
        bits = [word >> bit & 1 for word in words for bit in range(MET)]
        met = {access for access, bit in enumerate(bits) if bit}
        assert met == {access for access, node in enumerate(nodes) if slots[node] == slot}


@pytest.mark.parametrize("moved", [(0,), (3, 35), (35, 36, 1)])
def test_a_move_costs_what_its_accesses_meet(moved: tuple[int, ...]) -> None:
    """Each pair once, by the stages between its two."""
    _, task, state = annealed("mesh-3x3", 3, 0, moves=500, meets=True)
    places, motion, meets, ii = state.places, state.motion, task.meets, task.array.ii
    begin(motion)
    for access in moved:
        node = meets.node[access]
        put(task.array, motion, node, int(places.pe[node]), int(places.time[node]))
    met = 0.0
    for first in moved:
        for other, node in enumerate(meets.node.tolist()):
            one, is_again = meets.node[first], other in moved and other < first
            if other == first or is_again or places.slot[node] != places.slot[one]:
                continue
            apart = (places.time[one] - places.time[node]) // ii
            met += meets.stalls[first, other, 1 + min(max(apart, -1), 1)]
    assert meeting_cost(task, places, motion) == pytest.approx(STALL * met)
    assert met


@pytest.mark.parametrize("name", ["openedge-3x3", "mesh-3x3"])
def test_kept_costs_are_those_of_what_lies_there(name: str) -> None:
    _, task, state = annealed(name, 4, 0)
    fresh = new_motion(task, state.words)
    cost_all(task, state.places, fresh)
    assert np.array_equal(state.motion.edge_cost, fresh.edge_cost)
    assert np.array_equal(state.motion.word_cost, fresh.word_cost)
    assert fresh.word_cost.any()
    assert state.motion.listed[LATES] == fresh.listed[LATES]
    assert np.array_equal(state.motion.late, fresh.late)


def drawn_move(task: Task, state: State, random: np.random.Generator, nodes: int) -> Motion:
    """Some nodes go to any PEs that they can be on, in their own slots or in any others."""
    motion, count = state.motion, len(task.nodes.latency)
    begin(motion)
    for node in random.choice(count, nodes, replace=False).tolist():
        pe = int(random.choice(np.flatnonzero(task.nodes.can[node])))
        time = int(state.places.time[node])
        if random.random() < 0.5:
            time = int(random.integers(task.nodes.last[node] + 1))
        put(task.array, motion, node, pe, time)
    return motion


@pytest.mark.parametrize("name", ["openedge-3x3", "adres-3x3", "mesh-3x3"])
def test_a_move_changes_costs_by_what_they_are_afterwards(name: str) -> None:
    _, task, state = annealed(name, 5, 0, moves=2000)
    places, random = state.places, np.random.default_rng(7)
    before, after = new_motion(task, state.words), new_motion(task, state.words)
    cost_all(task, places, before)
    cost_all(task, places, state.motion)
    for turn in range(60):
        motion = drawn_move(task, state, random, 1 + turn % 3)
        swap(task, places, motion)
        cost_all(task, places, after)
        change, words = edges_change(task, places, motion), 0.0
        if words_may_change(task, places, motion):
            words = words_change(task, places, motion, 0.0)
        swap(task, places, motion)
        assert change == pytest.approx(after.edge_cost.sum() - before.edge_cost.sum())
        assert words == pytest.approx(after.word_cost.sum() - before.word_cost.sum())
        assert words >= -words_cost(task, motion)


@pytest.mark.parametrize("name", ["adres-3x3", "mesh-3x3"])
def test_what_is_refused_before_it_is_made_would_be_afterwards(name: str) -> None:
    """No less is beyond capacity than is foreseen, and who is known in a slot is what making the
    move and taking it back leave.
    """
    _, task, state = annealed(name, 6, 0, moves=3000)
    places, random, foreseen = state.places, np.random.default_rng(8), 0
    for turn in range(400):
        motion = drawn_move(task, state, random, 1 + turn % 4)
        over = int(places.over[0])
        arriving = arriving_excess(task, places, motion)
        least = over - excess_of_all(task, places, motion) + arriving
        foreseen += arriving
        touched = places._replace(at=places.at.copy())
        touch(task, touched, motion)
        exchange(task, places, motion)
        assert places.over[0] >= least
        exchange(task, places, motion)
        assert places.over[0] == over
        assert np.array_equal(touched.at, places.at)
    assert foreseen


def pushed_along_paths(
    task: Task, places: Places, first: int, time: int, sign: int
) -> tuple[Ints, set[int]]:
    """Times, and who is pushed, as the longest paths from the `first` node at a time say; around
    a recurrence without end they go on for as many rounds as there are nodes.
    """
    edges, times, pushed = task.edges, places.time.copy(), {first}
    times[first] = time
    for _ in range(len(times) + 1):
        for number, (src, dst) in enumerate(zip(edges.src, edges.dst, strict=True)):
            gap = edges.shift[number]
            if edges.routed[number]:
                gap = edges.ready[number] + task.array.reach[places.pe[src], places.pe[dst]]
            one, other = (src, dst) if sign > 0 else (dst, src)
            if int(one) in pushed and sign * (times[one] - times[other]) + gap > 0:
                times[other] = times[one] + sign * gap
                pushed.add(int(other))
    return times, pushed


@pytest.mark.parametrize("sign", [1, -1])
def test_what_is_pushed_goes_as_far_as_it_must(sign: int) -> None:
    """Nothing does if one leaves the schedule or comes back to where it began."""
    _, task, state = annealed("mesh-3x3", 0, 0, moves=5000)
    places, motion, last = state.places, state.motion, task.nodes.last
    random, outcomes = np.random.default_rng(9), set()
    for turn in range(120):
        node = turn % len(last)
        end = int(last[node]) if sign > 0 else 0
        time = int(places.time[node]) + sign
        time += int(random.integers(abs(end - time) + 1)) * sign if sign * (end - time) > 0 else 0
        if sign * (end - time) < 0:
            continue
        begin(motion)
        put(task.array, motion, node, int(places.pe[node]), time)
        possible = push(task, places, motion, sign)
        times, pushed = pushed_along_paths(task, places, node, time, sign)
        assert possible == (times[node] == time and bool(np.all((times >= 0) & (times <= last))))
        outcomes.add((possible, len(pushed) > 1))
        if possible:
            assert {int(motion.nodes[at]) for at in range(motion.listed[NODES])} == pushed
            assert all(motion.time[other] == times[other] for other in pushed)
    assert outcomes >= {(True, False), (True, True), (False, True)}


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
