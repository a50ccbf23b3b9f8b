"""Random kernels whose parallel loop runs as threads agree with numba, and keep every bit."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.fuzz.threads import judge_threads, random_parallel_source


@pytest.mark.parametrize("seed", [1, 3, 8, 12, 47, 139])
def test_threads(seed: int, tmp_path: Path) -> None:
    judge_threads(random_parallel_source(seed), seed, tmp_path)


def test_words_of_threads(tmp_path: Path) -> None:
    judge_threads(random_parallel_source(5), 5, tmp_path, simulate=True)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(1000, 1300))
def test_many_threads(seed: int, tmp_path: Path) -> None:
    judge_threads(random_parallel_source(seed), seed, tmp_path, simulate=seed % 10 == 0)
