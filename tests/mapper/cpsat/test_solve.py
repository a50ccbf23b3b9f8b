"""Place and route, the relaxations, and what each verdict may claim."""

from __future__ import annotations

import pytest
from fabrics import grid
from graphs import GraphBuilder, accumulator, chain
from random_graphs import random_loop

from vividc.machine.opcodes import Opcode
from vividc.mapper.bounds.bounds import all_bounds, mii, no_ii
from vividc.mapper.check.verify import violations
from vividc.mapper.deadline import Deadline
from vividc.mapper.engines.cpsat import (
    ScheduleOptions,
    Search,
    complete_slack,
    fixed,
    folded,
    place_and_route,
    refute_folded,
    refute_schedule,
    schedule,
    windowed,
)
from vividc.mapper.problem import MapProblem


def _search() -> Search:
    return Search(Deadline.after(30), workers=1)


def test_a_word_is_kept_by_copying_it_when_it_lives_longer_than_the_ii() -> None:
    g = GraphBuilder("long life")
    early = g.op(Opcode.ADD)
    late = early
    for _ in range(5):
        late = g.op(Opcode.ADD, late)
    g.op(Opcode.ADD, early, late)
    task = MapProblem(g.build(), grid(2, 4, registers=4, read_ports=2, write_ports=2))
    mapping = place_and_route(windowed(task, 1, 2), _search()).value
    assert mapping is not None
    assert violations(task.dfg, task.fabric, mapping) == []
    assert max(len(route) for route in mapping.routes.values()) > mapping.ii


def test_fixed_times_are_kept() -> None:
    task = MapProblem(accumulator(), grid(2, 2))
    start = schedule(task, 2, ScheduleOptions(), _search()).value
    assert start is not None
    mapping = place_and_route(fixed(task, 2, start), _search()).value
    assert mapping is not None
    assert {node: place.time for node, place in mapping.places.items()} == start


@pytest.mark.parametrize(
    ("registers", "write_ports", "verdict"),
    [(1, 2, "refuted"), (2, 1, "refuted"), (2, 2, "found"), (3, 1, "found")],
)
def test_words_that_chase_each_other_need_a_third_register_or_copies(
    registers: int, write_ports: int, verdict: str
) -> None:
    """Two words a slot, but three arcs each of which meets both others (Tucker 1975)."""
    g = GraphBuilder("arcs")
    sources = [g.op(Opcode.ADD) for _ in range(3)]
    readers = [g.op(Opcode.LIVE_OUT, source, name=f"%{source}") for source in sources]
    start = {s: s for s in sources} | {r: s + 2 for r, s in zip(readers, sources, strict=True)}
    fabric = grid(1, 1, registers=registers, read_ports=2, write_ports=write_ports)
    task = MapProblem(g.build(), fabric)
    outcome = place_and_route(fixed(task, 3, start), _search())
    assert outcome.verdict == verdict
    if outcome.value is not None:
        assert violations(task.dfg, fabric, outcome.value) == []


@pytest.mark.parametrize("seed", range(25))
def test_the_relaxations_refute_nothing_that_maps(seed: int) -> None:
    task = MapProblem(random_loop(seed, 4), grid(1, 3, max_stages=4))
    least = mii(all_bounds(task))
    if least >= no_ii(task):
        return
    for ii in (least, least + 1):
        problem = windowed(task, ii, complete_slack(task, ii))
        exact = place_and_route(problem, _search()).verdict
        relaxed = {
            refute_schedule(task, ii, _search()).verdict,
            refute_folded(folded(task, ii), _search()).verdict,
        }
        if exact == "found":
            assert relaxed == {"found"}
        if "refuted" in relaxed:
            assert exact == "refuted"


def test_the_cyclic_relaxation_refutes_without_a_horizon() -> None:
    """A word that must wait, on an array without registers or links."""
    g = GraphBuilder("wait")
    a = g.op(Opcode.ADD)
    g.op(Opcode.ADD, a, g.op(Opcode.ADD))
    task = MapProblem(g.build(), grid(1, 1, registers=0))
    assert refute_schedule(task, 4, _search()).verdict == "found"
    assert refute_folded(folded(task, 4), _search()).verdict == "refuted"


def test_no_time_is_not_a_refutation() -> None:
    task = MapProblem(chain(4), grid(1, 2))
    search = Search(Deadline.after(0))
    assert place_and_route(windowed(task, 2, 2), search).verdict == "unknown"


def test_windows_below_the_rec_mii_are_refused() -> None:
    g = GraphBuilder("loop")
    a, b = g.op(Opcode.ADD), g.op(Opcode.ADD)
    g.carry(a, b, 0, 0, distance=0)
    g.carry(b, a, 0, 0)
    with pytest.raises(ValueError, match="RecMII"):
        windowed(MapProblem(g.build(), grid(1, 2)), 1, 4)


def test_the_cyclic_problem_is_not_mistaken_for_a_mapping() -> None:
    with pytest.raises(ValueError, match="refute_folded"):
        place_and_route(folded(MapProblem(chain(2), grid(1, 2)), 2), _search())


def test_what_fails_in_the_solvers_thread_fails_in_the_callers(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def fails(*_: object) -> None:
        raise RuntimeError("Resource temporarily unavailable")

    monkeypatch.setattr("vividc.mapper.engines.cpsat.run.CpSolver.solve", fails)
    with pytest.raises(RuntimeError, match="Resource temporarily unavailable"):
        schedule(MapProblem(accumulator(), grid(2, 2)), 2, ScheduleOptions(), _search())
