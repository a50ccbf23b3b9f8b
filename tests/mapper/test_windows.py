"""Rectangles of an array: fabrics whose mappings are mappings of the array."""

from __future__ import annotations

import pytest
from random_graphs import random_loop

from vividc.arch import load
from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG, Edge, Node
from vividc.machine.opcodes import Opcode
from vividc.mapper import MapInterrupted, MapResult, map_dfg
from vividc.mapper.bounds.bounds import all_bounds, mii
from vividc.mapper.check.verify import violations
from vividc.mapper.deadline import Deadline
from vividc.mapper.problem import MapProblem
from vividc.mapper.request import Mapper, MapRequest
from vividc.mapper.search.portfolio import auto
from vividc.mapper.search.state import Attempt, IISearch
from vividc.mapper.search.windows import window, windows

_ARRAYS = ("mesh-5x6", "torus-6x5", "king-5x5", "hycube-5x5", "openedge-5x5", "adres-5x5")


@pytest.mark.parametrize("name", ["mesh-4x5", "hycube-5x4", "openedge-5x5", "adres-4x4"])
def test_a_mapping_to_a_window_is_one_to_the_array(name: str) -> None:
    fabric = load(name)
    for seed, corner in enumerate(((0, 0), (0, 1), (1, 0))):
        part = window(fabric, *corner, 3, 3)
        dfg = random_loop(seed, 8)
        result = map_dfg(dfg, part.fabric, time_limit_s=5, workers=1)
        if result.mapping is not None:
            assert violations(dfg, fabric, part.embed(result.mapping)) == []


def test_a_window_of_a_mesh_is_a_smaller_mesh() -> None:
    part, small = window(load("mesh-6x6"), 1, 2, 3, 4).fabric, load("mesh-3x4")
    assert part.pes == small.pes
    assert part.links == small.links


def test_a_window_of_full_height_keeps_the_links_round() -> None:
    part = window(load("torus-4x6"), 0, 1, 4, 2).fabric
    pairs = {(link.src, link.dst) for link in part.links}
    assert (0, 6) in pairs
    assert (0, 1) in pairs
    assert len(pairs) == 4 * 2 * 2 + 4 * 2


@pytest.mark.parametrize("name", _ARRAYS)
def test_large_arrays_map_small_graphs_at_their_bound(name: str) -> None:
    dfg = random_loop(5, 12)
    result = map_dfg(dfg, load(name), time_limit_s=30, workers=1)
    assert result.status == "optimal"
    assert result.mapping is not None
    assert violations(dfg, load(name), result.mapping) == []


@pytest.mark.parametrize("family", ["mesh", "king", "hycube"])
def test_a_larger_array_is_never_worse(family: str) -> None:
    for seed in range(4):
        dfg = random_loop(seed, 10)
        found = [_ii(dfg, load(f"{family}-{side}x{side}")) for side in (2, 3, 4, 5, 7)]
        assert found == sorted(found, reverse=True), (seed, found)


def _ii(dfg: DFG, fabric: Fabric) -> int:
    ii = map_dfg(dfg, fabric, time_limit_s=20, workers=1).ii
    return 10**6 if ii is None else ii


def test_no_window_is_tried_after_the_deadline() -> None:
    """Each window's bounds and models took their time, however late it was."""
    lines: list[str] = []
    request = MapRequest(None, Deadline.after(0.0), 1, lines.append)
    result = auto(MapProblem(random_loop(5, 30), load("mesh-8x8")), request)
    assert result.status == "timeout"
    assert not any("window" in line for line in lines)


def test_sixteen_by_sixteen_maps_at_once() -> None:
    nodes = tuple(Node(i, Opcode.GENERIC) for i in range(24))
    edges = tuple(Edge(i, i + 1, 0) for i in range(23))
    result = map_dfg(DFG("chain", nodes, edges), load("mesh-16x16"), workers=1)
    assert (result.status, result.ii) == ("optimal", 1)


