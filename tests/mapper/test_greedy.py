"""A greedy pass over straight code: what is taken back, what has no room, and both ways to run."""

from __future__ import annotations

import numpy as np
import pytest

from tests.mapper.random_graphs import random_region
from tests.mapper.tiny_fabrics import tiny_fabric
from vividc import arch
from vividc.arch.fabric import Fabric
from vividc.host import time_limit
from vividc.mapper.bounds.straight import heights_of
from vividc.mapper.check.verify import violations
from vividc.mapper.engines.greedy import Policy, Region, Schedule, schedule
from vividc.mapper.engines.greedy.board import back_to
from vividc.mapper.engines.greedy.order import place_some
from vividc.mapper.engines.greedy.placing import place
from vividc.mapper.engines.refusals import Stuck
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
