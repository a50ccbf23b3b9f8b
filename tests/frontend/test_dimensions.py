"""Arrays of four to six dimensions."""

from __future__ import annotations

import numpy as np
import pytest

import vividc
from tests.fuzz.witnesses import words_in_blocks
from vividc.errors import ArgumentError, KernelError


def scaled(x, y):
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            y[i, j] = x[i, j, ..., ::-1] * np.float32(2) + np.float32(i)
    y[0, 0, 0, -1] += x[1, 0, 1, 0]


@pytest.mark.parametrize("more", [(), (2,), (1, 2)])
def test_all_witnesses_agree_on_many_dimensions(more: tuple[int, ...]) -> None:
    shape = (2, 3, 2, 3, *more)
    type_ = f"float32[{':, ' * (len(shape) - 1)}::1]"
    kernel = vividc.kernel(f"void({type_}, {type_})")(scaled)
    program = words_in_blocks(kernel.lower())
    x = np.random.default_rng(1).standard_normal(shape).astype(np.float32)
    theirs, mine = np.zeros_like(x), np.zeros_like(x)
    kernel(x, theirs)
    for engine in ("reference", "native"):
        vividc.simulate(program, x, mine, engine=engine)
        assert np.allclose(mine, theirs)  # FMAs round once


def test_seven_dimensions_are_refused() -> None:
    with pytest.raises(KernelError, match="array x has 7 dimensions"):
        vividc.kernel("void(float32[:, :, :, :, :, :, ::1])")(lambda x: None)


def test_an_empty_array_is_no_larger_than_one_that_is_not() -> None:
    @vividc.kernel("void(float32[:, :, :, ::1])")
    def first(x):
        x[0, 0, 0, 0] = 1

    program = words_in_blocks(first.lower())
    with pytest.raises(ArgumentError, match="an array of shape"):
        vividc.simulate(program, np.zeros((0, 9000, 9000, 9000), np.float32))
