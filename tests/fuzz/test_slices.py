"""Random programs of slices compute what numba's do, and the search notices what does not."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.fuzz.slices import Search
from tests.kept import modules_made_anew
from vividc.frontend.numba.expressions.numbers import Numbers


@pytest.mark.parametrize("seed", [2, 3])
def test_random_slices_are_numbas(seed: int, tmp_path: Path) -> None:
    search = Search(tmp_path)
    search.run(seed)
    assert not search.finds
    assert search.counts["agree"] + search.counts["raise"] == 1


@pytest.mark.slow
@pytest.mark.parametrize("hundred", range(10))
def test_more_random_slices_are_numbas(hundred: int, tmp_path: Path) -> None:
    search = Search(tmp_path)
    for seed in range(100 * hundred, 100 * hundred + 100):
        search.run(seed)
    assert not search.finds


def test_a_wrong_bound_is_found(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(Numbers, "smaller", lambda self, one, other: other)
    search = Search(tmp_path)
    seeds = iter(range(12))
    with modules_made_anew():
        while not search.finds:
            search.run(next(seeds))
