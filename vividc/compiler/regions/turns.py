"""How the regions of a kernel are expected to come by turns, so that few contexts are brought."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from vividc.compiler.planning.estimate import RegionCost
from vividc.program.encoder.places import Turns
from vividc.ssa.analysis.frequency import entries_of, expected_trips, frequencies
from vividc.ssa.flow import find_loops
from vividc.ssa.ir import Function


def turns_of(function: Function, costs: Sequence[RegionCost], hints: Mapping[str, float]) -> Turns:
    """Of the regions of a normalised function with these costs."""
    trips = expected_trips(function, hints)
    entries = entries_of(function, frequencies(function, trips, hints))
    around: list[list[tuple[str, float]]] = [[] for _ in costs]
    reached = [min(cost.runs, 1.0) for cost in costs]
    for loop in find_loops(function):  # the outermost comes last
        iterations = entries[loop.header] * trips[loop.header]
        for index, cost in enumerate(costs):
            if cost.header in loop.blocks:
                reached[index] = min(cost.runs, entries[loop.header], 1.0)
                if (cost.kind, cost.header) != ("loop", loop.header):
                    around[index].insert(0, (loop.header, iterations))
    rare = frozenset(index for index, cost in enumerate(costs) if cost.is_rare)
    return Turns([cost.runs for cost in costs], reached, [tuple(one) for one in around], rare)
