"""Float sums with fused products in another order: shorter, and the same where nothing rounds."""

from __future__ import annotations

import itertools
import random

import numpy as np
import pytest

import vividc
from kernels.dot import dot
from tests.dfg.passes.test_balance import loads, rec_mii
from tests.dfg.test_passes_keep_meaning import run
from tests.strategies import MEMORY_WORDS
from vividc.dfg.builder import GraphBuilder, Operand
from vividc.dfg.check import check
from vividc.dfg.ir import DFG, Node
from vividc.dfg.passes import balance_reductions
from vividc.dfg.passes.balance import rebalance_sums_of_loops
from vividc.machine.opcodes import Opcode
from vividc.machine.words import word_of

SMALL = [word_of(float(n)) for n in np.random.default_rng(3).integers(-3, 4, MEMORY_WORDS)]
"""Words of small whole numbers: sums and products of a few are exact in any order."""


FUSED = (Opcode.FMA, Opcode.FNMA)


def step(
    builder: GraphBuilder,
    op: Opcode,
    total: Operand,
    one: Operand,
    two: Operand,
    guard: Operand | None = None,
) -> Operand:
    """The total with a product, or a word, added or subtracted; a product perhaps not always."""
    if op in FUSED:
        return builder.add_node(Node(0, op), [one, two, total], guard)
    return builder.add(op, [total, one])


def sums(
    ops: list[Opcode], *, in_loop: bool, carried_at: int = 0, guarded: frozenset[int] = frozenset()
) -> DFG:
    """A sum by these operations; what the last iteration left is added at one of them. Products
    that are guarded count where a word is positive.
    """
    builder = GraphBuilder("sum")
    words = loads(builder, len(ops) + 2, in_loop=in_loop)
    carried = builder.open_phi() if in_loop else words[-1]
    total = words[-1] if carried_at else carried
    for place, op in enumerate(ops):
        if place and place == carried_at:
            total = builder.add(Opcode.FADD, [carried, total])
        one, two = words[place], words[place + 1]
        guard = builder.add(Opcode.FCMP_OLT, [builder.const(0), one]) if place in guarded else None
        total = step(builder, op, total, one, two, guard)
    if in_loop:
        builder.close_phi(carried, builder.const(0), total)
    builder.add_node(Node(0, Opcode.LIVE_OUT, name="%1"), [builder.operation(total)])
    return builder.build()


def demand_same(dfg: DFG, made: DFG) -> None:
    assert check(made) == []
    assert run(made, SMALL, 2, 0) == run(dfg, SMALL, 2, 0)
    assert balance_reductions(made, reassociate=True) is made


