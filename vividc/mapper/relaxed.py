"""Large loops: first some mapping at an II with room to spare, then smaller IIs for a while."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping as ReadOnly

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG
from vividc.mapper.api import map_dfg
from vividc.mapper.bounds import all_bounds, mii
from vividc.mapper.mapping import MapResult
from vividc.mapper.problem import ConstantKey, MapProblem
from vividc.mapper.request import Progress

LARGE = 64
"""Operations from which the least II may take long to map."""

_ROOM = 1.12
_FIRST_SHARE = 0.35
_WORTH_TRYING_S = 0.5
_TIGHTER_LEAST_S = 4.0
_TIGHTER_FACTOR = 3.0
"""A smaller II may take so much longer than the relaxed one."""


def map_relaxed_first(
    dfg: DFG,
    fabric: Fabric,
    mapper: str,
    time_limit_s: float,
    resident: ReadOnly[int, frozenset[ConstantKey]],
    progress: Progress | None,
) -> MapResult:
    """`map_dfg`, which for a large graph gives up the least II before it gives up a mapping.

    Parameters are those of `map_dfg`. A graph with `LARGE` operations or more is mapped at an II
    about an eighth above its MII first.
    """
    deadline = time.monotonic() + time_limit_s

    def attempt(ii: int | None, limit_s: float) -> MapResult:
        return map_dfg(
            dfg,
            fabric,
            mapper,
            ii,
            max(limit_s, _WORTH_TRYING_S),
            resident=resident,
            progress=progress,
        )

    if len(dfg.operations) < LARGE:
        return attempt(None, time_limit_s)
    least = mii(all_bounds(MapProblem(dfg, fabric, {}, resident)))
    relaxed = math.ceil(least * _ROOM)
    if relaxed >= fabric.controller.contexts or relaxed == least:
        return attempt(None, time_limit_s)
    best = attempt(relaxed, _FIRST_SHARE * time_limit_s)
    if best.mapping is None:
        return attempt(None, deadline - time.monotonic())
    patience_s = max(_TIGHTER_LEAST_S, _TIGHTER_FACTOR * best.wall_s)
    for ii in range(relaxed - 1, least - 1, -1):
        left_s = min(deadline - time.monotonic(), patience_s)
        if left_s < _WORTH_TRYING_S:
            break
        tighter = attempt(ii, left_s)
        if tighter.mapping is None:
            break
        best = tighter
    return best
