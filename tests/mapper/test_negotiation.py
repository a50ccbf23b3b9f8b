"""Large graphs: smaller IIs step by step, and where a search stops."""

from __future__ import annotations

import pytest

from tests.mapper.random_graphs import random_loop
from vividc import arch
from vividc.mapper import map_dfg
from vividc.mapper.check.verify import verify
from vividc.mapper.deadline import Deadline
from vividc.mapper.mapping import Mapping
from vividc.mapper.problem import MapProblem
from vividc.mapper.request import EffortLevel, MapRequest
from vividc.mapper.search.attempt import map_decoupled
from vividc.mapper.search.state import OPEN, Attempt, IISearch

TILE = arch.load("vivid-tile")


def mapped(best: int, lower: int, effort: EffortLevel, found_s: float = 1.0) -> IISearch:
    request = MapRequest(None, Deadline.after(1000.0), effort=effort)
    made = IISearch(MapProblem(random_loop(1, 4), TILE), request, lambda *_: OPEN, lower)
    request.deadline.charge(found_s)
    made.record(best, Attempt(mapping=Mapping(best, {}, {})))
    return made


def left_s(best: int, lower: int, effort: EffortLevel, found_s: float = 1.0) -> float:
    return mapped(best, lower, effort, found_s).deadline.remaining_s


def test_fast_stops_at_the_first_good_mapping() -> None:
    assert left_s(6, 5, "fast") == 0
    assert left_s(36, 32, "fast") == 0
    assert 0 < left_s(7, 5, "fast") < left_s(7, 5, "normal")


def test_normal_goes_on_for_longer_the_more_there_is_to_gain_and_the_longer_it_took() -> None:
    assert 0 < left_s(6, 5, "normal") < left_s(7, 5, "normal") < 500
    assert left_s(7, 5, "normal", 1.0) < left_s(7, 5, "normal", 5.0) < 500


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
