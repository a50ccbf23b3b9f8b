"""What the table of stages says of what binds a stage."""

from __future__ import annotations

import pytest

from benchmarks.stages import binds

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
