"""Wrong types at the front doors are the user's errors, with a way out; no AttributeError."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import vividc
from benchmarks.workloads import WORKLOADS
from vividc.dfg.ir import DFG, Edge, Node
from vividc.machine.opcodes import Opcode

MESH = vividc.arch.load("mesh-2x2")
GRAPH = DFG("one", (Node(0, Opcode.GENERIC, name="op"),), ())
KERNEL = WORKLOADS[0].kernel()


def plain(x: object) -> object:
    return x


@pytest.mark.parametrize(
    "call",
    [
        lambda: vividc.compile(plain),  # type: ignore[arg-type]
        lambda: vividc.compile(KERNEL, fabric=None),  # type: ignore[arg-type]
        lambda: vividc.compile(KERNEL, time_limit_s="5"),  # type: ignore[arg-type]
        lambda: vividc.compile(KERNEL, time_limit_s=-1),
        lambda: vividc.compile(KERNEL, effort="all"),  # type: ignore[arg-type]
        lambda: vividc.compile(KERNEL, like=3),  # type: ignore[arg-type]
        lambda: vividc.compile(KERNEL, like={3: 3}),  # type: ignore[dict-item]
        lambda: vividc.compile(KERNEL, like=(1, 2, 3, 4, 5, 6)),
        lambda: vividc.simulate("a.vivid"),  # type: ignore[arg-type]
        lambda: vividc.simulate(KERNEL),  # type: ignore[arg-type]
        lambda: vividc.mapper.map_dfg(GRAPH, "mesh-2x2"),  # type: ignore[arg-type]
        lambda: vividc.mapper.map_dfg("x.json", MESH),  # type: ignore[arg-type]
        lambda: vividc.mapper.map_dfg(GRAPH, MESH, ii="2"),  # type: ignore[arg-type]
        lambda: vividc.mapper.map_dfg(GRAPH, MESH, ii=1.5),  # type: ignore[arg-type]
        lambda: vividc.mapper.map_dfg(GRAPH, MESH, ii=True),
        lambda: vividc.mapper.map_dfg(GRAPH, MESH, workers=True),
        lambda: vividc.mapper.map_dfg(GRAPH, MESH, time_limit_s=True),
        lambda: vividc.mapper.map_dfg(GRAPH, MESH, effort=3),  # type: ignore[arg-type]
        lambda: vividc.mapper.map_dfg(GRAPH, MESH, part="half"),  # type: ignore[arg-type]
        lambda: vividc.mapper.map_dfg(GRAPH, MESH, part=1.5),
        lambda: vividc.mapper.map_dfg(GRAPH, MESH, part=float("nan")),
        lambda: vividc.mapper.map_dfg(GRAPH, MESH, allowed=5),  # type: ignore[arg-type]
        lambda: vividc.mapper.map_dfg(GRAPH, MESH, allowed=0),  # type: ignore[arg-type]
        lambda: vividc.mapper.map_dfg(GRAPH, MESH, allowed={0: 1}),  # type: ignore[dict-item]
        lambda: vividc.mapper.map_dfg(GRAPH, MESH, allowed={"a": frozenset({0})}),  # type: ignore[dict-item]
        lambda: vividc.mapper.map_dfg(GRAPH, MESH, allowed={0: frozenset({"x", 9})}),  # type: ignore[dict-item]
        lambda: vividc.mapper.map_dfg(GRAPH, MESH, resident=[1]),  # type: ignore[arg-type]
        lambda: vividc.mapper.verify(GRAPH, MESH, None),  # type: ignore[arg-type]
        lambda: vividc.load(None),  # type: ignore[arg-type]
        lambda: vividc.arch.load(None),  # type: ignore[arg-type]
        lambda: vividc.dfg.load(None),  # type: ignore[arg-type]
        lambda: vividc.kernel(plain),  # type: ignore[arg-type]
        lambda: vividc.kernel("void(int32[::1])")(KERNEL),
    ],
)
def test_a_wrong_type_is_told(call: Callable[[], object]) -> None:
    with pytest.raises(vividc.VividcError) as caught:
        call()
    assert caught.value.hint or caught.value.loc


def test_a_distance_that_no_array_can_bridge_is_refuted_at_once() -> None:
    loop = DFG("far", GRAPH.nodes, (Edge(0, 0, 0, 10**12),))
    result = vividc.mapper.map_dfg(loop, MESH)
    assert result.status == "infeasible"
    assert "iterations later" in result.explain()


@pytest.mark.parametrize(("ii", "reason"), [(1000, "contexts"), (1, "lower bound 2")])
def test_a_requested_ii_out_of_range_says_why(ii: int, reason: str) -> None:
    nodes = tuple(Node(n, Opcode.GENERIC, name="op") for n in range(5))
    result = vividc.mapper.map_dfg(DFG("five", nodes, ()), MESH, ii=ii)
    assert result.status == "infeasible"
    assert reason in result.explain()


def test_a_foreign_operation_has_the_latency_of_its_name() -> None:
    fabric = vividc.arch.load("vivid-tile")
    latencies = [fabric.latency(Node(0, Opcode.GENERIC, name=n)) for n in ("FMUL", "add", "cmerge")]
    assert latencies == [4, 1, 1]


ODD = (None, "5", [1], {}, set(), b"x", 0.5, float("nan"), -1, 0, 1 << 80)


@pytest.fixture(scope="module")
def doubled() -> vividc.Program:
    return vividc.compile(KERNEL, loops=vividc.LoopOptions(auto=False))


@pytest.mark.parametrize("odd", ODD, ids=repr)
@pytest.mark.parametrize("name", ["cycle_limit", "engine", "observer", "progress", "fabric"])
def test_an_odd_option_of_a_run_is_named(doubled: vividc.Program, name: str, odd: object) -> None:
    if odd is None and name not in {"cycle_limit", "engine"}:
        return
    with pytest.raises(vividc.VividcError):
        vividc.simulate(doubled, **{name: odd})  # type: ignore[call-overload]


@pytest.mark.parametrize("odd", ODD, ids=repr)
def test_odd_places_in_a_job_are_named(odd: object) -> None:
    job = vividc.launch.Job("vivid")
    array = np.zeros(4, np.int32)
    for call in (
        lambda: job.move_in("a" if odd in ([1], 0) else odd, array, 0),  # type: ignore[arg-type]
        lambda: job.move_in(0, array, "a" if odd == 0 else odd),  # type: ignore[arg-type]
        lambda: job.move_out(0, 0, odd),  # type: ignore[arg-type]
        lambda: job.move_in(0, array, 0, after="a" if odd in ({}, []) else [odd, "x"]),  # type: ignore[list-item]
    ):
        with pytest.raises(vividc.VividcError):
            call()
