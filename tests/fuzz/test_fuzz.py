"""Random kernels: numba, the interpreter (as written and transformed) and the simulator agree."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.fuzz import witnesses
from tests.fuzz.generator import random_source
from tests.fuzz.shrink import shrink
from tests.fuzz.witnesses import Difference, compare, judge


def check(seed: int, folder: Path, *, simulate: bool = False) -> None:
    verdict = judge(random_source(seed), seed, folder, simulate=simulate)
    assert not verdict.is_find, verdict.text


@pytest.mark.parametrize("seed", [1, 4, 5, 11])
def test_graphs(seed: int, tmp_path: Path) -> None:
    check(seed, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(1000, 1400))
def test_many_graphs(seed: int, tmp_path: Path) -> None:
    check(seed, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2000, 2030))
def test_words(seed: int, tmp_path: Path) -> None:
    check(seed, tmp_path, simulate=True)


def test_a_wrong_word_is_a_difference(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(witnesses, "run_regions", lambda lowered, args: -12345)
    assert judge(random_source(11), 11, tmp_path).kind == "differs"


@pytest.mark.parametrize("found", [[0.0, 1.0], [-0.0, 2.0]])
def test_floats_are_compared_with_their_sign(found: list[float]) -> None:
    expected = np.array([-0.0, 1.0], np.float32)
    compare("same", [expected.copy()], [expected])
    with pytest.raises(Difference):
        compare("other", [np.array(found, np.float32)], [expected])


def test_a_failure_is_shrunk_to_what_causes_it() -> None:
    source = random_source(3)
    small = shrink(source, lambda text: "TABLE[" in text or "own" in text, budget_s=20.0)
    assert len(small) < len(source) / 2
    assert "own" in small


def test_sources_depend_on_the_seed_alone() -> None:
    assert random_source(5) == random_source(5) != random_source(6)