def _search(lines: list[str], mapper: Mapper = auto, best_ii: int | None = None) -> IISearch:
    """On an array with a mapping at some II that is not the least."""
    problem = MapProblem(random_loop(5, 12), load("mesh-5x5"))
    request = MapRequest(None, Deadline.after(60.0), 1, lines.append)
    lower = mii(all_bounds(problem))
    search = IISearch(problem, request, _never, lower, in_window=mapper)
    if best_ii is not None:
        search.incumbent = map_dfg(problem.dfg, problem.fabric, ii=lower + best_ii).mapping
        assert search.incumbent is not None
    return search


def _never(*_: object) -> Attempt:
    raise AssertionError("windows try no II of the array")


@pytest.mark.parametrize("best_ii", [None, 2])
def test_a_windows_mapping_is_kept_where_it_is_better(best_ii: int | None) -> None:
    lines: list[str] = []
    search = _search(lines, auto, best_ii)
    assert len(list(windows(search))) == 1
    assert search.incumbent is not None
    assert search.incumbent.ii == search.lower
    assert violations(search.problem.dfg, search.problem.fabric, search.incumbent) == []
    assert sum("trying the window" in line for line in lines) == 1


def test_what_no_window_betters_stays() -> None:
    asked: list[MapRequest] = []

    def mapper(problem: MapProblem, request: MapRequest) -> MapResult:
        asked.append(request)
        return MapResult("timeout", None, 1, (), request.known, "none", 0.0)

    search = _search([], mapper, 2)
    best = search.incumbent
    assert list(windows(search))
    assert search.incumbent is best
    assert asked
    assert all(request.known is best for request in asked)
    assert [r.deadline.at for r in asked] == sorted(r.deadline.at for r in asked)


@pytest.mark.parametrize("best_ii", [None, 2])
def test_an_interrupt_keeps_the_windows_mapping(best_ii: int | None) -> None:
    def mapper(problem: MapProblem, request: MapRequest) -> MapResult:
        raise MapInterrupted(auto(problem, request))

    search = _search([], mapper, best_ii)
    with pytest.raises(KeyboardInterrupt):
        list(windows(search))
    assert search.incumbent is not None
    assert search.incumbent.ii == search.lower
    assert violations(search.problem.dfg, search.problem.fabric, search.incumbent) == []


def test_nothing_is_searched_below_the_bound() -> None:
    lines: list[str] = []
    assert list(windows(_search(lines, auto, 0))) == []
    assert lines == []


@pytest.mark.parametrize("nodes", [12, 50])
def test_what_is_known_comes_back_where_nothing_better_is_found(nodes: int) -> None:
    problem = MapProblem(random_loop(5, nodes), load("mesh-4x4"))
    known = map_dfg(problem.dfg, problem.fabric, workers=1, time_limit_s=20).mapping
    assert known is not None
    result = auto(problem, MapRequest(None, Deadline.after(2.0), 1, known=known))
    assert result.mapping is known


def test_schedules_are_placed_in_windows_of_a_large_array() -> None:
    """With 256 PEs for each node placing alone takes longer than there is time."""
    told: list[str] = []
    dfg, fabric = random_loop(1, 16), load("mesh-16x16")
    result = map_dfg(dfg, fabric, "decoupled", time_limit_s=60, progress=told.append)
    assert result.status == "optimal"
    assert "trying the window" in " ".join(told)


@pytest.mark.parametrize(("name", "first"), [("openedge-12x12", True), ("mesh-12x12", False)])
def test_a_sparse_graph_begins_in_a_window_where_fus_move_words(name: str, first: bool) -> None:
    """A cycle of 12 operations, and a tail: 42 of 1728 slots at the bound."""
    nodes = tuple(Node(i, Opcode.GENERIC) for i in range(42))
    edges = (*(Edge(i, i + 1, 0) for i in range(41)), Edge(11, 0, 1, 1))
    told: list[str] = []
    dfg, fabric = DFG("cycle", nodes, edges), load(name)
    result = map_dfg(dfg, fabric, time_limit_s=60, workers=1, progress=told.append)
    assert (result.status, result.ii) == ("optimal", 12)
    assert result.mapping is not None
    assert violations(dfg, fabric, result.mapping) == []
    assert any("window" in line for line in told) == first
