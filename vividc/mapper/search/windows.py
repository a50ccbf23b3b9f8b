"""Maps a graph that is small for its array to rectangles of the array as well.

A mapping to a rectangle of PEs, with the links between them, is a mapping to the whole array: an
array does no worse than a smaller one that it contains.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from vividc.arch.fabric import Fabric, Link
from vividc.mapper.bounds.bounds import all_bounds, mii, no_ii
from vividc.mapper.mapping import Mapping, Place, Step
from vividc.mapper.problem import MapProblem
from vividc.mapper.result import MapInterrupted
from vividc.mapper.search.attempt import map_negotiated
from vividc.mapper.search.state import Attempt, IISearch
from vividc.mapper.search.tuning import (
    AMPLE_WINDOWS,
    FILLED,
    FIRST_WINDOW_SHARE,
    GROWTH,
    LARGE_ARRAY,
    LEAST_WINDOW,
    NARROWEST,
    QUICK,
    ROOM,
    ROOM_WITH_MOVES,
    SPARSE,
    WINDOW_SEED_SHARE,
    WINDOW_SEEDS,
    WINDOW_SHARE,
    WINDOW_TARGET,
)


@dataclass(frozen=True)
class Window:
    """A rectangle of an array as a fabric of its own; `pes` and `links` are the ids in the array of
    those that it numbers from 0.
    """

    fabric: Fabric
    pes: tuple[int, ...]
    links: tuple[int, ...]

    def embed(self, mapping: Mapping) -> Mapping:
        """A mapping to the window as one to the array."""
        places = {n: Place(self.pes[p.pe], p.time) for n, p in mapping.places.items()}
        routes = {
            index: tuple(self._embedded(step) for step in route)
            for index, route in mapping.routes.items()
        }
        return Mapping(mapping.ii, places, routes)

    def _embedded(self, step: Step) -> Step:
        index = self.links[step.index] if step.kind == "link" else step.index
        return Step(step.kind, self.pes[step.pe], index, step.time)


def window(fabric: Fabric, top: int, left: int, rows: int, cols: int) -> Window:
    """The rectangle of `rows` x `cols` PEs whose north-west corner is at (`top`, `left`)."""
    inside = [
        pe for pe in fabric.pes if top <= pe.row < top + rows and left <= pe.col < left + cols
    ]
    number = {pe.id: index for index, pe in enumerate(inside)}
    links = [link for link in fabric.links if link.src in number and link.dst in number]
    part = replace(
        fabric,
        name=f"{fabric.name}[{top}:{top + rows},{left}:{left + cols}]",
        rows=rows,
        cols=cols,
        pes=tuple(
            replace(pe, id=number[pe.id], row=pe.row - top, col=pe.col - left) for pe in inside
        ),
        links=tuple(Link(i, number[k.src], number[k.dst]) for i, k in enumerate(links)),
        source="",
    )
    return Window(part, tuple(pe.id for pe in inside), tuple(link.id for link in links))


def work_of(problem: MapProblem) -> int:
    """Slots of FUs that the operations take in an iteration."""
    return sum(problem.fabric.occupancy(node) for node in problem.dfg.operations)


def start_in_window(search: IISearch) -> None:
    """Where FUs move words and a graph takes hardly any of a large array's slots at the bound,
    negotiate at the bound in one window.
    """
    problem, request, bound = search.problem, search.request, search.lower
    work = work_of(problem)
    sparse = work <= SPARSE * len(problem.fabric.pes) * bound
    if not (sparse and problem.fabric.routing.moves and _has_windows(search)):
        return
    side = max(NARROWEST, math.ceil(math.sqrt(work / bound / FILLED)))
    if side > min(problem.fabric.rows, problem.fabric.cols):
        return
    part, its_bound = _best_corner(problem, side, side)
    smaller = replace(problem, fabric=part.fabric)
    for seed in WINDOW_SEEDS:
        if its_bound > bound or search.incumbent is not None:
            return
        request.tell(f"trying the window {part.fabric.name}")
        deadline = request.deadline.within(WINDOW_SEED_SHARE * request.deadline.remaining_s)
        attempt = map_negotiated(smaller, bound, request, deadline, seed, QUICK)
        _record(search, part, attempt.mapping)


def windows(search: IISearch) -> Iterator[None]:
    """Search rectangles of a large array for an II below the incumbent's, one a step, each with a
    share of the time that is left.
    """
    if not _has_windows(search) or search.lower >= no_ii(search.problem):
        return
    for part in _windows(search):
        _search_window(search, part)
        yield


def search_windows(search: IISearch) -> None:
    """All windows in turn."""
    for _ in windows(search):
        pass


def _has_windows(search: IISearch) -> bool:
    problem = search.problem
    fixed = problem.allowed or problem.resident or search.request.extend is not None
    return search.in_window is not None and len(problem.fabric.pes) > LARGE_ARRAY and not fixed


def _search_window(search: IISearch, part: Window) -> None:
    assert search.in_window is not None
    request, known = search.request, search.incumbent
    share = FIRST_WINDOW_SHARE if known is None else WINDOW_SHARE
    deadline = search.deadline.within(search.deadline.remaining_s * share)
    request.tell(f"trying the window {part.fabric.name}")
    problem = replace(search.problem, fabric=part.fabric)
    try:
        result = search.in_window(problem, replace(request, deadline=deadline, known=known))
    except MapInterrupted as stop:
        _record(search, part, stop.result.mapping)
        raise
    _record(search, part, result.mapping)


def _record(search: IISearch, part: Window, mapping: Mapping | None) -> None:
    """Record a window's mapping, unless it is the incumbent, which the window's search knew."""
    if mapping is not None and mapping is not search.incumbent:
        search.record(mapping.ii, Attempt(mapping=part.embed(mapping)))


def _windows(search: IISearch) -> Iterator[Window]:
    """Windows with room for the graph below the incumbent's II (without one: not far above the
    bound), each clearly larger than the one before, until some may reach the bound.
    """
    problem, bound = search.problem, search.lower
    work = work_of(problem)
    room = ROOM_WITH_MOVES if problem.fabric.routing.moves else ROOM
    area, ample = 0.0, 0
    for rows, cols in _shapes(problem.fabric):
        if not search.unfinished or search.deadline.passed or ample == AMPLE_WINDOWS:
            return
        size, best = rows * cols, search.incumbent
        target = WINDOW_TARGET * bound if best is None else best.ii - 1
        if size < max(LEAST_WINDOW, GROWTH * area, room * work / target):
            continue
        part, its_bound = _best_corner(problem, rows, cols)
        if its_bound <= target:
            yield part
            area = size
            ample += its_bound <= bound


def _best_corner(problem: MapProblem, rows: int, cols: int) -> tuple[Window, int]:
    """The window of a size in that corner of the array where its bound is least."""
    fabric = problem.fabric
    corners = dict.fromkeys(
        (top, left) for top in (0, fabric.rows - rows) for left in (0, fabric.cols - cols)
    )
    bounded = []
    for top, left in corners:
        part = window(fabric, top, left, rows, cols)
        bounded.append((part, mii(all_bounds(replace(problem, fabric=part.fabric)))))
        if len({(pe.classes, pe.sliced, pe.registers, pe.constants) for pe in fabric.pes}) == 1:
            break
    return min(bounded, key=lambda item: item[1])


def _shapes(fabric: Fabric) -> list[tuple[int, int]]:
    """Sizes of windows, by area and then from square to long: squares, nearly so, and strips of
    full height or width (memory PEs may line one side).
    """
    rows, cols = fabric.rows, fabric.cols
    shapes = set()
    for side in range(1, max(rows, cols) + 1):
        shapes |= {(side, side), (side, side + 1), (side + 1, side)}
        if side >= NARROWEST:
            shapes |= {(rows, side), (side, cols)}
    clipped = {(min(height, rows), min(width, cols)) for height, width in shapes}
    return sorted(clipped - {(rows, cols)}, key=lambda s: (s[0] * s[1], abs(s[0] - s[1]), s))
