"""Arrays on which words cannot get everywhere: proved answers with their reasons."""

from __future__ import annotations

from dataclasses import replace

import pytest
from tiny_fabrics import tiny_fabric

from vividc.arch import load, load_text
from vividc.arch.fabric import Fabric, Routing
from vividc.dfg.ir import DFG, Edge, Node
from vividc.machine.opcodes import BASE, LatencyClass, Opcode
from vividc.mapper import MapResult, map_dfg
from vividc.mapper.bounds.reach import reachable

_MEMORY = frozenset({LatencyClass.LOAD, LatencyClass.STORE})


def _load_then_add() -> DFG:
    nodes = (
        Node(0, Opcode.CONST, const=0),
        Node(1, Opcode.LIVE_IN, name="&x"),
        Node(2, Opcode.LOAD, name="x"),
        Node(3, Opcode.ADD),
    )
    return DFG("load", nodes, (Edge(0, 2, 0), Edge(1, 2, BASE), Edge(2, 3, 0), Edge(2, 3, 1)))


def _chain(length: int) -> DFG:
    nodes = tuple(Node(i, Opcode.GENERIC, name=f"n{i}") for i in range(length))
    return DFG("chain", nodes, tuple(Edge(i, i + 1, 0) for i in range(length - 1)))


def _map(dfg: DFG, fabric: Fabric) -> MapResult:
    return map_dfg(dfg, fabric, time_limit_s=20, workers=1)


def _apart(fabric: Fabric) -> Fabric:
    """PE 0 does nothing but memory, the others everything else."""
    pes = [replace(fabric.pes[0], classes=_MEMORY)]
    pes += [replace(pe, classes=pe.classes - _MEMORY) for pe in fabric.pes[1:]]
    return replace(fabric, pes=tuple(pes))


def test_a_word_that_no_link_takes_to_its_reader() -> None:
    result = _map(_load_then_add(), _apart(tiny_fabric(1, 2, links=((1, 0),))))
    assert result.status == "infeasible"
    assert result.bounds[0].name == "reach"
    assert "load x #2 to add #3" in result.bounds[0].reason
    assert _map(_load_then_add(), _apart(tiny_fabric(1, 2, links=((0, 1),)))).ii == 1


def test_words_that_links_do_not_carry_stay_with_neighbours() -> None:
    far = _apart(tiny_fabric(1, 3, routing=Routing(hops=0, shared=True)))
    middle = replace(far.pes[1], classes=frozenset({LatencyClass.GENERIC}))
    far = replace(far, pes=(far.pes[0], middle, far.pes[2]))
    assert _map(_load_then_add(), far).status == "infeasible"
    moving = replace(far, routing=Routing(hops=0, shared=True, moves=True))
    assert _map(_load_then_add(), moving).status == "optimal"


def test_no_memory_pe_for_a_load() -> None:
    fabric = load_text("extends: mesh-2x2\npe: {memory: false}\nabsent: [memory]\n")
    result = _map(_load_then_add(), fabric)
    assert result.status == "infeasible"
    assert "no PE allowed for it has that operation" in result.bounds[0].reason


def test_pes_without_links_are_islands() -> None:
    fabric = load_text("extends: mesh-4x4\ntopology: none\n")
    result = _map(_chain(9), fabric)
    assert (result.status, result.ii) == ("optimal", 9)
    assert result.bounds[0].name == "island"
    assert "PEs that no links join" in result.explain()


def test_one_pe_without_registers() -> None:
    """A word is read in the cycle in which it appears, or never."""
    bare = tiny_fabric(1, 1, registers=0, read_ports=0, write_ports=0, contexts=8)
    assert _map(_chain(4), bare).ii == 4
    fork = DFG("fork", _chain(3).nodes, (Edge(0, 1, 0), Edge(0, 2, 0)))
    result = _map(fork, bare)
    assert result.status in ("infeasible", "timeout")
    assert result.mapping is None


@pytest.mark.parametrize(
    ("routing", "reached"),
    [
        (Routing(), {0, 1, 2}),
        (Routing(hops=0), {0}),
        (Routing(hops=0, shared=True), {0, 1}),
        (Routing(hops=0, moves=True), {0}),
        (Routing(hops=0, shared=True, moves=True), {0, 1, 2}),
        (Routing(hops=3), {0, 1, 2}),
    ],
)
def test_how_far_words_go(routing: Routing, reached: set[int]) -> None:
    assert reachable(tiny_fabric(1, 3, routing=routing))[0] == reached


@pytest.mark.parametrize(
    "name", ["mesh-1x1", "openedge-1x1", "hycube-1x1", "adres-1x1", "king-1x1"]
)
def test_one_pe_is_an_array(name: str) -> None:
    result = _map(_chain(3), load(name))
    assert (result.status, result.ii) == ("optimal", 3)
