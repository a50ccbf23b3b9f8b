"""Each rule of the machine alone: mappings of a few nodes that keep it, and that break it."""

from __future__ import annotations

from dataclasses import replace

import pytest
from tiny_fabrics import tiny_fabric

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG, Control, Edge, EdgeKind, Node
from vividc.machine.opcodes import ORDER, LatencyClass, Opcode
from vividc.mapper.check.verify import verify, violations
from vividc.mapper.mapping import Mapping, Place, Step

# PEs 0 - 1; link 0 leads from 0 to 1, link 1 back.
PAIR = tiny_fabric(1, 2, registers=2, latencies={LatencyClass.IMUL: 2})
ONE = DFG("one", (Node(0, Opcode.MOV),), ())
TWO = DFG("two", (Node(0, Opcode.MOV), Node(1, Opcode.MOV)), ())
FEEDS = DFG("feeds", TWO.nodes, (Edge(0, 1, 0),))


def link(index: int, time: int, fabric: Fabric = PAIR) -> Step:
    return Step("link", fabric.links[index].dst, index, time)


def reg(pe: int, index: int, time: int) -> Step:
    return Step("reg", pe, index, time)


def mapped(
    ii: int, places: dict[int, tuple[int, int]], routes: dict[int, tuple[Step, ...]] | None = None
) -> Mapping:
    return Mapping(ii, {node: Place(*place) for node, place in places.items()}, routes or {})


def kinds(dfg: DFG, mapping: Mapping, fabric: Fabric = PAIR, **options: object) -> list[str]:
    found = violations(dfg, fabric, mapping, **options)  # type: ignore[arg-type]
    return sorted({violation.kind for violation in found})


def test_verify_is_the_public_name() -> None:
    assert verify is violations


def test_an_ii_below_1_is_reported() -> None:
    assert kinds(ONE, mapped(0, {0: (0, 0)})) == ["ii"]


@pytest.mark.parametrize(
    ("places", "kind"),
    [
        ({}, "missing"),
        ({0: (0, 0), 7: (0, 1)}, "unknown"),
        ({0: (2, 0)}, "pe"),
        ({0: (-1, 0)}, "pe"),
        ({0: (0, -1)}, "time"),
        ({0: (0, 8)}, "stages"),
    ],
)
def test_places_that_make_no_sense(places: dict[int, tuple[int, int]], kind: str) -> None:
    assert kinds(ONE, mapped(2, places)) == [kind]


def test_sources_are_not_placed() -> None:
    dfg = DFG("source", (Node(0, Opcode.CONST, const=1),), ())
    assert kinds(dfg, mapped(1, {0: (0, 0)})) == ["unknown"]


def test_an_operation_needs_a_pe_that_executes_it() -> None:
    fabric = tiny_fabric(1, 2, memory=frozenset({0}))
    load = DFG("load", (Node(0, Opcode.LOAD, name="a"),), ())
    assert kinds(load, mapped(1, {0: (0, 0)}), fabric) == []
    assert kinds(load, mapped(1, {0: (1, 0)}), fabric) == ["op"]


def test_an_operation_without_latency_is_reported() -> None:
    dfg = DFG("exp", (Node(0, Opcode.EXP),), ())
    known = {lat: cycles for lat, cycles in PAIR.latencies.items() if lat.value != "generic"}
    assert kinds(dfg, mapped(1, {0: (0, 0)}), replace(PAIR, latencies=known)) == ["op"]


def test_a_live_out_may_lie_anywhere_but_where_its_home_is() -> None:
    assert kinds(ONE, mapped(1, {0: (1, 0)}), allowed={0: frozenset({0})}) == ["allowed"]
    assert kinds(ONE, mapped(1, {0: (0, 0)}), allowed={0: frozenset({0})}) == []


