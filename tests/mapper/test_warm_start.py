"""A first mapping on fabrics whose words do not pass one link a cycle into any register."""

from __future__ import annotations

import pytest

from tests.mapper.graphs import accumulator, chain
from tests.mapper.random_graphs import random_loop
from tests.mapper.tiny_fabrics import tiny_fabric
from vividc import arch
from vividc.dfg.ir import DFG
from vividc.mapper import map_dfg
from vividc.mapper.bounds.bounds import all_bounds, mii
from vividc.mapper.bounds.straight import end_after_start
from vividc.mapper.check.verify import verify
from vividc.mapper.deadline import Deadline
from vividc.mapper.engines.negotiate import least_span
from vividc.mapper.problem import MapProblem
from vividc.mapper.request import MapRequest
from vividc.mapper.search.attempt import needs_warm_start
from vividc.mapper.search.climb import climb
from vividc.mapper.search.state import OPEN, Attempt, IISearch
from vividc.mapper.search.tuning import SHORT
from vividc.mapper.search.warm_start import negotiate_at_bound, warm_start


def started(fabric: str, dfg: DFG) -> IISearch:
    problem = MapProblem(dfg, arch.load(fabric))
    request = MapRequest(None, Deadline.after(60.0), 1)
    return IISearch(problem, request, lambda *_: OPEN, mii(all_bounds(problem)))


@pytest.mark.parametrize(
    ("fabric", "dfg"),
    [
        ("hycube-4x4", random_loop(3, 18)),
        ("hycube-4x4", random_loop(4, 18)),
        ("openedge-4x4", chain(9)),
        ("openedge-4x4", chain(20)),
    ],
)
def test_a_warm_start_is_a_legal_mapping_and_refutes_nothing(fabric: str, dfg: DFG) -> None:
    search = started(fabric, dfg)
    lower = search.lower
    assert needs_warm_start(search.problem)
    warm_start(search)
    assert search.incumbent is not None
    assert verify(search.problem.dfg, search.problem.fabric, search.incumbent) == []
    assert search.lower == lower
    assert not search.refuted


def test_a_warm_start_leaves_time_for_the_search() -> None:
    search = started("hycube-4x4", random_loop(3, 18))
    before = search.request.deadline.at
    warm_start(search)
    assert search.request.deadline.at >= before


def test_small_graphs_on_plain_fabrics_need_none() -> None:
    assert not needs_warm_start(MapProblem(random_loop(3, 18), arch.load("mesh-4x4")))


@pytest.mark.parametrize("dfg", [chain(9), accumulator(), random_loop(3, 12)], ids=lambda g: g.name)
def test_iterations_of_small_graphs_are_as_short_as_dependences_allow(dfg: DFG) -> None:
    search = started("vivid-tile", dfg)
    negotiate_at_bound(search)
    made = search.incumbent
    assert made is not None
    assert made.ii == search.lower
    assert verify(dfg, search.problem.fabric, made) == []
    ends = (
        place.time + end_after_start(search.problem.fabric, dfg.by_id[node])
        for node, place in made.places.items()
    )
    assert max(ends) <= least_span(search.problem, made.ii) + max(SHORT)


def test_no_warm_start_beyond_the_configuration_memory() -> None:
    """The only II was refuted, and the next one negotiated: an internal error."""
    fabric = tiny_fabric(1, 3, registers=1, constants=12, max_stages=2, contexts=1)
    result = map_dfg(random_loop(80, 4), fabric, time_limit_s=30, workers=1)
    assert result.status == "infeasible"


def test_below_an_incumbent_the_iis_between_come_before_the_bound() -> None:
    """The bound was tried for the same time before: another II is likelier to map."""
    tried = []

    def attempt(_: MapProblem, ii: int, *__: object) -> Attempt:
        tried.append(ii)
        return OPEN

    search = started("mesh-4x4", random_loop(3, 18))
    search.attempt = attempt
    lower = search.lower
    search.incumbent = map_dfg(search.problem.dfg, search.problem.fabric, ii=lower + 3).mapping
    climb(search, lambda _: 2.0)
    search.tries = {lower: 1}
    climb(search, lambda _: 2.0)
    assert tried == [lower, lower + 1, lower + 2, lower + 1, lower + 2]
