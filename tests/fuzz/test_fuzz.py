"""Random kernels: numba, the interpreter before and after transformations, and the simulator."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.fuzz.generate import random_source
from tests.fuzz.shrink import shrink
from tests.fuzz.witness import judge


@pytest.mark.parametrize("seed", range(2, 6))
def test_witnesses_agree(seed: int, tmp_path: Path) -> None:
    verdict = judge(random_source(seed), seed, tmp_path, f"fuzz{seed}", False)
    assert not verdict.find, verdict


def test_shrinking_keeps_what_fails() -> None:
    small = shrink(random_source(2), lambda source: "np.zeros(8" in source)
    assert "np.sin" not in small
    assert "v = np.zeros(8, np.int32)" in small


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(1000, 1200))
def test_witnesses_agree_on_many(seed: int, tmp_path: Path) -> None:
    verdict = judge(random_source(seed), seed, tmp_path, f"fuzz{seed}", seed % 20 == 0)
    assert not verdict.find, verdict
