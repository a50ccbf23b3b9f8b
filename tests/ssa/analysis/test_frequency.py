"""Estimated runs of blocks follow the trip counts."""

from __future__ import annotations

import pytest

from tests.programs import For, If, Load, Store, lower
from vividc.ssa.analysis.frequency import SINGLE_LOOP_TRIPS, expected_trips, frequencies
from vividc.ssa.flow import find_loops
from vividc.ssa.rewrite.tidy import tidy

BODY = (Load(1, 0), Store(0, 1))


def test_a_constant_loop_runs_its_iterations() -> None:
    function = tidy(lower((For(0, 0, 5, BODY),)))
    (loop,) = find_loops(function)
    trips = expected_trips(function, {})
    runs = frequencies(function, trips)
    assert trips[loop.header] == 5
    assert runs[loop.header] == pytest.approx(6)
    assert runs[loop.latches[0]] == pytest.approx(5)
    assert runs[function.blocks[0].name] == pytest.approx(1)


def test_nested_loops_multiply() -> None:
    function = tidy(lower((For(0, 0, 5, (For(1, 0, 3, BODY), Store(0, 1))),)))
    inner, outer = find_loops(function)
    runs = frequencies(function, expected_trips(function, {}))
    assert runs[inner.latches[0]] == pytest.approx(15)
    assert runs[outer.latches[0]] == pytest.approx(5)


def test_hints_are_preferred() -> None:
    function = tidy(lower((For(0, 0, 5, BODY),)))
    (loop,) = find_loops(function)
    assert expected_trips(function, {loop.header: 2.5}) == {loop.header: 2.5}


def test_branches_go_either_way() -> None:
    function = tidy(lower((If(0, 1, (Load(0, 0),), (Store(0, 1),)),)))
    runs = frequencies(function, {})
    assert set(runs.values()) <= {0.5, 1.0}


def test_branches_go_where_they_are_said_to() -> None:
    function = lower((If(0, 1, (Load(0, 0),), (Store(0, 1),)),))
    branches = [block.branch for block in function.blocks if block.branch.cond is not None]
    for target in branches[0].successors:
        runs = frequencies(function, {}, {target: 0.75})
        assert runs[target] == pytest.approx(0.75)


def test_unknown_loops_get_an_assumed_length() -> None:
    assert SINGLE_LOOP_TRIPS > 1
