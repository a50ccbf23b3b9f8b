"""Without any one family for a fabric's options the solver finds what the whole model refutes."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Final

import pytest
from option_fabrics import FABRICS
from ortools.sat.python.cp_model import FEASIBLE, INFEASIBLE, OPTIMAL, CpSolver
from random_graphs import random_loop

from vividc.mapper.engines.cpsat import Prepared, build, windowed
from vividc.mapper.problem import MapProblem

OPTION_FAMILIES: Final = (
    "outputs_keep_words",
    "results_enter_outputs",
    "moves_find_the_word",
    "one_word_per_output_and_slot",
    "words_pass_links",
)
_SLACK = 2


@pytest.mark.parametrize("family", OPTION_FAMILIES)
def test_each_family_refutes_something(family: str) -> None:
    assert any(_status(problem, {family}) in (OPTIMAL, FEASIBLE) for problem in _refuted())


@cache
def _refuted() -> tuple[Prepared, ...]:
    return tuple(p for p in _problems() if _status(p, set()) == INFEASIBLE)


def _problems() -> Iterator[Prepared]:
    for fabric in FABRICS.values():
        for seed in (2, 16, 19):
            for ii in (1, 2):
                try:
                    yield windowed(MapProblem(random_loop(seed, 4), fabric), ii, _SLACK)
                except ValueError:  # below the RecMII
                    continue


def _status(problem: Prepared, dropped: set[str]) -> int:
    solver = CpSolver()
    solver.parameters.num_workers = 1
    return int(solver.solve(build(problem, dropped).model))
