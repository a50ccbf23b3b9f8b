"""What one stage of a plan finds of a graph serves another, with other names of variables."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import vividc
from vividc import arch
from vividc.arch.fabric import Fabric
from vividc.compiler.driver import lower
from vividc.compiler.regions import map_regions, one_straight
from vividc.compiler.regions.earlier import Earlier, posed
from vividc.compiler.regions.map_regions import MapOptions, map_kernel
from vividc.dfg.alike import names, numbered
from vividc.dfg.ir import DFG
from vividc.dfg.regions import Kernel
from vividc.machine.opcodes import Opcode
from vividc.mapper import MapProblem, MapResult
from vividc.mapper.engines.list_schedule import list_schedule
from vividc.mapper.mapping import Mapping
from vividc.mapper.resources.banks import Meets
from vividc.mapper.result import mapping_of


@vividc.kernel("void(float32[::1], float32[::1], float32)")
def scaled(x, y, p):
    for i in range(len(x)):
        y[i] = x[i] * p + np.float32(2.0)


def tile() -> Fabric:
    fabric = arch.load("vivid-tile")
    assert isinstance(fabric, Fabric)
    return fabric


def renamed(dfg: DFG) -> DFG:
    """The graph as another stage would have it."""
    variables = (Opcode.LIVE_IN, Opcode.LIVE_OUT)
    nodes = (
        replace(node, name=f"{node.name}'") if node.op in variables else node for node in dfg.nodes
    )
    return replace(dfg, name="another", nodes=tuple(nodes))


def loop_of(kernel: Kernel) -> DFG:
    (loop,) = (region.dfg for region in kernel.regions if region.kind == "loop")
    return loop


def test_graphs_that_differ_in_names_only_are_equal() -> None:
    loop = loop_of(lower(scaled))
    assert renamed(loop) != loop
    again = renamed(loop)
    assert numbered(again, names(again)) == numbered(loop, names(loop))
    one, *others = (node for node in loop.nodes if node.op is Opcode.LIVE_IN)
    merged = tuple(replace(n, name=one.name) if n in others else n for n in loop.nodes)
    other = replace(loop, nodes=merged)
    assert numbered(other, names(other)) != numbered(loop, names(loop))


def test_words_of_others_count_by_number_and_by_whether_the_graph_has_them() -> None:
    loop = loop_of(lower(scaled))
    name = next(node.name for node in loop.nodes if node.op is Opcode.LIVE_IN)

    def with_held(graph: DFG, *names: str) -> object:
        held = {0: frozenset(("live_in", each) for each in names)}
        return posed(MapProblem(graph, tile(), {}, held))

    assert with_held(loop, "q") == with_held(loop, "r")
    assert with_held(loop, name) == with_held(renamed(loop), f"{name}'")
    assert with_held(loop, name) != with_held(loop, "q")
    assert with_held(loop, "q") != with_held(loop, "q", "r")


def test_an_equal_kernel_is_mapped_without_a_search(monkeypatch: pytest.MonkeyPatch) -> None:
    kernel, fabric, earlier = lower(scaled), tile(), Earlier()
    other = replace(
        kernel,
        regions=tuple(replace(region, dfg=renamed(region.dfg)) for region in kernel.regions),
    )
    first = map_kernel(kernel, fabric, MapOptions(), earlier)

    def none(*_: object, **__: object) -> MapResult:
        raise AssertionError("a search")

    def scheduled(
        problem: MapProblem, goes_on: Callable[[], bool], *, frugal: bool, meets: Meets
    ) -> Mapping:
        again.append(problem.dfg.name)
        return list_schedule(problem, goes_on, frugal=frugal, meets=meets)

    again: list[str] = []
    monkeypatch.setattr(map_regions, "map_dfg", none)
    monkeypatch.setattr(one_straight, "list_schedule", scheduled)
    second = map_kernel(other, fabric, MapOptions(), earlier)
    assert isinstance(first, tuple)
    assert isinstance(second, tuple)
    assert not again
    for index, result in first[1].items():
        assert mapping_of(second[1][index]) == mapping_of(result)
