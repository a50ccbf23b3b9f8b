"""What a result proves and what binds it, in words: a recurrence, a resource, or the routing."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator
from collections.abc import Mapping as ReadOnly
from typing import Final, TypeVar

from vividc.mapper.mapping import Bound, Mapping, MapResult, Refutation, Subject
from vividc.mapper.refutations import BY_BOUND, BY_CONTEXTS, BY_SCHEDULE, WITHIN_ADDED

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


def explain(result: MapResult) -> str:
    """A few lines for a person: the outcome, what binds it, all bounds, and what was refuted."""
    lines = [_headline(result), *(f"  {line}" for line in _binding(result))]
    if result.objective is not None:
        lines.append(f"  minimised: {result.objective}")
    lines += [f"  {bound.name} {bound.ii}: {bound.reason}" for bound in result.bounds]
    lines += [f"  II {item.ii} refuted by {item.by}" for item in result.refuted]
    return "\n".join(lines)


def _headline(result: MapResult) -> str:
    found = "proved impossible" if result.status == "infeasible" else "nothing found"
    what = (
        found if result.ii is None else f"II {result.ii}, proved lower bound {result.lower_bound}"
    )
    if result.status == "timeout":
        what += f", proved lower bound {result.lower_bound}"
    return f"{result.claim}: {what}"


def _binding(result: MapResult) -> Iterator[str]:
    ii, lower = result.ii, result.lower_bound
    bounded = result.bounds[0].ii if result.bounds else 1
    binding = _what_binds(result)
    if binding is not None:
        yield f"what binds: {binding}"
    if ii is None:
        return
    if lower < ii:
        missing = f"II {lower}" if lower == ii - 1 else f"II {lower} .. {ii - 1}"
        yield f"{missing} neither mapped nor refuted"
    if ii > bounded and result.mapping is not None:
        subject = result.subject or result.mapping.subject
        if subject is not None:
            yield from _bottlenecks(result.mapping, subject)


def _what_binds(result: MapResult) -> str | None:
    """What the largest refuted II was refuted by; None where nothing was."""
    last = result.refuted[-1] if result.refuted else None
    if last is not None and last.ii >= result.lower_bound - 1 and BY_BOUND not in last.by:
        return _refuted(last)
    sharpest = result.bounds[0] if result.bounds else None
    if sharpest is not None and sharpest.ii >= result.lower_bound > 1:
        return f"{_kind(sharpest)} ({sharpest.name})"
    return None


def _kind(bound: Bound) -> str:
    return _KINDS.get(bound.name, bound.name)


def _refuted(last: Refutation) -> str:
    if BY_SCHEDULE in last.by:
        return f"dependences and resources together; II {last.ii} has no schedule"
    if BY_CONTEXTS in last.by:
        return last.by
    how = f"II {last.ii} passes every bound and cannot be routed"
    if WITHIN_ADDED in last.by:
        return f"places and routes within the added constraints; {how} within them"
    return f"places and routes; {how}"


def _bottlenecks(mapping: Mapping, subject: Subject) -> Iterator[str]:
    """The fullest FU, link and register file: where a smaller II would need room first."""
    fabric, ii = subject.fabric, mapping.ii
    issues = Counter(
        place.pe for node, place in mapping.places.items() if subject.dfg.by_id[node].uses_fu
    )
    links: dict[int, set[int]] = defaultdict(set)
    registers: dict[tuple[int, int], set[int]] = defaultdict(set)
    for steps in mapping.routes.values():
        for step in steps:
            if step.kind == "link":
                links[step.index].add(step.time % ii)
            elif step.kind == "reg":
                registers[step.pe, step.time % ii].add(step.index)
    parts = []
    if issues:
        pe, count = _fullest(issues)
        parts.append(f"PE {pe} issues in {count} of {ii} slots")
    if links:
        link, count = _fullest({index: len(slots) for index, slots in links.items()})
        ends = f"PE {fabric.links[link].src} -> {fabric.links[link].dst}"
        parts.append(f"the link {ends} is driven in {count} of {ii}")
    if registers:
        (pe, _), count = _fullest({key: len(found) for key, found in registers.items()})
        parts.append(f"PE {pe} holds {count} words in {fabric.pes[pe].registers} registers")
    if parts:
        yield f"fullest in this mapping: {'; '.join(parts)}"


def _fullest(counts: ReadOnly[K, int]) -> tuple[K, int]:
    return max(counts.items(), key=lambda item: item[1])
