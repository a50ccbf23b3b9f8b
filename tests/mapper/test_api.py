"""`map_dfg` as a caller sees it: status, bounds, limits, homes, errors."""

from __future__ import annotations

import _thread
import gc
import signal
import threading
import time
from dataclasses import replace

import pytest
from fabrics import EVERYTHING, grid
from graphs import GraphBuilder, accumulator, blending, chain

from vividc import arch
from vividc.errors import InternalError, VividcError
from vividc.machine.opcodes import LatencyClass, Opcode
from vividc.mapper import MapProblem, MapRequest, MapResult, map_dfg, registry, violations
from vividc.mapper.problem import ConstantKey


@pytest.mark.parametrize("mapper", ["auto", "cpsat", "decoupled"])
def test_every_built_in_mapper_maps_a_small_loop(mapper: str) -> None:
    fabric = grid(2, 2, latencies={LatencyClass.FADD: 4, LatencyClass.LOAD: 2})
    result = map_dfg(accumulator(), fabric, mapper, time_limit_s=120, workers=1)
    assert (result.status, result.ii, result.lower_bound) == ("optimal", 4, 4)
    assert result.bounds[0].name == "RecMII"
    assert result.mapper == mapper


@pytest.mark.parametrize("fabric", ["vivid-tile", "vivid-tile-unit"])
def test_blending_reaches_its_mii(fabric: str) -> None:
    result = map_dfg(blending(), arch.load(fabric), time_limit_s=60, workers=1)
    assert result.status == "optimal", result.explain()
    assert result.ii == result.bounds[0].ii


def test_a_requested_ii_is_the_only_one_tried() -> None:
    result = map_dfg(chain(4), grid(2, 2), ii=3, time_limit_s=120, workers=1)
    assert (result.status, result.ii, result.lower_bound) == ("feasible", 3, 1)


def test_an_ii_below_a_bound_is_infeasible() -> None:
    result = map_dfg(chain(9), grid(2, 2), ii=2, time_limit_s=120, workers=1)
    assert (result.status, result.mapping, result.lower_bound) == ("infeasible", None, 3)


def test_an_ii_that_only_routing_forbids_is_refuted() -> None:
    """Each of three operations reads those before it: on three PEs in a row a word has no way."""
    g = GraphBuilder("triangle")
    iv, one = g.source(Opcode.IV), g.const(1)
    first = g.op(Opcode.ADD, iv, one)
    second = g.op(Opcode.ADD, first, one)
    g.op(Opcode.ADD, first, second)
    fabric = grid(1, 3)
    below = map_dfg(g.build(), fabric, ii=1, time_limit_s=120, workers=1)
    assert below.status == "infeasible"
    least = map_dfg(g.build(), fabric, time_limit_s=120, workers=1)
    assert (least.status, least.ii, least.bounds[0].ii) == ("optimal", 2, 1)
    assert [item.ii for item in least.refuted] == [1]
    assert "II 1 refuted by" in least.explain()


def test_a_chain_without_links_shares_a_pe() -> None:
    least = map_dfg(chain(2), grid(1, 2, links=False), time_limit_s=120, workers=1)
    assert (least.status, least.ii) == ("optimal", 2)


def test_an_unplaceable_node_makes_it_infeasible_with_a_reason() -> None:
    fabric = grid(1, 2, classes=dict.fromkeys((0, 1), EVERYTHING - {LatencyClass.FADD}))
    result = map_dfg(accumulator(), fabric, time_limit_s=120)
    assert result.status == "infeasible"
    assert "fadd" in result.bounds[0].reason


def test_no_ii_fits_the_contexts() -> None:
    result = map_dfg(chain(2), grid(1, 2, links=False, contexts=1), time_limit_s=120, workers=1)
    assert (result.status, result.ii) == ("infeasible", None)


def test_homes_and_resident_constants_are_kept() -> None:
    g = GraphBuilder("home")
    value = g.op(Opcode.ADD, g.source(Opcode.IV), g.const(7))
    home = g.op(Opcode.LIVE_OUT, value, name="%v")
    fabric = grid(2, 2, constants=1)
    full = frozenset({("const", 1)})
    resident = {0: full, 1: full, 2: frozenset({("const", 7)}), 3: frozenset({("live_in", "%v")})}
    result = map_dfg(
        g.build(), fabric, allowed={home: frozenset({3})}, resident=resident, workers=1
    )
    assert result.mapping is not None
    assert result.mapping.places[home].pe == 3
    assert result.mapping.places[value].pe == 2


