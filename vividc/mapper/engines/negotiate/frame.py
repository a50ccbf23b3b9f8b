"""Between which cycles the operations of an iteration may start, and what should be apart there."""

from __future__ import annotations

from collections.abc import Mapping as ReadOnly
from dataclasses import dataclass, replace

from vividc.mapper.bounds.straight import end_after_start
from vividc.mapper.mapping import Mapping
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.banks import NO_MEETINGS, Meetings
from vividc.mapper.resources.dependences import Dependence, dependences, earliest_starts
from vividc.mapper.resources.distances import FAR, hop_distances


@dataclass(frozen=True, slots=True)
class Frame:
    """The cycles of an iteration.

    Attributes
    ----------
    begin
        A start of each node that keeps all dependences.
    last
        The latest start of each node.
    meetings
        Accesses that should be in different slots.
    origin
        A mapping at the same II, where to begin instead, which takes a third of the moves.
    """

    begin: ReadOnly[int, int]
    last: ReadOnly[int, int]
    meetings: Meetings = NO_MEETINGS
    origin: Mapping | None = None


def loose_frame(problem: MapProblem, ii: int, meetings: Meetings = NO_MEETINGS) -> Frame | None:
    """Somewhat longer than the longest path; None: it does not fit the II, or its stages."""
    nodes = tuple(node.id for node in problem.dfg.placed)
    start = earliest_starts(nodes, dependences(problem.dfg, problem.fabric), ii)
    if start is None:
        return None
    slack = _slack(problem, ii)
    if meetings.accesses:  # a stage apart is a bank apart, for accesses that step through an array
        slack = max(slack, problem.fabric.scratchpad.banks)
    latest = max(start.values(), default=0) + slack
    latest = min(latest, ii * problem.fabric.controller.max_stages - 1)
    if any(time > latest for time in start.values()):
        return None
    return Frame(_with_room(problem, start, latest), dict.fromkeys(nodes, latest), meetings)


def tight_frame(
    problem: MapProblem, ii: int, span: int, meetings: Meetings = NO_MEETINGS
) -> Frame | None:
    """Iterations of `span` cycles, from the first issue to the last completion; None: dependences
    take more, or stages would not do. Each node leaves room for what depends on it.
    """
    deps = dependences(problem.dfg, problem.fabric)
    ends = {node.id: end_after_start(problem.fabric, node) for node in problem.dfg.placed}
    first, tails = earliest_starts(ends, deps, ii), _tails(ends, deps, ii)
    if first is None or tails is None:
        return None
    latest = ii * problem.fabric.controller.max_stages - 1
    last = {node: min(span - tails[node], latest) for node in ends}
    if any(first[node] > last[node] for node in ends):
        return None
    return Frame(first, last, meetings)


def least_span(problem: MapProblem, ii: int) -> int:
    """Cycles that the dependences alone take for an iteration, at an II at which they fit."""
    nodes = problem.dfg.placed
    deps = dependences(problem.dfg, problem.fabric)
    start = earliest_starts([node.id for node in nodes], deps, ii) or {}
    return max((start[n.id] + end_after_start(problem.fabric, n) for n in nodes), default=1)


def _tails(
    ends: ReadOnly[int, int], deps: tuple[Dependence, ...], ii: int
) -> dict[int, int] | None:
    """Cycles from each node's start to the end of all that follows it; None: the II is too small.

    The end of the iteration is one more node, where longest paths backward begin.
    """
    end = -1
    back = [replace(dep, src=dep.dst, dst=dep.src) for dep in deps]
    back += [Dependence(end, node, 0, cycles, False, 0, -1) for node, cycles in ends.items()]
    return earliest_starts((end, *ends), back, ii)


def _slack(problem: MapProblem, ii: int) -> int:
    """Cycles by which the schedule may be longer than the longest path."""
    if problem.fabric.routing.hops:
        return ii
    widest = max(hops for row in hop_distances(problem.fabric) for hops in row if hops < FAR)
    return max(ii, 2 * widest)


def _with_room(problem: MapProblem, start: ReadOnly[int, int], latest: int) -> ReadOnly[int, int]:
    """The schedule to begin with. Where words go through output registers nothing draws nodes
    together in time, and one that comes too early cannot push all that follows: so there is room
    before the first.
    """
    if problem.fabric.routing.hops:
        return start
    later = (latest - max(start.values(), default=0)) // 2
    return {node: time + later for node, time in start.items()}
