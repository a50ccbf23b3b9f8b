"""How time is shared out between stages."""

from __future__ import annotations

import pytest

from vividc.compiler.planning.budget import Budget
from vividc.errors import TimeLimit
from vividc.mapper.deadline import Deadline


@pytest.mark.parametrize("limit_s", [1.0, 20.0, 60.0, 600.0])
@pytest.mark.parametrize("stages", [1, 2, 5, 20])
def test_the_kernel_as_written_has_its_share_whatever_the_stages_before_it_took(
    limit_s: float, stages: int
) -> None:
    budget = Budget.of(Deadline.after(limit_s))
    for _ in range(stages):
        try:
            spent_s = budget.share(as_written=False).remaining_s
            budget.whole.charge(spent_s)
        except TimeLimit:
            break
    assert budget.share(as_written=True).remaining_s >= 0.4 * limit_s - 1e-6
    assert budget.share(as_written=True).at == pytest.approx(limit_s)


def test_a_transformed_stage_has_half_of_what_is_left_and_never_more_than_25_s() -> None:
    assert Budget.of(Deadline.after(20.0)).share(as_written=False).remaining_s == pytest.approx(
        10.0
    )
    assert Budget.of(Deadline.after(600.0)).share(as_written=False).remaining_s == pytest.approx(
        25.0
    )


def test_stages_that_come_too_late_are_not_tried() -> None:
    budget = Budget.of(Deadline.after(20.0))
    budget.whole.charge(12.5)
    with pytest.raises(TimeLimit, match="no time was left"):
        budget.share(as_written=False)
