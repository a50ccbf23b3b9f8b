"""What a search finds follows from its effort: the clock changes nothing but by ending it."""

from __future__ import annotations

import random
from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest
from random_graphs import random_loop

import vividc
from vividc import patient
from vividc.arch import load
from vividc.host import time_limit
from vividc.mapper import deadline, map_dfg
from vividc.mapper.deadline import Deadline, limited
from vividc.mapper.result import MapResult


def _still() -> float:
    return 0.0


def _jumping() -> Callable[[], float]:
    """A clock that leaps ahead at random, by less than the guard in sum."""
    draw, now = random.Random(1), SimpleNamespace(seconds=0.0)

    def monotonic() -> float:
        now.seconds += draw.random() * 1e-3
        return float(now.seconds)

    return monotonic


def _set_clock(monkeypatch: pytest.MonkeyPatch, clock: Callable[[], float]) -> None:
    monkeypatch.setattr(time_limit, "time", SimpleNamespace(monotonic=clock))


@pytest.mark.parametrize("name", ["vivid-tile", "openedge-4x4"])
@pytest.mark.parametrize("nodes", [14, 50])
def test_a_graph_is_mapped_alike_whatever_the_clock_and_the_threads_do(
    monkeypatch: pytest.MonkeyPatch, name: str, nodes: int
) -> None:
    dfg, fabric = random_loop(nodes, nodes), load(name)

    def found(clock: Callable[[], float], workers: int) -> MapResult:
        _set_clock(monkeypatch, clock)
        with patient(1e6):
            return map_dfg(dfg, fabric, time_limit_s=0.3, workers=workers)

    still, jumping = found(_still, 1), found(_jumping(), 2)
    assert still.mapping == jumping.mapping
    assert (still.status, still.lower_bound) == (jumping.status, jumping.lower_bound)
    assert not still.hurried
    assert not jumping.hurried


@vividc.kernel("float32(float32[::1], float32[::1])")
def dot(x, y):
    """A recurrence, a prologue and an epilogue."""
    total = np.float32(0.0)
    for i in range(len(x)):
        total += x[i] * y[i]
    return total


def test_a_kernel_has_the_same_words_whatever_the_clock_does(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    words = []
    for clock in (_still, _jumping()):
        _set_clock(monkeypatch, clock)
        with patient(1e6):
            program = vividc.compile(dot, time_limit_s=1.0)
        words.append(program.words.tobytes() + program.images.tobytes())
        assert not program.hurried
    assert words[0] == words[1]


@pytest.fixture
def late(monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """A clock that is set by hand."""
    now = SimpleNamespace(seconds=100.0)
    _set_clock(monkeypatch, lambda: float(now.seconds))
    return now


def test_the_clock_ends_a_search_and_that_is_told(late: SimpleNamespace) -> None:
    with limited(10.0) as whole:
        assert not whole.passed
        late.seconds += 10.0
        assert whole.passed
        assert whole.meter.hurried


def test_effort_ends_a_search_without_a_word(late: SimpleNamespace) -> None:
    with limited(10.0) as whole:
        whole.charge(whole.remaining_s)
        assert whole.passed
        assert not whole.meter.hurried


def test_limits_inside_a_limit_share_its_effort(late: SimpleNamespace) -> None:
    with limited(10.0) as whole:
        with limited(2.0) as part:
            part.charge(1.5)
        assert Deadline.after(1.0).at == pytest.approx(2.5)
        assert whole.remaining_s == pytest.approx(10.0 * deadline.EFFORT_SHARE - 1.5)
        with limited(1000.0) as longer:
            assert longer.remaining_s == whole.remaining_s


def test_a_result_that_the_clock_stopped_says_so(
    monkeypatch: pytest.MonkeyPatch, late: SimpleNamespace
) -> None:
    def clock() -> float:
        late.seconds += 1.0
        return float(late.seconds)

    _set_clock(monkeypatch, clock)
    result = map_dfg(random_loop(50, 50), load("openedge-4x4"), time_limit_s=3.0, workers=1)
    assert result.hurried
    assert result.to_json()["hurried"] is True
