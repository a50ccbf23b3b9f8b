"""Checks what a result says was minimised: its value is recomputed from the mapping."""

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
    objective, mapping = result.objective, result.mapping
    if objective is None:
        return
    if mapping is None:
        yield Finding(
            "wrong", f"an objective is given without a mapping: {own_words(objective.name)}"
        )
        return
    case = _case(mapping, subject)
    yield _check_value(objective, case, constrained=result.constrained)
    if objective.before is not None:
        yield Finding("trusted", f"the first mapping found had {objective.before}")
    if objective.bound is not None:
        yield _check_bound(objective, case)


def _case(mapping: Mapping, subject: Subject) -> Case:
    dfg, fabric = subject.dfg, subject.fabric
    latency = {node.id: fabric.latency(node) for node in dfg.placed}
    return Case(dfg, fabric, mapping, mapping.places, latency)


def _check_value(objective: Objective, case: Case, *, constrained: bool) -> Finding:
    hops, registers = carrying(case)
    length = max((case.ready(node) for node in case.places), default=0)
    values = {"hops": hops, "registers": registers, "length": length}
    added = objective.name in (_ADDED, *(f"{_ADDED} + {name}" for name in values))
    if not added and objective.name not in values:
        return Finding("wrong", f"no objective is called {own_words(objective.name)}")
    if added and not constrained:
        return Finding("wrong", f"{objective.name}: nothing was added to the problem")
    if objective.value is None:
        return Finding("confirmed", f"{objective.name}: no value is claimed")
    if added:
        return Finding(
            "trusted", f"{objective.name}: {objective.value}, of an expression unknown here"
        )
    real = values[objective.name]
    if objective.value != real:
        return Finding("wrong", f"{objective.name} {objective.value}: the mapping has {real}")
    return Finding("confirmed", f"the mapping has {objective.name} {real}")


def _check_bound(objective: Objective, case: Case) -> Finding:
    last = max((place.time for place in case.places.values()), default=0)
    limit = f"no mapping that issues nothing after cycle {objective.last_issue} has less than"
    text = f"{own_words(objective.name)}: {limit} {objective.bound}"
    if last > objective.last_issue:
        return Finding("wrong", f"{text}; this one issues in cycle {last}")
    if objective.value is None or (
        objective.bound is not None and objective.bound > objective.value
    ):
        return Finding("wrong", f"{text}; this one has {objective.value}")
    return Finding("trusted", text)