def test_one_issue_per_pe_and_slot() -> None:
    assert kinds(TWO, mapped(2, {0: (0, 0), 1: (0, 1)})) == []
    assert kinds(TWO, mapped(2, {0: (0, 0), 1: (1, 2)})) == []
    assert kinds(TWO, mapped(2, {0: (0, 0), 1: (0, 2)})) == ["completion", "issue"]


def test_one_completion_per_pe_and_slot() -> None:
    dfg = DFG("late", (Node(0, Opcode.MUL), Node(1, Opcode.MOV)), ())
    assert kinds(dfg, mapped(3, {0: (0, 0), 1: (0, 1)})) == ["completion"]
    assert kinds(dfg, mapped(3, {0: (0, 0), 1: (0, 2)})) == []
    assert kinds(dfg, mapped(3, {0: (0, 0), 1: (1, 1)})) == []


def test_contexts() -> None:
    fabric = tiny_fabric(contexts=2)
    assert kinds(ONE, mapped(2, {0: (0, 0)}), fabric) == []
    assert kinds(ONE, mapped(3, {0: (0, 0)}), fabric) == ["contexts"]


def test_control_results_reach_the_controller_one_a_slot() -> None:
    nodes = (
        Node(0, Opcode.MUL, control=Control.BRANCH),
        Node(1, Opcode.MOV, control=Control.TRIP),
    )
    dfg = DFG("control", nodes, ())
    assert kinds(dfg, mapped(2, {0: (0, 0), 1: (1, 0)})) == []
    assert kinds(dfg, mapped(2, {0: (0, 0), 1: (1, 1)})) == ["control"]


@pytest.mark.parametrize(
    ("kind", "earliest"), [(EdgeKind.ORDER, 1), (EdgeKind.CONTROL, 3)], ids=["order", "control"]
)
def test_edges_without_a_word_separate(kind: EdgeKind, earliest: int) -> None:
    nodes = (Node(0, Opcode.MUL), Node(1, Opcode.STORE, name="a"))
    for distance in (0, 1):
        dfg = DFG("separate", nodes, (Edge(0, 1, ORDER, distance, kind=kind),))
        good, bad = 5 + earliest - 4 * distance, 4 + earliest - 4 * distance
        assert kinds(dfg, mapped(4, {0: (0, 5), 1: (1, good)})) == []
        assert kinds(dfg, mapped(4, {0: (0, 5), 1: (1, bad)})) == ["dependence"]


