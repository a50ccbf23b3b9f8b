"""Order edges between accesses of any width: every meeting is kept in order, and nothing else."""

from __future__ import annotations

from itertools import product
from random import Random

import pytest

from vividc.dfg.builder import GraphBuilder
from vividc.dfg.cut.memory_order import Access, order_accesses
from vividc.dfg.ir import Edge, EdgeKind, Node
from vividc.machine.lanes import Lane
from vividc.machine.opcodes import Opcode

ITERATIONS = 24


def ordered(*shapes: tuple[bool, int, int, int | None]) -> tuple[list[Access], list[Edge]]:
    """Accesses given as (is store, offset, width, stride), in program order, and their edges."""
    builder = GraphBuilder("loop")
    accesses = []
    for is_store, offset, width, stride in shapes:
        op = Opcode.STORE if is_store else Opcode.LOAD
        node = builder.add(op, [])
        accesses.append(Access(node, "x", is_store, "base", None, offset, stride, width=width))
    order_accesses(builder, accesses, loop="header")
    return accesses, [edge for edge in builder.build().edges if edge.kind is EdgeKind.ORDER]


def meetings(first: Access, second: Access) -> set[int]:
    """By how many iterations the second is later when they touch one byte (negative: earlier)."""
    assert first.stride_bytes is not None
    gap = second.offset - first.offset
    return {
        k
        for k in range(-ITERATIONS, ITERATIONS + 1)
        if -second.width < gap + k * first.stride_bytes < first.width
    }


@pytest.mark.parametrize("seed", range(200))
def test_byte_dependences_against_enumeration(seed: int) -> None:
    random = Random(seed)
    stride = random.choice((0, 1, 2, 4, 8, 3, 12, -1, -4, -6))
    accesses, edges = ordered(
        *(
            (random.random() < 0.6, random.randint(-9, 9), random.choice((1, 2, 4)), stride)
            for _ in range(4)
        )
    )
    kept = {(edge.src, edge.dst): edge.distance for edge in edges}
    for (i, first), (j, second) in product(enumerate(accesses), repeat=2):
        earliest = 0 if i < j else 1
        needed = min((k for k in meetings(first, second) if k >= earliest), default=None)
        if not (first.is_store or second.is_store):
            needed = None
        assert kept.get((first.node.node, second.node.node)) == needed


def test_an_address_that_is_not_affine_may_be_any_byte() -> None:
    _, edges = ordered((True, 0, 1, None), (False, 7, 1, 1))
    assert {(e.src, e.dst, e.distance) for e in edges} == {(0, 0, 1), (0, 1, 0), (1, 0, 1)}


def test_bytes_of_one_word_are_independent() -> None:
    _, edges = ordered(*((True, offset, 1, 4) for offset in range(4)))
    assert not edges


@pytest.mark.parametrize(("loop", "kept"), [("h.threads", False), ("elsewhere", True)])
def test_accesses_of_different_threads_have_no_order_in_their_loops(loop: str, kept: bool) -> None:
    builder = GraphBuilder("threads")
    accesses = []
    for thread in (0, 1):
        index = builder.live_in(f"i{thread}")
        node = builder.add_node(Node(0, Opcode.STORE, name="x"), [index, builder.iv()])
        lane = Lane(thread, 7, 0, ("groups", "h.threads"))
        accesses.append(Access(node, "x", True, "&x", index, 0, None, lane=lane))
    order_accesses(builder, accesses, loop=loop)
    between = {(edge.src, edge.dst) for edge in builder.build().edges if not edge.is_data}
    first, second = (access.node.node for access in accesses)
    assert ((first, second) in between) is kept
    assert {(first, first), (second, second)} <= between


def test_an_edge_tells_whether_its_distance_is_proved() -> None:
    _, stepping = ordered((False, 0, 4, 4), (True, 4, 4, 4))
    assert stepping
    assert not any(edge.assumed for edge in stepping)
    _, reversed_ = ordered((False, 0, 4, 4), (True, 0, 4, -4))
    assert any(edge.distance for edge in reversed_)
    assert all(edge.assumed for edge in reversed_)
    _, same_place = ordered((False, 0, 4, 0), (True, 0, 4, 0))
    assert any(edge.distance for edge in same_place)
    assert not any(edge.assumed for edge in same_place)
