"""Solves the joint model of time, place and route within given windows, registers included."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Final

from ortools.sat.python.cp_model import CpModel

from vividc.arch.fabric import Fabric
from vividc.mapper.engines.cpsat.constraints import add_constraints
from vividc.mapper.engines.cpsat.extract import RegisterConflict, extract
from vividc.mapper.engines.cpsat.handle import Extension, ModelHandle
from vividc.mapper.engines.cpsat.problem import NodeAt, Prepared
from vividc.mapper.engines.cpsat.run import Outcome, Search, run
from vividc.mapper.engines.cpsat.variables import Variables, new_variables
from vividc.mapper.mapping import Mapping as ModuloMapping

MOST_CUTS: Final = 3000
"""Cuts for one conflict, over all its places and times."""


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

    The model counts the words of a register file per slot. When the lifetimes of a solution fit no
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
            mapping = outcome.value.mapping
            return Outcome("found", mapping, outcome.objective, outcome.bound)
        for clash in outcome.value.conflicts:
            exclude(problem, joint, clash)


def refute_folded(problem: Prepared, search: Search) -> Outcome[bool]:
    """Solve the cyclic relaxation: "refuted" refutes the II, "found" says nothing."""
    return run(build(problem).model, search, lambda _: True)


def exclude(problem: Prepared, joint: JointModel, clash: RegisterConflict) -> None:
    """What has no allocation has none at other times either, nor on PEs with equal files: an
    allocation knows cycles only relative to each other.
    """
    variables, cuts = joint.variables, 0
    horizon = max(time for _, _, time in variables.held)
    first = min(time for _, _, time in clash.held)
    for pe in _equal_files(problem.fabric, clash.pe):
        for shift in sorted(range(-first, horizon - first + 1), key=abs):
            held = _moved(clash.held, pe, shift)
            if cuts >= MOST_CUTS or any(key not in variables.held for key in held):
                continue
            inside = _moved(clash.inside, pe, shift)
            cut = [variables.written[key] for key in inside if key in variables.written]
            joint.model.add_bool_or([*(~variables.held[key] for key in held), *cut])
            cuts += 1


def _equal_files(fabric: Fabric, pe: int) -> list[int]:
    """PEs with as many registers that rotate alike, `pe` first."""
    wanted = fabric.pes[pe].registers, fabric.pes[pe].rotating
    others = [one.id for one in fabric.pes if (one.registers, one.rotating) == wanted]
    return [pe, *(one for one in others if one != pe)]


def _moved(keys: tuple[NodeAt, ...], pe: int, shift: int) -> tuple[NodeAt, ...]:
    return tuple((word, pe, time + shift) for word, _, time in keys)
