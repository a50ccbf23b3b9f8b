"""More time never gives a larger II."""

from __future__ import annotations

import pytest
from random_graphs import random_loop

from vividc.arch import load
from vividc.mapper import map_dfg

_LIMITS_S = (0.3, 1.0, 3.0)


@pytest.mark.parametrize("name", ["mesh-3x3", "openedge-3x3", "openedge-4x4", "hycube-5x5"])
@pytest.mark.parametrize("nodes", [20, 45, 70])
def test_more_time_gives_no_larger_ii(name: str, nodes: int) -> None:
    dfg, fabric = random_loop(nodes, nodes), load(name)
    found = []
    for limit_s in _LIMITS_S:
        result = map_dfg(dfg, fabric, time_limit_s=limit_s, workers=1)
        found.append(10**6 if result.ii is None else result.ii)
        if result.status == "optimal":
            break
    assert found == sorted(found, reverse=True)