class TestRoutes:
    """One word from node 0 to node 1."""

    def check(self, where: tuple[int, int], *route: Step, ii: int = 8) -> list[str]:
        return kinds(FEEDS, mapped(ii, {0: (0, 0), 1: where}, {0: route}))

    def test_ways_that_work(self) -> None:
        assert self.check((0, 1)) == []
        assert self.check((0, 1), reg(0, 0, 1)) == []
        assert self.check((1, 1), link(0, 1)) == []
        assert self.check((0, 2), link(0, 1), link(1, 2)) == []
        assert self.check((0, 3), reg(0, 1, 1), reg(0, 1, 2), reg(0, 0, 3)) == []
        assert self.check((1, 3), reg(0, 1, 1), link(0, 2), reg(1, 0, 3)) == []

    def test_the_output_register_holds_for_one_cycle_on_its_own_pe(self) -> None:
        assert self.check((0, 2)) == ["route"]
        assert self.check((1, 1)) == ["route"]

    def test_a_result_does_not_arrive_before_it_is_there(self) -> None:
        assert self.check((1, 0)) == ["dependence", "route"]

    def test_a_route_begins_at_the_result(self) -> None:
        assert self.check((1, 2), link(0, 2)) == ["route"]
        assert self.check((1, 1), reg(1, 0, 1)) == ["route"]
        assert self.check((0, 1), link(1, 1)) == ["route"]

    def test_a_route_ends_at_the_reader(self) -> None:
        assert self.check((0, 1), link(0, 1)) == ["route"]
        assert self.check((1, 2), link(0, 1)) == ["route"]
        assert self.check((1, 1), link(0, 1), reg(1, 0, 2)) == ["route"]

    def test_a_route_takes_one_step_a_cycle(self) -> None:
        assert self.check((1, 3), link(0, 1), reg(1, 0, 3)) == ["route"]
        assert self.check((1, 2), reg(1, 0, 2), link(0, 1)) == ["route"]

    def test_a_word_cannot_jump(self) -> None:
        assert self.check((1, 2), reg(0, 0, 1), reg(1, 0, 2)) == ["route"]
        assert self.check((1, 2), link(0, 1), link(0, 2)) == ["route"]

    def test_steps_that_do_not_exist(self) -> None:
        assert self.check((0, 1), reg(0, 2, 1)) == ["route"]
        assert self.check((0, 1), reg(0, -1, 1)) == ["route"]
        assert self.check((0, 1), reg(5, 0, 1)) == ["route"]
        assert self.check((1, 1), Step("link", 1, 2, 1)) == ["route"]
        assert self.check((1, 1), Step("link", 0, 0, 1)) == ["route"]
        assert self.check((1, 1), Step("wire", 1, 0, 1)) == ["route"]  # type: ignore[arg-type]

    def test_every_routed_edge_and_no_other_has_a_route(self) -> None:
        places = {0: (0, 0), 1: (0, 1)}
        assert kinds(FEEDS, mapped(2, places)) == ["route"]
        assert kinds(TWO, mapped(2, places, {0: ()})) == ["route"]
        assert kinds(FEEDS, mapped(2, {0: (0, 0)}, {0: ()})) == ["missing"]

    def test_a_route_reaches_into_later_iterations(self) -> None:
        carried = DFG("carried", FEEDS.nodes, (Edge(0, 1, 0, 1),))
        places = {0: (0, 2), 1: (1, 1)}
        assert kinds(carried, mapped(2, places, {0: (link(0, 3),)})) == []
        assert kinds(carried, mapped(3, places, {0: (link(0, 3),)})) == ["route"]

    def test_a_register_is_overwritten_by_its_own_successor(self) -> None:
        steps = (*(reg(0, 0, time) for time in (1, 2, 3)), link(0, 4))
        assert self.check((1, 4), *steps, ii=3) == []
        assert self.check((1, 4), *steps, ii=2) == ["register"]


FORK = DFG("fork", tuple(Node(i, Opcode.MOV) for i in range(3)), (Edge(0, 1, 0), Edge(0, 2, 0)))
CROSS = DFG("cross", tuple(Node(i, Opcode.MOV) for i in range(4)), (Edge(0, 2, 0), Edge(1, 3, 0)))


def test_two_words_on_one_link() -> None:
    fabric = tiny_fabric(1, 3, registers=1)
    early, late = mesh_route(fabric, 1), mesh_route(fabric, 4)
    places = {0: (0, 0), 1: (0, 3), 2: (1, 1), 3: (1, 4)}
    assert kinds(CROSS, mapped(4, places, {0: early, 1: late}), fabric) == []
    assert "link" in kinds(CROSS, mapped(3, places, {0: early, 1: late}), fabric)


def mesh_route(fabric: Fabric, time: int) -> tuple[Step, ...]:
    return (link(0, time, fabric),)


def test_two_words_in_one_register() -> None:
    routes = {0: (reg(0, 0, 1), reg(0, 0, 2)), 1: (reg(0, 0, 2), reg(0, 0, 3))}
    places = {0: (0, 0), 1: (0, 1), 2: (0, 2), 3: (0, 3)}
    assert kinds(CROSS, mapped(4, places, routes)) == ["register"]
    routes[1] = (reg(0, 1, 2), reg(0, 1, 3))
    assert kinds(CROSS, mapped(4, places, routes)) == []


def test_routes_of_one_word_share_places_only_with_one_driver() -> None:
    places = {0: (0, 0), 1: (1, 2), 2: (1, 3)}
    through_register = (link(0, 1), reg(1, 0, 2), reg(1, 0, 3))
    assert kinds(FORK, mapped(8, places, {0: through_register[:2], 1: through_register})) == []


