"""What the table of stages says of what binds a stage."""

from __future__ import annotations

import pytest

from benchmarks.stages import binds, side_by_side
from tests.render.array.jobs import job_stats

_WAITS = {"transfers": 0.1, "programs": 0.05, "banks": 0.2, "idle": 0.15}


@pytest.mark.parametrize(
    ("used", "said"),
    [
        ({"DRAM": 0.9, "NoC": 0.8, "FUs": 0.3}, "DRAM"),
        ({"DRAM": 0.4, "NoC": 0.3, "FUs": 0.5}, "FUs"),
        ({"DRAM": 0.4, "NoC": 0.45, "FUs": 0.4}, "NoC, banks"),
        ({"DRAM": 0.1, "NoC": 0.1, "FUs": 0.2}, "FUs, own code"),
    ],
)
def test_a_stage_below_half_has_a_reason(used: dict[str, float], said: str) -> None:
    assert binds(used, _WAITS) == said


def test_stages_side_by_side_take_what_is_busy_longest() -> None:
    moving = job_stats(100, tiles=2, dram=100, noc=60, dma=120)
    computing = job_stats(300, tiles=2, dram=20, noc=70, configuration=30, idle=30)
    # DRAM is busy for 120 cycles, tiles for 40 and 270.
    assert side_by_side([moving, computing]) == pytest.approx(400 / 310)
    assert side_by_side([moving]) == pytest.approx(1.0)
