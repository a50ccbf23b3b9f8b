"""Distances between accesses: no loop waits for a dependence that is not there, and every one that
memory shows is kept.
"""

from __future__ import annotations

from copy import deepcopy
from dataclasses import replace

import islpy as isl
import numpy as np
import pytest

from tests.fuzz.witnesses import run_regions
from tests.ssa.polyhedral import dependence_kernels as k
from vividc import arch
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.ir import EdgeKind
from vividc.dfg.pipeline import optimize_kernel
from vividc.dfg.regions import Kernel
from vividc.frontend import KernelFunction, kernel
from vividc.machine.opcodes import MEMORY
from vividc.mapper import MapProblem
from vividc.mapper.bounds.bounds import Bound, all_bounds
from vividc.mapper.bounds.refutations import ASSUMED
from vividc.ssa.flow import find_loops
from vividc.ssa.polyhedral.distances.linear import Distances, Place
from vividc.ssa.polyhedral.distances.meetings import Meetings
from vividc.ssa.rewrite.normalize import normalize

MACHINE = arch.load("vivid-tile")


def regions(kernel: KernelFunction) -> Kernel:
    return optimize_kernel(build_kernel(kernel.lower()))


def recurrences(kernel: KernelFunction) -> list[Bound]:
    (dfg,) = (region.dfg for region in regions(kernel).regions if region.kind == "loop")
    return [b for b in all_bounds(MapProblem(dfg, MACHINE)) if b.name == "RecMII" and b.ii > 1]


@pytest.mark.parametrize("kernel", k.INDEPENDENT, ids=lambda kernel: kernel.name)
def test_no_recurrence_through_memory(kernel: KernelFunction) -> None:
    assert not recurrences(kernel)


@pytest.mark.parametrize(
    ("kernel", "assumed", "ii"),
    [
        (k.carried, False, 7),
        (k.carried_backwards, False, 7),
        (k.one_place, False, 4),  # a sum in a register
        (k.from_the_end, True, 7),
    ],
    ids=lambda item: getattr(item, "name", ""),
)
def test_a_recurrence_through_memory_tells_whether_it_is_proved(
    kernel: KernelFunction, assumed: bool, ii: int
) -> None:
    (bound,) = recurrences(kernel)
    assert (bound.ii, ASSUMED in bound.reason) == (ii, assumed)


@pytest.mark.parametrize("kernel", k.INDEPENDENT + k.DEPENDENT, ids=lambda kernel: kernel.name)
@pytest.mark.parametrize(("rows", "columns", "n"), [(4, 4, 1), (3, 5, 2), (5, 3, 0), (1, 3, 0)])
def test_what_meets_is_kept_in_order(
    kernel: KernelFunction, rows: int, columns: int, n: int
) -> None:
    """`run_regions` traces memory."""
    random = np.random.default_rng(1)
    a = random.standard_normal((rows, max(rows, columns))).astype(np.float32)
    x = random.standard_normal(4 * n + 6).astype(np.float32)
    expected, actual = [a, x], deepcopy([a, x])
    kernel(*expected, np.int32(n))
    run_regions(regions(kernel), [*actual, np.int32(n)])
    for ours, theirs in zip(actual, expected, strict=True):
        assert np.array_equal(ours, theirs)


def test_the_trace_notices_a_missing_edge() -> None:
    kernel = regions(k.carried)
    without = [
        replace(
            r,
            dfg=replace(r.dfg, edges=tuple(e for e in r.dfg.edges if e.kind is not EdgeKind.ORDER)),
        )
        for r in kernel.regions
    ]
    a, x = np.zeros((1, 1), np.float32), np.ones(9, np.float32)
    with pytest.raises(AssertionError, match="met in memory"):
        run_regions(replace(kernel, regions=tuple(without)), [a, x, np.int32(0)])


def test_both_ends_of_an_array_meet() -> None:
    """x[2 * i - 1] is x[-1] and x[1]: the first and the second of two elements."""
    x = np.array([1, 2, 3, 4, 5], np.float32)
    expected = x.copy()
    a = np.zeros((1, 1), np.float32)
    k.from_the_end(a, expected, np.int32(-1))
    run_regions(regions(k.from_the_end), [a, x, np.int32(-1)])
    assert np.array_equal(x, expected)


@kernel(k.COLUMNS)
def two_behind(a, x, n):
    """What is stored is loaded two iterations later, and by no other."""
    for i in range(2, len(x)):
        x[i] = k.TWO
        a[0, i] = x[i - 2]


def test_what_meets_once_has_that_distance() -> None:
    function = normalize(two_behind.lower())
    (loop,) = find_loops(function)
    store, load = (
        Place(instr, block.name)
        for block in function.blocks
        for instr in block.instrs
        if instr.op in MEMORY and instr.array == "x"
    )
    meetings = Meetings(function, loop)
    assert meetings.between(store, load, now=True) == Distances(2, None)
    assert meetings.between(load, store, now=True) == Distances(None, 2)
    assert meetings.between(store, store, now=False) == Distances(None, None)


@pytest.mark.parametrize("operations", [1, 30, 300])
def test_what_isl_has_no_time_for_is_assumed(operations: int) -> None:
    function = normalize(k.by_three.lower())
    (loop,) = find_loops(function)
    load, store = (
        Place(instr, block.name)
        for block in function.blocks
        for instr in block.instrs
        if instr.op in MEMORY
    )
    found = Meetings(function, loop, operations).between(load, store, now=True)
    assert found in (Distances(0, 1, assumed=True), Distances(0, None, assumed=True))
    assert Meetings(function, loop).between(load, store, now=True).earlier is None


def test_a_pair_has_fewer_operations_the_more_isl_has_given_up_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    function = normalize(k.by_three.lower())
    (loop,) = find_loops(function)
    load, store = (
        Place(instr, block.name)
        for block in function.blocks
        for instr in block.instrs
        if instr.op in MEMORY
    )
    given: list[int] = []
    answers = iter([False, True, False, False, False, True, False])

    def ends(*_: object) -> Distances:
        given.append(isl.DEFAULT_CONTEXT.get_max_operations())
        if next(answers):
            return Distances(3)
        raise isl.Error("no operations are left")

    monkeypatch.setattr(Meetings, "found_by_isl", ends)
    meetings = Meetings(function, loop, 8000)
    for number in range(7):
        other = replace(store, instr=replace(store.instr, id=1000 + number))
        answered = meetings.between(load, other, now=True)
        assert answered == (Distances(3) if number in (1, 5) else Distances(0, 1, assumed=True))
    assert given == [8000, 4000, 4000, 2000, 1000, 1000, 1000]


def test_isl_gives_up_on_the_strides_of_parts_with_clipped_lengths() -> None:
    """It took the first accesses of NPBench's adi more than five minutes, whatever the limit."""
    mine = np.linspace(-1, 1, 81, dtype=np.float32).reshape(9, 9)
    numbas = mine.copy()
    run_regions(regions(k.sweeps), [np.int64(9), np.int64(2), mine])
    k.sweeps(np.int64(9), np.int64(2), numbas)
    np.testing.assert_allclose(mine, numbas, rtol=1e-5)
