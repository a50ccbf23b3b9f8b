"""Some mapping soon on fabrics whose words do not pass one link a cycle into any register."""

from __future__ import annotations

import pytest

from tests.mapper.graphs import chain
from tests.mapper.random_graphs import random_loop
from tests.mapper.tiny_fabrics import tiny_fabric
from vividc import arch
from vividc.dfg.ir import DFG
from vividc.mapper import map_dfg
from vividc.mapper.bounds.bounds import all_bounds, mii
from vividc.mapper.check.verify import verify
from vividc.mapper.deadline import Deadline
from vividc.mapper.problem import MapProblem
from vividc.mapper.request import MapRequest
from vividc.mapper.search.attempt import OPEN, Attempt
from vividc.mapper.search.campaign import Campaign
from vividc.mapper.search.foothold import gain_foothold, needs_foothold
from vividc.mapper.search.portfolio import climb, ii_limit


def campaign(fabric: str, dfg: DFG) -> Campaign:
    problem = MapProblem(dfg, arch.load(fabric))
    request = MapRequest(None, Deadline.after(60.0), 1)
    return Campaign(problem, request, lambda *_: OPEN, mii(all_bounds(problem)))


@pytest.mark.parametrize(
    ("fabric", "dfg"),
    [
        ("hycube-4x4", random_loop(3, 18)),
        ("hycube-4x4", random_loop(4, 18)),
        ("openedge-4x4", chain(9)),
        ("openedge-4x4", chain(20)),
    ],
)
def test_a_foothold_is_a_legal_mapping_and_refutes_nothing(fabric: str, dfg: DFG) -> None:
    search = campaign(fabric, dfg)
    lower = search.lower
    assert needs_foothold(search.problem)
    gain_foothold(search, ii_limit(search.problem))
    assert search.best is not None
    assert verify(search.problem.dfg, search.problem.fabric, search.best) == []
    assert search.lower == lower
    assert not search.refuted


def test_a_foothold_leaves_time_for_the_search() -> None:
    search = campaign("hycube-4x4", random_loop(3, 18))
    before = search.request.deadline.at
    gain_foothold(search, ii_limit(search.problem))
    assert search.request.deadline.at >= before


def test_small_graphs_on_plain_fabrics_need_none() -> None:
    assert not needs_foothold(MapProblem(random_loop(3, 18), arch.load("mesh-4x4")))


def test_no_foothold_beyond_the_configuration_memory() -> None:
    """The only II was refuted, and the next one negotiated: an internal error."""
    fabric = tiny_fabric(1, 3, registers=1, constants=12, max_stages=2, contexts=1)
    result = map_dfg(random_loop(80, 4), fabric, time_limit_s=30, workers=1)
    assert result.status == "infeasible"


def test_below_a_foothold_the_iis_between_come_before_the_bound() -> None:
    """The bound was tried for the same time before: another II is likelier to map."""
    tried = []

    def strategy(_: MapProblem, ii: int, *__: object) -> Attempt:
        tried.append(ii)
        return OPEN

    search = campaign("mesh-4x4", random_loop(3, 18))
    search.strategy = strategy
    lower = search.lower
    search.best = map_dfg(search.problem.dfg, search.problem.fabric, ii=lower + 3).mapping
    climb(search, 10.0, 1.0)
    search.tries = {lower: 1}
    climb(search, 10.0, 1.0)
    assert tried == [lower, lower + 1, lower + 2, lower + 1, lower + 2]
