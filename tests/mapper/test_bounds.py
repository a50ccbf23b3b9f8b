"""Bounds: exact against enumeration, and worded so that a user sees what binds."""

from __future__ import annotations

import random
from dataclasses import replace

import networkx as nx
import pytest
from fabrics import EVERYTHING, NO_MEMORY, grid
from graphs import GraphBuilder, accumulator, chain

from vividc import arch
from vividc.dfg.ir import DFG, Control, Edge, Node
from vividc.errors import SourceLoc
from vividc.machine.opcodes import LatencyClass, Opcode
from vividc.mapper.bounds.bounds import all_bounds, hall_sets, mii, no_ii
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.dependences import (
    Dependence,
    dependences,
    earliest_starts,
    least_ii,
    positive_cycle,
)

SLOW_FP = {LatencyClass.FADD: 4, LatencyClass.IMUL: 3}


def _random_cyclic(seed: int) -> DFG:
    draw = random.Random(seed)
    g = GraphBuilder(f"random{seed}")
    size = draw.randint(2, 7)
    for _ in range(size):
        g.op(draw.choice((Opcode.ADD, Opcode.MUL, Opcode.FADD)))
    for _ in range(draw.randint(1, 2 * size)):
        a, b = draw.randrange(size), draw.randrange(size)
        if a < b and draw.random() < 0.7:
            g.carry(a, b, 0, 0, distance=0)
        elif draw.random() < 0.3:
            g.order(a, b, distance=draw.randint(1, 3))
        else:
            g.carry(a, b, 0, 0, distance=draw.randint(1, 3))
    return g.build()


