"""Checks what a result says was minimised: its value is read anew from the mapping."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from vividc.mapper.check.case import Case
from vividc.mapper.check.finding import Finding, own_words
from vividc.mapper.check.routes import carrying
from vividc.mapper.mapping import Mapping, Objective, Subject
from vividc.mapper.result import MapResult

_ADDED: Final = "added objective"


def check_objective(result: MapResult, subject: Subject) -> Iterator[Finding]:
    """Findings on the objective of a result whose mapping, if it has one, is legal."""
    found, mapping = result.objective, result.mapping
    if found is None:
        return
    if mapping is None:
        yield Finding("wrong", f"an objective is given without a mapping: {own_words(found.name)}")
        return
    case = _case(mapping, subject)
    yield _check_value(found, case, constrained=result.constrained)
    if found.before is not None:
        yield Finding("trusted", f"the first mapping found had {found.before}")
    if found.bound is not None:
        yield _check_bound(found, case)


def _case(mapping: Mapping, subject: Subject) -> Case:
    dfg, fabric = subject.dfg, subject.fabric
    latency = {node.id: fabric.latency(node) for node in dfg.placed}
    return Case(dfg, fabric, mapping, mapping.places, latency)


def _check_value(found: Objective, case: Case, *, constrained: bool) -> Finding:
    hops, registers = carrying(case)
    length = max((case.ready(node) for node in case.places), default=0)
    values = {"hops": hops, "registers": registers, "length": length}
    added = found.name in (_ADDED, *(f"{_ADDED} + {name}" for name in values))
    if not added and found.name not in values:
        return Finding("wrong", f"no objective is called {own_words(found.name)}")
    if added and not constrained:
        return Finding("wrong", f"{found.name}: nothing was added to the problem")
    if found.value is None:
        return Finding("confirmed", f"{found.name}: nothing is said of it")
    if added:
        return Finding("trusted", f"{found.name}: {found.value}, of what is not in the result")
    real = values[found.name]
    if found.value != real:
        return Finding("wrong", f"{found.name} {found.value}: the mapping has {real}")
    return Finding("confirmed", f"the mapping has {found.name} {real}")


def _check_bound(found: Objective, case: Case) -> Finding:
    last = max((place.time for place in case.places.values()), default=0)
    limit = f"no mapping that issues nothing after cycle {found.last_issue} has less than"
    text = f"{own_words(found.name)}: {limit} {found.bound}"
    if last > found.last_issue:
        return Finding("wrong", f"{text}; this one issues in cycle {last}")
    if found.value is None or (found.bound is not None and found.bound > found.value):
        return Finding("wrong", f"{text}; this one has {found.value}")
    return Finding("trusted", text)
