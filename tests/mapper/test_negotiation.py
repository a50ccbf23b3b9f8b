"""Large graphs: smaller IIs step by step, and where a search stops."""

from __future__ import annotations

import pytest

from tests.mapper.random_graphs import random_loop
from vividc import arch
from vividc.mapper import map_dfg
from vividc.mapper.bounds.bounds import all_bounds, mii
from vividc.mapper.check.verify import verify
from vividc.mapper.deadline import Deadline
from vividc.mapper.mapping import Mapping
from vividc.mapper.problem import MapProblem
from vividc.mapper.request import EFFORT_LEVELS, EffortLevel, MapRequest, Progress
from vividc.mapper.search import negotiation
from vividc.mapper.search.attempt import map_decoupled
from vividc.mapper.search.negotiation import climb, negotiate_downward, restart_below
from vividc.mapper.search.state import OPEN, Attempt, IISearch

TILE = arch.load("vivid-tile")


def mapped(
    best: int,
    lower: int,
    effort: EffortLevel,
    found_s: float = 1.0,
    nodes: int = 4,
    tell: Progress = lambda _: None,
    part: float = 1.0,
) -> IISearch:
    request = MapRequest(None, Deadline.after(1000.0), progress=tell, effort=effort, part=part)
    made = IISearch(MapProblem(random_loop(1, nodes), TILE), request, lambda *_: OPEN, lower)
    request.deadline.charge(found_s)
    made.record(best, Attempt(mapping=Mapping(best, {}, {})))
    return made


def bound_of(nodes: int) -> int:
    return mii(all_bounds(MapProblem(random_loop(1, nodes), TILE)))


def left_s(
    best: int, lower: int, effort: EffortLevel, found_s: float = 1.0, nodes: int = 4
) -> float:
    return mapped(best, lower, effort, found_s, nodes).deadline.remaining_s


def test_fast_stops_at_the_first_good_mapping() -> None:
    assert left_s(6, 5, "fast") == 0
    assert left_s(36, 32, "fast") == 0
    assert 0 < left_s(7, 5, "fast") < left_s(7, 5, "normal")


def test_normal_goes_on_for_longer_the_more_there_is_to_gain_and_the_longer_it_took() -> None:
    assert 0 < left_s(6, 5, "normal") < left_s(7, 5, "normal") < 500
    assert left_s(7, 5, "normal", 1.0) < left_s(7, 5, "normal", 20.0) < 500


def test_thorough_goes_on_for_less_with_a_large_graph() -> None:
    assert left_s(6, 5, "thorough", nodes=60) == left_s(6, 5, "thorough", nodes=4)
    assert 0 < left_s(7, 5, "thorough", nodes=60) < left_s(7, 5, "thorough", nodes=4)


@pytest.mark.parametrize(("left_s", "is_tried"), [(0.03, False), (0.5, True)])
def test_no_negotiation_begins_that_patience_would_cut_short(left_s: float, is_tried: bool) -> None:
    """Annealing 60 nodes takes 0.06 s of effort."""
    lines: list[str] = []
    bound = bound_of(60)
    search = mapped(bound + 1, bound, "normal", nodes=60, tell=lines.append)
    search.request.deadline.charge(search.deadline.remaining_s - left_s)
    restart_below(search)
    assert any("annealing" in line for line in lines) == is_tried
    assert is_tried or (search.over and search.deadline.passed)


@pytest.mark.parametrize(("nodes", "is_tried"), [(60, True), (160, False)])
def test_a_proof_has_its_effort_whatever_patience_is_left(nodes: int, is_tried: bool) -> None:
    """But of large graphs, of which it proved nothing."""
    bound = bound_of(nodes)
    search = mapped(bound + 1, bound, "normal", nodes=nodes)
    search.request.deadline.charge(search.deadline.remaining_s)
    spent_s = search.request.deadline.meter.spent_s
    negotiate_downward(search)
    assert (search.request.deadline.meter.spent_s > spent_s) == is_tried


def test_loops_share_the_patience_of_normal_and_of_nothing_else() -> None:
    def left(effort: EffortLevel, part: float) -> float:
        return mapped(7, 5, effort, 0.01, part=part).deadline.remaining_s

    assert left("normal", 0.5) == pytest.approx(left("normal", 1.0) / 2)
    assert 0 < left("normal", 0.0) <= 0.01
    for effort in EFFORT_LEVELS:
        assert effort == "normal" or left(effort, 0.5) == left(effort, 1.0)
    assert left("fast", 1.0) < left("normal", 1.0) < left("thorough", 1.0) < left("prove", 1.0)


@pytest.mark.parametrize(
    ("far_below", "tried"), [(0, [25, 26, 28, 32]), (24, [25, 26, 28, 32]), (32, [26, 32])]
)
def test_what_is_far_from_a_mapping_is_left_behind_in_longer_steps(
    monkeypatch: pytest.MonkeyPatch, far_below: int, tried: list[int]
) -> None:
    """From a bound of 24, where IIs below one are far and 30 is the first to map."""
    iis: list[int] = []

    def attempt(_problem: MapProblem, ii: int, *_: object) -> Attempt:
        iis.append(ii)
        found = Mapping(ii, {}, {}) if ii >= 30 else None
        return Attempt(mapping=found, is_far=ii < far_below)

    monkeypatch.setattr(negotiation, "map_negotiated", attempt)
    request = MapRequest(None, Deadline.after(1000.0))
    problem = MapProblem(random_loop(1, 4), TILE)
    search = IISearch(problem, request, lambda *_: OPEN, 24, far=min(far_below, 25) - 1)
    climb(search, 100)
    assert iis == tried


def test_prove_goes_on_to_the_deadline() -> None:
    assert left_s(6, 5, "prove") == pytest.approx(999.0)


def test_a_mapping_no_better_than_the_incumbent_is_dropped() -> None:
    search = mapped(6, 5, "prove")
    search.record(8, Attempt(mapping=Mapping(8, {}, {})))
    assert search.incumbent is not None
    assert search.incumbent.ii == 6


def test_what_is_found_is_told_with_ever_smaller_iis() -> None:
    lines: list[str] = []
    dfg = random_loop(21, 60, (8, 2, 1))
    result = map_dfg(dfg, TILE, time_limit_s=60, effort="normal", workers=1, progress=lines.append)
    assert result.mapping is not None
    assert verify(dfg, TILE, result.mapping) == []
    mapped = [int(line.split()[1][:-1]) for line in lines if line.endswith("mapped")]
    assert mapped == sorted(mapped, reverse=True)
    assert mapped[-1] == result.ii


def test_many_tries_of_an_ii_do_not_overflow_the_budget() -> None:
    problem = MapProblem(random_loop(1, 4), TILE)
    request = MapRequest(None, Deadline.after(20.0), 1)
    attempt = map_decoupled(problem, 4, request, request.deadline, tries=9)
    assert attempt.mapping is not None


def test_an_ii_far_above_the_bound_of_a_small_graph() -> None:
    """Constraints over hundreds of slots found nothing in time."""
    result = map_dfg(random_loop(3, 18), TILE, ii=300, time_limit_s=20, workers=1)
    assert (result.status, result.ii) == ("feasible", 300)


def test_one_ii_of_a_large_graph() -> None:
    dfg = random_loop(21, 60, (8, 2, 1))
    result = map_dfg(dfg, TILE, ii=30, time_limit_s=60, workers=1)
    assert result.ii == 30
    assert result.mapping is not None
    assert verify(dfg, TILE, result.mapping) == []
