"""The table of formats' errors keeps the bounds it states."""

from __future__ import annotations

import pytest

from benchmarks.formats import arithmetic, conversion
from vividc.formats import E4M3, E5M2, Format

FP8 = pytest.mark.parametrize("fmt", [E4M3, E5M2], ids=["e4m3", "e5m2"])


@FP8
@pytest.mark.parametrize("name", ["fadd", "fmul", "fma"])
def test_rounding_once_keeps_the_bound(fmt: Format, name: str) -> None:
    errors = arithmetic(fmt, name)
    assert errors.bound is not None
    assert 0.8 * errors.bound < errors.alone.max() <= errors.bound
    assert errors.with_operands is not None
    assert errors.with_operands.max() > errors.bound


@FP8
def test_conversion_keeps_the_bound(fmt: Format) -> None:
    errors = conversion(fmt)
    assert errors.bound is not None
    assert 0.9 * errors.bound < errors.alone.max() <= errors.bound
