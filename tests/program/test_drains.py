"""Straight regions that begin while the loop before them ends."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import vividc
from tests.sim.native.agreement import agreed_run, launch, outcome, same
from vividc.compiler.regions import one_straight
from vividc.errors import BundleError, InternalError
from vividc.host.once import once_each
from vividc.machine.opcodes import Opcode
from vividc.mapper.problem import Drain
from vividc.mapper.resources.drain import drain_of
from vividc.program import Program, RegionRow, from_bytes
from vividc.program.overlaps.parts import parts
from vividc.program.words.entry import Entry
from vividc.sim import NativeEngine, ReferenceEngine
from vividc.sim.engine import Launch, RegionSpan, Run


@vividc.kernel("int32(int32[::1], int32[::1], int32[::1])")
def rows(ends, a, out):
    """Weighted sums of pieces that end where they say: of any length, none among them."""
    begin = 0
    total = 0
    for i in range(ends.shape[0]):
        total = total * 3
        for j in range(begin, ends[i]):
            total += (a[j] * a[j] + 7) * (j - begin)
        out[i] = total + i
        begin = ends[i]
    return total


@vividc.kernel("void(int32, int32[::1], int32[::1], int32[::1], int32[::1])")
def beside(n, x, y, z, w):
    """An array is written that the loop does not touch while it still loads what it loads last."""
    for i in range(z.shape[0]):
        s = 0
        for j in range(n):
            s = s * 3 + y[x[j] * x[j] + j]
        w[i] = n
        z[i] = ((s * 3 + i) * 5 + n) * 7


def expected(ends: np.ndarray, a: np.ndarray) -> np.ndarray:
    out = np.zeros(len(ends), np.int32)
    rows(ends, a, out)
    return out


@once_each
def of(_: type) -> Program:
    """Compiled once."""
    return vividc.compile(rows, fabric="vivid-tile", loops=vividc.LoopOptions(auto=False))


@pytest.fixture
def program() -> Program:
    return of(Program)


def drained(program: Program) -> tuple[int, RegionRow]:
    found = [(index, row) for index, row in enumerate(program.table) if row.drain]
    assert len(found) == 1
    return found[0]


def with_row(program: Program, index: int, row: RegionRow) -> Program:
    return replace(program, table=(*program.table[:index], row, *program.table[index + 1 :]))


@pytest.mark.parametrize("lengths", [(0,), (1,), (2, 0, 1), (3, 9, 0, 0, 2), (1, 40, 1)])
def test_loops_of_any_length_end_early(program: Program, lengths: tuple[int, ...]) -> None:
    """Fewer iterations than there are stages, and none."""
    ends = np.cumsum(lengths).astype(np.int32)
    a = np.arange(-3, max(1, ends[-1]) - 3, dtype=np.int32)
    out = np.zeros(len(ends), np.int32)
    assert vividc.simulate(program, ends, a, out).value == rows(ends, a, out.copy())
    np.testing.assert_array_equal(out, expected(ends, a))
    agreed_run(program, launch(program, ends, a, out))


def test_a_drain_saves_its_cycles_and_the_switch(program: Program) -> None:
    loop, row = drained(program)
    assert row.next is not None
    behind, switch = program.table[row.next], program.fabric.controller.switch_cycles
    ends = np.array([6, 6, 15], np.int32)
    run = agreed_run(program, launch(program, ends, np.arange(15, dtype=np.int32), ends.copy()))
    of_loop, of_behind = run.regions[loop], run.regions[row.next]
    assert (of_loop.entries, of_loop.iterations) == (3, 15)
    assert of_loop.cycles == of_loop.bank_stalls + 13 * row.ii + 2 * row.span
    assert of_behind.cycles == 3 * behind.ii - 2 * row.drain
    entries = sum(region.entries for region in run.regions)
    assert run.switch_cycles == switch * (entries - 1 - 2)
    assert run.cycles == run.switch_cycles + sum(region.cycles for region in run.regions)


def test_observers_see_no_cycle_twice(program: Program) -> None:
    ends = np.array([3, 3, 9], np.int32)
    given = launch(program, ends, np.arange(9, dtype=np.int32), ends.copy())
    _, told = engines_agree(program, given)
    assert all(a.end <= b.start for a, b in pairwise(told))


def test_faults_while_the_region_behind_is_under_way(program: Program) -> None:
    """An access outside its array, in a late stage or in the region behind."""
    for last in (4, 5, 12):
        ends = np.array([3, last], np.int32)
        given = launch(program, ends, np.arange(4, dtype=np.int32), ends.copy())
        same(outcome(ReferenceEngine(program), given), outcome(NativeEngine(program), given))


def engines_agree(program: Program, given: Launch) -> tuple[Run | str, list[RegionSpan]]:
    """The run or the error, and what an observer was told, of both engines alike."""
    found = []
    for engine in (ReferenceEngine(program), NativeEngine(program)):
        spans: list[RegionSpan] = []
        found.append((outcome(engine, replace(given, observer=spans.append)), spans))
    (one, told), (other, as_well) = found
    same(one, other)
    assert told == as_well
    return one[0], told


def accesses(contexts: list[list[Entry]], op: Opcode) -> list[int]:
    """Contexts that have such an access."""
    return [
        slot
        for slot, entries in enumerate(contexts)
        if any(entry.issue is not None and entry.issue.op is op for entry in entries)
    ]


def test_of_two_faults_the_loops_comes_first() -> None:
    """Though the region behind accesses an array out of bounds before the loop does."""
    program = vividc.compile(beside, fabric="vivid-tile", loops=vividc.LoopOptions(auto=False))
    loop, row = drained(program)
    made = parts(program)
    assert row.next is not None
    early = accesses(made.own[row.next], Opcode.STORE)
    assert early[0] < accesses(made.rests[loop], Opcode.LOAD)[-1]
    x = np.zeros(6, np.int32)
    late = x.copy()
    late[5] = 9  # the last iteration's load is outside
    for values, room, array in ((x, 0, "w"), (late, 0, "y"), (late, 3, "y")):
        args = (6, values, np.ones(9, np.int32), np.zeros(3, np.int32), np.zeros(room, np.int32))
        for limit in (*range(12, 60), 1000):
            error, told = engines_agree(program, launch(program, *args, cycle_limit=limit))
            assert isinstance(error, str)
        assert f"the array {array}" in error
        assert (loop in {span.region for span in told}) is (array == "w")


def test_limits_and_observers_of_runs_that_end_well(program: Program) -> None:
    ends = np.array([3, 3, 9], np.int32)
    for limit in (*range(0, 130, 3), 1000):
        given = launch(program, ends, np.arange(9, dtype=np.int32), ends.copy(), cycle_limit=limit)
        engines_agree(program, given)


def test_words_are_parted(program: Program) -> None:
    loop, row = drained(program)
    made = parts(program)
    assert not made.faults
    rest = made.rests[loop]
    assert len(rest) == row.drain
    assert any(entry.issue is not None for entries in rest for entry in entries)
    stages = [e.issue.stage for entries in rest for e in entries if e.issue is not None]
    assert min(stages) >= 1
    assert row.next is not None
    own = made.own[row.next]
    assert all(e.issue.stage == 0 for entries in own for e in entries if e.issue is not None)


def test_files_keep_drains(program: Program) -> None:
    assert from_bytes(program.to_bytes()) == program


@pytest.mark.parametrize("change", ["longer", "negative", "exit", "uncounted", "ends", "short"])
def test_rows_that_cannot_end_early(program: Program, change: str) -> None:
    loop, row = drained(program)
    rows_ = {
        "longer": replace(row, drain=row.span),
        "negative": replace(row, drain=-1),
        "exit": replace(row, has_exit=True),
        "uncounted": replace(row, counted=False),
        "ends": replace(row, next=None),
        "short": replace(row, drain=row.drain - 1 or row.drain + 1),
    }
    broken = with_row(program, loop, rows_[change])
    refused(broken, f"region {loop} cannot end")


def test_a_straight_region_has_no_drain(program: Program) -> None:
    index = next(i for i, row in enumerate(program.table) if row.kind == "straight")
    refused(with_row(program, index, replace(program.table[index], drain=1)), "it is no loop")


def test_two_loops_cannot_end_in_one_region(program: Program) -> None:
    _, row = drained(program)
    refused(replace(program, table=(*program.table, row)), "another loop ends there")


@vividc.kernel("void(float32[:, ::1], float32[:, ::1], float32[:, ::1])")
def gemm(a, b, c):
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            total = np.float32(0.0)
            for k in range(a.shape[1]):
                total += a[i, k] * b[k, j]
            c[i, j] = total


@vividc.kernel("void(int32[:, ::1], int32[::1], int32[::1])")
def recurrence(a, x, y):
    for i in range(a.shape[0]):
        s = y[i]
        for j in range(a.shape[1]):
            s = s * x[j] + a[i, j]
            y[j] += s
        x[i] = s * s + y[i + 1] * x[i + 2] + i * s


@pytest.mark.parametrize(
    ("kernel", "unseen", "text"),
    [
        (gemm, "issued", "two operations issue"),
        (gemm, "completed", "complete on PE"),
        (gemm, "shown", "two live-outs"),
        (gemm, "words", "two sources for|written by both"),
        (gemm, "entries_written", "is read too early"),
        (recurrence, "accesses", "memory is accessed before the one before|in a cycle"),
    ],
    ids=["issues", "results", "live-outs", "words", "entries", "accesses"],
)
def test_what_a_scheduler_does_not_see_is_noticed(
    monkeypatch: pytest.MonkeyPatch, kernel: vividc.KernelFunction, unseen: str, text: str
) -> None:
    def blind(*args: Any) -> Drain:
        return replace(drain_of(*args), **{unseen: frozenset()})

    monkeypatch.setattr(one_straight, "drain_of", blind)
    with pytest.raises(InternalError, match=text):
        vividc.compile(kernel, fabric="vivid-tile", cache=False)


def refused(program: Program, text: str) -> None:
    """By whoever reads it, and by both engines."""
    for engine in (ReferenceEngine, NativeEngine):
        with pytest.raises(BundleError, match=text):
            engine(program)
