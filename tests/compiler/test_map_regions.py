"""Regions are mapped in an order, and what the first ones take must leave room for the last."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import vividc
from vividc.compiler import map_regions
from vividc.errors import MappingFailed
from vividc.mapper.engines.list_schedule import list_schedule
from vividc.mapper.mapping import Mapping
from vividc.mapper.problem import MapProblem


@vividc.kernel("void(float32[:, ::1])")
def sums(a):
    """Each row's sum, in its first element."""
    for i in range(a.shape[0]):
        total = np.float32(0.0)
        for j in range(a.shape[1]):
            total += a[i, j]
        a[i, 0] = total


def test_straight_regions_that_leave_no_room_are_scheduled_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """All of them, not only the one that found no room: those before it took it."""
    tried: list[tuple[str, bool]] = []

    def crowded(problem: MapProblem, goes_on: Callable[[], bool], *, frugal: bool) -> Mapping:
        tried.append((problem.dfg.name, frugal))
        if not frugal and len(tried) == 2:
            raise MappingFailed("no constant store has room")
        return list_schedule(problem, goes_on, frugal=frugal)

    monkeypatch.setattr(map_regions, "list_schedule", crowded)
    program = vividc.compile(sums, loops=vividc.LoopOptions(auto=False))
    assert [frugal for _, frugal in tried[:2]] == [False, False]
    again = tried[2:]
    assert all(frugal for _, frugal in again)
    assert [name for name, _ in again[:2]] == [name for name, _ in tried[:2]]
    a = np.arange(12, dtype=np.float32).reshape(3, 4)
    vividc.simulate(program, a)
    assert a[:, 0].tolist() == [6.0, 22.0, 38.0]
