"""Sizes that steer the renderers are scaled, and given back."""

from __future__ import annotations

import pytest

from benchmarks.steering import scaled, sized
from vividc.render.array import steering
from vividc.render.array.models import grouping


@pytest.mark.parametrize(
    ("size", "factor", "made"),
    [(8, 2, 16), (3, 0.5, 1), (1, 0.5, 1), (0.9, 2, 0.99), ((1, 2, 8), 0.5, (1, 4))],
)
def test_sizes_are_scaled(size: object, factor: float, made: object) -> None:
    assert scaled(size, factor) == made


def test_all_that_use_a_size_have_another_for_a_while() -> None:
    own = steering.GROUPED
    with sized("GROUPED", (1, 2)):
        assert (steering.GROUPED, vars(grouping)["GROUPED"]) == ((1, 2), (1, 2))
    assert (steering.GROUPED, vars(grouping)["GROUPED"]) == (own, own)