def test_one_register_does_not_take_a_word_from_two_places() -> None:
    places = {0: (0, 0), 1: (1, 4), 2: (1, 3)}
    through_register = (link(0, 1), reg(1, 0, 2), reg(1, 0, 3))
    around = (reg(0, 0, 1), link(0, 2))
    other = (*around, reg(1, 1, 3), reg(1, 1, 4))
    same = (*around, reg(1, 0, 3), reg(1, 0, 4))
    assert kinds(FORK, mapped(8, places, {0: other, 1: through_register})) == []
    assert kinds(FORK, mapped(8, places, {0: same, 1: through_register})) == ["driver"]


def test_read_ports_count_registers_not_readers() -> None:
    dfg = DFG("join", (*CROSS.nodes[:2], Node(2, Opcode.ADD)), (Edge(0, 2, 0), Edge(1, 2, 1)))
    places = {0: (0, 0), 1: (0, 1), 2: (0, 3)}
    held = {0: tuple(reg(0, 0, t) for t in (1, 2, 3)), 1: tuple(reg(0, 1, t) for t in (2, 3))}
    assert kinds(dfg, mapped(4, places, held)) == ["read_ports"]
    assert kinds(dfg, mapped(4, places, held), tiny_fabric(registers=2, read_ports=2)) == []
    square = DFG("square", (*TWO.nodes[:1], Node(1, Opcode.ADD)), (Edge(0, 1, 0), Edge(0, 1, 1)))
    twice = {0: (reg(0, 0, 1),), 1: (reg(0, 0, 1),)}
    assert kinds(square, mapped(4, {0: (0, 0), 1: (0, 1)}, twice)) == []


def test_links_and_copies_use_read_ports() -> None:
    places = {0: (0, 0), 1: (0, 1), 2: (1, 3), 3: (0, 3)}
    sent = (reg(0, 0, 1), reg(0, 0, 2), link(0, 3))
    copied = (reg(0, 1, 2), link(0, 3), link(1, 4))
    crowded = (reg(0, 1, 2), reg(0, 0, 3))
    assert kinds(CROSS, mapped(4, places, {0: sent, 1: crowded})) == ["read_ports"]
    places[3] = (0, 4)
    assert "read_ports" in kinds(CROSS, mapped(8, places, {0: sent, 1: copied}))


def test_write_ports() -> None:
    places = {0: (0, 0), 1: (0, 1), 2: (0, 2)}
    both = {0: (reg(0, 0, 1),), 1: (reg(0, 1, 1), reg(0, 1, 2))}
    assert kinds(FORK, mapped(4, places, both)) == ["write_ports"]
    wide = tiny_fabric(registers=2, write_ports=2)
    assert kinds(FORK, mapped(4, places, both), wide) == []


def test_the_constant_store_holds_operands_inits_and_live_outs() -> None:
    nodes = (
        Node(0, Opcode.CONST, const=5),
        Node(1, Opcode.LIVE_IN, name="n"),
        Node(2, Opcode.ADD),
        Node(3, Opcode.LIVE_OUT, name="%x"),
    )
    edges = (Edge(0, 2, 0), Edge(2, 2, 1, 1, 1), Edge(2, 3, 0))
    dfg = DFG("constants", nodes, edges)
    mapping = mapped(1, {2: (0, 0), 3: (0, 1)}, {1: (), 2: ()})
    assert kinds(dfg, mapping, tiny_fabric(constants=3)) == []
    assert kinds(dfg, mapping, tiny_fabric(constants=2)) == ["constants"]
    held = {0: frozenset({("live_in", "n"), ("const", 9)})}
    assert kinds(dfg, mapping, tiny_fabric(constants=4), resident=held) == []
    assert kinds(dfg, mapping, tiny_fabric(constants=3), resident=held) == ["constants"]


