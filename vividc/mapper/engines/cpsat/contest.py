"""CP-SAT's search and its local search on one model; effort decides which of the two counts.

CP-SAT with several workers is fast because they are unlike each other, but what it finds depends
on which thread comes first. Each of the two here runs on one thread and repeats itself exactly, and
a solution of the local search counts before one of the search, whichever came first.
"""

from __future__ import annotations

import threading
from typing import Final

from ortools.sat.python.cp_model import FEASIBLE, INFEASIBLE, OPTIMAL, CpModel, CpSolver

from vividc.errors import InternalError

_POLL_S: Final = 0.1


class Contender:
    """A solver that works in a thread: the main thread stays free to take a KeyboardInterrupt and
    pass it on.
    """

    def __init__(self, solver: CpSolver, model: CpModel, news: threading.Event) -> None:
        self.solver = solver
        self._model, self._news = model, news
        self._status: list[int] = []
        self._faults: list[Exception] = []
        self._begun, self._given_up = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._work, daemon=True)

    def start(self) -> None:
        """Begin to solve."""
        self._thread.start()

    def stop(self) -> None:
        """End the thread. Whatever moment that is: either it is seen to have begun, or it sees
        that it was given up.
        """
        self._given_up.set()
        while self._begun.is_set() and self._thread.is_alive():
            self.solver.stop_search()  # without effect until the solver has set itself up
            self._thread.join(_POLL_S)

    @property
    def ended(self) -> bool:
        """Whether it was started and has finished."""
        return self._thread.ident is not None and not self._thread.is_alive()

    @property
    def status(self) -> int:
        """Its status; an exception is raised here, in the caller's thread."""
        if self._faults:
            raise self._faults[0]
        if not self._status:
            raise InternalError("the solver stopped without a status")
        return self._status[0]

    def _work(self) -> None:
        try:
            self._begun.set()
            if not self._given_up.is_set():
                self._status.append(int(self.solver.solve(self._model)))
        except Exception as fault:
            self._faults.append(fault)
        finally:
            self._news.set()


def solve_alone(solver: CpSolver, model: CpModel) -> int:
    """The status that a solver ends with."""
    news = threading.Event()
    one = Contender(solver, model, news)
    try:
        one.start()
        _wait(one, news)
    except BaseException:
        one.stop()
        raise
    return one.status


def solve_beside(search: CpSolver, jumps: CpSolver, model: CpModel, workers: int) -> CpSolver:
    """The solver whose outcome counts: `jumps` where it finds a solution (with an objective: a
    better one, or a best one) within its own limit, otherwise `search`.

    With one worker they work one after the other; the outcome is the same.
    """
    news = threading.Event()
    first, second = Contender(jumps, model, news), Contender(search, model, news)
    try:
        first.start()
        if workers > 1:
            second.start()
        while not first.ended:
            _rest(news)
            if second.ended and second.status == INFEASIBLE:  # there is nothing to find
                first.stop()
                return search
        if _is_decided(first, model):
            second.stop()
            return jumps
        if workers == 1:
            second.start()
        _wait(second, news)
    except BaseException:
        first.stop()
        second.stop()
        raise
    return jumps if _is_better(first, second, model) else search


def _wait(one: Contender, news: threading.Event) -> None:
    while not one.ended:
        _rest(news)


def _rest(news: threading.Event) -> None:
    news.wait(_POLL_S)
    news.clear()


def _is_decided(jumps: Contender, model: CpModel) -> bool:
    """Whether nothing better exists."""
    return jumps.status == OPTIMAL or (jumps.status == FEASIBLE and not model.has_objective())


def _is_better(jumps: Contender, search: Contender, model: CpModel) -> bool:
    if jumps.status != FEASIBLE or search.status in (OPTIMAL, INFEASIBLE):
        return False
    if search.status != FEASIBLE:
        return True
    return model.has_objective() and _cost(jumps, model) < _cost(search, model)


def _cost(one: Contender, model: CpModel) -> float:
    objective = one.solver.objective_value
    return objective if model.proto.objective.scaling_factor >= 0 else -objective