@pytest.mark.parametrize("op", [Opcode.FMA, Opcode.FNMA, Opcode.FSUB])
@pytest.mark.parametrize("count", [2, 3, 8])
def test_a_recurrence_is_one_sum_long(op: Opcode, count: int) -> None:
    dfg = sums([op] * count, in_loop=True)
    assert balance_reductions(dfg) is dfg
    made = balance_reductions(dfg, reassociate=True)
    demand_same(dfg, made)
    assert rec_mii(dfg) == count * rec_mii(sums([op], in_loop=True))
    assert rec_mii(made) == rec_mii(sums([Opcode.FSUB], in_loop=True))
    chains = max(1, count // 4)
    extra = chains if op is not Opcode.FSUB else 0  # a product begins each
    assert len(made.operations) == len(dfg.operations) + extra


def test_one_product_each_time_is_left_alone() -> None:
    dfg = sums([Opcode.FMA], in_loop=True)
    assert balance_reductions(dfg, reassociate=True) is dfg


def test_chains_stand_side_by_side_outside_loops() -> None:
    dfg = sums([Opcode.FMA] * 8, in_loop=False)
    made = balance_reductions(dfg, reassociate=True)
    demand_same(dfg, made)
    assert height(made) <= 6 < height(dfg)


def filtered(order: tuple[int, ...]) -> DFG:
    """`y[i] = x[i] + y[i - 1] * b - y[i - 2] * c` with its terms in this order."""
    builder = GraphBuilder("filter")
    x, b, c = loads(builder, 3, in_loop=True)
    last, before = builder.open_phi(), builder.open_phi()
    terms = ((Opcode.FADD, x, x), (Opcode.FMA, last, b), (Opcode.FNMA, before, c))
    total = builder.add(Opcode.FADD, [x, x])
    for place in order:
        total = step(builder, *(terms[place][0], total, *terms[place][1:]))
    builder.close_phi(last, builder.const(0), total)
    builder.close_phi(before, builder.const(0), last)
    builder.add_node(Node(0, Opcode.LIVE_OUT, name="%1"), [builder.operation(total)])
    return builder.build()


@pytest.mark.parametrize("order", [*itertools.permutations(range(3))])
def test_the_latest_word_of_a_filter_is_added_last(order: tuple[int, ...]) -> None:
    dfg = filtered(order)
    made = balance_reductions(dfg, reassociate=True)
    demand_same(dfg, made)
    assert rec_mii(made) == rec_mii(filtered((0, 2, 1)))
    assert (made is dfg) == (rec_mii(dfg) == rec_mii(made))


def height(dfg: DFG) -> int:
    """Operations on the longest way."""
    levels: dict[int, int] = {}

    def level(node: int) -> int:
        if node not in levels:
            own = 1 if dfg.by_id[node].uses_fu else 0
            levels[node] = own + max((level(e.src) for e in dfg.in_edges[node]), default=0)
        return levels[node]

    return max(map(level, dfg.by_id))


@pytest.mark.parametrize("op", [Opcode.FMA, Opcode.FADD])
def test_long_chains_of_an_iteration_stand_side_by_side(op: Opcode) -> None:
    """What an iteration takes counts where a loop is entered and left."""
    dfg = iteration_sum(op, 12)
    assert balance_reductions(dfg) is dfg
    made = balance_reductions(dfg, reassociate=True)
    demand_same(dfg, made)
    assert height(dfg) == 13
    assert height(made) == 7 - (op is Opcode.FADD)  # a load, four terms, two sums
    assert len(made.operations) == len(dfg.operations) + (2 if op is Opcode.FMA else 0)


def iteration_sum(op: Opcode, count: int) -> DFG:
    """`y[i] + a[i] * b[i] + ...`, which no iteration leaves to the next."""
    builder = GraphBuilder("sum")
    *words, total = loads(builder, count + 2, in_loop=True)
    for one, two in itertools.pairwise(words):
        total = step(builder, op, total, one, two)
    builder.add_node(Node(0, Opcode.LIVE_OUT, name="%1"), [builder.operation(total)])
    return builder.build()


@pytest.mark.parametrize("count", [2, 8, 16])
def test_products_that_do_not_always_count(count: int) -> None:
    """Where a loop masks rows, the recurrence is one sum long all the same."""
    dfg = sums([Opcode.FMA] * count, in_loop=True, guarded=frozenset(range(0, count, 2)))
    made = rebalance_sums_of_loops(dfg)
    demand_same(dfg, made)
    assert rec_mii(made) == rec_mii(sums([Opcode.FSUB], in_loop=True))
    straight = sums([Opcode.FMA] * count, in_loop=False, guarded=frozenset({1}))
    assert rebalance_sums_of_loops(straight) is straight


def test_a_sum_that_decides_what_is_added_to_it_stays() -> None:
    builder = GraphBuilder("sum")
    words = loads(builder, 4, in_loop=True)
    carried = builder.open_phi()
    guard = builder.add(Opcode.FCMP_OLT, [carried, words[0]])
    total = carried
    for one, two in itertools.pairwise(words):
        total = step(builder, Opcode.FMA, total, one, two, guard)
    builder.close_phi(carried, builder.const(0), total)
    builder.add_node(Node(0, Opcode.LIVE_OUT, name="%1"), [builder.operation(total)])
    dfg = builder.build()
    assert rebalance_sums_of_loops(dfg) is dfg


@pytest.mark.parametrize("seed", range(90))
def test_random_sums(seed: int) -> None:
    chance = random.Random(seed)
    choices = [*FUSED, Opcode.FADD, Opcode.FSUB]
    ops = chance.choices(choices, [4, 2, 1, 1], k=chance.randint(1, 14))
    in_loop = chance.random() < 0.6
    share = chance.choice((0, 0, 0.4, 1))
    guarded = frozenset(at for at, op in enumerate(ops) if op in FUSED and chance.random() < share)
    dfg = sums(ops, in_loop=in_loop, carried_at=chance.randrange(len(ops)), guarded=guarded)
    made = balance_reductions(dfg, reassociate=True)
    demand_same(dfg, made)
    assert rec_mii(made) <= rec_mii(dfg)
    assert in_loop or height(made) <= height(dfg)


def test_a_dot_product_is_summed_in_parts_if_that_is_allowed() -> None:
    values = np.random.default_rng(0)
    x, y = (values.integers(-9, 9, 256).astype(np.float32) for _ in range(2))
    strict = vividc.simulate(vividc.compile(dot), x, y, 256)
    free = vividc.simulate(vividc.compile(dot, reassociate=True), x, y, 256)
    assert strict.value == free.value == dot(x, y, 256)
    assert 5 * free.cycles < strict.cycles
