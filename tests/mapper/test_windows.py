"""Rectangles of an array: fabrics whose mappings are mappings of the array."""

from __future__ import annotations

from dataclasses import replace

import pytest
from random_graphs import random_loop

from vividc.arch import load
from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG, Edge, Node
from vividc.dfg.opcodes import Opcode
from vividc.mapper import MapResult, map_dfg
from vividc.mapper.deadline import Deadline
from vividc.mapper.problem import MapProblem
from vividc.mapper.registry import find_mapper
from vividc.mapper.request import MapRequest
from vividc.mapper.verify import violations
from vividc.mapper.windows import window, with_windows

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
    result = find_mapper("auto")(MapProblem(random_loop(5, 30), load("mesh-8x8")), request)
    assert result.status == "timeout"
    assert not any("window" in line for line in lines)


def test_sixteen_by_sixteen_takes_a_window() -> None:
    nodes = tuple(Node(i, Opcode.GENERIC) for i in range(24))
    edges = tuple(Edge(i, i + 1, 0) for i in range(23))
    lines: list[str] = []
    result = map_dfg(
        DFG("chain", nodes, edges), load("mesh-16x16"), workers=1, progress=lines.append
    )
    assert (result.status, result.ii) == ("optimal", 1)
    assert any("window" in line for line in lines)


@pytest.mark.parametrize("windows_map", [True, False])
def test_what_maps_tells_when(windows_map: bool) -> None:
    """Seconds to a window's mapping, or to the array's after those of the windows."""
    array = load("mesh-5x5")

    def mapper(problem: MapProblem, request: MapRequest) -> MapResult:
        result = find_mapper("auto")(problem, request)
        if problem.fabric == array:
            return replace(result, stats={"found_s": 200.0})
        mapping = result.mapping if windows_map else None
        return replace(result, mapping=mapping, stats={"found_s": 100.0})

    problem = MapProblem(random_loop(5, 12), array)
    result = with_windows(mapper)(problem, MapRequest(None, Deadline.after(60.0), 1))
    assert result.mapping is not None
    first_s = 100.0 if windows_map else 200.0
    assert first_s < result.stats["found_s"] < first_s + 60.0
