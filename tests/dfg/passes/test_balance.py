"""Balanced reductions: shorter recurrences and trees, the same words."""

from __future__ import annotations

import numpy as np
import pytest

from tests.dfg.test_passes_keep_meaning import run
from tests.strategies import MEMORY_WORDS
from vividc import arch
from vividc.dfg.builder import GraphBuilder, Operand
from vividc.dfg.check import check
from vividc.dfg.ir import DFG, Node
from vividc.dfg.passes import balance_reductions
from vividc.machine.opcodes import Opcode
from vividc.mapper.bounds.bounds import recurrence_bounds
from vividc.mapper.problem import MapProblem

UNIT = arch.load("vivid-tile")


def loads(builder: GraphBuilder, count: int, *, in_loop: bool = True) -> list[Operand]:
    index = builder.iv() if in_loop else builder.const(0)
    return [
        builder.add_node(
            Node(0, Opcode.LOAD, name="x", shift=2, offset=4 * k),
            [index],
            None,
            builder.live_in("&x"),
        )
        for k in range(count)
    ]


def accumulation(op: Opcode, count: int) -> DFG:
    """total = (((total op x0) op x1) op ...), written out every iteration."""
    builder = GraphBuilder("sum")
    total = builder.open_phi()
    result = total
    for word in loads(builder, count):
        result = builder.add(op, [result, word])
    builder.close_phi(total, builder.const(1), result)
    builder.add_node(Node(0, Opcode.LIVE_OUT, name="%1"), [builder.operation(result)])
    return builder.build()


def rec_mii(dfg: DFG) -> int:
    return max((bound.ii for bound in recurrence_bounds(MapProblem(dfg, UNIT))), default=1)


@pytest.mark.parametrize("op", [Opcode.ADD, Opcode.XOR, Opcode.SMIN, Opcode.MUL, Opcode.AND])
@pytest.mark.parametrize("count", [2, 3, 4, 7])
def test_a_recurrence_is_one_operation_long(op: Opcode, count: int) -> None:
    dfg = accumulation(op, count)
    balanced = balance_reductions(dfg)
    assert check(balanced) == []
    assert rec_mii(dfg) == count * rec_mii(accumulation(op, 1))
    assert rec_mii(balanced) == rec_mii(accumulation(op, 1))
    assert len(balanced.nodes) == len(dfg.nodes)
    assert balance_reductions(balanced) is balanced


def test_floats_keep_their_order_unless_asked() -> None:
    dfg = accumulation(Opcode.FADD, 4)
    assert balance_reductions(dfg) is dfg
    assert rec_mii(balance_reductions(dfg, reassociate=True)) == rec_mii(dfg) // 4


def chain(*, in_loop: bool) -> DFG:
    """The sum of eight words, one after another."""
    builder = GraphBuilder("tree")
    words = loads(builder, 8, in_loop=in_loop)
    result = words[0]
    for word in words[1:]:
        result = builder.add(Opcode.ADD, [result, word])
    builder.add_node(Node(0, Opcode.LIVE_OUT, name="%1"), [builder.operation(result)])
    return builder.build()


def test_a_chain_of_many_words_becomes_a_tree() -> None:
    dfg = chain(in_loop=False)
    balanced = balance_reductions(dfg)
    memory = [int(word) for word in np.random.default_rng(1).integers(0, 1 << 32, MEMORY_WORDS)]
    assert run(balanced, memory, 3, 0) == run(dfg, memory, 3, 0)
    assert max(_depths(balanced).values()) == 4  # a load and three additions


def test_a_chain_in_a_loop_that_starts_anew_each_time_stays() -> None:
    dfg = chain(in_loop=True)
    assert balance_reductions(dfg) is dfg


def _depths(dfg: DFG) -> dict[int, int]:
    depths: dict[int, int] = {}

    def depth(node: int) -> int:
        if node not in depths:
            own = 1 if dfg.by_id[node].uses_fu else 0
            depths[node] = own + max((depth(e.src) for e in dfg.in_edges[node]), default=0)
        return depths[node]

    for node in dfg.nodes:
        depth(node.id)
    return depths


def test_partial_results_that_others_read_stay() -> None:
    builder = GraphBuilder("partial")
    first, second, third = loads(builder, 3)
    total = builder.open_phi()
    partial = builder.add(Opcode.ADD, [total, first])
    result = builder.add(Opcode.ADD, [builder.add(Opcode.ADD, [partial, second]), third])
    builder.close_phi(total, builder.const(0), result)
    builder.add_node(Node(0, Opcode.LIVE_OUT, name="%1"), [builder.operation(partial)])
    builder.add_node(Node(0, Opcode.LIVE_OUT, name="%2"), [builder.operation(result)])
    dfg = builder.build()
    balanced = balance_reductions(dfg)
    memory = [int(word) for word in np.random.default_rng(2).integers(0, 1 << 32, MEMORY_WORDS)]
    assert run(balanced, memory, 3, 0) == run(dfg, memory, 3, 0)
    assert rec_mii(balanced) == 2
