"""How a native run is cut into pieces, interrupted, and mixed with the reference engine."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from random import Random

import numpy as np
import pytest

import vividc
from tests.program.hand_kernels import choose, dot, fabric, find, positive, saxpy
from tests.sim.native.agreement import assert_engines_agree, launch, outcome, same
from tests.sim.native.mutations import mutated
from vividc.errors import BundleError, CycleLimit
from vividc.program import Program, Use, pack, word_layout
from vividc.sim import Launch, NativeEngine, ReferenceEngine
from vividc.sim.native import engine as native_engine

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(params=[(1, 1), (7, 2), (10**9, 1)], ids=["cycle by cycle", "7 cycles", "regions"])
def small_pieces(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    cycles, entries = request.param
    monkeypatch.setattr(native_engine, "CYCLES_A_CALL", cycles)
    monkeypatch.setattr(native_engine, "ENTRIES_A_CALL", entries)


def floats(count: int) -> np.ndarray:
    return np.arange(1, count + 1, dtype=np.float32)


def cases() -> Iterator[tuple[Program, Launch]]:
    x, y = np.arange(100, 116, dtype=np.int32), np.zeros(16, np.int32)
    yield (program := saxpy(fabric())), launch(program, floats(9), floats(9), 9)
    yield (program := saxpy(fabric())), launch(program, floats(9), floats(8), 9)
    yield (program := dot(fabric(latencies="{fma: 4}"))), launch(program, floats(7), floats(7), 7)
    yield (program := find(fabric())), launch(program, x, y, 109)
    yield (program := find(fabric())), launch(program, x, y, 3)
    yield (program := find(fabric(), counted=True)), launch(program, x, y, 120, 12)
    yield (program := positive(fabric())), launch(program, x, y, 16)
    yield (program := choose(fabric())), launch(program, 3)


@pytest.mark.usefixtures("small_pieces")
def test_runs_in_small_pieces_are_the_same() -> None:
    for program, given in cases():
        assert_engines_agree(program, given)
        for limit in (0, 5, 9, 13, 17):
            assert_engines_agree(program, replace(given, cycle_limit=limit))


@pytest.mark.usefixtures("small_pieces")
def test_broken_programs_in_small_pieces_are_the_same() -> None:
    random = Random(5)
    originals = list(cases())
    for _ in range(40):
        program, given = random.choice(originals)
        mutant = mutated(program, random)
        try:
            mutant.entries  # noqa: B018 - decoding tells whether a PE can do it
        except BundleError:
            continue
        assert_engines_agree(mutant, replace(given, cycle_limit=500))


def with_two_exits(program: Program) -> Program:
    """The program with a second node that may end the loop: not a form that is compiled."""
    entry = program.entries[0][2]
    assert entry.issue is not None
    words = program.words.copy()
    changed = replace(entry, issue=replace(entry.issue, use=Use.EXIT))
    words[0, 2] = pack(word_layout(program.fabric), changed)
    return replace(program, words=words)


def test_irregular_regions_run_on_the_reference_engine() -> None:
    program = with_two_exits(find(fabric()))
    engine = NativeEngine(program)
    assert engine.irregular_regions == (0,)
    x, y = np.arange(100, 116, dtype=np.int32), np.zeros(16, np.int32)
    assert_engines_agree(program, launch(program, x, y, 105))


@pytest.mark.parametrize("irregular", [(0,), (1,), (2,), (0, 2), (0, 1, 2)])
def test_engines_take_turns(irregular: tuple[int, ...]) -> None:
    """A straight region that rests a cycle at its end, or a loop that counts and has no exit."""
    program = dot(fabric(latencies="{fma: 4}"))
    rows = list(program.table)
    for index in irregular:
        row = rows[index]
        rows[index] = replace(row, span=row.span + 1)
        if row.kind == "loop":
            rows[index] = replace(row, counted=True, has_exit=True)
    program = replace(program, table=tuple(rows))
    assert NativeEngine(program).irregular_regions == irregular
    for n in (0, 1, 5):
        given = launch(program, floats(5), floats(5), n)
        assert_engines_agree(program, given, *(replace(given, cycle_limit=k) for k in range(30)))


def test_a_launch_that_names_no_arrays_may_touch_the_whole_scratchpad() -> None:
    program = saxpy(fabric())
    given = launch(program, floats(8), floats(8), 9)
    assert isinstance(outcome(NativeEngine(program), given)[0], str)
    open_launch = replace(given, extents={})
    assert not isinstance(outcome(NativeEngine(program), open_launch)[0], str)
    assert_engines_agree(program, open_launch)


def test_extents_beyond_the_scratchpad_are_not_trusted() -> None:
    program = saxpy(fabric())
    size = program.fabric.scratchpad.size_bytes
    given = launch(program, floats(8), floats(8), 8)
    wide = replace(given, extents={"x": (0, size + 4096), "y": (0, size)})
    assert NativeEngine(program).run(wide).engine == "reference"
    assert_engines_agree(program, wide)


class Stop(Exception):
    """Raised by a progress function."""


def test_threads_launch_one_engine_at_a_time_each_and_agree() -> None:
    program = dot(fabric(latencies="{fma: 4}"))
    engine, reference = NativeEngine(program), ReferenceEngine(program)
    launches = [launch(program, floats(n), floats(n), n) for n in range(1, 40)]
    with ThreadPoolExecutor(4) as pool:
        runs = list(pool.map(lambda given: outcome(engine, given), launches))
    for given, run in zip(launches, runs, strict=True):
        same(outcome(reference, given), run)


@vividc.kernel("int32(int32)")
def spin(n):
    word = np.int32(1)
    for i in range(n):
        word = (word << np.int32(1)) ^ (word >> np.int32(3)) ^ np.int32(i)
    return word


@pytest.fixture(scope="module")
def spinning() -> Program:
    return vividc.compile(spin)


LONG = 2**31 - 1


INTERRUPTED = """
import signal
import numpy as np
import vividc

signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job has none
try:
    vividc.simulate(
        vividc.load({path!r}), np.int32(2**31 - 1), cycle_limit=1 << 40, engine="native",
        progress=lambda cycles: print("running", flush=True),
    )
    print("done")
except KeyboardInterrupt:
    print("interrupted")
"""


def test_a_long_run_can_be_interrupted(spinning: Program, tmp_path: Path) -> None:
    spinning.save(tmp_path / "spin.vivid")
    script = INTERRUPTED.format(path=str(tmp_path / "spin.vivid"))
    with subprocess.Popen(
        [sys.executable, "-c", script], cwd=ROOT, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "running\n"
        process.send_signal(signal.SIGINT)
        assert process.stdout.read().endswith("interrupted\n")


def test_progress_is_told_and_may_end_the_run(spinning: Program) -> None:
    told: list[int] = []

    def progress(cycles: int) -> None:
        told.append(cycles)
        if len(told) == 3:
            raise Stop

    given = launch(spinning, np.int32(LONG), cycle_limit=1 << 40)
    with pytest.raises(Stop):
        NativeEngine(spinning).run(replace(given, progress=progress))
    assert told == sorted(told)
    assert told[2] < LONG


def test_the_cycle_limit_of_a_long_run(spinning: Program) -> None:
    given = launch(spinning, np.int32(LONG), cycle_limit=20_000_000)
    with pytest.raises(CycleLimit, match="after 20000000 cycles") as caught:
        NativeEngine(spinning).run(given)
    assert caught.value.loc is not None


def test_a_run_of_millions_of_cycles_is_numbas(spinning: Program) -> None:
    n = 3_000_000
    run = NativeEngine(spinning).run(launch(spinning, np.int32(n), cycle_limit=1 << 40))
    assert run.value is not None
    assert np.uint32(run.value).astype(np.int32) == spin(np.int32(n))
    assert n in [region.iterations for region in run.regions]
