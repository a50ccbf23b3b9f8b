"""What was estimated is not made again, and is what would be made."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

import vividc
from vividc import arch
from vividc.compiler.planning.estimate import Estimator, Room
from vividc.compiler.planning.nests.parts import Apart
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.ir import DFG
from vividc.dfg.pipeline import PassOptions, optimize_kernel
from vividc.dfg.regions import Kernel
from vividc.ssa.flow import find_loops, preheader_of
from vividc.ssa.rewrite.normalize import normalize
from vividc.ssa.rewrite.tidy import tidy


@vividc.kernel("void(int32[::1], int32)")
def twice(x, n):
    for i in range(n):
        x[i] = x[i] * np.int32(3) + np.int32(1)
    for i in range(n):
        x[i] = x[i] * np.int32(3) + np.int32(1)


def loops(kernel: Kernel) -> list[DFG]:
    return [region.dfg for region in kernel.regions if region.kind == "loop"]


def test_equal_loops_share_an_estimate_and_keep_their_source_lines() -> None:
    options = PassOptions(contract=False)
    estimator = Estimator(arch.load("vivid-tile"), options)
    function = estimator.prepared(twice.lower(), {})
    estimator.estimate(twice.lower(), {})
    assert estimator.prepared(twice.lower(), {}) is function
    built = estimator.built(function)
    assert estimator.built(function) is built
    made = estimator.optimized_kernel(built)
    anew = optimize_kernel(build_kernel(function), options)
    assert made == anew
    first, second = loops(made)
    assert [node.loc for node in first.nodes] != [node.loc for node in second.nodes]
    for one, other in zip(loops(made), loops(anew), strict=True):
        assert [node.loc for node in one.nodes] == [node.loc for node in other.nodes]


@vividc.kernel("void(float32[::1], float32[::1], float32, float32)")
def scaled(x, y, a, b):
    c = a * b
    for i in range(len(x)):
        y[i] = x[i] * c + x[i] * c


def test_graphs_that_differ_in_variables_and_addresses_are_optimised_alike() -> None:
    estimator = Estimator(arch.load("vivid-tile"), PassOptions(contract=False))
    [loop] = loops(build_kernel(scaled.lower()))
    names = {n.name: f"%{7 + k}" for k, n in enumerate(loop.nodes) if n.name[:1] == "%"}
    assert names
    nodes = (replace(node, name=names.get(node.name, node.name)) for node in loop.nodes)
    form = ((("&x",), 1), (("far",), 4))
    other = replace(
        loop, nodes=tuple(replace(n, address=form) if n.is_memory else n for n in nodes)
    )
    mine, theirs = estimator.optimized(loop), estimator.optimized(other)
    anew = Estimator(estimator.fabric, estimator.options).optimized(other)
    assert theirs == anew != mine
    assert {node.address for node in theirs.nodes if node.is_memory} == {form}
    assert len(mine.nodes) < len(loop.nodes)


def test_a_nest_apart_from_others_takes_what_it_takes_beside_them() -> None:
    estimator = Estimator(arch.load("vivid-tile"), PassOptions(contract=False))
    function = tidy(twice.lower())
    first, second = find_loops(function)
    apart = Apart.of(estimator, function, {}, {first.header})
    assert apart.headers == {second.header}
    [alone] = apart.estimate(function, {})
    both = estimator.estimate(function, {})
    assert {cost.header for cost in alone.regions} >= {first.header, second.header}
    assert alone.largest_loop(16) == both.largest_loop(16)
    assert abs(alone.cycles - both.cycles) < 0.05 * both.cycles
    short, long = apart.estimate(function, {first.header: 10.0}, {first.header: 1000.0})
    assert long.cycles > short.cycles + 500


@vividc.kernel("void(int32[::1], int32[::1], int32)")
def either(x, y, n):
    if n > 0:
        for i in range(len(x)):
            x[i] = 3 * y[i] + n
    else:
        for i in range(len(x)):
            x[i] = 5 * y[i] - n


def test_rare_nests_beside_one_take_no_room() -> None:
    estimator = Estimator(arch.load("vivid-tile"), PassOptions(contract=False))
    function = tidy(either.lower())
    first, second = find_loops(function)
    hints = {preheader_of(function, second): 0.005}
    whole = estimator.estimate(function, hints)
    assert [cost.is_rare for cost in whole.regions if cost.header == second.header] == [True]
    apart = Apart.of(estimator, function, hints, {first.header})
    room = Room(whole.largest_loop(16), whole.contexts)
    [alone] = apart.estimate(function, hints, room=room)
    assert alone.cycles < math.inf
    [beyond] = apart.estimate(function, hints, room=replace(room, contexts=whole.contexts - 1))
    assert beyond.cycles == math.inf


@vividc.kernel("void(int32[::1], int32[::1])")
def crowded(x, y):
    for i in range(len(x)):
        v = x[i]
        y[i] = ((((((v + 9) * v + 1) * v + 2) * v + 3) * v + 4) * v + 5) * v + 6


def test_what_is_beyond_the_room_is_estimated_as_far_as_shows_it() -> None:
    options = PassOptions(contract=False)
    function = normalize(crowded.lower())
    whole = Estimator(arch.load("vivid-tile"), options).estimate(function, {})
    largest = whole.largest_loop(16)
    assert largest > 10
    for room, is_beyond in (
        (Room(largest, whole.contexts), False),
        (Room(largest - 1, whole.contexts), True),
        (Room(largest, whole.contexts - 1), True),
    ):
        estimator = Estimator(arch.load("vivid-tile"), options)
        found = estimator.estimate(function, {}, room)
        assert found == (
            replace(whole, cycles=math.inf, regions=found.regions) if is_beyond else whole
        )
        assert set(found.regions) <= set(whole.regions)
        assert estimator.estimate(function, {}) == whole
