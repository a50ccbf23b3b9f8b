"""Random constants have every layout, and lengths that their names tell."""

from __future__ import annotations

from random import Random

import numpy as np

from tests.fuzz.constants import random_constant
from tests.fuzz.places import counted, fixed_length, most


def test_constants_have_every_layout() -> None:
    constants = [random_constant(Random(seed), "G") for seed in range(200)]
    found = set().union(*(constant.features for constant in constants))
    wanted = {"C order", "F order", "A order", "backwards", "axis of 0 or 1"}
    assert {f"constant array, {what}" for what in wanted} == found
    for constant in constants:
        value = eval(constant.text, {"np": np})
        assert constant.array.dims == tuple(map(counted, value.shape))
        assert constant.array.is_constant


def test_a_cut_dimension_is_no_longer_than_it_was() -> None:
    assert [most(dim) for dim in ("L", "L-1", "L//2", "#3", "#3-1")] == [17, 17, 17, 3, 3]
    assert [fixed_length(dim) for dim in ("#12", "#3-1", "OWN", "L")] == [12, None, 16, None]
