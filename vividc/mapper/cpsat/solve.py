"""Solves the joint model of time, place and route within given windows, registers included."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from ortools.sat.python.cp_model import CpModel, LiteralT

from vividc.mapper.cpsat.constraints import add_constraints
from vividc.mapper.cpsat.extract import Extracted, RegisterConflict, extract
from vividc.mapper.cpsat.handle import Extension, ModelHandle
from vividc.mapper.cpsat.problem import Prepared
from vividc.mapper.cpsat.run import Outcome, Search, run
from vividc.mapper.cpsat.variables import Variables, new_variables
from vividc.mapper.mapping import Mapping as ModuloMapping


@dataclass(frozen=True, slots=True)
class JointModel:
    """A built model with its variables: the door for callers who want to add constraints of their
    own.
    """

    model: CpModel
    variables: Variables


def build(problem: Prepared, dropped: Collection[str] = ()) -> JointModel:
    """Build the model; `dropped` names constraint families to leave out."""
    model = CpModel()
    variables = new_variables(model, problem)
    add_constraints(model, problem, variables, dropped)
    return JointModel(model, variables)


def place_and_route(
    problem: Prepared,
    search: Search,
    dropped: Collection[str] = (),
    extend: Extension | None = None,
) -> Outcome[ModuloMapping]:
    """A mapping within the problem's windows. "refuted": these windows hold none (that satisfies
    what `extend` adds).

    The model counts the words of a register file per slot. When the stays of a solution fit no
    allocation, that combination is excluded and the model solved again: held cycles that are a
    superset, cut nowhere inside, would fail alike.
    """
    if problem.cyclic:
        raise ValueError("the cyclic problem has no mappings: use refute_folded")
    joint = build(problem, dropped)
    if extend is not None:
        extend(ModelHandle(joint.model, problem, joint.variables, []))
    return solved(problem, joint, search)


def solved(problem: Prepared, joint: JointModel, search: Search) -> Outcome[ModuloMapping]:
    """Solve a model until the registers of its solution have names."""
    while True:
        outcome = run(
            joint.model,
            search,
            lambda value: extract(problem, joint.variables, lambda x: bool(value(x))),
        )
        if outcome.value is None:
            return Outcome(outcome.verdict)
        if outcome.value.mapping is not None:
            found = outcome.value.mapping
            return Outcome("found", found, outcome.objective, outcome.bound)
        _exclude(joint, outcome.value)


def refute_folded(problem: Prepared, search: Search) -> Outcome[bool]:
    """Solve the cyclic relaxation: "refuted" refutes the II, "found" says nothing."""
    return run(build(problem).model, search, lambda _: True)


def _exclude(joint: JointModel, extracted: Extracted) -> None:
    for clash in extracted.conflicts:
        joint.model.add_bool_or(_escapes(joint.variables, clash))


def _escapes(variables: Variables, clash: RegisterConflict) -> list[LiteralT]:
    freed = [~variables.held[key] for key in clash.held]
    cut = [variables.written[key] for key in clash.inside]
    return [*freed, *cut]