@pytest.mark.parametrize(
    ("allowed", "resident", "text"),
    [
        ({99: frozenset({0})}, {}, "no node 99"),
        ({1: frozenset({0, 4})}, {}, "no PE 4"),
        ({}, {-1: frozenset({("const", 1)})}, "no PE -1"),
    ],
)
def test_nodes_and_pes_that_are_not_there_are_refused(
    allowed: dict[int, frozenset[int]], resident: dict[int, frozenset[ConstantKey]], text: str
) -> None:
    """They were ignored: a slip of the pen mapped as if nothing had been asked."""
    with pytest.raises(VividcError, match=text):
        map_dfg(chain(2), grid(2, 2), allowed=allowed, resident=resident)


def test_an_empty_graph_maps() -> None:
    result = map_dfg(GraphBuilder("empty").build(), grid(1, 1), time_limit_s=5, workers=1)
    assert (result.status, result.ii) == ("optimal", 1)


def test_the_time_limit_is_kept() -> None:
    began = time.monotonic()
    result = map_dfg(blending(), grid(4, 4, registers=1, constants=32), time_limit_s=0.5)
    assert time.monotonic() - began < 3
    assert result.status in {"timeout", "feasible", "optimal"}


def test_an_interrupt_stops_the_solver() -> None:
    # A shell's background job ignores interrupts: so would the simulated one.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.1, _thread.interrupt_main)
    timer.start()
    began = time.monotonic()
    try:
        with pytest.raises(KeyboardInterrupt):
            map_dfg(blending(), arch.load("vivid-tile"), "cpsat", ii=4, time_limit_s=60)
    finally:
        signal.signal(signal.SIGINT, before)
    assert time.monotonic() - began < 10


def test_an_interrupt_in_a_callback_of_the_collector_stops_the_mapper() -> None:
    """It was lost, and the search went on to its limit: hypothesis has such a callback."""
    interrupts = iter([signal.SIGINT])

    def callback(_phase: str, _info: dict[str, int]) -> None:
        for one in interrupts:
            signal.raise_signal(one)

    def collect(_: str) -> None:
        gc.collect()

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    gc.callbacks.append(callback)
    began = time.monotonic()
    try:
        with pytest.raises(KeyboardInterrupt):
            map_dfg(
                blending(),
                arch.load("vivid-tile"),
                "cpsat",
                ii=4,
                time_limit_s=60,
                progress=collect,
            )
    finally:
        gc.callbacks.remove(callback)
        signal.signal(signal.SIGINT, before)
    assert time.monotonic() - began < 10


def test_one_worker_gives_the_same_mapping_twice() -> None:
    runs = [map_dfg(accumulator(), grid(2, 2), workers=1).mapping for _ in range(2)]
    assert runs[0] == runs[1]


def test_progress_is_told() -> None:
    lines: list[str] = []
    map_dfg(chain(3), grid(2, 2), workers=1, progress=lines.append)
    assert any("mapped" in line for line in lines)


@pytest.mark.parametrize(
    "wrong",
    [
        {"ii": 0},
        {"time_limit_s": 0.0},
        {"time_limit_s": float("nan")},
        {"workers": 0},
        {"workers": 10**9},
        {"workers": 1.5},
    ],
)
def test_senseless_limits_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(VividcError):
        map_dfg(chain(2), grid(1, 2), **wrong)  # type: ignore[arg-type]


def test_an_unknown_mapper_is_refused_with_the_known_ones() -> None:
    with pytest.raises(VividcError, match="auto, cpsat, decoupled"):
        map_dfg(chain(2), grid(1, 2), mapper="magic")


def test_an_illegal_mapping_of_a_mapper_of_ours_is_our_bug_report(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def careless(problem: MapProblem, request: MapRequest) -> MapResult:
        result = registry.BUILT_IN["auto"](problem, request)
        assert result.mapping is not None
        return replace(result, mapping=replace(result.mapping, routes={}))

    monkeypatch.setitem(registry.BUILT_IN, "careless", careless)
    with pytest.raises(InternalError, match="illegal mapping"):
        map_dfg(chain(3), grid(2, 2), mapper="careless", workers=1)


def test_returned_mappings_are_legal() -> None:
    dfg, fabric = accumulator(), grid(2, 2)
    result = map_dfg(dfg, fabric, workers=1)
    assert result.mapping is not None
    assert violations(dfg, fabric, result.mapping) == []
