"""A greedy pass over straight code: what is taken back, what has no room, and both ways to run."""

from __future__ import annotations

import random
from itertools import pairwise

import numpy as np
import pytest

from tests.mapper.random_graphs import random_region
from tests.mapper.tiny_fabrics import tiny_fabric
from vividc import arch
from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG, Edge, EdgeKind, Node
from vividc.errors import MappingFailed
from vividc.host import time_limit
from vividc.machine.opcodes import ORDER, Opcode
from vividc.mapper.bounds.straight import heights_of
from vividc.mapper.check.verify import violations
from vividc.mapper.engines.greedy import Policy, Region, Schedule, schedule
from vividc.mapper.engines.greedy.board import NONE, PARKED, back_to
from vividc.mapper.engines.greedy.order import place_some
from vividc.mapper.engines.greedy.placing import place
from vividc.mapper.engines.list_schedule import list_schedule
from vividc.mapper.engines.refusals import Stuck
from vividc.mapper.mapping import Place
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.banks import NO_MEETS

PLAIN = Policy({}, 0.6, deep=False, affinity=2, constants=1, spared=0, apart=2)
CROWDED = Policy({}, 0.0, deep=True, affinity=0, constants=8, spared=12, apart=4)


def tile(name: str = "vivid-tile") -> Fabric:
    fabric = arch.load(name)
    assert isinstance(fabric, Fabric)
    return fabric


def region(seed: int, nodes: int, fabric: Fabric) -> Region:
    problem = MapProblem(random_region(seed, nodes), fabric)
    return Region(problem, heights_of(problem), NO_MEETS)


@pytest.mark.parametrize("policy", [PLAIN, CROWDED], ids=["plain", "crowded"])
@pytest.mark.parametrize("seed", range(3))
def test_machine_code_does_what_python_does(
    monkeypatch: pytest.MonkeyPatch, seed: int, policy: Policy
) -> None:
    one = region(seed, 14, tile())
    native, interpreted = Schedule(one, policy), Schedule(one, policy)
    length = native.run()
    monkeypatch.setattr(schedule, "place_some", place_some.py_func)  # type: ignore[attr-defined]
    assert interpreted.run() == length
    assert interpreted.mapping() == native.mapping()
    assert np.array_equal(interpreted.job.board.cells, native.job.board.cells)
    assert np.array_equal(interpreted.job.tried, native.job.tried)


@pytest.mark.parametrize("seed", range(3))
def test_what_is_taken_back_leaves_nothing(seed: int) -> None:
    one = region(seed, 14, tile("torus-4x4"))
    job = Schedule(one, PLAIN).job
    for node in range(len(one.nodes)):  # producers have lower numbers
        before = job.board.cells.copy()
        assert place(job, node)
        placed = job.board.cells.copy()
        assert not np.array_equal(placed, before)
        back_to(job.board, 0)
        assert np.array_equal(job.board.cells, before)
        assert place(job, node)
        assert np.array_equal(job.board.cells, placed)


@pytest.mark.parametrize(("cycles", "spots"), [(0, 2000), (500, 4), (0, 4)])
def test_room_that_does_not_do_is_made(cycles: int, spots: int) -> None:
    one, small = region(5, 40, tile()), region(5, 40, tile())
    small.cycles, small.spots = small.most + cycles, spots
    wide, grown = Schedule(one, PLAIN), Schedule(small, PLAIN)
    assert grown.run() == wide.run()
    assert grown.mapping() == wide.mapping()
    assert (small.cycles > small.most + cycles) == (cycles == 0)
    assert (small.spots > spots) == (spots == 4)


@pytest.mark.parametrize("policy", [PLAIN, CROWDED], ids=["plain", "crowded"])
@pytest.mark.parametrize("name", ["vivid-tile", "torus-4x4", "vivid-tile-unit"])
@pytest.mark.parametrize("seed", range(3))
def test_each_pass_is_legal(name: str, seed: int, policy: Policy) -> None:
    fabric = tile(name)
    one = region(seed, 60, fabric)
    found = Schedule(one, policy)
    assert found.run() is not None
    assert violations(one.problem.dfg, fabric, found.mapping(), straight=True) == []


