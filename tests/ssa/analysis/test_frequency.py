"""Estimated runs of blocks follow the trip counts."""

from __future__ import annotations

import pytest

from tests.programs import For, If, Load, Store, lower
from vividc.ssa.analysis.frequency import SINGLE_LOOP_TRIPS, expected_trips, frequencies
from vividc.ssa.flow import find_loops
from vividc.ssa.rewrite.tidy import tidy
from vividc.ssa.text import parse

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


SIZES = """
function "f"
param "a" float32[2]
param "b" float32[2]
param "n" int32
b0:
  %0 i32 = smax $"a.shape0", 0x00000002
  %1 i32 = smax $"b.shape0", 0x00000002
  {test}
  branch %9 b1 else b2
b1:
  jump b3
b2:
  jump b3
b3:
  return
"""


@pytest.mark.parametrize(
    ("test", "runs"),
    [
        ("%9 pred = icmp.eq %0, %1", 0.995),
        ("%9 pred = icmp.ne %0, %1", 0.005),
        ('%9 pred = icmp.eq %0, $"n"', 0.5),
        ("%9 pred = icmp.eq %0, 0x00000002", 0.5),
        ("%9 pred = icmp.slt %0, %1", 0.5),
        ("%2 pred = icmp.eq %0, %1\n  %3 pred = icmp.eq %1, %0\n  %9 pred = and %2, %3", 0.990),
        (
            "%2 pred = icmp.eq %0, %1\n  %3 pred = icmp.slt %1, %0\n"
            "  %9 pred = select %2, 0x00000000, %3",
            0.0025,
        ),
        ("%2 pred = icmp.ne %0, %1\n  %3 pred = icmp.slt %1, %0\n  %9 pred = and %2, %3", 0.0025),
        ("%2 pred = icmp.ne %0, %1\n  %3 pred = icmp.ne %1, %0\n  %9 pred = or %2, %3", 0.010),
    ],
)
def test_sizes_that_are_compared_agree(test: str, runs: float) -> None:
    function = parse(SIZES.format(test=test))
    assert frequencies(function, {})["b1"] == pytest.approx(runs, abs=1e-4)


def test_unknown_loops_get_an_assumed_length() -> None:
    assert SINGLE_LOOP_TRIPS > 1
