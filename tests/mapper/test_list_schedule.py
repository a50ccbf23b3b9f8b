"""Straight regions: legal, as short as the bound says where it can be, refused with a reason."""

from __future__ import annotations

import pytest
from random_graphs import random_region
from tiny_fabrics import tiny_fabric

from vividc.arch import load
from vividc.arch.fabric import Fabric
from vividc.dfg.check import check
from vividc.dfg.ir import DFG, Control, Edge, EdgeKind, Node
from vividc.errors import MappingFailed, SourceLoc
from vividc.machine.opcodes import ORDER, PRED, LatencyClass, Opcode
from vividc.mapper.bounds.straight import heights_of
from vividc.mapper.check.verify import violations
from vividc.mapper.engines.greedy import Policy, Region, Schedule
from vividc.mapper.engines.list_schedule import list_schedule, straight_lower_bound
from vividc.mapper.mapping import Mapping
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.banks import NO_MEETS

_SLOW_MUL = {LatencyClass.IMUL: 3}


def legal_schedule(problem: MapProblem, *, frugal: bool = False) -> Mapping:
    mapping = list_schedule(problem, frugal=frugal)
    found = violations(
        problem.dfg,
        problem.fabric,
        mapping,
        allowed=problem.allowed,
        resident=problem.resident,
        straight=True,
    )
    assert found == []
    assert mapping.ii >= straight_lower_bound(problem).ii
    return mapping


def chain(length: int, op: Opcode = Opcode.MOV) -> DFG:
    nodes = tuple(Node(index, op) for index in range(length))
    return DFG("chain", nodes, tuple(Edge(i, i + 1, 0) for i in range(length - 1)))


def sum_of(leaves: int) -> DFG:
    """A balanced tree of additions over `leaves` values, all alive at first."""
    nodes = [Node(index, Opcode.MOV) for index in range(leaves)]
    edges: list[Edge] = []
    level = list(range(leaves))
    while len(level) > 1:
        above = []
        for left, right in zip(level[::2], level[1::2], strict=True):
            nodes.append(Node(len(nodes), Opcode.ADD))
            above.append(nodes[-1].id)
            edges += [Edge(left, above[-1], 0), Edge(right, above[-1], 1)]
        level = above
    return DFG("sum", tuple(nodes), tuple(edges))


def chains(count: int, width: int) -> DFG:
    """Chains beside each other, each of which has `width` words alive at once in its middle."""
    nodes = [Node(index, Opcode.MOV) for index in range(count)]
    edges: list[Edge] = []

    def made(op: Opcode, left: int, right: int) -> int:
        nodes.append(Node(len(nodes), op))
        edges.extend((Edge(left, nodes[-1].id, 0), Edge(right, nodes[-1].id, 1)))
        return nodes[-1].id

    for first in range(count):
        words = [first]
        for _ in range(width):
            words.append(made(Opcode.ADD, first, words[-1]))
        last = words[-1]
        for word in words[1:-1]:
            last = made(Opcode.MUL, last, word)
    return DFG("chains", tuple(nodes), tuple(edges))


FABRICS: dict[str, Fabric] = {
    "vivid-tile": load("vivid-tile"),
    "vivid-tile-unit": load("vivid-tile-unit"),
    "torus": load("torus-4x4"),
    "row-of-two": tiny_fabric(1, 2, registers=12, read_ports=2, constants=60),
    "one-register": tiny_fabric(4, 4, registers=1, memory=frozenset({0, 1, 4})),
    "one-way-ring": tiny_fabric(
        2, 2, registers=8, read_ports=3, constants=60, links=((0, 1), (1, 3), (3, 2), (2, 0))
    ),
}


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("name", FABRICS)
def test_random_regions_are_scheduled_legally(name: str, seed: int) -> None:
    dfg = random_region(seed, 5 + 4 * seed, reach=(3, 8, 25)[seed % 3])
    assert check(dfg) == []
    homes = {
        node.id: frozenset({node.id % len(FABRICS[name].pes)})
        for node in dfg.nodes
        if node.op is Opcode.LIVE_OUT
    }
    legal_schedule(MapProblem(dfg, FABRICS[name], allowed=homes))


