"""What output registers have room for: refuted IIs are impossible, and some are refuted."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest
from brute_routing import minimum_ii
from tiny_fabrics import tiny_fabric

from tests.marks import with_slow
from vividc.arch import load
from vividc.arch.fabric import Fabric, Routing
from vividc.dfg.ir import DFG, Edge, Node
from vividc.machine.opcodes import LatencyClass, Opcode
from vividc.mapper.bounds.bounds import all_bounds, mii
from vividc.mapper.deadline import Deadline
from vividc.mapper.engines.cpsat import Search, refute_schedule
from vividc.mapper.engines.cpsat.output_cells import outputs_are_the_only_way
from vividc.mapper.engines.negotiate import Effort, negotiate
from vividc.mapper.problem import MapProblem

OPEN = Routing(hops=0, holds=True, shared=True, moves=True)
RING = ((0, 1), (1, 2), (2, 0))
TINY: dict[str, Fabric] = {
    "row": tiny_fabric(
        1, 3, registers=1, max_stages=2, contexts=3, routing=OPEN, written_by_fu=True
    ),
    "no registers": tiny_fabric(
        1, 2, registers=0, read_ports=0, write_ports=0, max_stages=2, contexts=3, routing=OPEN
    ),
    "ring": tiny_fabric(
        1,
        3,
        registers=1,
        links=RING,
        max_stages=2,
        contexts=3,
        routing=replace(OPEN, holds=False),
        written_by_fu=True,
        latencies={LatencyClass.IMUL: 2},
    ),
}
OPENEDGE = load("openedge-3x3")
LARGER: dict[str, Fabric] = {
    "openedge": OPENEDGE,
    "no moves": replace(OPENEDGE, routing=replace(OPENEDGE.routing, moves=False)),
    "no holding": replace(OPENEDGE, routing=replace(OPENEDGE.routing, holds=False)),
    "one register": replace(
        OPENEDGE, pes=tuple(replace(pe, registers=1, read_ports=1) for pe in OPENEDGE.pes)
    ),
    "slow": replace(OPENEDGE, latencies={**OPENEDGE.latencies, LatencyClass.IMUL: 2}),
}


def wide_loop(seed: int, most: int) -> DFG:
    """A loop in which a few words have many readers, and some are read iterations later."""
    draw = random.Random(seed)
    count, hub = draw.randint(3, most), draw.random()
    nodes = tuple(Node(n, draw.choice((Opcode.ADD, Opcode.MUL, Opcode.ADD))) for n in range(count))
    edges = []
    for node in range(1, count):
        for port in range(draw.randint(1, 2)):
            below = min(node, 2) if draw.random() < hub else node
            distance = draw.choice((0, 0, 0, 0, 1))
            edges.append(Edge(draw.randrange(below), node, port, distance))
    for _ in range(draw.randint(0, 3)):
        src, dst = draw.randrange(count), draw.randrange(count)
        edges.append(Edge(src, dst, 2, draw.randint(1, 3)))
    return DFG(f"wide {seed}", nodes, tuple(edges))


def refuted(dfg: DFG, fabric: Fabric, ii: int) -> bool:
    search = Search(Deadline.after(60), workers=1)
    return refute_schedule(MapProblem(dfg, fabric), ii, search).verdict == "refuted"


def star(readers: int) -> DFG:
    """One word that so many operations read."""
    nodes = tuple(Node(n, Opcode.MOV) for n in range(readers + 1))
    return DFG("star", nodes, tuple(Edge(0, n, 0) for n in range(1, readers + 1)))


def test_at_an_ii_of_one_four_neighbours_read_a_word() -> None:
    fabric = load("openedge-4x4")
    assert not refuted(star(4), fabric, 1)
    assert refuted(star(13), fabric, 1)
    assert not refuted(star(13), fabric, 2)


def test_a_word_that_waits_at_an_ii_of_one_takes_a_pe_for_each_cycle() -> None:
    nodes = tuple(Node(n, Opcode.MOV) for n in range(4))
    chain = [Edge(n, n + 1, 0) for n in range(3)]
    dfg = DFG("late", nodes, (*chain, Edge(0, 3, 1)))
    assert refuted(dfg, load("openedge-1x5"), 1)
    assert not refuted(dfg, load("openedge-2x3"), 1)


def test_links_and_free_register_files_are_another_way() -> None:
    assert outputs_are_the_only_way(OPENEDGE)
    assert not outputs_are_the_only_way(load("hycube-3x3"))
    files = tuple(replace(pe, written_by_fu=False) for pe in OPENEDGE.pes)
    assert not outputs_are_the_only_way(replace(OPENEDGE, pes=files))


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("name", TINY)
def test_what_it_refutes_is_impossible(name: str, seed: int) -> None:
    dfg, fabric = wide_loop(seed, 3), TINY[name]
    bound = mii(all_bounds(MapProblem(dfg, fabric)))
    found = minimum_ii(dfg, fabric)
    if bound <= fabric.controller.contexts and found is not None:
        assert not refuted(dfg, fabric, found[0])


@pytest.mark.parametrize("seed", with_slow(range(8), {4, 5, 6, 7}))
@pytest.mark.parametrize("name", LARGER)
def test_what_is_mapped_is_not_refuted(name: str, seed: int) -> None:
    dfg, fabric = wide_loop(100 + seed, 14), LARGER[name]
    problem = MapProblem(dfg, fabric)
    least = mii(all_bounds(problem))
    for ii in range(least, least + 4):
        found = negotiate(problem, ii, seed, Deadline.after(60), Effort(moves=2000, repairs=20))
        if found.mapping is not None:
            assert not refuted(dfg, fabric, ii)
            return
