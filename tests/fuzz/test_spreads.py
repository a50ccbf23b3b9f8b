"""Random kernels with a loop over `prange` do on all tiles what numba does."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.fuzz.spreads import judge_spread, random_spread_source
from tests.marks import with_slow


@pytest.mark.parametrize("seed", with_slow([1000, 1003], {1003}))
def test_spread_loops(seed: int, tmp_path: Path) -> None:
    verdict = judge_spread(random_spread_source(seed), seed, tmp_path)
    assert verdict.kind == "agrees", verdict.text


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2000, 2100))
def test_many_spread_loops(seed: int, tmp_path: Path) -> None:
    verdict = judge_spread(random_spread_source(seed), seed, tmp_path)
    assert not verdict.is_find, verdict.text
