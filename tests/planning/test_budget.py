"""How time is shared out between stages."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from vividc import time_limit
from vividc.errors import TimeLimit
from vividc.planning.budget import Budget


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """Time that passes only when told."""
    now = SimpleNamespace(seconds=100.0)
    monkeypatch.setattr(time_limit, "now", lambda: now.seconds)
    return now


@pytest.mark.parametrize("limit_s", [1.0, 20.0, 60.0, 600.0])
@pytest.mark.parametrize("stages", [1, 2, 5, 20])
def test_the_kernel_as_written_has_its_share_whatever_the_stages_before_it_took(
    clock: SimpleNamespace, limit_s: float, stages: int
) -> None:
    budget = Budget.of(limit_s)
    for _ in range(stages):
        try:
            clock.seconds += budget.share_s(as_written=False)
        except TimeLimit:
            break
    left_s = budget.share_s(as_written=True)
    assert left_s >= 0.4 * limit_s - 1e-6
    assert clock.seconds + left_s == pytest.approx(100.0 + limit_s)


def test_a_transformed_stage_has_half_of_what_is_left_and_never_more_than_25_s(
    clock: SimpleNamespace,
) -> None:
    assert Budget.of(20.0).share_s(as_written=False) == pytest.approx(10.0)
    assert Budget.of(600.0).share_s(as_written=False) == pytest.approx(25.0)


def test_stages_that_come_too_late_are_not_tried(clock: SimpleNamespace) -> None:
    budget = Budget.of(20.0)
    clock.seconds += 12.5
    with pytest.raises(TimeLimit, match="no time was left"):
        budget.share_s(as_written=False)
