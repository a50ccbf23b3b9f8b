"""Parts of arrays have the lengths that their dimensions name, and fit where they say they do."""

from __future__ import annotations

from random import Random

import numpy as np
import pytest

from tests.fuzz.places import Array, Places
from tests.fuzz.views import fitting, part

ARRAYS = [Array("a", "int32", ("L", "M")), Array("b", "int32", ("M",)), Array("c", "int32", ("L",))]


def shape(text: str, lengths: dict[str, int]) -> tuple[int, ...]:
    arrays = {a.name: np.zeros([lengths[dim] for dim in a.dims], np.int32) for a in ARRAYS}
    found: np.ndarray = eval(text, {**arrays, "nL": lengths["L"], "nM": lengths["M"]})
    return found.shape


@pytest.mark.parametrize("lengths", [{"L": n, "M": m} for n in range(5) for m in (0, 1, 2, 7)])
def test_parts_that_fit_can_be_combined(lengths: dict[str, int]) -> None:
    random = Random(str(lengths))
    places = Places(random, ARRAYS, is_fixed=False)
    for _ in range(60):
        view = part(random, places, random.choice(ARRAYS), lambda: "0")
        whole = shape(view.text, lengths)
        assert len(whole) == len(view.dims)
        for array in ARRAYS:
            other = fitting(random, array, view.dims)
            if other is not None:
                assert np.broadcast_shapes(whole, shape(other.text, lengths)) == whole


def test_an_axis_that_may_be_empty_has_no_index() -> None:
    places = Places(Random(0), ARRAYS, is_fixed=False)
    texts = {part(places.random, places, ARRAYS[0], lambda: "0").text for _ in range(100)}
    assert all(text == "a" or ":" in text.split(",")[0] for text in texts)
