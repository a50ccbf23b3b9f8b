"""A graph that is small for its array is mapped to rectangles of it, too.

A mapping to a rectangle of PEs, with the links between them, is a mapping to the whole array: an
array does no worse than a smaller one that it contains.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

from vividc.arch.fabric import Fabric, Link
from vividc.mapper.bounds.bounds import all_bounds, mii, no_ii
from vividc.mapper.mapping import Mapping, Place, Step
from vividc.mapper.problem import MapProblem
from vividc.mapper.request import Mapper
from vividc.mapper.result import MapInterrupted
from vividc.mapper.search.attempt import Attempt, map_negotiated
from vividc.mapper.search.campaign import Campaign
from vividc.mapper.search.large import QUICK, limit_of, work_of

_WORTH_WINDOWS = 16
"""PEs of an array from which on rectangles are tried."""

_LEAST = 16
"""PEs of the smallest window."""

_FIRST = 2
"""The II, in bounds, for which windows have room when nothing is mapped yet."""

_ROOM, _ROOM_WITH_MOVES = 1.2, 2.0
"""Slots for an operation; where FUs move words, too, they take slots themselves."""

_NARROWEST = 4
_GROWTH = 1.5
_AMPLE = 3
_FIRST_SHARE, _SHARE = 0.3, 0.2
"""Of the time that is left, for a window until something is mapped, and after that."""

_SPARSE, _FILLED = 0.06, 0.2
"""Parts of the slots: a graph that takes less of the array's begins in a window where it takes no
more than this of them, since on the array annealing leaves it far apart.
"""
_FIRST_SEEDS: Final = (1, 2)
_SEED_SHARE: Final = 0.1


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


def start_in_window(campaign: Campaign) -> None:
    """Where FUs move words and a graph takes hardly any of a large array's slots at the bound,
    negotiate at the bound in one window.
    """
    problem, request, bound = campaign.problem, campaign.request, campaign.lower
    work = work_of(problem)
    sparse = work <= _SPARSE * len(problem.fabric.pes) * bound
    if not (sparse and problem.fabric.routing.moves and _has_windows(campaign)):
        return
    side = max(_NARROWEST, math.ceil(math.sqrt(work / bound / _FILLED)))
    if side > min(problem.fabric.rows, problem.fabric.cols):
        return
    part, its_bound = _best_corner(problem, side, side)
    smaller = replace(problem, fabric=part.fabric)
    for seed in _FIRST_SEEDS:
        if its_bound > bound or campaign.best is not None:
            return
        request.tell(f"trying the window {part.fabric.name}")
        deadline = request.deadline.within(_SEED_SHARE * request.deadline.remaining_s)
        found = map_negotiated(smaller, bound, request, deadline, seed, QUICK).mapping
        _keep(campaign, part, found)


def search_windows(campaign: Campaign, mapper: Mapper) -> Iterator[None]:
    """Have `mapper` look for an II below the best, if there is any, on rectangles of a large array,
    one a step, each with a share of the time that is left.
    """
    if not _has_windows(campaign) or campaign.lower >= no_ii(campaign.problem):
        return
    for part in _windows(campaign):
        _search_window(campaign, mapper, part)
        yield


def _has_windows(campaign: Campaign) -> bool:
    problem = campaign.problem
    fixed = problem.allowed or problem.resident or campaign.request.extend is not None
    return len(problem.fabric.pes) > _WORTH_WINDOWS and not fixed


def _search_window(campaign: Campaign, mapper: Mapper, part: Window) -> None:
    request, best = campaign.request, campaign.best
    share = _FIRST_SHARE if best is None else _SHARE
    deadline = limit_of(campaign)
    deadline = deadline.within(deadline.remaining_s * share)
    request.tell(f"trying the window {part.fabric.name}")
    problem = replace(campaign.problem, fabric=part.fabric)
    try:
        found = mapper(problem, replace(request, deadline=deadline, known=best)).mapping
    except MapInterrupted as stop:
        _keep(campaign, part, stop.result.mapping)
        raise
    _keep(campaign, part, found)


def _keep(campaign: Campaign, part: Window, found: Mapping | None) -> None:
    """Keep a window's mapping, unless it is the one that was known."""
    if found is not None and found is not campaign.best:
        campaign.note(found.ii, Attempt(mapping=part.embed(found)))


def _windows(campaign: Campaign) -> Iterator[Window]:
    """Windows with room for the graph below the best II (where there is none: not far above the
    bound), each clearly larger than the one before, until some may reach the bound.
    """
    problem, bound = campaign.problem, campaign.lower
    work = work_of(problem)
    room = _ROOM_WITH_MOVES if problem.fabric.routing.moves else _ROOM
    area, ample = 0.0, 0
    for rows, cols in _shapes(problem.fabric):
        if not campaign.unfinished or limit_of(campaign).passed or ample == _AMPLE:
            return
        size, best = rows * cols, campaign.best
        target = _FIRST * bound if best is None else best.ii - 1
        if size < max(_LEAST, _GROWTH * area, room * work / target):
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
    found = []
    for top, left in corners:
        part = window(fabric, top, left, rows, cols)
        found.append((part, mii(all_bounds(replace(problem, fabric=part.fabric)))))
        if len({(pe.classes, pe.sliced, pe.registers, pe.constants) for pe in fabric.pes}) == 1:
            break
    return min(found, key=lambda item: item[1])


def _shapes(fabric: Fabric) -> list[tuple[int, int]]:
    """Sizes of windows, by area and then from square to long: squares, nearly so, and strips of
    full height or width (memory PEs may line one side).
    """
    rows, cols = fabric.rows, fabric.cols
    found = set()
    for side in range(1, max(rows, cols) + 1):
        found |= {(side, side), (side, side + 1), (side + 1, side)}
        if side >= _NARROWEST:
            found |= {(rows, side), (side, cols)}
    clipped = {(min(height, rows), min(width, cols)) for height, width in found}
    return sorted(clipped - {(rows, cols)}, key=lambda s: (s[0] * s[1], abs(s[0] - s[1]), s))
