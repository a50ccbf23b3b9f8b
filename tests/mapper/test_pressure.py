"""The bound from lives is sound, exact where it can be seen, and names what binds."""

from __future__ import annotations

import random

import pytest
from brute_force import minimum_ii
from random_graphs import random_loop
from tiny_fabrics import tiny_fabric

from vividc import arch
from vividc.dfg.ir import DFG, Edge, Node
from vividc.machine.opcodes import LatencyClass, Opcode
from vividc.mapper import map_dfg
from vividc.mapper.bounds.bounds import all_bounds, mii
from vividc.mapper.bounds.pressure import least_life, pressure_bounds
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.dependences import dependences, earliest_starts


def test_words_that_need_not_wait_live_no_longer_than_their_reads_take() -> None:
    """A chain is read from output registers alone; of four reads, three take a place each."""
    chain = DFG("chain", tuple(Node(i, Opcode.MOV) for i in range(5)), (Edge(0, 1, 0),))
    fan = tuple(Edge(0, i, 0) for i in range(1, 5))
    assert least_life(MapProblem(chain, tiny_fabric()), 3) == 0
    assert least_life(MapProblem(DFG("fan", chain.nodes, fan), tiny_fabric()), 3) == 3


def test_a_carried_word_lives_its_distance() -> None:
    nodes = (Node(0, Opcode.MOV), Node(1, Opcode.CONST, const=0), Node(2, Opcode.MOV))
    dfg = DFG("carried", nodes, (Edge(0, 2, 0, 3, 1), Edge(2, 0, 0)))
    problem = MapProblem(dfg, tiny_fabric())
    assert [least_life(problem, ii) for ii in (1, 2, 5)] == [1, 4, 13]


def test_lives_that_do_not_fit_the_registers_bind() -> None:
    """A multiplication of 9 cycles takes two words in and one past it that cannot be made later."""
    latencies = {LatencyClass.IMUL: 9}
    nodes = [Node(0, Opcode.LOAD)]
    edges = []
    for at in range(1, 7):
        nodes += [Node(2 * at, Opcode.MUL), Node(2 * at + 1, Opcode.ADD)]
        before = 0 if at == 1 else 2 * at - 1
        edges += [Edge(before, 2 * at, 0), Edge(before, 2 * at, 1)]
        edges += [Edge(before, 2 * at + 1, 0), Edge(2 * at, 2 * at + 1, 1)]
    dfg = DFG("detours", tuple(nodes), tuple(edges))
    fabric = tiny_fabric(1, 4, registers=1, latencies=latencies, max_stages=64)
    problem = MapProblem(dfg, fabric)
    life = least_life(problem, 4)
    assert life == 6 * 9
    (bound,) = pressure_bounds(problem, 4, 100)
    assert bound.ii == -(-life // (6 + 4)) == 6
    assert "54 cycles" in bound.reason
    assert mii(all_bounds(problem)) == 6
    assert "register pressure 6" in map_dfg(dfg, fabric, time_limit_s=5, workers=1).explain()


@pytest.mark.parametrize("seed", range(40))
def test_it_is_never_above_the_least_ii(seed: int) -> None:
    draw = random.Random(seed)
    fabric = tiny_fabric(
        1,
        draw.choice((1, 2)),
        registers=draw.choice((0, 1, 1, 2)),
        contexts=5,
        max_stages=3,
        latencies={LatencyClass.IMUL: draw.choice((1, 3)), LatencyClass.LOAD: 2},
    )
    dfg = random_loop(700 + seed, 2 + seed % 3)
    best = minimum_ii(dfg, fabric)
    problem = MapProblem(dfg, fabric)
    nodes = [node.id for node in dfg.placed]
    edges = dependences(dfg, fabric)
    least = next(ii for ii in range(1, 99) if earliest_starts(nodes, edges, ii) is not None)
    for bound in pressure_bounds(problem, least, 99):
        assert best is None or bound.ii <= best[0]


def test_a_schedule_is_never_below_the_least_life() -> None:
    fabric = arch.load("vivid-tile")
    for seed in range(10):
        dfg = random_loop(seed, 30)
        problem = MapProblem(dfg, fabric)
        ii = mii(all_bounds(problem))
        nodes = [node.id for node in dfg.placed]
        edges = dependences(dfg, fabric)
        starts = earliest_starts(nodes, edges, ii)
        assert starts is not None
        ends: dict[int, int] = {}
        for edge in edges:
            if edge.routed:
                life = starts[edge.dst] + ii * edge.distance - starts[edge.src] - edge.latency
                ends[edge.src] = max(ends.get(edge.src, 0), life)
        reads = sum(len(dfg.out_edges[word]) for word in ends)
        assert least_life(problem, ii) <= sum(ends.values()) + reads
