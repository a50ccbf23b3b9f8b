"""The native engine gives what the reference engine gives: memory, time, every count, errors."""

from __future__ import annotations

from itertools import product
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings

import vividc
from tests.program.hand_kernels import choose, dot, fabric, find, pairs, positive, saxpy
from tests.program.test_drains import rows
from tests.program.test_fills import arguments, tails
from tests.programs import WORDS, programs
from tests.sim.native.agreement import assert_engines_agree, launch
from tests.sim.native.mutations import field_of, mutated, with_field
from tests.sim.test_against_interpreter import FABRICS, compiled
from vividc.dfg.regions import loop_behind
from vividc.errors import BundleError
from vividc.machine.opcodes import MEMORY
from vividc.program import Program
from vividc.program.overlaps.parts import sound_parts
from vividc.program.words.entry import Use
from vividc.sim import Launch
from vividc.sim.native.write import loop


def floats(count: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal(count).astype(np.float32)


@pytest.mark.parametrize("n", [-1, 0, 1, 2, 3, 4, 5, 100])
def test_counted_loops(n: int) -> None:
    x, y = floats(max(n, 1)), floats(max(n, 1), 1)
    program = saxpy(fabric())
    assert_engines_agree(program, launch(program, x, y, n))
    program = dot(fabric(latencies="{fma: 4}"))
    assert_engines_agree(program, launch(program, x, y, n))


@pytest.mark.parametrize("counted", [False, True])
def test_exits_everywhere(counted: bool) -> None:
    program = find(fabric(), counted=counted)
    x, y = np.arange(100, 116, dtype=np.int32), np.zeros(16, np.int32)
    trips = range(-1, 18) if counted else [0]
    keys = [*range(100, 116), 7]
    launches = [
        launch(program, x, y, *((key, n) if counted else (key,)), cycle_limit=1000)
        for n in trips
        for key in keys
    ]
    assert_engines_agree(program, *launches)


@pytest.mark.parametrize("counted", [False, True])
def test_speculation_past_the_end_of_an_array(counted: bool) -> None:
    program = find(fabric(scratchpad="{size_bytes: 128, banks: 4}"), counted=counted)
    x, y = np.arange(100, 128, dtype=np.int32), np.zeros(4, np.int32)
    n = (40,) if counted else ()
    assert_engines_agree(program, *(launch(program, x, y, k, *n) for k in (100, 103, 104, 127, 9)))
    x, y = np.arange(4, dtype=np.int32), np.zeros(28, np.int32)
    assert_engines_agree(program, *(launch(program, x, y, k, *n) for k in (0, 2, 3, 4)))


def test_faults_of_accesses() -> None:
    program = saxpy(fabric())
    assert_engines_agree(program, *(launch(program, floats(n), floats(8), 8) for n in range(1, 9)))


@pytest.mark.parametrize("distance", [1, 8, 16])
def test_bank_conflicts_and_predicates(distance: int) -> None:
    program = pairs(fabric(), distance)
    x = np.arange(10 + distance, dtype=np.int32)
    assert_engines_agree(program, launch(program, x, np.zeros(10, np.int32), 10))
    program = positive(fabric())
    x = np.array([3, -1, 0, 2, -5], np.int32)
    assert_engines_agree(program, launch(program, x, np.full(5, 9, np.int32), 5))


@pytest.mark.parametrize("limit", range(0, 60, 3))
def test_cycle_limits(limit: int) -> None:
    program = dot(fabric(latencies="{fma: 4}"))
    assert_engines_agree(program, launch(program, floats(9), floats(9), 9, cycle_limit=limit))
    program = find(fabric())
    x, y = np.arange(16, dtype=np.int32), np.zeros(16, np.int32)
    assert_engines_agree(program, launch(program, x, y, 99, cycle_limit=limit))


def test_branches() -> None:
    program = choose(fabric())
    assert_engines_agree(program, *(launch(program, n) for n in (-5, 0, 3, 99)))


@pytest.mark.parametrize("name", sorted(FABRICS))
@settings(max_examples=12)
@given(programs())
def test_random_programs(name: str, source: tuple[object, ...]) -> None:
    program, _ = compiled(source, FABRICS[name])
    assert_engines_agree(program, launch(program, np.arange(WORDS, dtype=np.int32)))


def samples() -> list[tuple[Program, Launch]]:
    x, y = np.arange(100, 116, dtype=np.int32), np.zeros(16, np.int32)
    found = [
        (saxpy(fabric()), (floats(9), floats(9), 9)),
        (dot(fabric(latencies="{fma: 4}")), (floats(6), floats(6), 6)),
        (find(fabric()), (x, y, 107)),
        (find(fabric(), counted=True), (x, y, 109, 12)),
        (positive(fabric()), (x, y, 16)),
        (pairs(fabric(), 8), (x, np.zeros(8, np.int32), 8)),
        (choose(fabric()), (3,)),
    ]
    return [(program, launch(program, *args, cycle_limit=2000)) for program, args in found]


def test_loops_too_large_for_a_steady_body(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(loop, "STEADY_OPS", 0)
    for program, given_launch in samples():
        assert_engines_agree(program, given_launch)


def test_accesses_that_decide() -> None:
    """A store has no result that could end a loop or choose the next region; a load has."""
    done = 0
    for program, given_launch in samples():
        issues = {
            (context, pe): entry.issue
            for context, entries in enumerate(program.entries)
            for pe, entry in enumerate(entries)
            if entry.issue is not None
        }
        accesses = [at for at, issue in issues.items() if issue.op in MEMORY]
        for at, issue in issues.items():
            if issue.use is not Use.NONE:
                for access in accesses:
                    op = field_of(program, *access, "op")
                    mutant = with_field(program, *at, "op", op)
                    if _is_possible(mutant):
                        assert_engines_agree(mutant, given_launch)
                        done += 1
        for access, use in product(accesses, (1, 2, 3)):
            assert_engines_agree(with_field(program, *access, "control", use), given_launch)
    assert done


def _is_possible(program: Program) -> bool:
    """Whether its PEs can do what its words tell them, and hold what is left of each loop."""
    try:
        sound_parts(program)
    except BundleError:
        return False
    return True


def assert_mutants_agree(seed: int, count: int) -> None:
    random = Random(seed)
    originals = samples()
    done = 0
    while done < count:
        program, given_launch = random.choice(originals)
        mutant = mutated(program, random)
        if _is_possible(mutant):
            assert_engines_agree(mutant, given_launch)
            done += 1


def test_programs_with_changed_words() -> None:
    assert_mutants_agree(seed=1, count=60)


def drained() -> tuple[Program, Launch]:
    """A program whose loop ends while the region behind it begins, and its words there only."""
    program = vividc.compile(rows, fabric="vivid-tile", loops=vividc.LoopOptions(auto=False))
    ends = np.array([2, 2, 3, 11], np.int32)
    args = (ends, np.arange(11, dtype=np.int32), np.zeros(4, np.int32))
    return program, launch(program, *args, cycle_limit=2000)


def assert_overlapping_mutants_agree(
    program: Program, given_launch: Launch, regions: tuple[int, int], seed: int, count: int
) -> int:
    """How many programs could be run of those with changed words of two regions that overlap."""
    random, possible = Random(seed), 0
    rows_ = [program.table[region] for region in regions]
    contexts = [at for row in rows_ for at in range(row.context, row.context + row.ii)]
    for _ in range(count):
        mutant = mutated(program, random, contexts)
        if _is_possible(mutant):
            assert_engines_agree(mutant, given_launch)
            possible += 1
    return possible


def assert_drained_mutants_agree(seed: int, count: int) -> int:
    """As above, of a region that begins while the loop before it ends."""
    program, given_launch = drained()
    loop = next(index for index, row in enumerate(program.table) if row.drain)
    behind = program.table[loop].next
    assert behind is not None
    return assert_overlapping_mutants_agree(program, given_launch, (behind, loop), seed, count)


def test_changed_words_of_a_region_that_begins_early() -> None:
    """Most of them contradict the loop, and are refused; what is not runs the same on both."""
    possible = assert_drained_mutants_agree(1, 150)
    assert 20 < possible < 130


def assert_filled_mutants_agree(seed: int, count: int) -> int:
    """As above, of a loop that begins while the region before it ends."""
    program = vividc.compile(tails, fabric="vivid-tile", loops=vividc.LoopOptions(auto=False))
    given_launch = launch(program, *arguments((2, 0, 9, 1, 3)), cycle_limit=2000)
    index = max(index for index, row in enumerate(program.table) if row.fill)
    loop = loop_behind(program.table, index)
    assert loop is not None
    return assert_overlapping_mutants_agree(program, given_launch, (index, loop), seed, count)


def test_changed_words_of_a_loop_that_begins_early() -> None:
    possible = assert_filled_mutants_agree(1, 150)
    assert 20 < possible < 140


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2, 8))
def test_many_changed_words_of_a_loop_that_begins_early(seed: int) -> None:
    assert_filled_mutants_agree(seed, 3_000)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2, 8))
def test_many_changed_words_of_a_region_that_begins_early(seed: int) -> None:
    assert_drained_mutants_agree(seed, 3_000)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2, 12))
def test_many_programs_with_changed_words(seed: int) -> None:
    assert_mutants_agree(seed, count=1_000)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(FABRICS))
@settings(max_examples=400)
@given(programs())
def test_many_random_programs(name: str, source: tuple[object, ...]) -> None:
    program, _ = compiled(source, FABRICS[name])
    assert_engines_agree(program, launch(program, np.arange(WORDS, dtype=np.int32)))
