"""Random kernels over bytes, halves and flags: numba, interpreter and simulator agree on every
byte.
"""

from __future__ import annotations

import warnings
from copy import deepcopy
from pathlib import Path

import numpy as np
import pytest

import vividc
from tests.e2e.random_bytes import interpreted, random_arguments, random_kernel
from vividc.driver import lower
from vividc.errors import KernelError, VividcWarning

TRIALS = 3


def assert_same(found: list[object], expected: list[object]) -> None:
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(one, other)


def check_graphs(seed: int, folder: Path) -> None:
    kernel = random_kernel(seed, folder)
    try:
        lowered = lower(kernel)
    except (KernelError, VividcWarning):  # refused, or float64 that runs in float32
        return
    for trial in range(TRIALS):
        expected = random_arguments(seed, trial)
        found = deepcopy(expected)
        value = kernel(*expected)
        word = interpreted(lowered, found)
        assert word is not None
        assert lowered.returns is not None
        assert (word - int(value)) % (1 << 8 * lowered.returns.size_bytes) == 0
        assert_same(found, expected)


def check_words(seed: int, folder: Path) -> None:
    kernel = random_kernel(seed, folder)
    try:
        lower(kernel)
    except (KernelError, VividcWarning):
        return
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VividcWarning)  # a loop too long to schedule in time
        program = vividc.compile(kernel, time_limit_s=20)
    expected = random_arguments(seed, 0)
    found = deepcopy(expected)
    value = kernel(*expected)
    assert vividc.simulate(program, *found).value == value
    assert_same(found, expected)


@pytest.mark.parametrize("seed", range(4))
def test_graphs(seed: int, tmp_path: Path) -> None:
    check_graphs(seed, tmp_path)


@pytest.mark.parametrize("seed", [33])
def test_words(seed: int, tmp_path: Path) -> None:
    check_words(seed, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 400))
def test_many_graphs(seed: int, tmp_path: Path) -> None:
    check_graphs(seed, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(400, 460))
def test_words_of_many(seed: int, tmp_path: Path) -> None:
    check_words(seed, tmp_path)
