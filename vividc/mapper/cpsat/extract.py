"""From a solution of the open-timeline model to a mapping with concrete registers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from ortools.sat.python.cp_model import IntVar

from vividc.mapper.cpsat.problem import NodeAt, Prepared
from vividc.mapper.cpsat.variables import Variables
from vividc.mapper.mapping import Mapping as ModuloMapping
from vividc.mapper.mapping import Place, Step
from vividc.mapper.registers import Stay, allocate, conflict

Holds = Callable[[IntVar], bool]


@dataclass(frozen=True, slots=True)
class RegisterConflict:
    """Stays on one PE that no allocation fits. `inside`: where an unused write would cut one of
    them in two.
    """

    pe: int
    held: tuple[NodeAt, ...]
    inside: tuple[NodeAt, ...]


@dataclass(frozen=True, slots=True)
class Extracted:
    """A mapping, or the register conflicts that stand in its way."""

    mapping: ModuloMapping | None
    conflicts: tuple[RegisterConflict, ...] = ()


@dataclass(slots=True)
class _Spot:
    """A word on a link (`link` set) or in a register of `pe`, readable at `time`."""

    pe: int
    time: int
    link: int | None = None


@dataclass
class _Routes:
    """Routes as spots, and the registers' use that follows from them."""

    spots: dict[int, list[_Spot]] = field(default_factory=dict)
    held: dict[NodeAt, None] = field(default_factory=dict)


def extract(problem: Prepared, variables: Variables, holds: Holds) -> Extracted:
    """Places, routes and registers of a solution; `holds` tells a literal's value.

    Only what some route uses counts: the solver may have driven links or kept words to no purpose.
    """
    places = {
        node: Place(pe, time)
        for (node, pe, time), literal in variables.start.items()
        if holds(literal)
    }
    routes = _trace(problem, variables, holds, places)
    stays = _stays(routes, variables, holds)
    registers, conflicts = _allocate(problem, variables, stays)
    if conflicts:
        return Extracted(None, conflicts)
    steps = {
        index: tuple(_step(problem, spot, word, registers) for spot in spots)
        for index, spots in routes.spots.items()
        for word in (problem.task.dfg.edges[index].src,)
    }
    return Extracted(ModuloMapping(problem.ii, places, steps))


def _trace(problem: Prepared, v: Variables, holds: Holds, places: Mapping[int, Place]) -> _Routes:
    routes = _Routes()
    for index, edge in problem.task.dfg.routed_edges():
        at = places[edge.dst]
        time = at.time + problem.ii * edge.distance
        spots = _route(problem, v, holds, places[edge.src], edge.src, at.pe, time)
        routes.spots[index] = spots
        for spot in spots:
            if spot.link is None:
                routes.held[edge.src, spot.pe, spot.time] = None
    return routes


def _route(
    problem: Prepared,
    v: Variables,
    holds: Holds,
    source: Place,
    word: int,
    pe: int,
    time: int,
) -> list[_Spot]:
    """Walk back from the read to the result, one cycle a step."""
    ready = source.time + problem.latency[word]
    spots: list[_Spot] = []
    while not (pe == source.pe and time == ready - bool(spots)):
        spot = _arrival(problem, v, holds, word, pe, time)
        spots.append(spot)
        if spot.link is not None:
            pe = problem.fabric.links[spot.link].src
        elif not holds(v.written[word, pe, time]):
            spots += _kept(v, holds, word, spot)
            time = spots[-1].time
        time -= 1
    return list(reversed(spots))


def _arrival(problem: Prepared, v: Variables, holds: Holds, word: int, pe: int, time: int) -> _Spot:
    for link in problem.fabric.links_to[pe]:
        literal = v.link.get((word, link.id, time))
        if literal is not None and holds(literal):
            return _Spot(pe, time, link.id)
    return _Spot(pe, time)


def _kept(v: Variables, holds: Holds, word: int, last: _Spot) -> list[_Spot]:
    """Earlier cycles of the same stay, back to its write."""
    spots = [_Spot(last.pe, last.time - 1)]
    while not holds(v.written[word, last.pe, spots[-1].time]):
        spots.append(_Spot(last.pe, spots[-1].time - 1))
    return spots


def _stays(routes: _Routes, v: Variables, holds: Holds) -> dict[int, list[Stay]]:
    """Runs of held cycles on each PE, cut at each write."""
    found: dict[int, list[Stay]] = {}
    for word, pe, time in sorted(routes.held):
        stays = found.setdefault(pe, [])
        goes_on = stays and stays[-1].word == word and stays[-1].last == time - 1
        if goes_on and not holds(v.written[word, pe, time]):
            stays[-1] = Stay(word, stays[-1].first, time)
        else:
            stays.append(Stay(word, time, time))
    return found


def _allocate(
    problem: Prepared, v: Variables, stays: Mapping[int, list[Stay]]
) -> tuple[dict[NodeAt, int], tuple[RegisterConflict, ...]]:
    registers: dict[NodeAt, int] = {}
    conflicts = []
    for pe, here in stays.items():
        available = problem.fabric.pes[pe].registers
        chosen = allocate(here, problem.ii, available)
        if chosen is None:
            core = conflict(here, problem.ii, available)
            conflicts.append(_conflict(v, pe, core))
            continue
        for stay, register in zip(here, chosen, strict=True):
            for time in range(stay.first, stay.last + 1):
                registers[stay.word, pe, time] = register
    return registers, tuple(conflicts)


def _conflict(v: Variables, pe: int, core: tuple[Stay, ...]) -> RegisterConflict:
    held = tuple((s.word, pe, t) for s in core for t in range(s.first, s.last + 1))
    inside = tuple((s.word, pe, t) for s in core for t in range(s.first + 1, s.last + 1))
    return RegisterConflict(pe, held, tuple(key for key in inside if key in v.written))


def _step(problem: Prepared, spot: _Spot, word: int, registers: Mapping[NodeAt, int]) -> Step:
    if spot.link is not None:
        return Step("link", problem.fabric.links[spot.link].dst, spot.link, spot.time)
    return Step("reg", spot.pe, registers[word, spot.pe, spot.time], spot.time)