@pytest.mark.parametrize("reach", [5, 60])
def test_a_large_region_comes_close_to_its_bound(reach: int) -> None:
    problem = MapProblem(random_region(1, 250, reach=reach), FABRICS["vivid-tile"])
    assert legal_schedule(problem).ii <= 1.1 * straight_lower_bound(problem).ii


def test_two_runs_give_the_same_mapping() -> None:
    problem = MapProblem(random_region(5, 40), FABRICS["vivid-tile"])
    assert list_schedule(problem) == list_schedule(problem)


def test_an_empty_region_takes_one_cycle() -> None:
    assert legal_schedule(MapProblem(DFG("empty", (), ()), FABRICS["vivid-tile"])).ii == 1


def test_a_chain_takes_the_sum_of_its_latencies() -> None:
    problem = MapProblem(chain(4, Opcode.MUL), tiny_fabric(latencies=_SLOW_MUL))
    assert straight_lower_bound(problem).ii == 12
    assert straight_lower_bound(problem).nodes == (0, 1, 2, 3)
    assert legal_schedule(problem).ii == 12


def test_operations_that_share_a_pe_wait_for_each_other() -> None:
    fabric = tiny_fabric(1, 2, memory=frozenset({1}), latencies={LatencyClass.LOAD: 2})
    loads = DFG("loads", tuple(Node(index, Opcode.LOAD, name="a") for index in range(5)), ())
    problem = MapProblem(loads, fabric)
    assert straight_lower_bound(problem).ii == 6
    assert straight_lower_bound(problem).name == "shared PEs"
    assert legal_schedule(problem).ii == 6


def test_hops_that_fixed_homes_force_are_in_the_bound() -> None:
    nodes = (Node(0, Opcode.MOV), Node(1, Opcode.LIVE_OUT, name="%x"))
    homes = {0: frozenset({0}), 1: frozenset({3})}
    dfg = DFG("far", nodes, (Edge(0, 1, 0),))
    problem = MapProblem(dfg, tiny_fabric(1, 4), allowed=homes)
    assert straight_lower_bound(problem).ii == 4  # one cycle, three hops of which one is free, one
    assert legal_schedule(problem).ii == 4


def test_a_control_result_acts_within_the_region() -> None:
    dfg = DFG("branch", (Node(0, Opcode.MUL, control=Control.BRANCH),), ())
    problem = MapProblem(dfg, tiny_fabric(latencies=_SLOW_MUL))
    assert straight_lower_bound(problem).ii == 4
    assert legal_schedule(problem).ii == 4


def test_control_results_come_one_a_cycle() -> None:
    nodes = (
        Node(0, Opcode.MOV, control=Control.BRANCH),
        Node(1, Opcode.MOV, control=Control.TRIP),
    )
    problem = MapProblem(DFG("both", nodes, ()), tiny_fabric(1, 2))
    assert straight_lower_bound(problem).ii == 3
    assert legal_schedule(problem).ii == 3


def loads(count: int) -> DFG:
    """Loads, each of an address of its own."""
    nodes = [Node(n, Opcode.MOV) for n in range(count)]
    nodes += [Node(count + n, Opcode.LOAD, name="a") for n in range(count)]
    edges = tuple(Edge(n, count + n, 0) for n in range(count))
    return DFG("loads", tuple(nodes), edges)


def test_accesses_that_meet_in_a_bank_start_in_different_cycles() -> None:
    problem = MapProblem(loads(2), FABRICS["vivid-tile"])
    accesses = [node.id for node in problem.dfg.nodes if node.is_memory]
    meets = {one: {other: 1.0 for other in accesses if other != one} for one in accesses}
    assert len(set(starts(list_schedule(problem), accesses))) == 1
    apart = list_schedule(problem, meets=meets)
    assert len(set(starts(apart, accesses))) == 2
    straight = violations(problem.dfg, problem.fabric, apart, straight=True)
    assert straight == []


def test_accesses_that_hardly_meet_are_not_late_for_it() -> None:
    problem = MapProblem(loads(4), FABRICS["vivid-tile"])
    accesses = [node.id for node in problem.dfg.nodes if node.is_memory]
    meets = {one: {other: 0.05 for other in accesses if other != one} for one in accesses}
    assert list_schedule(problem, meets=meets).ii == list_schedule(problem).ii


