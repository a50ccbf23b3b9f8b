"""Estimated runs of blocks follow the trip counts."""

from __future__ import annotations

from random import Random

import numpy as np
import pytest

from tests.programs import For, If, Load, Store, lower
from vividc.ssa.analysis.frequency import (
    SINGLE_LOOP_TRIPS,
    expected_trips,
    frequencies,
    runs_of,
)
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


def test_exceptions_are_raised_seldom() -> None:
    """A check in a loop does not end it after the iterations that its other way out would have."""
    function = parse("""
function "f"
param "n" int32
local "raise.ValueError.x" words 0
b0:
  jump b1
b1:
  %0 i32 = phi [b0: 0x0, b3: %1]
  %2 pred = icmp.slt %0, $"n"
  branch %2 b2 else b4
b2:
  %3 pred = icmp.eq %0, $"n"
  branch %3 b5 else b3
b3:
  %1 i32 = add %0, 0x1 exact
  jump b1
b5:
  %4 none = store 0x0, 0x7ffffffc, 0x0 array "raise.ValueError.x"
  return
b4:
  return
""")
    runs = frequencies(function, {"b1": 100.0})
    assert runs["b3"] == pytest.approx(100.0, rel=1e-3)
    assert runs["b5"] < 1e-3


def test_unknown_loops_get_an_assumed_length() -> None:
    assert SINGLE_LOOP_TRIPS > 1


def _shares(random: Random, size: int) -> dict[str, dict[str, float]]:
    """How often blocks go to any others, themselves among them, and to none."""
    names = [f"b{number}" for number in range(size)]
    shares: dict[str, dict[str, float]] = {}
    for name in names:
        targets = random.sample(names, min(size, random.choice((0, 1, 1, 2))))
        given = [random.uniform(0.1, 1.0) for _ in targets]
        whole = sum(given) / random.choice((1.0, 0.9))
        shares[name] = {t: g / whole for t, g in zip(targets, given, strict=True)}
    return shares


def test_blocks_run_as_often_as_others_go_to_them() -> None:
    random = Random(3)
    ended = 0
    for _ in range(300):
        shares = _shares(random, random.randint(1, 12))
        names = list(shares)
        flow = np.eye(len(names))
        for name, targets in shares.items():
            for target, share in targets.items():
                flow[names.index(target), names.index(name)] -= share
        if np.linalg.cond(flow) > 1e6:
            continue
        expected = np.linalg.solve(flow, np.eye(len(names))[0])
        assert list(runs_of(shares).values()) == pytest.approx(list(expected), rel=1e-9, abs=1e-9)
        ended += 1
    assert ended > 150


def test_blocks_are_all_1_where_a_loop_has_no_end() -> None:
    assert runs_of({"a": {"b": 1.0}, "b": {"c": 1.0}, "c": {"b": 1.0}}) == {
        "a": 1.0,
        "b": 1.0,
        "c": 1.0,
    }
    assert runs_of({"a": {"a": 1.0}}) == {"a": 1.0}