def decided(seed: int, fabric: Fabric) -> tuple[MapProblem, dict[int, dict[int, float]]]:
    """A region of which much is decided: homes of variables, what stores hold, who meets whom."""
    rng, pes = random.Random(seed), range(len(fabric.pes))
    dfg = random_region(seed, 40, reach=(3, 8, 25)[seed % 3])
    named = {Opcode.CONST: Opcode.LIVE_IN, Opcode.LIVE_OUT: Opcode.LIVE_OUT}
    nodes = tuple(
        Node(node.id, named[node.op], name=f"%v{rng.randrange(5)}")
        if node.op in named and rng.random() < 0.5
        else node
        for node in dfg.nodes
    )
    outs = [node.id for node in nodes if node.op is Opcode.LIVE_OUT]
    homes = {node: frozenset({rng.choice(pes)}) for node in outs}
    held = {pe: frozenset(("const", rng.randrange(12)) for _ in range(5)) for pe in pes}
    accesses = [node.id for node in nodes if node.is_memory]
    meets = {a: {b: rng.random() for b in accesses if b != a} for a in accesses[::2]}
    return MapProblem(DFG("region", nodes, dfg.edges), fabric, homes, held), meets


@pytest.mark.parametrize("frugal", [False, True], ids=["", "frugal"])
@pytest.mark.parametrize("name", ["vivid-tile", "torus-4x4", "small"])
@pytest.mark.parametrize("seed", range(6))
def test_what_is_decided_is_kept_to(name: str, seed: int, frugal: bool) -> None:
    fabric = tiny_fabric(3, 3, registers=6, constants=20) if name == "small" else tile(name)
    problem, meets = decided(seed, fabric)
    mapping = list_schedule(problem, frugal=frugal, meets=meets)
    faults = violations(
        problem.dfg,
        fabric,
        mapping,
        allowed=problem.allowed,
        resident=problem.resident,
        straight=True,
    )
    assert faults == []
    assert list_schedule(problem, frugal=frugal, meets=meets) == mapping


def test_words_that_have_no_room_stop_the_pass_at_their_node() -> None:
    """The same node with the same reason, however much room the pass had."""
    fabric = tiny_fabric(1, 2, registers=2)
    refused = []
    for spots in (4, 4000):
        one = region(2, 30, fabric)
        one.spots = spots
        with pytest.raises(Stuck) as stuck:
            Schedule(one, PLAIN).run()
        refused.append((stuck.value.node.id, stuck.value.reason))
    assert refused[0] == refused[1]
    assert refused[0][1] == "all 4 registers hold words that are still needed"


def test_the_clock_is_looked_at_within_a_pass(monkeypatch: pytest.MonkeyPatch) -> None:
    looks = []
    monkeypatch.setattr(time_limit, "step", looks.append)
    one = Schedule(region(7, 400, tile()), PLAIN)
    one.run()
    assert len(looks) > 2


def test_no_word_is_parked_when_all_are_read() -> None:
    one = Schedule(region(3, 80, tile()), PLAIN)
    one.run()
    board = one.job.board
    parked = board.cells[board.begin.parked : board.begin.parked + board.places]
    assert not (parked != NONE).any()
    assert board.cells[board.begin.numbers + PARKED] == 0


def test_stores_are_filled_and_not_beyond() -> None:
    def numbers(count: int) -> MapProblem:
        nodes = [Node(at, Opcode.CONST, const=at) for at in range(count)]
        nodes += [Node(count + at, Opcode.MOV) for at in range(count)]
        edges = tuple(Edge(at, count + at, 0) for at in range(count))
        return MapProblem(DFG("numbers", tuple(nodes), edges), tiny_fabric(1, 2, constants=2))

    problem = numbers(4)
    assert violations(problem.dfg, problem.fabric, list_schedule(problem), straight=True) == []
    with pytest.raises(
        MappingFailed, match="no constant store of a PE that could take it has room"
    ):
        list_schedule(numbers(5))


def test_a_variable_is_not_read_where_it_was_written_before() -> None:
    """What follows a write has it come early; by then its PE has had no slot for the reader."""
    chain = [Node(at, Opcode.MOV) for at in range(2, 14)]
    here, there = [2, 3, 4, 5], list(range(6, 14))
    nodes = (
        Node(0, Opcode.LIVE_IN, name="%x"),
        Node(1, Opcode.LIVE_OUT, name="%x"),
        *chain,
        Node(14, Opcode.MOV),
    )
    pairs = [*pairwise(here), *pairwise(there)]
    edges = (
        Edge(2, 1, 0),
        Edge(1, 5, ORDER, kind=EdgeKind.ORDER),
        Edge(0, 14, 0),
        *(Edge(src, dst, 0) for src, dst in pairs),
    )
    homes = {1: frozenset({0})}
    homes |= {at: frozenset({0}) for at in here} | {at: frozenset({1}) for at in there}
    problem = MapProblem(DFG("late", nodes, edges), tiny_fabric(1, 2), homes)
    found = Schedule(Region(problem, heights_of(problem), NO_MEETS), PLAIN)
    found.run()
    mapping = found.mapping()
    assert violations(problem.dfg, problem.fabric, mapping, allowed=homes, straight=True) == []
    assert mapping.places[14] == Place(1, 8)
