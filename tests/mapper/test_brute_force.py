"""CP-SAT finds the same least II as trying everything, and says that it is the least."""

from __future__ import annotations

import pytest
from brute_force import mapping_at, minimum_ii
from random_graphs import random_loop
from tiny_fabrics import tiny_fabric

from vividc.arch.fabric import Fabric
from vividc.dfg.check import check
from vividc.dfg.ir import DFG, Edge, Node
from vividc.machine.opcodes import LatencyClass, Opcode
from vividc.mapper import map_dfg, violations

_NO_REGISTERS = {"registers": 0, "read_ports": 0, "write_ports": 0}
_IMUL2 = {LatencyClass.IMUL: 2}
_SLOW = {LatencyClass.IMUL: 3, LatencyClass.LOAD: 2}

FABRICS: dict[str, Fabric] = {
    "1x1": tiny_fabric(1, 1, registers=1, max_stages=3, contexts=5),
    "1x1-two-registers": tiny_fabric(1, 1, max_stages=3, contexts=5, latencies=_IMUL2),
    "1x2": tiny_fabric(1, 2, registers=1, max_stages=3, contexts=4, latencies=_SLOW),
    "1x2-one-lsu": tiny_fabric(
        1, 2, max_stages=2, contexts=4, latencies=_IMUL2, memory=frozenset({0})
    ),
    "1x2-no-registers": tiny_fabric(1, 2, **_NO_REGISTERS, max_stages=3, contexts=4),
    "1x2-few-constants": tiny_fabric(1, 2, constants=2, max_stages=2, contexts=4),
    "2x2": tiny_fabric(
        2, 2, registers=1, max_stages=2, contexts=3, latencies=_IMUL2, memory=frozenset({0, 1})
    ),
    "ring": tiny_fabric(
        1, 3, registers=1, max_stages=2, contexts=3, links=((0, 1), (1, 2), (2, 0))
    ),
}


def _least_iis(seed: int, size: int, fabric: Fabric) -> tuple[int | None, int | None]:
    dfg = random_loop(seed, size)
    assert check(dfg) == []
    exhaustive = minimum_ii(dfg, fabric)
    if exhaustive is not None:
        assert violations(dfg, fabric, exhaustive[1]) == []
    result = map_dfg(dfg, fabric, mapper="cpsat", workers=1)
    assert result.status == ("infeasible" if exhaustive is None else "optimal"), result.explain()
    return result.ii, None if exhaustive is None else exhaustive[0]


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("name", FABRICS)
def test_cpsat_finds_the_least_ii_of_small_loops(name: str, seed: int) -> None:
    found, least = _least_iis(100 * len(name) + seed, 2 + seed % 3, FABRICS[name])
    assert found == least


@pytest.mark.slow
@pytest.mark.parametrize("block", range(10))
@pytest.mark.parametrize("name", FABRICS)
def test_cpsat_finds_the_least_ii_of_many_loops(name: str, block: int) -> None:
    for seed in range(10 * block, 10 * block + 10):
        found, least = _least_iis(seed, 3 + seed % 3, FABRICS[name])
        assert found == least, f"seed {seed}"


def test_a_chain_on_one_pe_needs_a_slot_for_each_node() -> None:
    nodes = (Node(0, Opcode.MOV), Node(1, Opcode.MOV), Node(2, Opcode.MOV))
    dfg = DFG("chain", nodes, (Edge(0, 1, 0), Edge(1, 2, 0)))
    found = minimum_ii(dfg, FABRICS["1x1"])
    assert found is not None
    assert found[0] == 3
    assert mapping_at(dfg, FABRICS["1x1"], 2) is None


def test_a_word_with_two_readers_on_one_pe_must_wait_in_a_register() -> None:
    """The output register holds it for one cycle, in which only one of the two can issue."""
    nodes = (Node(0, Opcode.MOV), Node(1, Opcode.MOV), Node(2, Opcode.MOV))
    dfg = DFG("fork", nodes, (Edge(0, 1, 0), Edge(0, 2, 0)))
    assert minimum_ii(dfg, tiny_fabric(1, 1, **_NO_REGISTERS, contexts=5)) is None
    found = minimum_ii(dfg, tiny_fabric(1, 1, registers=1, contexts=5))
    assert found is not None
    assert found[0] == 3


def test_homes_are_kept() -> None:
    nodes = (Node(0, Opcode.MOV), Node(1, Opcode.LIVE_OUT, name="%x"))
    dfg = DFG("home", nodes, (Edge(0, 1, 0),))
    homes = {0: frozenset({1}), 1: frozenset({0})}
    found = minimum_ii(dfg, FABRICS["1x2"], allowed=homes)
    assert found is not None
    assert found[1].places[0].pe == 1
    assert violations(dfg, FABRICS["1x2"], found[1], allowed=homes) == []