def _rec_mii_by_enumeration(problem: MapProblem) -> int:
    graph = nx.MultiDiGraph()
    for edge in dependences(problem.dfg, problem.fabric):
        graph.add_edge(edge.src, edge.dst, cost=(edge.separation, edge.distance))
    worst = 0
    for cycle in nx.simple_cycles(nx.DiGraph(graph)):
        ratios = [(0, 0)]
        for a, b in zip(cycle, [*cycle[1:], cycle[0]], strict=True):
            costs = {data["cost"] for data in graph[a][b].values()}
            ratios = [(s + cs, d + cd) for s, d in ratios for cs, cd in costs]
        worst = max([worst, *(-(-s // d) for s, d in ratios)])
    return worst


@pytest.mark.parametrize("seed", range(60))
def test_rec_mii_is_the_maximum_cycle_ratio(seed: int) -> None:
    problem = MapProblem(_random_cyclic(seed), grid(2, 2, latencies=SLOW_FP, contexts=64))
    found = [bound for bound in all_bounds(problem) if bound.name == "RecMII"]
    assert mii(found) == max(_rec_mii_by_enumeration(problem), 1)


@pytest.mark.parametrize("seed", range(20))
def test_the_cycle_of_rec_mii_reaches_it(seed: int) -> None:
    problem = MapProblem(_random_cyclic(seed), grid(2, 2, latencies=SLOW_FP, contexts=64))
    for bound in all_bounds(problem):
        if bound.name == "RecMII":
            nodes = set(bound.nodes)
            inside = [n for n in problem.dfg.nodes if n.id in nodes]
            kept = [e for e in problem.dfg.edges if {e.src, e.dst} <= nodes]
            alone = MapProblem(DFG("cycle", tuple(inside), tuple(kept)), problem.fabric)
            assert _rec_mii_by_enumeration(alone) == bound.ii


def test_a_recurrence_names_its_source_lines() -> None:
    dfg = accumulator()
    nodes = tuple(replace(n, loc=SourceLoc("fir.py", 9 + n.id)) for n in dfg.nodes)
    problem = MapProblem(replace(dfg, nodes=nodes), grid(2, 2, latencies=SLOW_FP))
    bound = all_bounds(problem)[0]
    assert (bound.name, bound.ii) == ("RecMII", 4)
    assert "fir.py:12" in bound.reason


def test_issue_slots_of_the_whole_array_bind() -> None:
    bound = all_bounds(MapProblem(chain(9), grid(2, 2)))[0]
    assert (bound.name, bound.ii) == ("ResMII", 3)
    assert "all 4 PEs" in bound.reason


def test_memory_pes_bind_before_the_array_does() -> None:
    g = GraphBuilder("loads")
    iv = g.source(Opcode.IV)
    for name in "abc":
        g.load(name, iv)
    fabric = grid(2, 2, classes={1: NO_MEMORY, 2: NO_MEMORY, 3: NO_MEMORY})
    bound = all_bounds(MapProblem(g.build(), fabric))[0]
    assert (bound.name, bound.ii) == ("ResMII", 3)
    assert "PEs 0" in bound.reason


def test_unions_of_pe_sets_bind_where_no_set_alone_does() -> None:
    only_mul = NO_MEMORY - {LatencyClass.INT}
    fabric = grid(1, 3, classes={0: only_mul, 2: frozenset({LatencyClass.FADD})})
    g = GraphBuilder("mixed")
    for op in (Opcode.MUL, Opcode.MUL, Opcode.MUL, Opcode.ADD, Opcode.ADD):
        g.op(op)
    assert mii(all_bounds(MapProblem(g.build(), fabric))) == 3


def test_control_results_need_a_slot_each() -> None:
    g = GraphBuilder("control")
    for _ in range(2):
        g.mark(g.op(Opcode.ICMP_EQ), control=Control.EXIT)
    bound = all_bounds(MapProblem(g.build(), grid(2, 2)))[0]
    assert (bound.name, bound.ii) == ("control port", 2)


def test_live_outs_with_one_home_need_a_slot_each() -> None:
    g = GraphBuilder("live-outs")
    value = g.op(Opcode.ADD)
    outs = [g.op(Opcode.LIVE_OUT, value, name=f"%{n}") for n in "abc"]
    problem = MapProblem(g.build(), grid(2, 2), allowed=dict.fromkeys(outs, frozenset({3})))
    assert max(b.ii for b in all_bounds(problem) if b.name == "live-out writes") == 3


def test_a_path_longer_than_the_stages_raises_the_ii() -> None:
    bound = all_bounds(MapProblem(chain(6), grid(2, 3, max_stages=2)))[0]
    assert (bound.name, bound.ii) == ("stages", 3)


def test_a_node_no_pe_can_run_is_named() -> None:
    fabric = grid(1, 2, classes=dict.fromkeys((0, 1), EVERYTHING - {LatencyClass.FADD}))
    problem = MapProblem(accumulator(), fabric)
    bounds = all_bounds(problem)
    assert mii(bounds) == no_ii(problem)
    assert "fadd #3" in bounds[0].reason


def test_a_node_with_more_constants_than_any_store_is_named() -> None:
    bounds = all_bounds(MapProblem(chain(1), grid(1, 2, constants=0)))
    assert "constant store" in bounds[0].reason


def test_a_live_out_that_reads_the_entry_it_writes_is_named() -> None:
    g = GraphBuilder("delayed")
    total = g.op(Opcode.ADD, g.source(Opcode.IV), g.const(1))
    delivered = g.op(Opcode.LIVE_OUT, name="%sum")
    g.carry(total, delivered, 0, g.source(Opcode.LIVE_IN, name="%sum"))
    problem = MapProblem(g.build(), grid(2, 2))
    (bound,) = all_bounds(problem)
    assert bound.ii == no_ii(problem)
    assert "reads the entry of the constant store that it writes" in bound.reason


def test_a_node_that_reads_more_words_than_come_to_a_pe_is_named() -> None:
    """Twelve operands kept the search going until its time was up."""
    nodes = tuple(Node(i, Opcode.GENERIC, name="op") for i in range(9))
    edges = tuple(Edge(i, 8, port) for port, i in enumerate(range(8)))
    problem = MapProblem(DFG("sum of eight", nodes, edges), arch.load("mesh-3x3"))
    (bound,) = all_bounds(problem)
    assert bound.ii == no_ii(problem)
    assert "reads 8 words at once: 7 come to a PE" in bound.reason
    seven = replace(problem, dfg=replace(problem.dfg, edges=edges[1:]))
    assert mii(all_bounds(seven)) == 1


def test_a_resident_constant_costs_no_room() -> None:
    resident = {0: frozenset({("const", 1)})}
    problem = MapProblem(chain(1), grid(1, 2, constants=1), resident=resident)
    assert mii(all_bounds(problem)) == 1


def test_a_cycle_of_distance_zero_admits_no_ii() -> None:
    g = GraphBuilder("knot")
    a, b = g.op(Opcode.ADD), g.op(Opcode.ADD)
    g.carry(a, b, 0, 0, distance=0)
    g.carry(b, a, 0, 0, distance=0)
    problem = MapProblem(g.build(), grid(2, 2))
    assert mii(all_bounds(problem)) == no_ii(problem)


def test_hall_sets_are_capped_but_keep_the_whole() -> None:
    sets = hall_sets([{n} for n in range(16)])
    assert frozenset(range(16)) in sets
    assert len(sets) <= 256


def test_the_least_ii_is_the_first_without_a_positive_cycle() -> None:
    rng = random.Random(3)
    for _ in range(300):
        nodes = range(rng.randint(1, 9))
        edges = [
            Dependence(
                *(rng.choice(nodes), rng.choice(nodes), rng.choice((0, 0, 1, 1, 2, 3))),
                *(rng.randint(0, 7), True, 1, index),
            )
            for index in range(rng.randint(1, 20))
        ]
        limit = sum(edge.separation for edge in edges) + 1
        works = [ii for ii in range(limit) if not positive_cycle(nodes, edges, ii)]
        assert least_ii(nodes, edges) == min(works, default=None)
        assert all(earliest_starts(nodes, edges, ii) is not None for ii in works)
