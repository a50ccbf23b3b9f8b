"""Maps the regions of a kernel: loops first, then the straight regions around them, all within the
time limit.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass

from vividc.arch.fabric import Fabric
from vividc.compiler.regions.earlier import Earlier, posed
from vividc.compiler.regions.map_again import Runs, with_fewer_cycles
from vividc.compiler.regions.map_straight import (
    IsLost,
    Mapped,
    Straight,
    spans_of,
)
from vividc.compiler.regions.one_straight import NODE_S, Progress
from vividc.compiler.regions.shared_variables import with_shared_variables
from vividc.compiler.regions.stores import Stores
from vividc.dfg.alike import unnamed
from vividc.dfg.regions import Kernel, Region
from vividc.errors import MappingFailed, TimeLimit
from vividc.host import time_limit
from vividc.mapper import EffortLevel, MapProblem, MapResult, map_dfg
from vividc.mapper.api import about
from vividc.mapper.bounds.bounds import all_bounds, mii
from vividc.mapper.check.verify import violations
from vividc.mapper.deadline import Deadline, limited
from vividc.mapper.engines.negotiate import least_span
from vividc.mapper.result import mapping_of

_SEARCH = "the search for mappings"

LEAST_S = 0.3
"""Seconds that all loops together have in any case."""

_LEAST_LOOP_S = 0.1
"""A loop that has less time is not tried: it runs block by block."""

_FEW = 8
"""Loops, each of which has its part of the time."""

_STRAIGHT_SHARE = 0.5
"""Largest share of the time that is kept for straight regions while loops are mapped."""


@dataclass(frozen=True, slots=True)
class MapOptions:
    """How regions are mapped.

    Attributes
    ----------
    mapper
        "auto", or another mapper's name.
    time_limit_s
        Seconds for all of it, which buy an effort (`mapper/deadline.py`).
    effort
        Where the search for a loop's mapping stops before that.
    progress
        Called with one line for each step.
    """

    mapper: str = "auto"
    time_limit_s: float = 60.0
    effort: EffortLevel = "normal"
    progress: Progress | None = None


@dataclass(frozen=True, slots=True)
class Unmapped:
    """Headers of the loops that have no mapping, and why the first of them has none."""

    headers: tuple[str, ...]
    error: MappingFailed | TimeLimit


def map_kernel(
    kernel: Kernel,
    fabric: Fabric,
    options: MapOptions,
    earlier: Earlier | None = None,
    *,
    demanded: frozenset[str] = frozenset(),
    runs: Runs | None = None,
    is_lost: IsLost = lambda _: False,
) -> tuple[Kernel, dict[int, MapResult]] | Unmapped | None:
    """Maps all regions: loops first, then straight regions around them.

    Parameters
    ----------
    earlier
        Keeps what is known from one call to the next. Its straight regions without a mapping, or
        with a frugal one only, are not tried again, though other loops may leave them more room:
        another kernel does it.
    demanded
        Headers of loops without which the rest is of no use.
    runs
        How often regions are expected to run: loops are mapped for few bank stalls, too, unless
        the effort is "fast".
    is_lost
        Whether the kernel is of no use, as regions take as many cycles; asked as they are mapped.

    Returns
    -------
    The kernel whose straight regions hold their deliveries, and the result of each region by index;
    or the loops that have no mapping; or None, if it is of no use.

    Raises
    ------
    MappingFailed, TimeLimit
        A straight region has no mapping.
    """
    with limited(options.time_limit_s) as effort:
        earlier = Earlier() if earlier is None else earlier
        for region in kernel.regions if earlier.hopeless else ():
            if (error := earlier.hopeless.get(unnamed(region.dfg))) is not None:
                raise error
        asked = _Asked(options, runs, earlier, demanded)
        results = _map_loops(kernel, fabric, asked, effort, is_lost)
        if results is None or isinstance(results, Unmapped):
            return results
        if is_lost(_least(kernel, fabric, results)):
            return None
        chosen = results
        if runs is not None and options.mapper == "auto":
            chosen = with_fewer_cycles(
                kernel, fabric, results, runs, effort, options.effort, earlier.again
            )
        before, after = (spans_of(kernel, fabric, loops) for loops in (results, chosen))
        if is_lost({index: min(span, after[index]) for index, span in before.items()}):
            return None
        return _finished(kernel, fabric, options, runs, earlier, is_lost, (results, chosen))


def _finished(
    kernel: Kernel,
    fabric: Fabric,
    options: MapOptions,
    runs: Runs | None,
    earlier: Earlier,
    is_lost: IsLost,
    loops: tuple[dict[int, MapResult], dict[int, MapResult]],
) -> Mapped | None:
    """With straight regions beside the loops as they are chosen, or as they were mapped first if
    that leaves more room; at last with variables that share their places.
    """
    first, chosen = loops
    finish = Straight(fabric, options.progress, runs, earlier, is_lost).mapped
    is_crowded = any(unnamed(region.dfg) in earlier.crowded for region in kernel.regions)
    with suppress(MappingFailed):
        if not is_crowded:
            return finish(kernel, chosen, "none")
    with suppress(MappingFailed):  # what the first ones took may be what the last ones need
        if chosen != first:
            return finish(kernel, chosen, "frugal")
    with suppress(MappingFailed):
        return finish(kernel, first, "frugal")
    return finish(with_shared_variables(kernel), first, "last")


def _least(
    kernel: Kernel, fabric: Fabric, results: dict[int, MapResult]
) -> dict[int, tuple[int, int]]:
    """The II of each mapped loop, and the span that no mapping at this II is shorter than."""
    found = ((index, mapping_of(result).ii) for index, result in results.items())
    return {i: (ii, least_span(MapProblem(kernel.regions[i].dfg, fabric), ii)) for i, ii in found}


def _bounds(kernel: Kernel, fabric: Fabric) -> dict[int, tuple[int, int]]:
    """What no mapping of a loop has less of: the II, and the span at any II."""
    found: dict[int, tuple[int, int]] = {}
    contexts = fabric.controller.contexts
    for index, region in enumerate(kernel.regions):
        if region.kind == "loop":
            problem = MapProblem(region.dfg, fabric)
            ii = mii(all_bounds(problem))  # more than there are contexts: it runs block by block
            found[index] = ii if ii <= contexts else 1, least_span(problem, contexts)
    return found


@contextmanager
def guarded(seconds: float, *, grace_s: float = 0.0) -> Iterator[None]:
    """Limits what is done inside to so many seconds, and notes if the clock ended it."""
    with time_limit.limited(seconds, grace_s=grace_s) as guard:
        try:
            yield
        finally:
            if guard.left_s <= 0.0:
                time_limit.left_out(_SEARCH)


@dataclass(frozen=True, slots=True)
class _Asked:
    """Arguments of `map_kernel`."""

    options: MapOptions
    runs: Runs | None
    earlier: Earlier
    demanded: frozenset[str]


def _map_loops(
    kernel: Kernel,
    fabric: Fabric,
    asked: _Asked,
    effort: Deadline,
    is_lost: IsLost,
) -> dict[int, MapResult] | Unmapped | None:
    """The results of all loops; None: the kernel is of no use, as some are mapped and by the bounds
    of the others.
    """
    stores = Stores.of(kernel, fabric)
    loops = _in_order(kernel, stores)
    nodes = sum(len(region.dfg.placed) for region in kernel.regions if region.kind != "loop")
    left_s = time_limit.remaining_s()
    reserve_s = min(nodes * NODE_S, _STRAIGHT_SHARE * left_s)
    until = time_limit.now() + max(left_s - reserve_s, LEAST_S)
    results: dict[int, MapResult] = {}
    failed: dict[str, MappingFailed | TimeLimit] = {}
    least = _bounds(kernel, fabric)
    parts = _parts(least, asked.runs)
    for number, (index, region) in enumerate(loops):
        turn = _Turn(_share(loops[number:]), parts[index], until, effort)
        result, stores = _mapped_beside(region, index, stores, asked, turn)
        if isinstance(result, MapResult):
            results[index] = result
            least |= _least(kernel, fabric, {index: result})
            if number + 1 < len(loops) and not failed and is_lost(least):
                return None
            continue
        failed[region.header] = result
        if region.header in asked.demanded:
            break
    if failed:
        return Unmapped(tuple(failed), next(iter(failed.values())))
    return dict(sorted(results.items()))


def _parts(least: dict[int, tuple[int, int]], runs: Runs | None) -> dict[int, float]:
    """The part of each loop in the cycles that all loops take at least, where runs are known."""
    if runs is None:
        return dict.fromkeys(least, 1.0)
    cycles = {
        i: runs.entries[i] * span + runs.iterations[i] * ii for i, (ii, span) in least.items()
    }
    every = sum(cycles.values())
    if not 0.0 < every < math.inf:
        return dict.fromkeys(least, 1.0)
    return {index: each / every for index, each in cycles.items()}


def _in_order(kernel: Kernel, stores: Stores) -> list[tuple[int, Region]]:
    """Loops as they are mapped, with their indices. Entries of constant stores are left to those
    that come last: where one store might not hold what all loops need, the largest come first.
    """
    loops = [(i, region) for i, region in enumerate(kernel.regions) if region.kind == "loop"]
    if not stores.are_crowded:
        return loops
    return sorted(loops, key=lambda loop: -len(loop[1].dfg.placed))


@dataclass(frozen=True, slots=True)
class _Turn:
    """A loop's `share` of the time `until` some point, and of an effort; its `part` of the cycles
    that are expected in loops.
    """

    share: float
    part: float
    until: float
    effort: Deadline


def _share(left: Sequence[tuple[int, Region]]) -> float:
    """The first loop's part of what is left: as much as each, and more if it is larger; or as much
    as one of a few, as few of many loops take what they are given (vadv of NPBench: 46 are mapped
    in 6 s, one of them in 3 s).
    """
    sizes = [len(region.dfg.placed) for _, region in left]
    return max(1 / min(len(sizes), _FEW), sizes[0] / max(1, sum(sizes)))


def _mapped_beside(
    region: Region,
    index: int,
    stores: Stores,
    asked: _Asked,
    turn: _Turn,
) -> tuple[MapResult | MappingFailed | TimeLimit, Stores]:
    """The result of a loop beside what constant stores hold, an earlier one if there is one, and
    what they hold with it; or why it has no mapping.
    """
    earlier = asked.earlier
    for held in stores.beside(index):
        problem = MapProblem(region.dfg, stores.fabric, {}, held)
        result: MapResult | MappingFailed | TimeLimit | None = _still_good(problem, earlier)
        if result is None:
            with guarded((turn.until - time_limit.now()) * turn.share):
                result = _mapped_loop(region, problem, asked.options, turn)
        if not isinstance(result, MapResult):
            return result, stores
        with_it = stores.with_regions([(region.dfg, mapping_of(result))])
        if with_it.fit():
            earlier.loops[unnamed(region.dfg)] = result
            earlier.searched[posed(problem)] = result
            return result, with_it
    text = f"the constant stores have no entries left for what {region.name} reads and writes"
    return MappingFailed(text, loc=region.loc), stores


def _still_good(problem: MapProblem, earlier: Earlier) -> MapResult | None:
    """A loop's earlier result: of the same problem under other names, or of the same loop beside
    other ones, if it is compatible with those mapped so far.
    """
    same = earlier.searched.get(posed(problem))
    result = same or earlier.loops.get(unnamed(problem.dfg))
    if result is None:
        return None
    held, mapping = problem.resident, mapping_of(result)
    if violations(problem.dfg, problem.fabric, mapping, resident=held):
        return None
    return result if same is None else about(result, problem)


def _mapped_loop(
    region: Region, problem: MapProblem, options: MapOptions, turn: _Turn
) -> MapResult | MappingFailed | TimeLimit:
    """The result of a loop, or why it has no mapping."""
    share_s = turn.effort.remaining_s * turn.share
    hint = "give a longer --time-limit, or a larger fabric"
    if time_limit.remaining_s() < _LEAST_LOOP_S:
        time_limit.left_out(_SEARCH)
    if min(share_s, time_limit.remaining_s()) < _LEAST_LOOP_S:
        text = f"{region.name} was not mapped: no time was left for it"
        return TimeLimit(text, loc=region.loc, hint=hint)
    result = map_dfg(
        region.dfg,
        problem.fabric,
        options.mapper,
        time_limit_s=share_s,
        resident=problem.resident,
        progress=_prefixed(options.progress, region),
        effort=options.effort,
        part=turn.part,
    )
    if result.mapping is not None:
        return result
    if result.status == "infeasible":
        text = f"{region.name} cannot be mapped: {result.explain()}"
        return MappingFailed(text, loc=region.loc)
    text = f"{region.name} was not mapped in time: {result.explain()}"
    return TimeLimit(text, loc=region.loc, hint=hint)


def _prefixed(progress: Progress | None, region: Region) -> Progress | None:
    if progress is None:
        return None
    return lambda text: progress(f"{region.name}: {text}")
