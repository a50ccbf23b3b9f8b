"""Loops whose iterations are worth running side by side, if they prove to be independent.

A loop inside them waits: it has no fixed length, so that nothing else shortens it (sphere tracing,
Mandelbrot), or leaves most slots of the PEs empty, because a recurrence binds it or because it ends
before it fills them.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator

from vividc.compiler.planning.estimate import Estimate
from vividc.compiler.planning.state import State
from vividc.ssa.analysis.counters import counter_of
from vividc.ssa.flow import Loop, find_loops

_IDLE = 0.25
"""A loop that uses a smaller share of the slots has room for iterations beside it."""


def loops_around_waiting(
    state: State, estimate: Estimate, pes: int, taken: Collection[str], tried: Collection[str]
) -> Iterator[str]:
    """Headers of loops around one that waits, outer ones first; none in `tried`, nor around or
    inside one in `taken`.

    Parameters
    ----------
    estimate
        Of the state.
    pes
        Of the fabric.
    """
    loops = find_loops(state.function)
    waiting = {loop.header for loop in loops if _waits(state, loop, estimate, pes)}
    for loop in reversed(loops):
        near = [o for o in loops if o.header in loop.blocks or loop.header in o.blocks]
        inside = {o.header for o in near if o.header in loop.blocks} - {loop.header}
        is_free = loop.header not in tried and not any(o.header in taken for o in near)
        if is_free and inside & waiting:
            yield loop.header


def _waits(state: State, loop: Loop, estimate: Estimate, pes: int) -> bool:
    if counter_of(state.function, loop) is None:
        return True
    cost = estimate.loop(loop.header)
    if cost is None:
        return False
    if cost.shape.bound is not None and cost.shape.bound.name == "RecMII":
        return True
    return cost.runs * cost.trips * cost.shape.operations < _IDLE * cost.cycles * pes
