"""From a solution of the open-timeline model to a mapping with concrete registers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal

from ortools.sat.python.cp_model import IntVar

from vividc.mapper.engines.cpsat.problem import NodeAt, Prepared
from vividc.mapper.engines.cpsat.variables import Variables
from vividc.mapper.mapping import Mapping as ModuloMapping
from vividc.mapper.mapping import Place, Step
from vividc.mapper.resources.registers import Lifetime, allocate, conflict

Holds = Callable[[IntVar], bool]


@dataclass(frozen=True, slots=True)
class RegisterConflict:
    """Lifetimes on one PE that no allocation fits. `inside`: where an unused write, if there can be
    one, would cut one of them in two.
    """

    pe: int
    held: tuple[NodeAt, ...]
    inside: tuple[NodeAt, ...]


@dataclass(frozen=True, slots=True)
class Extracted:
    """A mapping, or the register conflicts that stand in its way."""

    mapping: ModuloMapping | None
    conflicts: tuple[RegisterConflict, ...] = ()


@dataclass(frozen=True, slots=True)
class _Spot:
    """Where a word is at `time`: on a link that ends at `pe`, or in a register or the output
    register of `pe`.
    """

    kind: Literal["link", "reg", "out"]
    pe: int
    time: int
    link: int = 0


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
    lifetimes = _lifetimes(routes, variables, holds)
    registers, conflicts = _allocate(problem, variables, lifetimes)
    if conflicts:
        return Extracted(None, conflicts)
    steps = {
        index: tuple(_step(spot, word, registers) for spot in spots)
        for index, spots in routes.spots.items()
        for word in (problem.task.dfg.edges[index].src,)
    }
    return Extracted(ModuloMapping(problem.ii, places, steps))


def _trace(problem: Prepared, v: Variables, holds: Holds, places: Mapping[int, Place]) -> _Routes:
    routes = _Routes()
    for index, edge in problem.task.dfg.routed_edges():
        at = places[edge.dst]
        walk = _Walk(problem, v, holds, edge.src, places[edge.src])
        spots = walk.back_from(at.pe, at.time + problem.ii * edge.distance)
        routes.spots[index] = spots
        for spot in spots:
            if spot.kind == "reg":
                routes.held[edge.src, spot.pe, spot.time] = None
    return routes


@dataclass(frozen=True)
class _Walk:
    """The way of one word, walked back from a read to the result.

    Where a word comes from depends on where it is only, so the ways of all its reads agree.
    """

    problem: Prepared
    v: Variables
    holds: Holds
    word: int
    source: Place

    def back_from(self, pe: int, time: int) -> list[_Spot]:
        """The spots from the result to a read on `pe` at `time`."""
        if self._is_fresh(pe, time):
            return []
        spots: list[_Spot] = []
        spot: _Spot | None = self._arrival(pe, time)
        while spot is not None:
            spots.append(spot)
            spot = self._before(spot)
        return spots[::-1]

    def _is_fresh(self, pe: int, time: int) -> bool:
        """The result enters a place of its own PE, readable at `time`."""
        return pe == self.source.pe and time == self.source.time + self.problem.latency[self.word]

    def _is_true(self, table: Mapping[NodeAt, IntVar], key: NodeAt) -> bool:
        literal = table.get(key)
        return literal is not None and self.holds(literal)

    def _arrival(self, pe: int, time: int) -> _Spot:
        """From where `pe` reads the word."""
        fabric = self.problem.fabric
        for seen in fabric.outputs_seen_by[pe]:
            if self._is_true(self.v.output, (self.word, seen, time)):
                return _Spot("out", seen, time)
        for link in fabric.links_to[pe]:
            if self._is_true(self.v.link, (self.word, link.id, time)):
                return _Spot("link", pe, time, link.id)
        return _Spot("reg", pe, time)

    def _before(self, spot: _Spot) -> _Spot | None:
        """Where the word came from; None: it is the result of its own operation."""
        if spot.kind == "link":
            return self._before_link(spot)
        keeps = _Spot(spot.kind, spot.pe, spot.time - 1)
        key = (self.word, spot.pe, spot.time)
        if spot.kind == "reg" and not self.holds(self.v.written[key]):
            return keeps
        if self._is_fresh(spot.pe, spot.time):
            return None
        before = (self.word, spot.pe, spot.time - 1)
        held = self.problem.fabric.routing.holds and self._is_true(self.v.output, before)
        if spot.kind == "out" and held:
            return keeps
        return self._arrival(spot.pe, spot.time - 1)

    def _before_link(self, spot: _Spot) -> _Spot | None:
        from_pe = self.problem.fabric.links[spot.link].src
        depth = self._depth(spot.link, spot.time)
        if depth > 1:
            passed = (k.id for k in self.problem.fabric.links_to[from_pe])
            link = next(k for k in passed if self._is_driven(k, spot.time, depth - 1))
            return _Spot("link", from_pe, spot.time, link)
        if self._is_fresh(from_pe, spot.time):
            return None
        return self._arrival(from_pe, spot.time - 1)

    def _depth(self, link: int, time: int) -> int:
        """The least number of links that the word has passed in the cycle, this one included."""
        depth = 1
        while self.v.hop and not self._is_driven(link, time, depth):
            depth += 1
        return depth

    def _is_driven(self, link: int, time: int, depth: int) -> bool:
        literal = self.v.hop.get((self.word, link, time, depth))
        return literal is not None and self.holds(literal)


def _lifetimes(routes: _Routes, v: Variables, holds: Holds) -> dict[int, list[Lifetime]]:
    """Runs of held cycles on each PE, cut at each write."""
    by_pe: dict[int, list[Lifetime]] = {}
    for word, pe, time in sorted(routes.held):
        lifetimes = by_pe.setdefault(pe, [])
        goes_on = lifetimes and lifetimes[-1].word == word and lifetimes[-1].last == time - 1
        if goes_on and not holds(v.written[word, pe, time]):
            lifetimes[-1] = Lifetime(word, lifetimes[-1].first, time)
        else:
            lifetimes.append(Lifetime(word, time, time))
    return by_pe


def _allocate(
    problem: Prepared, v: Variables, lifetimes: Mapping[int, list[Lifetime]]
) -> tuple[dict[NodeAt, int], tuple[RegisterConflict, ...]]:
    registers: dict[NodeAt, int] = {}
    conflicts = []
    for pe, here in lifetimes.items():
        available, rotating = problem.fabric.pes[pe].registers, problem.fabric.pes[pe].rotating
        chosen = allocate(here, problem.ii, available, rotating=rotating)
        if chosen is None:
            core = conflict(here, problem.ii, available, rotating=rotating)
            conflicts.append(_conflict(pe, core))
            continue
        for lifetime, register in zip(here, chosen, strict=True):
            for time in range(lifetime.first, lifetime.last + 1):
                registers[lifetime.word, pe, time] = register
    return registers, tuple(conflicts)


def _conflict(pe: int, core: tuple[Lifetime, ...]) -> RegisterConflict:
    held = tuple((s.word, pe, t) for s in core for t in range(s.first, s.last + 1))
    inside = tuple((s.word, pe, t) for s in core for t in range(s.first + 1, s.last + 1))
    return RegisterConflict(pe, held, inside)


def _step(spot: _Spot, word: int, registers: Mapping[NodeAt, int]) -> Step:
    if spot.kind == "link":
        return Step("link", spot.pe, spot.link, spot.time)
    if spot.kind == "out":
        return Step("out", spot.pe, 0, spot.time)
    return Step("reg", spot.pe, registers[word, spot.pe, spot.time], spot.time)
