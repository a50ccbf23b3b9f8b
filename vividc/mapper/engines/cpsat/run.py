"""Runs CP-SAT on a model within a deadline, so that Ctrl-C stops it; three outcomes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final, Generic, Literal, TypeVar

from ortools.sat.python.cp_model import (
    FEASIBLE,
    INFEASIBLE,
    MODEL_INVALID,
    OPTIMAL,
    CpModel,
    CpSolver,
    LinearExprT,
)

from vividc.errors import InternalError
from vividc.mapper.deadline import Deadline
from vividc.mapper.engines.cpsat.contest import solve_alone, solve_beside

Verdict = Literal["found", "refuted", "unknown"]
T = TypeVar("T")

_LIGHT_UNIT_S, _UNIT_S = 1.5, 2.5
"""Effort of a unit of OR-Tools' deterministic time, measured on graphs of `benchmarks/mappers`."""
_JUMP_UNIT_S: Final = 1.0
_BASE_S: Final = 0.005
_SIZE_S: Final = 2e-5
"""Effort of building a model, and of each variable in it with its constraints."""
_JUMPS: Final = 0.5
"""Units that the local search may spend; it finds most of its solutions in half of that."""
_LEAST_FOR_JUMPS, _MOST_FOR_SHORT, _SHORT = 200, 5000, 0.1
"""Variables from which the local search is of use, up to which the search is first tried alone, and
for how many units.
"""


@dataclass(frozen=True, slots=True)
class Search:
    """Resources of one solver run.

    `light` leaves out probing, symmetry detection and the LP: finding a placement needs none of
    them, and they took up to two thirds of its time; proofs profit from all three. `as_hinted`
    fixes every variable that has a hint to it. `jumps` has CP-SAT's local search tried, too, beside
    the search where there are two `workers`: their number changes no outcome.
    """

    deadline: Deadline
    workers: int = 2
    seed: int = 0
    light: bool = False
    as_hinted: bool = False
    jumps: bool = True


@dataclass(frozen=True, slots=True)
class Outcome(Generic[T]):
    """ "found" with a value; "refuted": the model has no solution; "unknown": time ran out.

    `objective`: of the value, where the model has one; no solution has less than `bound`.
    """

    verdict: Verdict
    value: T | None = None
    objective: float = 0.0
    bound: float = 0.0


def run(
    model: CpModel, search: Search, read: Callable[[Callable[[LinearExprT], int]], T]
) -> Outcome[T]:
    """Solve; `read` turns the solution into a value."""
    meter = search.deadline.meter
    size = len(model.proto.variables)
    meter.charge(_BASE_S + _SIZE_S * size)
    if search.deadline.passed:
        return Outcome("unknown")
    if not search.jumps or search.as_hinted or size < _LEAST_FOR_JUMPS:
        return _outcome(_alone(model, search, search.deadline.remaining_s), model, read)
    if size <= _MOST_FOR_SHORT:
        solver = _alone(model, search, min(_SHORT * _unit_s(search), search.deadline.remaining_s))
        if solver.response_proto.status in (OPTIMAL, INFEASIBLE) or search.deadline.passed:
            return _outcome(solver, model, read)
    return _outcome(_beside_jumps(model, search), model, read)


def _alone(model: CpModel, search: Search, limit_s: float) -> CpSolver:
    solver = _solver(search, limit_s / _unit_s(search))
    solve_alone(solver, model)
    _charge(solver, search, _unit_s(search))
    return solver


def _beside_jumps(model: CpModel, search: Search) -> CpSolver:
    units = search.deadline.remaining_s / _unit_s(search)
    solver, jumps = _solver(search, units), _solver(replace(search, light=True), min(_JUMPS, units))
    jumps.parameters.use_ls_only = True
    won = solve_beside(solver, jumps, model, search.workers)
    _charge(won, search, _JUMP_UNIT_S if won is jumps else _unit_s(search))
    return won


def _solver(search: Search, units: float) -> CpSolver:
    """A solver on one thread, limited in units of deterministic time."""
    solver = CpSolver()
    solver.parameters.num_workers = 1
    solver.parameters.random_seed = search.seed
    solver.parameters.max_deterministic_time = units
    solver.parameters.max_time_in_seconds = search.deadline.meter.guard_s
    solver.parameters.catch_sigint_signal = False
    solver.parameters.fix_variables_to_their_hinted_value = search.as_hinted
    if search.light:
        solver.parameters.cp_model_probing_level = 0
        solver.parameters.symmetry_level = 0
        solver.parameters.linearization_level = 0
    return solver


def _unit_s(search: Search) -> float:
    return _LIGHT_UNIT_S if search.light else _UNIT_S


def _charge(solver: CpSolver, search: Search, unit_s: float) -> None:
    search.deadline.charge(solver.response_proto.deterministic_time * unit_s)
    if solver.response_proto.status not in (OPTIMAL, INFEASIBLE):
        _ = search.deadline.meter.guard_s  # where the clock has stopped it, that is noted


def _outcome(
    solver: CpSolver, model: CpModel, read: Callable[[Callable[[LinearExprT], int]], T]
) -> Outcome[T]:
    status = solver.response_proto.status
    if status in (OPTIMAL, FEASIBLE):
        value = read(solver.value)
        return Outcome("found", value, solver.objective_value, solver.best_objective_bound)
    if status == INFEASIBLE:
        return Outcome("refuted")
    if status == MODEL_INVALID:
        raise InternalError(f"invalid solver model: {model.validate()}")
    return Outcome("unknown")
