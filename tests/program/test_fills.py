"""Loops that begin while the straight region before them ends."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import vividc
from benchmarks.polybench.suite import CASES
from tests.program.test_drains import engines_agree, refused, with_row
from tests.sim.native.agreement import agreed_run, launch, outcome, same
from vividc.compiler.regions import one_straight
from vividc.dfg.regions import loop_behind
from vividc.errors import BundleError, InternalError
from vividc.host.once import once_each
from vividc.machine.opcodes import Opcode
from vividc.mapper.problem import Fill
from vividc.mapper.resources.fill import fill_of
from vividc.program import Program, RegionRow, from_bytes
from vividc.program.overlaps.parts import parts
from vividc.sim import NativeEngine, ReferenceEngine
from vividc.sim.view.recording import record


@vividc.kernel("void(int32[::1], int32[:, ::1], int32[::1], int32[::1])")
def tails(ends, a, x, out):
    """Sums of rows that end where they say, from a word on that takes long to compute."""
    for i in range(ends.shape[0]):
        total = x[i] * x[i] // 3 + 7
        for j in range(ends[i]):
            total = total * 5 + a[i, j]
        out[i] = total % 1000 + i


def expected(ends: np.ndarray, a: np.ndarray, x: np.ndarray) -> np.ndarray:
    out = np.zeros(len(ends), np.int32)
    tails(ends, a, x, out)
    return out


@once_each
def of(_: type) -> Program:
    """Compiled once."""
    return vividc.compile(tails, fabric="vivid-tile", loops=vividc.LoopOptions(auto=False))


@pytest.fixture
def program() -> Program:
    return of(Program)


def before(program: Program) -> tuple[int, RegionRow, int, RegionRow]:
    """A straight region in whose last cycles a loop begins, and the loop."""
    index = max(index for index, row in enumerate(program.table) if row.fill)
    loop = loop_behind(program.table, index)
    assert loop is not None
    return index, program.table[index], loop, program.table[loop]


def arguments(lengths: tuple[int, ...]) -> tuple[np.ndarray, ...]:
    ends = np.array(lengths, np.int32)
    a = np.arange(-5, len(ends) * 40 - 5, dtype=np.int32).reshape(len(ends), 40)
    return ends, a, 3 - 2 * ends, np.zeros_like(ends)


@pytest.mark.parametrize("lengths", [(0,), (1,), (2, 0, 1), (3, 9, 0, 0, 2), (1, 40, 1), (-3, 4)])
def test_loops_of_any_length_begin_early(program: Program, lengths: tuple[int, ...]) -> None:
    """Fewer iterations than begin while the region ends, and none."""
    ends, a, x, out = arguments(lengths)
    vividc.simulate(program, ends, a, x, out)
    np.testing.assert_array_equal(out, expected(ends, a, x))
    agreed_run(program, launch(program, ends, a, x, np.zeros_like(ends)))


def test_a_fill_saves_its_cycles_and_the_switch(program: Program) -> None:
    """Where the loop has enough iterations; else it begins as if there were none."""
    _, _, loop, behind = before(program)
    fill = program.table[0].fill
    assert loop_behind(program.table, 0) == loop
    least = behind.least_trips(fill)
    without = replace(program, table=tuple(replace(one, fill=0) for one in program.table))
    assert parts(without).faults, "its words hold what the loop begins with"
    for trips in range(1, least + 3):
        ends, a, x, out = arguments((trips,))
        run = agreed_run(program, launch(program, ends, a, x, out))
        of_loop = run.regions[loop]
        alone = behind.span + (trips - 1) * behind.ii + of_loop.bank_stalls
        assert of_loop.cycles == alone - (fill if trips >= least else 0)
    assert run.cycles == run.switch_cycles + sum(region.cycles for region in run.regions)


def test_observers_see_no_cycle_twice(program: Program) -> None:
    _, told = engines_agree(program, launch(program, *arguments((3, 0, 9, 40))))
    assert all(a.end <= b.start for a, b in pairwise(told))
    assert any(a.end == b.start for a, b in pairwise(told))


def test_limits_and_observers(program: Program) -> None:
    for limit in (*range(0, 130, 3), 1000):
        engines_agree(program, launch(program, *arguments((3, 3, 9)), cycle_limit=limit))


@vividc.kernel("void(int32, int32[::1], int32[::1], int32[::1], int32[::1])")
def beside(n, x, y, z, w):
    """An array is written last that the loop does not touch, which loads at once."""
    for i in range(z.shape[0]):
        s = i
        for j in range(n):
            s = s * 3 + y[x[j]]
        z[i] = ((((s * 3 + i) * 5 + n) * 7 + s) * 11 + i) * 13
        w[((i * n + i) * n + n) & 3] = n


def test_of_two_faults_the_regions_comes_first() -> None:
    """Though the loop may access an array out of bounds before the region does."""
    program = vividc.compile(beside, fabric="vivid-tile", loops=vividc.LoopOptions(auto=False))
    assert any(row.fill for row in program.table)
    x = np.zeros(6, np.int32)
    for wrong in (None, 0, 5):
        values = x.copy()
        if wrong is not None:
            values[wrong] = 99
        for rooms in ((3, 4), (3, 0), (0, 4)):
            z, w = (np.zeros(room, np.int32) for room in rooms)
            for limit in (*range(10, 70, 3), 1000):
                given = launch(program, 6, values, np.ones(9, np.int32), z, w, cycle_limit=limit)
                same(
                    outcome(ReferenceEngine(program), given), outcome(NativeEngine(program), given)
                )


def test_words_are_parted(program: Program) -> None:
    index, row, loop, behind = before(program)
    made = parts(program)
    assert not made.faults
    ahead = made.aheads[index]
    assert len(ahead) == row.fill
    issued = [e.issue for entries in ahead for e in entries if e.issue is not None]
    begun = -(-row.fill // behind.ii)
    assert issued
    assert {one.stage for one in issued} <= set(range(row.stages - begun, row.stages))
    assert issued[0].stage == row.stages - 1
    own = made.own[index]
    assert all(e.issue.stage == 0 for entries in own for e in entries if e.issue is not None)
    assert not any(e.issue.op is Opcode.STORE for e in made.own[loop][0] if e.issue is not None)


def test_files_keep_fills(program: Program) -> None:
    assert from_bytes(program.to_bytes()) == program


def test_rows_whose_loop_cannot_begin_early(program: Program) -> None:
    index, row, loop, behind = before(program)
    at = f"no loop can begin in the last {{}} cycles of region {index}"
    for fill in (-1, row.ii + 1):
        refused(with_row(program, index, replace(row, fill=fill)), at.format(fill))
    for other in ({"has_exit": True}, {"counted": False}):
        broken = with_row(program, loop, replace(behind, drain=0, **other))  # type: ignore[arg-type]
        refused(broken, "no loop can begin in the last")
    refused(with_row(program, loop, replace(behind, fill=1, drain=0)), "it is no straight region")


def test_rows_that_do_not_fit_their_words(program: Program) -> None:
    index, row, *_ = before(program)
    for fill in (row.fill - 1, row.fill + 1):
        if fill:
            refused(with_row(program, index, replace(row, fill=fill)), "region")
    for stages in (row.stages + 1, row.stages - 1, 1, 1000):
        refused(with_row(program, index, replace(row, stages=stages)), "region")


def test_files_that_claim_long_overlaps(program: Program) -> None:
    index, row, loop, behind = before(program)
    broken = with_row(program, index, replace(row, fill=10**12))
    for table in (broken, with_row(broken, loop, replace(behind, drain=-(10**12)))):
        with pytest.raises(BundleError, match="overlaps others for longer"):
            from_bytes(table.to_bytes())


def test_files_say_what_reads_them(program: Program) -> None:
    assert b"vividc.program/7" in program.to_bytes()


@pytest.mark.parametrize("trips", [1, 2, 3, 4, 5])
def test_limits_in_every_cycle(program: Program, trips: int) -> None:
    for limit in range(30, 80):
        engines_agree(program, launch(program, *arguments((trips, trips)), cycle_limit=limit))


def test_recordings_show_the_loop_in_its_own_time(program: Program) -> None:
    args = arguments((9, 9))
    seen = record(program, args, {}, window=(0, 200))
    assert (np.diff(seen.cycles) >= 1).all()
    _, told = engines_agree(program, launch(program, *args))
    assert list(seen.spans) == told
    assert not seen.stalled().any()


@pytest.mark.parametrize(
    ("kernel", "unseen", "text"),
    [
        (CASES["trmm"].kernel, "completed", "complete on PE"),
        (CASES["gramschmidt"].kernel, "words", "two sources for"),
        (tails, "entries_read", "is read too early"),
        (CASES["trmm"].kernel, "accesses", "both access memory in a cycle"),
    ],
    ids=["results", "words", "entries", "accesses"],
)
def test_what_is_not_seen_is_noticed(
    monkeypatch: pytest.MonkeyPatch, kernel: vividc.KernelFunction, unseen: str, text: str
) -> None:
    def blind(*args: Any) -> Fill:
        made = fill_of(*args)
        return replace(made, **{unseen: type(getattr(made, unseen))()})

    monkeypatch.setattr(one_straight, "fill_of", blind)
    plain = vividc.LoopOptions(auto=False)
    with pytest.raises(InternalError, match=text):
        vividc.compile(kernel, loops=plain, effort="thorough", cache=False)
