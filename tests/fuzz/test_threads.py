"""Random kernels whose parallel loop runs as threads agree with numba, and keep every bit."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.fuzz.threads import judge_threads, random_parallel_source, random_serial_source


@pytest.mark.parametrize("seed", [1, 3, 8, 12, 47, 139])
def test_threads(seed: int, tmp_path: Path) -> None:
    judge_threads(random_parallel_source(seed), seed, tmp_path)


def test_words_of_threads(tmp_path: Path) -> None:
    judge_threads(random_parallel_source(5), 5, tmp_path, simulate=True)


@pytest.mark.parametrize("seed", [1, 6, 11, 18])
def test_iterations_that_prove_to_be_independent(seed: int, tmp_path: Path) -> None:
    assert judge_threads(random_serial_source(seed), seed, tmp_path) == ""


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2000, 2300))
def test_many_serial_loops(seed: int, tmp_path: Path) -> None:
    judge_threads(random_serial_source(seed), seed, tmp_path, simulate=seed % 10 == 0)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(1000, 1300))
def test_many_threads(seed: int, tmp_path: Path) -> None:
    judge_threads(random_parallel_source(seed), seed, tmp_path, simulate=seed % 10 == 0)
