"""Programs longer than the configuration memory."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import vividc
from tests.program.test_drains import engines_agree, refused, with_row
from tests.sim.native.agreement import agreed_run, launch
from vividc import arch
from vividc.arch.fabric import Fabric
from vividc.compiler.planning.options import LoopOptions
from vividc.errors import ArgumentError, BundleError, KernelError, VividcWarning
from vividc.host.once import once_each
from vividc.program import Program, from_bytes
from vividc.program.encoder.places import Turns
from vividc.sim import ReferenceEngine
from vividc.sim.engine import RegionSpan
from vividc.sim.view.recording import record

TILE = arch.load_tile("vivid-tile")
SMALL = (16, 12, 10)
HARDLY = 75


def tile_of(contexts: int) -> Fabric:
    """`vivid-tile` with so many contexts."""
    return arch.load_text(TILE.source.replace("contexts: 512", f"contexts: {contexts}"))


@vividc.kernel("int32(int32[::1], int32[::1], int32)")
def rounds(a, b, n):
    """Loops in a loop, which come by turns, and what runs of some of its iterations only."""
    total = 0
    for j in range(4):
        for i in range(n):
            a[i] += b[i] * j
        for i in range(n):
            if a[i] % 3 == 1:
                total += a[i]
            b[i] ^= a[i]
        if total > 100:
            total -= 50
    return total


@once_each
def of(_: type) -> dict[int, Program]:
    """Compiled once, for memories of some sizes."""
    fits = vividc.compile(rounds, tile_of(512), cache=False)
    return {512: fits, **{n: warned(n) for n in SMALL}}


def warned(contexts: int) -> Program:
    text = f"rounds takes [0-9]+ contexts, and fabric vivid-tile has {contexts}: others are brought"
    with pytest.warns(VividcWarning, match=text):
        program = vividc.compile(rounds, tile_of(contexts), cache=False)
    assert len(program.warnings) == 1
    return program


def arguments(n: int) -> tuple[np.ndarray, np.ndarray, int]:
    return np.arange(n, dtype=np.int32), np.arange(n, 0, -1, dtype=np.int32), n


@pytest.mark.parametrize("contexts", [512, *SMALL])
@pytest.mark.parametrize("n", [0, 1, 20])
def test_a_program_of_any_length_runs(contexts: int, n: int) -> None:
    program = of(Program)[contexts]
    a, b, _ = arguments(n)
    value = rounds(a, b, n)
    mine = arguments(n)
    assert vividc.simulate(program, *mine).value == value
    np.testing.assert_array_equal((a, b), mine[:2])
    assert (len(program.words) > contexts) is (contexts < 512)


def brought(program: Program, spans: list[RegionSpan]) -> int:
    """Cycles of reloads, by what each place of the memory holds after one region and the next."""
    memory = dict(enumerate(range(program.fabric.controller.contexts)))
    cycles = 0
    for span in spans:
        row = program.table[span.region]
        own = {n % len(memory): n for n in range(row.context, row.context + row.ii)}
        if any(memory[place] != context for place, context in own.items()):
            cycles += 16 * row.ii
            memory |= own
    return cycles


@pytest.mark.parametrize("contexts", [512, *SMALL])
def test_what_is_not_there_is_brought_an_entry_a_cycle(contexts: int) -> None:
    program = of(Program)[contexts]
    given = launch(program, *arguments(20))
    run = agreed_run(program, given)
    spans: list[RegionSpan] = []
    ReferenceEngine(program).run(replace(given, observer=spans.append))
    assert run.reload_cycles == brought(program, spans)
    assert (run.reload_cycles > 0) is (contexts < 512)
    assert run.switch_cycles == len(spans) - 1 + run.reload_cycles - overlapping(spans)
    assert run.cycles == run.switch_cycles + sum(region.cycles for region in run.regions)
    stats = vividc.simulate(program, *arguments(20)).stats
    assert stats["reload_cycles"] == run.reload_cycles
    assert stats["cycles_by_use"]["switch"] == run.switch_cycles


def overlapping(spans: list[RegionSpan]) -> int:
    """Regions that begin at once."""
    return sum(a.end == b.start for a, b in pairwise(spans))


def test_limits_and_observers() -> None:
    program = of(Program)[12]
    for limit in (*range(0, 900, 7), 10_000):
        engines_agree(program, launch(program, *arguments(20), cycle_limit=limit))


def test_a_recording_tells_reloads_from_stalls() -> None:
    """In a window that ends at any time, one in which contexts are brought among them."""
    program = of(Program)[12]
    whole = record(program, arguments(20), {}, window=(0, 10_000))
    stalls = sum(span.bank_stalls for span in whole.spans)
    assert whole.stalled().sum() == stalls
    assert (
        whole.end - len(whole.cycles) - stalls
        == agreed_run(program, launch(program, *arguments(20))).switch_cycles
    )
    for end in range(1, whole.end, 17):
        part = record(program, arguments(20), {}, window=(0, end))
        np.testing.assert_array_equal(part.stalled(), whole.stalled()[:end])


def test_the_file_says_that_it_is_long() -> None:
    for contexts, program in of(Program).items():
        data = program.to_bytes()
        assert (b"vividc.program/8" in data) is (contexts < 512)
        assert from_bytes(data) == program


def test_a_long_program_has_no_overlaps() -> None:
    program = of(Program)[12]
    loop = next(n for n, row in enumerate(program.table) if row.counts_alone and row.next)
    row = program.table[loop]
    early = with_row(program, loop, replace(row, drain=1))
    refused(early, "may have to be brought first")


@vividc.kernel("void(int32[:, ::1], int32[:, ::1])")
def differences(a, b):
    """A version for arrays of one shape, and one for others."""
    a[1:, :] -= b[1:, :] - b[:-1, :]
    a[:-1, :] += b[1:, :] * 3


@once_each
def of_versions(_: type) -> tuple[Program, Program]:
    """Compiled for memories that hold all of it, and hardly more than the first version."""
    loops = LoopOptions(restructure=False)
    whole, hardly = (
        vividc.compile(differences, tile_of(contexts), effort="fast", loops=loops, cache=False)
        for contexts in (512, HARDLY)
    )
    return whole, hardly


def matrices(columns: int) -> list[np.ndarray]:
    """The second one has so many columns, where the first one has six."""
    return [np.arange(5 * n, dtype=np.int32).reshape(5, n) * 7 - 30 for n in (6, columns)]


def test_what_is_hardly_ever_run_is_not_held_and_costs_nothing() -> None:
    whole, program = of_versions(Program)
    assert len(program.words) > HARDLY
    assert not program.warnings
    run = agreed_run(program, launch(program, *matrices(6)))
    assert run.reload_cycles == 0
    assert run.cycles <= 1.1 * agreed_run(whole, launch(whole, *matrices(6))).cycles
    assert any(row.drain or row.fill for row in program.table)


@pytest.mark.parametrize("columns", [1, 6])
def test_what_is_hardly_ever_run_is_brought(columns: int) -> None:
    _, program = of_versions(Program)
    given, wanted = matrices(columns), matrices(columns)
    differences(*wanted)
    run = agreed_run(program, launch(program, *matrices(columns)))
    assert (run.reload_cycles > 0) is (columns == 1)
    vividc.simulate(program, *given)
    for mine, numba in zip(given, wanted, strict=True):
        np.testing.assert_array_equal(mine, numba)


def test_what_hardly_ever_runs_shares_its_places_with_what_runs_once() -> None:
    """Six contexts of 28 are too many: two regions are at the end, one other at the beginning."""
    turns = Turns([1, 9, 0.005, 0.005, 1], [1, 1, 0.005, 0.005, 1], [()] * 5, frozenset({2, 3}))
    made = turns.layout([6, 6, 5, 5, 6], tile_of(22))
    assert made.order == (4, 0, 1, 2, 3)
    assert made.stays == {0, 1}
    assert made.cycles == pytest.approx(16 * (6 * 0.01 + 2 * 5 * 0.005))
    assert turns.layout([4] * 5, tile_of(22)).order == (0, 1, 2, 3, 4)


def test_memories_that_a_program_cannot_be_for() -> None:
    program = of(Program)[10]
    longest = max(row.ii for row in program.table)
    for contexts, what in ((longest - 1, "is longer than"), (1, "do not fit the fabric")):
        with pytest.raises(BundleError, match=what):
            from_bytes(replace(program, fabric=tile_of(contexts)).to_bytes())
    with pytest.raises(KernelError, match="of which a program may have 16"):
        vividc.compile(rounds, tile_of(1), cache=False)


def test_tiles_of_an_accelerator_bring_nothing() -> None:
    vivid = arch.load_accelerator("vivid")
    few = replace(TILE.controller, contexts=12)
    small = replace(vivid, tiles=tuple(replace(tile, controller=few) for tile in vivid.tiles))
    with pytest.raises(ArgumentError, match="has 20 contexts, and a tile of vivid holds 12"):
        vividc.launch.Job(small).configure(0, of(Program)[12])
    with pytest.raises(KernelError, match=r"has 12\nhint"):
        vividc.compile(rounds, small, cache=False)