def test_one_live_out_per_pe_and_slot() -> None:
    nodes = (
        Node(0, Opcode.MOV),
        Node(1, Opcode.LIVE_OUT, name="%x"),
        Node(2, Opcode.LIVE_OUT, name="%y"),
    )
    dfg = DFG("outs", nodes, (Edge(0, 1, 0), Edge(0, 2, 0)))
    apart = {0: (), 1: (link(0, 1),)}
    assert kinds(dfg, mapped(2, {0: (0, 0), 1: (0, 1), 2: (1, 1)}, apart)) == []
    assert kinds(dfg, mapped(2, {0: (0, 0), 1: (0, 1), 2: (0, 1)}, {0: (), 1: ()})) == ["live_out"]


def test_a_live_out_does_not_read_the_constant_store() -> None:
    nodes = (Node(0, Opcode.CONST, const=1), Node(1, Opcode.LIVE_OUT, name="%x"))
    dfg = DFG("copy", nodes, (Edge(0, 1, 0),))
    assert kinds(dfg, mapped(1, {1: (0, 0)})) == ["live_out"]


def test_reads_of_a_variable_do_not_follow_its_write_on_the_same_pe() -> None:
    nodes = (
        Node(0, Opcode.LIVE_IN, name="%x"),
        Node(1, Opcode.MOV),
        Node(2, Opcode.LIVE_OUT, name="%x"),
        Node(3, Opcode.MOV),
    )
    dfg = DFG("swap", nodes, (Edge(0, 1, 0), Edge(1, 2, 0), Edge(0, 3, 0)))
    straight = {"straight": True}
    good = mapped(4, {1: (0, 0), 2: (0, 1), 3: (0, 1)}, {1: ()})
    assert kinds(dfg, good, **straight) == []
    late = mapped(4, {1: (0, 0), 2: (0, 1), 3: (0, 2)}, {1: ()})
    assert kinds(dfg, late, **straight) == ["live_in"]
    elsewhere = mapped(4, {1: (0, 0), 2: (0, 1), 3: (1, 2)}, {1: ()})
    assert kinds(dfg, elsewhere, **straight) == []
    assert kinds(dfg, good) == ["live_in"]  # a loop comes back to read


@pytest.mark.parametrize(
    ("node", "time", "length"),
    [
        (Node(0, Opcode.MUL), 1, 3),
        (Node(0, Opcode.MUL, control=Control.BRANCH), 0, 3),
        (Node(0, Opcode.MOV), 0, 1),
    ],
)
def test_a_straight_region_lasts_until_all_is_done(node: Node, time: int, length: int) -> None:
    dfg = DFG("length", (node,), ())
    assert kinds(dfg, mapped(length, {0: (0, time)}), straight=True) == []
    if length > 1:
        assert kinds(dfg, mapped(length - 1, {0: (0, time)}), straight=True) == ["straight"]


def test_a_straight_region_waits_for_its_live_outs_and_has_no_distances() -> None:
    nodes = (Node(0, Opcode.MOV), Node(1, Opcode.LIVE_OUT, name="%x"))
    dfg = DFG("out", nodes, (Edge(0, 1, 0),))
    assert kinds(dfg, mapped(2, {0: (0, 0), 1: (0, 1)}, {0: ()}), straight=True) == []
    assert "straight" in kinds(dfg, mapped(1, {0: (0, 0), 1: (0, 1)}, {0: ()}), straight=True)
    carried = DFG("carried", nodes, (Edge(0, 1, 0, 1),))
    assert "straight" in kinds(carried, mapped(2, {0: (0, 0), 1: (0, 1)}), straight=True)


def test_a_message_names_nodes_and_place() -> None:
    (found,) = violations(ONE, PAIR, mapped(1, {0: (9, 0)}))
    assert str(found) == "pe: node 0 (mov) lies on PE 9; the fabric has PEs 0 to 1"
    assert found.nodes == (0,)
