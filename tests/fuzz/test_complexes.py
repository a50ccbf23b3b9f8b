"""Random kernels of complex numbers: numba, the interpreter and both engines agree."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.fuzz.complexes import random_complex_source
from tests.fuzz.test_fuzz import check
from tests.marks import with_slow


@pytest.mark.parametrize("seed", with_slow(range(1, 40), {3, *range(7, 40)}))
def test_complex_numbers(seed: int, tmp_path: Path) -> None:
    check(seed, tmp_path, random_complex_source)


@pytest.mark.parametrize("seed", with_slow(range(100, 130), {102, *range(106, 130)}))
def test_words_of_complex_numbers(seed: int, tmp_path: Path) -> None:
    check(seed, tmp_path, random_complex_source, simulate="blocks")
