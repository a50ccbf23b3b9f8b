"""Mappers of a process: functions given as they are, or by a name."""

from __future__ import annotations

import pytest

import vividc
from tests.launch.kernels import saxpy
from vividc.errors import VividcError
from vividc.mapper import (
    MapProblem,
    MapRequest,
    MapResult,
    map_dfg,
    mapper_names,
    register,
    unregister,
)
from vividc.mapper.published.ims import ims

ADDS = vividc.dfg.from_json(
    {
        "name": "adds",
        "nodes": [{"id": node, "op": "add"} for node in range(3)],
        "edges": [{"src": 0, "dst": 1, "distance": 0}, {"src": 1, "dst": 2, "distance": 0}],
    }
)
FABRIC = vividc.arch.load("mesh-2x2")


class Counted:
    """`ims`, counting how often it is asked."""

    def __init__(self) -> None:
        self.calls = 0

    def __call__(self, problem: MapProblem, request: MapRequest) -> MapResult:
        self.calls += 1
        return ims(problem, request)


def test_a_function_maps_as_it_is_and_by_its_name() -> None:
    mine = Counted()
    result = map_dfg(ADDS, FABRIC, mine)
    assert (result.status, mine.calls) == ("optimal", 1)
    register("counted", mine)
    assert "counted" in mapper_names()
    assert map_dfg(ADDS, FABRIC, "counted").ii == result.ii
    register("counted", Counted())  # the new one takes the name
    map_dfg(ADDS, FABRIC, "counted")
    assert mine.calls == 2
    unregister("counted")
    assert "counted" not in mapper_names()
    with pytest.raises(VividcError, match="unknown mapper 'counted'"):
        map_dfg(ADDS, FABRIC, "counted")


def test_a_kernel_is_compiled_with_it() -> None:
    mine = Counted()
    program = vividc.compile(saxpy, mapper=mine, loops=vividc.LoopOptions(auto=False))
    assert mine.calls
    assert {region.kind for region in program.regions} == {"loop", "straight"}


def test_faults_are_the_functions_own() -> None:
    def broken(problem: MapProblem, request: MapRequest) -> MapResult:
        raise ZeroDivisionError("no time")

    with pytest.raises(VividcError, match=r"broken' failed with ZeroDivisionError: no time"):
        map_dfg(ADDS, FABRIC, broken)


@pytest.mark.parametrize("name", ["auto", "", "  "])
def test_names_that_cannot_be_taken(name: str) -> None:
    with pytest.raises(VividcError, match="the name of a mapper cannot be"):
        register(name, ims)


def test_what_is_no_mapper_is_refused() -> None:
    with pytest.raises(VividcError, match="not callable"):
        register("seven", 7)  # type: ignore[arg-type]
    with pytest.raises(VividcError, match="the mapper cannot be 7"):
        map_dfg(ADDS, FABRIC, 7)  # type: ignore[arg-type]
