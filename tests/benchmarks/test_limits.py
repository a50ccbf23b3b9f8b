"""The kernels of the table of limits are kernels, whatever their size."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.hard_kernels import FAMILIES
from benchmarks.limits import Row
from vividc.cli.kernels import load_kernel

_SIZE = 3
_C = [name for name, (make, _) in FAMILIES.items() if make(_SIZE).startswith("define")]


@pytest.mark.parametrize("family", FAMILIES)
def test_a_family_has_kernels_of_each_size(family: str) -> None:
    make, sizes = FAMILIES[family]
    lengths = [len(make(size)) for size in (_SIZE, *sizes)]
    assert lengths == sorted(set(lengths))
    if family not in _C:
        compile(make(_SIZE), family, "exec")


@pytest.mark.parametrize("family", [*_C, "switch", "local arrays"])
def test_a_small_one_lowers(family: str, tmp_path: Path) -> None:
    path = tmp_path / ("hard.ll" if family in _C else "hard.py")
    path.write_text(FAMILIES[family][0](_SIZE))
    assert load_kernel(str(path)).lower().blocks


@pytest.mark.parametrize(
    ("took_s", "limit_s", "within"), [(6.4, 5.0, True), (6.6, 5.0, False), (2.2, 1.0, False)]
)
def test_a_row_is_allowed_a_tenth_and_a_second(took_s: float, limit_s: float, within: bool) -> None:
    assert Row(took_s).is_within(limit_s) is within
