"""Sizes that stand in for a user's: as many iterations as are assumed of loops without them."""

from __future__ import annotations

import numpy as np

import vividc
from vividc.compiler.advice.sizes import sizes_option, stand_in_sizes


@vividc.kernel("void(float32[::1], float32[:, ::1], int32, int64, int32, float32)")
def mixed(x, a, rows, count, shift, scale):
    """A loop by itself, and a nest."""
    for i in range(count):
        x[i] = x[i] * scale + np.float32(shift)
    for i in range(rows):
        for j in range(a.shape[1]):
            a[i, j] = a[i, j] * scale


def test_what_bounds_loops_alone_is_larger_than_what_bounds_nests() -> None:
    like = stand_in_sizes(mixed.lower())
    assert like == {"x": (24,), "a": (24, 24), "rows": 24, "count": 240}
    assert sizes_option(like) == "--sizes x=24,a=24x24,rows=24,count=240"


def test_what_is_known_stays() -> None:
    like = stand_in_sizes(mixed.sized({"count": 7}).lower())
    assert like["count"] == 7
    everything = {"x": 24, "a": (24, 24), "rows": 24, "count": 240}
    assert stand_in_sizes(mixed.sized(everything).lower()) == {}