def starts(mapping: Mapping, nodes: list[int]) -> list[int]:
    """The cycles in which nodes start."""
    return [mapping.places[node].time for node in nodes]


def test_memory_operations_keep_their_order() -> None:
    nodes = (Node(0, Opcode.STORE, name="a"), Node(1, Opcode.LOAD, name="a"))
    dfg = DFG("order", nodes, (Edge(0, 1, ORDER, kind=EdgeKind.ORDER),))
    mapping = legal_schedule(MapProblem(dfg, tiny_fabric(1, 2)))
    assert mapping.places[1].time > mapping.places[0].time
    assert mapping.ii == 2


def test_one_value_goes_to_several_homes() -> None:
    outs = tuple(Node(1 + pe, Opcode.LIVE_OUT, name="%x") for pe in range(4))
    edges = tuple(Edge(0, node.id, 0) for node in outs)
    dfg = DFG("copies", (Node(0, Opcode.MOV), *outs), edges)
    homes = {node.id: frozenset({node.id - 1}) for node in outs}
    mapping = legal_schedule(MapProblem(dfg, tiny_fabric(2, 2), allowed=homes))
    assert mapping.ii == 3


def test_two_variables_are_exchanged_without_losing_a_word() -> None:
    """Each is read before its constant-store entry on that PE is written."""
    nodes = (
        Node(0, Opcode.LIVE_IN, name="%x"),
        Node(1, Opcode.LIVE_IN, name="%y"),
        Node(2, Opcode.MOV),
        Node(3, Opcode.MOV),
        Node(4, Opcode.LIVE_OUT, name="%x"),
        Node(5, Opcode.LIVE_OUT, name="%y"),
    )
    edges = (Edge(1, 2, 0), Edge(0, 3, 0), Edge(2, 4, 0), Edge(3, 5, 0))
    dfg = DFG("exchange", nodes, edges)
    legal_schedule(MapProblem(dfg, tiny_fabric(1, 1)))
    legal_schedule(MapProblem(dfg, FABRICS["vivid-tile"]))


def test_many_words_alive_at_once_fit_few_registers() -> None:
    assert legal_schedule(MapProblem(sum_of(64), FABRICS["one-register"])).ii <= 20


def test_chains_whose_words_do_not_fit_together_come_one_after_another() -> None:
    """60 chains with 5 words each need 300 registers if they keep pace, of 128."""
    legal_schedule(MapProblem(chains(60, 5), FABRICS["vivid-tile"]))


def test_resident_constants_leave_less_room() -> None:
    nodes = (Node(0, Opcode.CONST, const=7), Node(1, Opcode.MOV))
    dfg = DFG("constant", nodes, (Edge(0, 1, 0),))
    full = frozenset({("const", 1), ("const", 2)})
    fabric = tiny_fabric(1, 2, constants=2)
    mapping = legal_schedule(MapProblem(dfg, fabric, resident={0: full}))
    assert mapping.places[1].pe == 1
    again = frozenset({("const", 7), ("const", 2)})
    legal_schedule(MapProblem(dfg, fabric, resident={0: again, 1: full}))
    with pytest.raises(MappingFailed, match="constant store"):
        list_schedule(MapProblem(dfg, fabric, resident={0: full, 1: full}))


def test_a_frugal_schedule_leaves_nearly_full_stores_alone() -> None:
    """Rather later than with an entry in a store that regions behind may need."""
    dfg = DFG(
        "numbers",
        (Node(0, Opcode.CONST, const=7), Node(1, Opcode.MOV), Node(2, Opcode.MOV)),
        (Edge(0, 1, 0), Edge(0, 2, 0)),
    )
    fabric = tiny_fabric(1, 3, constants=16)
    nearly = frozenset(("const", 100 + number) for number in range(fabric.pes[0].constants - 1))
    problem = MapProblem(dfg, fabric, resident={0: nearly, 1: nearly})
    pes = {place.pe for place in legal_schedule(problem).places.values()}
    frugal = {place.pe for place in legal_schedule(problem, frugal=True).places.values()}
    assert pes & {0, 1}
    assert frugal == {2}


