"""Encoding: tables and reports of hand-made kernels; a contradicting mapping is refused."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.program.hand_kernels import (
    ARRAYS,
    Hand,
    N,
    O,
    dot,
    fabric,
    find,
    memory_op,
    program,
    saxpy,
    trip_region,
)
from vividc.arch import Fabric, load
from vividc.dfg.ir import DFG, Control, Edge, Node
from vividc.dfg.regions import RETURN_VARIABLE, Kernel, Region
from vividc.errors import InternalError, KernelError
from vividc.machine.opcodes import BASE
from vividc.machine.params import DType
from vividc.mapper.mapping import Bound, Mapping, Place, Refutation, Step
from vividc.mapper.result import MapResult
from vividc.program import encode


def test_region_table_of_dot() -> None:
    start, loop, end = dot(fabric(latencies="{fma: 4}")).table
    assert (start.kind, start.context, start.ii, start.span, start.next) == ("straight", 0, 2, 2, 1)
    assert (loop.kind, loop.context, loop.ii, loop.span, loop.stages) == ("loop", 2, 4, 6, 2)
    assert loop.counted
    assert not loop.has_exit
    assert (end.context, end.next) == (6, None)


def test_launch_rows_and_return_home() -> None:
    compiled = dot(fabric(latencies="{fma: 4}"))
    assert sorted((row.pe, row.key) for row in compiled.launch) == [(0, "&x"), (0, "n"), (3, "&y")]
    assert compiled.return_home is not None
    assert compiled.return_home.pe == 1
    assert compiled.stored_arrays == frozenset()
    assert saxpy(fabric()).stored_arrays == {"y"}


def test_span_counts_the_control_latency() -> None:
    assert find(fabric()).table[0].span == 4
    slow = fabric(controller="{control_latency: 2}")
    with pytest.raises(InternalError, match="before the exit can stop it"):
        find(slow)


def test_reports_come_from_the_mapper() -> None:
    fab = fabric()
    region, hand = trip_region(fab, after=0)
    region = replace(region, next=None)
    result = MapResult(
        "optimal",
        2,
        2,
        (Bound("path", 2, "control latency"),),
        hand.mapping(),
        "list",
        0.5,
        (Refutation(1, "path"),),
    )
    kernel = Kernel("k", (N,), (region,))
    compiled = encode(
        kernel, fab, {0: hand.mapping()}, reports={0: result}, options={"unroll": 2}, warnings=["w"]
    )
    (report,) = compiled.regions
    assert (report.status, report.ii, report.mii, report.lower_bound) == ("optimal", 2, 2, 2)
    assert (report.operations, report.utilization) == (1, 1 / 8)
    assert "length 1 refuted by path" in report.explain()
    assert report.wall_s == 0.5
    assert compiled.warnings == ("w",)
    assert [(o.name, o.value) for o in compiled.provenance.options] == [("unroll", 2)]
    assert dict(compiled.provenance.versions).keys() >= {"vividc", "numba", "ortools"}


def loop_parts() -> tuple[Region, Hand, dict[str, int]]:
    """x[i] -> mov -> y[i], II 1."""
    fab = fabric()
    hand = Hand(fab, 1)
    iv = hand.iv()
    x = memory_op(hand, O.LOAD, 0, 0, "x", iv)
    mov = hand.op(O.MOV, 1, 1)
    hand.feed(x, mov, via="1")
    store = memory_op(hand, O.STORE, 3, 2, "y", iv)
    hand.feed(mov, store, 1, via="3")
    region = Region("loop", "loop", hand.dfg("loop"), counted=True)
    return region, hand, {"x": x, "mov": mov, "store": store}


def encode_loop(region: Region, hand: Hand, mapping: Mapping) -> None:
    first, trip = trip_region(hand.fabric)
    kernel = Kernel("k", (*ARRAYS, N), (first, region))
    encode(kernel, hand.fabric, {0: trip.mapping(), 1: mapping})


def route_of(hand: Hand, src: int, dst: int) -> int:
    return next(i for i, e in enumerate(hand.edges) if (e.src, e.dst) == (src, dst))


def test_the_unbroken_loop_encodes() -> None:
    region, hand, _ = loop_parts()
    encode_loop(region, hand, hand.mapping())


@pytest.mark.parametrize(
    ("node", "place", "reason"),
    [
        ("store", Place(0, 2), "two operations issue on PE 0"),
        ("store", Place(3, 3), "does not end at its consumer"),
        ("store", Place(2, 2), "does not end at its consumer"),
        ("mov", Place(1, 2), "is at cycle 2, not 3"),
        ("mov", Place(2, 1), "link 2 does not run from PE 2"),
        ("mov", Place(9, 1), "no place"),
        ("mov", Place(1, -1), "no place"),
        ("x", Place(0, 1), "route of edge"),
        ("store", Place(3, 99), "stages do not fit"),
    ],
)
def test_moved_node(node: str, place: Place, reason: str) -> None:
    region, hand, ids = loop_parts()
    places = {**hand.places, ids[node]: place}
    with pytest.raises(InternalError, match=reason):
        encode_loop(region, hand, Mapping(1, places, hand.routes))


@pytest.mark.parametrize(
    ("steps", "reason"),
    [
        ((), "no route"),
        ((Step("link", 1, 99, 1),), "link 99 does not run"),
        ((Step("reg", 1, 0, 1),), "jumps from PE 0"),
        ((Step("reg", 0, 0, 1),), "does not end at its consumer"),
        ((Step("link", 1, 0, 2),), "is at cycle 2, not 1"),
    ],
)
def test_broken_route(steps: tuple[Step, ...], reason: str) -> None:
    region, hand, ids = loop_parts()
    routes = {**hand.routes, route_of(hand, ids["x"], ids["mov"]): steps}
    with pytest.raises(InternalError, match=reason):
        encode_loop(region, hand, Mapping(1, hand.places, routes))


def test_missing_place_and_missing_mapping() -> None:
    region, hand, ids = loop_parts()
    places = {node: place for node, place in hand.places.items() if node != ids["mov"]}
    with pytest.raises(InternalError, match="no place"):
        encode_loop(region, hand, Mapping(1, places, hand.routes))
    with pytest.raises(InternalError, match="no mapping"):
        encode(Kernel("k", (*ARRAYS, N), (region,)), hand.fabric, {})


def test_word_that_stays_longer_than_ii_in_one_register() -> None:
    fab = fabric()
    hand = Hand(fab, 1)
    x = memory_op(hand, O.LOAD, 0, 0, "x", hand.iv())
    mov = hand.op(O.MOV, 1, 3)
    hand.feed(x, mov, via="1 r0 r0")
    region = Region("loop", "loop", hand.dfg("loop"), counted=True)
    with pytest.raises(InternalError, match="holds two words"):
        encode_loop(region, hand, hand.mapping())


def test_two_completions_in_one_slot() -> None:
    fab = fabric(latencies="{imul: 2}")
    hand = Hand(fab, 4)
    one = hand.const(1)
    for op, time in ((O.MUL, 0), (O.ADD, 1)):
        node = hand.op(op, 0, time)
        hand.feed(one, node, 0)
        hand.feed(one, node, 1)
    region = Region("loop", "loop", hand.dfg("loop"), counted=True)
    with pytest.raises(InternalError, match="complete on PE 0 in the same slot"):
        encode_loop(region, hand, hand.mapping())


def test_load_on_pe_without_memory() -> None:
    hand = Hand(load("vivid-tile"), 1)
    memory_op(hand, O.LOAD, 5, 0, "x", hand.iv())
    region = Region("loop", "loop", hand.dfg("loop"), counted=True)
    with pytest.raises(InternalError, match="PE 5 cannot execute"):
        encode_loop(region, hand, hand.mapping())


def test_offset_too_large_is_the_users_error() -> None:
    hand = Hand(fabric(), 1)
    node = memory_op(hand, O.LOAD, 0, 0, "x", hand.iv(), offset=40_000)
    region = Region("loop", "loop", hand.dfg("loop"), counted=True)
    with pytest.raises(KernelError, match="40000 bytes") as caught:
        encode_loop(region, hand, hand.mapping())
    assert caught.value.loc == hand.nodes[node].loc


def test_a_program_may_be_longer_than_the_configuration_memory() -> None:
    assert len(dot(fabric(latencies="{fma: 4}", controller="{contexts: 7}")).words) == 8


def straight(hand: Hand, **links: int) -> Region:
    return Region("r", "straight", hand.dfg("r"), **links)


def writes(fab: Fabric, pe: int, variable: str = "%v", **links: int) -> tuple[Region, Hand]:
    hand = Hand(fab, 2)
    value = hand.op(O.MOV, pe, 0)
    hand.feed(hand.const(7), value)
    hand.feed(value, hand.op(O.LIVE_OUT, pe, 1, name=variable))
    return straight(hand, **links), hand


def reads(fab: Fabric, pe: int, variable: str = "%v", **links: int) -> tuple[Region, Hand]:
    hand = Hand(fab, 2)
    hand.feed(hand.live_in(variable), hand.op(O.MOV, pe, 0))
    return straight(hand, **links), hand


def test_variable_written_where_nobody_reads_it() -> None:
    fab = fabric()
    program("k", (), [writes(fab, 0, next=1), reads(fab, 0)])
    with pytest.raises(InternalError, match="does not write %v on its reader PE 1"):
        program("k", (), [writes(fab, 0, next=1), reads(fab, 1)])
    with pytest.raises(InternalError, match="writes variable %v"):
        program("k", (), [reads(fab, 1)])


def test_return_value_without_common_home() -> None:
    fab = fabric()
    parts = [writes(fab, pe, RETURN_VARIABLE, next=1 - pe) for pe in (0, 1)]
    with pytest.raises(InternalError, match="no common PE"):
        program("k", (), parts, DType.I32)


def test_read_after_the_regions_own_write() -> None:
    fab = fabric()
    hand = Hand(fab, 3)
    value = hand.op(O.MOV, 0, 0)
    hand.feed(hand.const(7), value)
    hand.feed(value, hand.op(O.LIVE_OUT, 0, 1, name="%v"))
    hand.feed(hand.live_in("%v"), hand.op(O.MOV, 0, 2))
    with pytest.raises(InternalError, match="after the region has written it"):
        program("k", (), [(straight(hand), hand)])


def test_constant_store_overflow() -> None:
    hand = Hand(fabric(pe="{constants: 2}"), 4)
    for time in range(3):
        hand.feed(hand.const(time), hand.op(O.MOV, 0, time))
    with pytest.raises(InternalError, match="needs 3 constant-store entries"):
        program("k", (), [(straight(hand), hand)])


@pytest.mark.parametrize(
    ("node", "region", "reason"),
    [
        (Node(0, O.MOV), Region("r", "loop", DFG("r", (), ())), "never ends"),
        (Node(0, O.MOV, control=Control.EXIT), Region("r", "straight", DFG("r", (), ())), "kind"),
        (Node(0, O.MOV, control=Control.BRANCH), Region("r", "straight", DFG("r", (), ())), "both"),
        (Node(0, O.MOV), Region("r", "straight", DFG("r", (), ()), branch=0), "both"),
        (Node(0, O.MOV, unless_exit=True), Region("r", "straight", DFG("r", (), ())), "no effect"),
        (
            Node(0, O.GENERIC, name="exp"),
            Region("r", "straight", DFG("r", (), ())),
            "cannot execute|has operands",
        ),
    ],
)
def test_control_marks(node: Node, region: Region, reason: str) -> None:
    graph = DFG("r", (node, Node(1, O.CONST, const=1)), (Edge(1, 0, 0),))
    kernel = Kernel("k", (), (replace(region, dfg=graph),))
    with pytest.raises(InternalError, match=reason):
        encode(kernel, fabric(), {0: Mapping(3, {0: Place(0, 0)}, {})})


@pytest.mark.parametrize(
    ("edges", "reason"),
    [
        ((), "has operands"),
        ((Edge(1, 0, 0), Edge(1, 0, 0)), "two words for operand 0"),
        ((Edge(1, 0, 0), Edge(1, 0, BASE)), "base address"),
        ((Edge(1, 0, 0, 2, 1),), "distance 2"),
        ((Edge(2, 0, 0, 1, 1),), "distance 1"),
    ],
)
def test_operands(edges: tuple[Edge, ...], reason: str) -> None:
    graph = DFG("r", (Node(0, O.MOV), Node(1, O.CONST, const=1), Node(2, O.IV)), edges)
    kernel = Kernel("k", (), (Region("r", "straight", graph),))
    with pytest.raises(InternalError, match=reason):
        encode(kernel, fabric(), {0: Mapping(1, {0: Place(0, 0)}, {})})


def test_region_too_short_for_its_results() -> None:
    graph = DFG("r", (Node(0, O.MUL), Node(1, O.CONST, const=1)), (Edge(1, 0, 0), Edge(1, 0, 1)))
    kernel = Kernel("k", (), (Region("r", "straight", graph),))
    slow = fabric(latencies="{imul: 2}")
    encode(kernel, slow, {0: Mapping(2, {0: Place(0, 0)}, {})})
    with pytest.raises(InternalError, match="not done after the region's 1 cycles"):
        encode(kernel, slow, {0: Mapping(1, {0: Place(0, 0)}, {})})


def test_region_without_nodes_needs_no_mapping() -> None:
    kernel = Kernel("k", (), (Region("r", "straight", DFG("r", (), ())),))
    (row,) = encode(kernel, fabric(), {}).table
    assert (row.ii, row.span) == (1, 1)
