"""Random programs whose variables are several arrays compute what numba's do, and the search
notices what does not.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.fuzz.renamed import random_source
from tests.fuzz.slices import Search
from tests.kept import modules_made_anew
from vividc.frontend.memory.arrays import by_array


@pytest.mark.parametrize("seed", [2, 3, 4])
def test_random_names_are_numbas(seed: int, tmp_path: Path) -> None:
    search = Search(tmp_path, random_source)
    search.run(seed)
    assert not search.finds
    assert search.counts.total() == 1


@pytest.mark.slow
@pytest.mark.parametrize("hundred", range(5))
def test_more_random_names_are_numbas(hundred: int, tmp_path: Path) -> None:
    search = Search(tmp_path, random_source)
    for seed in range(100 * hundred, 100 * hundred + 100):
        search.run(seed)
    assert not search.finds


def test_a_place_that_is_taken_too_early_is_found(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(by_array.Copies, "read_behind", lambda *_: set())
    search = Search(tmp_path, random_source)
    seeds = iter(range(40))
    with modules_made_anew():
        while not search.finds:
            search.run(next(seeds))
