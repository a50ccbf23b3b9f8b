"""What a result proves and what binds it, in words: a recurrence, a resource, or the routing."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from collections.abc import Mapping as ReadOnly
from dataclasses import dataclass
from typing import Final, TypeVar

from vividc.mapper.bounds.refutations import (
    BY_BOUND,
    BY_CONTEXTS,
    BY_SCHEDULE,
    IF_THEY_MEET,
    WITHIN_ADDED,
    rests_on_assumed,
)
from vividc.mapper.mapping import Mapping, Refutation, Subject
from vividc.mapper.resources.fu_slots import fu_slots_by_pe
from vividc.mapper.result import MapResult

K = TypeVar("K")

_KINDS: Final = {
    "RecMII": "the recurrence",
    "ResMII": "the issue slots of FUs",
    "FU occupancy": "an operation that keeps its FU",
    "live-out writes": "the write ports of constant stores",
    "control port": "the tile controller's input",
    "banks": "the scratchpad's banks",
    "stages": "the controller's stages",
    "placement": "a node that no PE can take",
    "lifetime": "a word that lives too long",
    "island": "PEs that no links join",
    "reach": "a word that cannot get to its reader",
}
_SCHEDULE: Final = "dependences and resources together"
_PLACES_AND_ROUTES: Final = "places and routes"
_WITHIN: Final = " within the added constraints"


def explain(result: MapResult) -> str:
    """A few lines for a person: the outcome, what binds it, all bounds, and what was refuted."""
    lines = [_headline(result), *(f"  {line}" for line in _binding_lines(result))]
    if result.hurried:
        lines.append("  stopped by the clock, not by effort: another run may differ")
    if result.objective is not None:
        lines.append(f"  minimised: {result.objective}")
    lines += [f"  {bound.name} {bound.ii}: {bound.reason}" for bound in result.bounds]
    lines += [f"  II {item.ii} refuted by {item.by}" for item in result.refuted]
    return "\n".join(lines)


def _headline(result: MapResult) -> str:
    outcome = "proved impossible" if result.status == "infeasible" else "nothing found"
    what = (
        outcome if result.ii is None else f"II {result.ii}, proved lower bound {result.lower_bound}"
    )
    if result.status == "timeout":
        what += f", proved lower bound {result.lower_bound}"
    if rests_on_assumed(result.bounds, result.lower_bound):
        what += IF_THEY_MEET
    return f"{result.claim}: {what}"


@dataclass(frozen=True, slots=True)
class Binding:
    """What binds a result: a kind of bound, or the search that refuted the II below.

    Attributes
    ----------
    bound
        Name of the bound that binds; None: a search does.
    refuted_ii
        The largest II that a search refuted; None: a bound binds.
    """

    what: str
    bound: str | None = None
    refuted_ii: int | None = None


@dataclass(frozen=True, slots=True)
class FullestFU:
    """The PE whose FU is taken in most slots: by operations, units kept busy and moves."""

    pe: int
    slots: int


@dataclass(frozen=True, slots=True)
class FullestLink:
    """The link, from PE `src` to PE `dst`, that is driven in most slots."""

    src: int
    dst: int
    slots: int


@dataclass(frozen=True, slots=True)
class FullestFile:
    """The PE whose registers hold most words in a slot."""

    pe: int
    words: int
    registers: int


@dataclass(frozen=True, slots=True)
class Fullest:
    """Where a smaller II would run out of room first; None: nothing of that kind is used."""

    fu: FullestFU | None
    link: FullestLink | None
    file: FullestFile | None


def binding(result: MapResult) -> Binding | None:
    """What refuted the largest II that was refuted; None where nothing was."""
    last = result.refuted[-1] if result.refuted else None
    if last is not None and last.ii >= result.lower_bound - 1 and BY_BOUND not in last.by:
        return Binding(_searched(last), refuted_ii=last.ii)
    sharpest = result.bounds[0] if result.bounds else None
    if sharpest is not None and sharpest.ii >= result.lower_bound > 1:
        return Binding(_KINDS.get(sharpest.name, sharpest.name), bound=sharpest.name)
    return None


def _searched(last: Refutation) -> str:
    if BY_SCHEDULE in last.by:
        return _SCHEDULE
    if BY_CONTEXTS in last.by:
        return last.by
    return _PLACES_AND_ROUTES + (_WITHIN if WITHIN_ADDED in last.by else "")


def fullest(result: MapResult) -> Fullest | None:
    """The fullest FU, link and register file of a mapping whose II is above every bound."""
    subject = result.subject or (None if result.mapping is None else result.mapping.subject)
    bounded = result.bounds[0].ii if result.bounds else 1
    if result.mapping is None or subject is None or result.mapping.ii <= bounded:
        return None
    return _fullest_of(result.mapping, subject)


def _binding_lines(result: MapResult) -> Iterator[str]:
    cause, ii, lower = binding(result), result.ii, result.lower_bound
    if cause is not None:
        yield f"what binds: {cause.what}{_because(cause)}"
    if ii is not None and lower < ii:
        missing = f"II {lower}" if lower == ii - 1 else f"II {lower} .. {ii - 1}"
        yield f"{missing} neither mapped nor refuted"
    room = fullest(result)
    parts = [] if room is None or ii is None else list(_fullest_parts(room, ii))
    if parts:
        yield f"fullest in this mapping: {'; '.join(parts)}"


def _because(cause: Binding) -> str:
    if cause.bound is not None:
        return f" ({cause.bound})"
    if cause.what == _SCHEDULE:
        return f"; II {cause.refuted_ii} has no schedule"
    if _PLACES_AND_ROUTES not in cause.what:
        return ""
    within = " within them" if _WITHIN in cause.what else ""
    return f"; II {cause.refuted_ii} passes every bound and cannot be routed{within}"


def _fullest_parts(room: Fullest, ii: int) -> Iterator[str]:
    if room.fu is not None:
        yield f"the FU of PE {room.fu.pe} is taken in {room.fu.slots} of {ii} slots"
    if room.link is not None:
        ends = f"PE {room.link.src} -> {room.link.dst}"
        yield f"the link {ends} is driven in {room.link.slots} of {ii}"
    if room.file is not None:
        words, registers = room.file.words, room.file.registers
        yield f"PE {room.file.pe} holds {words} words in {registers} registers"


def _fullest_of(mapping: Mapping, subject: Subject) -> Fullest:
    fabric, ii = subject.fabric, mapping.ii
    taken = fu_slots_by_pe(subject.dfg, fabric, mapping)
    links: dict[int, set[int]] = defaultdict(set)
    registers: dict[tuple[int, int], set[int]] = defaultdict(set)
    for steps in mapping.routes.values():
        for step in steps:
            if step.kind == "link":
                links[step.index].add(step.time % ii)
            elif step.kind == "reg":
                registers[step.pe, step.time % ii].add(step.index)
    fu = link = file = None
    if taken:
        fu = FullestFU(*_most(taken))
    if links:
        index, slots = _most({index: len(used) for index, used in links.items()})
        link = FullestLink(fabric.links[index].src, fabric.links[index].dst, slots)
    if registers:
        (pe, _), words = _most({key: len(used) for key, used in registers.items()})
        file = FullestFile(pe, words, fabric.pes[pe].registers)
    return Fullest(fu, link, file)


def _most(counts: ReadOnly[K, int]) -> tuple[K, int]:
    return max(counts.items(), key=lambda item: item[1])
