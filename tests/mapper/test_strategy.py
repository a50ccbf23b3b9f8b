"""Strategies as rows: which steps try an II, and which phases walk over IIs."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.mapper.random_graphs import random_loop
from vividc import arch
from vividc.mapper.deadline import Deadline
from vividc.mapper.mapping import Mapping
from vividc.mapper.problem import MapProblem
from vividc.mapper.request import MapRequest
from vividc.mapper.search.state import OPEN, Attempt, IISearch, TryII
from vividc.mapper.search.strategy import Phase, Step, Strategy, run

SMALL = MapProblem(random_loop(3, 12), arch.load("mesh-4x4"))
LARGE = MapProblem(random_loop(3, 60), arch.load("mesh-4x4"))


def request(ii: int | None = None, *, extended: bool = False) -> MapRequest:
    extend = (lambda _: None) if extended else None
    return MapRequest(ii, Deadline.after(100.0), 1, extend=extend)


def named(name: str, names: list[str], attempt: Attempt = OPEN) -> TryII:
    """A step that only leaves its name."""

    def step(_: MapProblem, ii: int, *__: object) -> Attempt:
        names.append(name)
        return replace(attempt, mapping=attempt.mapping and replace(attempt.mapping, ii=ii))

    return step


def tried(*steps: Step, extended: bool = False) -> Attempt:
    asked = request(extended=extended)
    return Strategy("rows", steps, (), ()).try_ii(SMALL, 5, asked, asked.deadline, 0)


@pytest.mark.parametrize(
    "decided", [Attempt(mapping=Mapping(1, {}, {})), Attempt(refuted_by="a test")]
)
def test_steps_follow_each_other_until_one_decides(decided: Attempt) -> None:
    names: list[str] = []
    steps = [Step(named("a", names)), Step(named("b", names, decided)), Step(named("c", names))]
    assert tried(*steps).decided
    assert names == ["a", "b"]


def test_a_step_that_knows_no_constraints_is_left_out_where_there_are_some() -> None:
    for extended, expected in ((False, ["a", "b"]), (True, ["b"])):
        names: list[str] = []
        tried(Step(named("a", names), extended=False), Step(named("b", names)), extended=extended)
        assert names == expected


def test_a_step_has_its_share_of_the_time_that_is_left() -> None:
    seconds: list[float] = []

    def step(_: MapProblem, __: int, ___: MapRequest, deadline: Deadline, *____: object) -> Attempt:
        seconds.append(deadline.remaining_s)
        deadline.charge(10.0)
        return OPEN

    tried(Step(step, 0.5), Step(step, 0.5), Step(step))
    assert seconds == pytest.approx([50.0, 45.0, 80.0])


def walk(problem: MapProblem, asked: MapRequest) -> list[str]:
    """The phases of a strategy that has one of each kind, with a mapping after the first two."""
    names: list[str] = []

    def phase(name: str, ii: int = 0, **columns: object) -> Phase:
        def leave(search: IISearch) -> None:
            names.append(name)
            if ii:
                search.record(ii, Attempt(mapping=Mapping(ii, {}, {})))

        return Phase(leave, **columns)  # type: ignore[arg-type]

    phases = (
        phase("small", graphs="small"),
        phase("large", graphs="large"),
        phase("not extended", extended=False),
        phase("unmapped", 300, unless_mapped=True),
        phase("unmapped again", unless_mapped=True),
        phase("always"),
    )
    run(Strategy("rows", (), phases, (phase("only"),)), problem, asked)
    return names


def test_phases_are_those_of_the_graphs_size() -> None:
    assert walk(SMALL, request()) == ["small", "not extended", "unmapped", "always"]
    assert walk(LARGE, request()) == ["large", "not extended", "unmapped", "always"]


def test_a_phase_that_knows_no_constraints_is_left_out_where_there_are_some() -> None:
    assert walk(SMALL, request(extended=True)) == ["small", "unmapped", "always"]


def test_one_ii_has_phases_of_its_own() -> None:
    assert walk(SMALL, request(200)) == ["only"]


def test_an_ii_that_a_bound_refutes_has_no_phases() -> None:
    contexts = SMALL.fabric.controller.contexts
    assert walk(LARGE, request(1)) == []
    assert walk(SMALL, request(contexts + 1)) == []