def test_an_operation_that_no_pe_executes_is_refused_with_its_line() -> None:
    load_node = Node(0, Opcode.LOAD, name="a", loc=SourceLoc("kernel.py", 7))
    fabric = tiny_fabric(memory=frozenset())
    with pytest.raises(MappingFailed, match=r"kernel\.py:7: no PE permitted to node 0 \(load\)"):
        list_schedule(MapProblem(DFG("load", (load_node,), ()), fabric))


def test_a_region_longer_than_the_configuration_memory_is_refused() -> None:
    with pytest.raises(MappingFailed, match="takes 9 cycles, but a PE has 8 contexts"):
        list_schedule(MapProblem(chain(9), tiny_fabric(contexts=8)))


def test_a_distance_is_refused() -> None:
    dfg = DFG("loop", (Node(0, Opcode.MOV),), (Edge(0, 0, 0, 1),))
    with pytest.raises(MappingFailed, match="has distance 1"):
        list_schedule(MapProblem(dfg, tiny_fabric()))


def test_a_cycle_is_refused() -> None:
    nodes = (Node(0, Opcode.MOV), Node(1, Opcode.MOV))
    dfg = DFG("cycle", nodes, (Edge(0, 1, 0), Edge(1, 0, 0)))
    with pytest.raises(MappingFailed, match="form a cycle"):
        list_schedule(MapProblem(dfg, tiny_fabric()))


def test_registers_that_do_not_suffice_are_named() -> None:
    fabric = tiny_fabric(1, 1, registers=1)
    with pytest.raises(MappingFailed, match="registers hold words that are still needed"):
        list_schedule(MapProblem(sum_of(8), fabric))


def test_more_words_at_once_than_a_pe_can_bring_together_are_named() -> None:
    nodes = (*(Node(index, Opcode.MOV) for index in range(4)), Node(4, Opcode.SELECT))
    dfg = DFG("wide", nodes, (Edge(3, 4, PRED), *(Edge(i, 4, i) for i in range(3))))
    legal_schedule(MapProblem(dfg, tiny_fabric(2, 2, read_ports=2)))
    lone = tiny_fabric(1, 1, registers=8, read_ports=1)
    with pytest.raises(MappingFailed, match="reads 4 words at once"):
        list_schedule(MapProblem(dfg, lone))


def test_pes_without_links_between_them_are_named() -> None:
    homes = {0: frozenset({0}), 1: frozenset({1})}
    with pytest.raises(MappingFailed, match="no links lead"):
        list_schedule(MapProblem(chain(2), tiny_fabric(links=()), allowed=homes))


def test_a_pass_ends_once_it_cannot_be_shorter() -> None:
    problem = MapProblem(random_region(3, 40), tile())
    length = greedy_pass(problem).run()
    assert length is not None
    assert greedy_pass(problem).run(length + 1) == length
    assert greedy_pass(problem).run(length) is None


@pytest.mark.parametrize(("cycles", "is_enough"), [(250, True), (252, True), (253, False)])
def test_a_schedule_within_a_hundredth_of_a_long_bound_is_enough(
    monkeypatch: pytest.MonkeyPatch, cycles: int, is_enough: bool
) -> None:
    trials = []

    def run(_: Schedule, below: float) -> int:
        trials.append(below)
        return cycles

    monkeypatch.setattr(Schedule, "run", run)
    monkeypatch.setattr(Schedule, "mapping", lambda _: Mapping(cycles, {}, {}))
    problem = MapProblem(chain(250), load("vivid-tile"))
    assert straight_lower_bound(problem).ii == 250
    assert list_schedule(problem).ii == cycles
    assert (len(trials) == 1) == is_enough


def test_a_place_that_cannot_be_better_is_not_tried() -> None:
    """All PEs are as good in time; the least that routes and constants take tells them apart."""
    problem = MapProblem(random_region(3, 40), tile())
    schedule = greedy_pass(problem)
    schedule.run()
    assert schedule.job.tried[0] < 2 * len(problem.dfg.placed)


def greedy_pass(problem: MapProblem) -> Schedule:
    policy = Policy({}, 0.6, deep=False, affinity=2, constants=1, spared=0, apart=2)
    return Schedule(Region(problem, heights_of(problem), NO_MEETS), policy)


def tile() -> Fabric:
    fabric = load("vivid-tile")
    assert isinstance(fabric, Fabric)
    return fabric
