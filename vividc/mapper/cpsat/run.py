"""Runs CP-SAT on a model within a deadline, so that Ctrl-C stops it; three outcomes."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
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

Verdict = Literal["found", "refuted", "unknown"]
T = TypeVar("T")
_POLL_S = 0.1

_LIGHT_UNIT_S, _UNIT_S = 1.5, 2.5
"""Effort of a unit of OR-Tools' deterministic time, measured on graphs of `benchmarks/mappers`."""
_BASE_S: Final = 0.005
_SIZE_S: Final = 2e-5
"""Effort of building a model, and of each variable in it with its constraints."""


@dataclass(frozen=True, slots=True)
class Search:
    """Resources of one solver run.

    `light` leaves out probing, symmetry detection and the LP: finding a placement needs none of
    them, and they took up to two thirds of its time; proofs profit from all three. `as_hinted`
    fixes every variable that has a hint to it.
    """

    deadline: Deadline
    workers: int = 2
    seed: int = 0
    light: bool = False
    as_hinted: bool = False


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
    if search.deadline.passed:
        return Outcome("unknown")
    solver = CpSolver()
    meter = search.deadline.meter
    unit_s = _LIGHT_UNIT_S if search.light else _UNIT_S
    meter.charge(_BASE_S + _SIZE_S * len(model.proto.variables))
    # Several workers of CP-SAT do not find the same thing twice.
    solver.parameters.num_workers = 1
    solver.parameters.random_seed = search.seed
    solver.parameters.max_deterministic_time = search.deadline.remaining_s / unit_s
    solver.parameters.max_time_in_seconds = meter.guard_s
    solver.parameters.catch_sigint_signal = False
    solver.parameters.fix_variables_to_their_hinted_value = search.as_hinted
    if search.light:
        solver.parameters.cp_model_probing_level = 0
        solver.parameters.symmetry_level = 0
        solver.parameters.linearization_level = 0
    status = _solve(solver, model)
    meter.charge(solver.response_proto.deterministic_time * unit_s)
    if status not in (OPTIMAL, INFEASIBLE):
        _ = meter.guard_s  # where the clock has stopped it, that is noted
    if status in (OPTIMAL, FEASIBLE):
        value = read(solver.value)
        return Outcome("found", value, solver.objective_value, solver.best_objective_bound)
    if status == INFEASIBLE:
        return Outcome("refuted")
    if status == MODEL_INVALID:
        raise InternalError(f"invalid solver model: {model.validate()}")
    return Outcome("unknown")


def _solve(solver: CpSolver, model: CpModel) -> int:
    """Solve in a thread: the main thread stays free to take a KeyboardInterrupt and pass it on."""
    result: list[int] = []
    begun, given_up = threading.Event(), threading.Event()

    def work() -> None:
        begun.set()
        if not given_up.is_set():
            result.append(int(solver.solve(model)))

    thread = threading.Thread(target=work, daemon=True)
    try:
        thread.start()
        while thread.is_alive():
            thread.join(_POLL_S)
    except KeyboardInterrupt:
        # Whatever moment it came at: either the thread is seen to have begun, or it sees that.
        given_up.set()
        while begun.is_set() and thread.is_alive():
            solver.stop_search()  # without effect until the solver has set itself up
            thread.join(_POLL_S)
        raise
    if not result:
        raise InternalError("the solver stopped without a status")
    return result[0]
