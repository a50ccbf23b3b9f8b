"""Random kernels: numba, the interpreter (as written and transformed) and both engines agree."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.fuzz import witnesses
from tests.fuzz.arguments import Shapes, arguments
from tests.fuzz.generator import random_source
from tests.fuzz.nests import random_nest_source
from tests.fuzz.places import FIXED, MOST
from tests.fuzz.shrink import shrink
from tests.fuzz.witnesses import Simulated, judge, load, shapes_of, stays_inside
from tests.marks import with_slow


def check(
    seed: int,
    folder: Path,
    source: Callable[[int], str] = random_source,
    *,
    simulate: Simulated = "",
) -> None:
    verdict = judge(source(seed), seed, folder, simulate=simulate)
    assert not verdict.is_find, verdict.text


@pytest.mark.parametrize("seed", with_slow(range(1, 13), {1, 2, 3, 5, 6, 8, 10}))
def test_graphs(seed: int, tmp_path: Path) -> None:
    check(seed, tmp_path)


@pytest.mark.parametrize("seed", with_slow([1, 2, 3], {1, 3}))
def test_words_of_loops_in_blocks(seed: int, tmp_path: Path) -> None:
    check(seed, tmp_path, simulate="blocks")


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 1000))
def test_many_graphs(seed: int, tmp_path: Path) -> None:
    check(seed, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(1000, 1100))
def test_words_of_many_in_blocks(seed: int, tmp_path: Path) -> None:
    check(seed, tmp_path, simulate="blocks")


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2000, 2050))
def test_words_of_scheduled_loops(seed: int, tmp_path: Path) -> None:
    check(seed, tmp_path, simulate="mapped")


@pytest.mark.parametrize("seed", with_slow(range(1, 9), {1, 4, 6}))
def test_affine_nests(seed: int, tmp_path: Path) -> None:
    check(seed, tmp_path, random_nest_source)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 500))
def test_many_affine_nests(seed: int, tmp_path: Path) -> None:
    check(seed, tmp_path, random_nest_source, simulate="" if seed % 10 else "mapped")


@pytest.mark.parametrize("seed", with_slow(range(20, 25), {22, 24}))
@pytest.mark.parametrize("source", [random_source, random_nest_source])
def test_programs_stay_inside_their_arrays(
    source: Callable[[int], str], seed: int, tmp_path: Path
) -> None:
    assert stays_inside(source(seed), seed, tmp_path)


def test_a_wrong_word_is_a_difference(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(witnesses, "run_regions", lambda lowered, args: -12345)
    assert judge(random_source(1), 1, tmp_path).kind == "differs"


def test_a_failure_is_shrunk_to_what_causes_it() -> None:
    source = next(text for seed in range(99) if "break" in (text := random_source(seed)))
    small = shrink(source, lambda text: "break" in text, budget_s=20.0)
    assert len(small) < len(source)
    assert "break" in small


def test_sources_depend_on_the_seed_alone() -> None:
    assert random_source(5) == random_source(5) != random_source(6)


def test_tiny_arrays_are_among_the_arguments(tmp_path: Path) -> None:
    source = next(
        text
        for seed in range(30)
        if "FIXED = False" in (text := random_source(seed)) and "[::1]" in text
    )
    module = load(source, tmp_path)
    sizes = set()
    for seed in range(20):
        for trial in range(3):
            given = arguments(module.program, shapes_of(module), seed, trial)
            sizes |= {n for value in given for n in getattr(value, "shape", ())}
    assert {0, 1, 2, 3} <= sizes
    assert max(sizes) <= max(MOST.values())


def test_lengths_that_programs_rely_on_are_powers_of_two() -> None:
    assert all(n & (n - 1) == 0 for n in FIXED.values())
    assert all(FIXED[dim] <= MOST[dim] for dim in FIXED)
    assert Shapes().is_fixed
