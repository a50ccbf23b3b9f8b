"""Scalars of 64 bits from the call to the returned value, through a saved program."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import vividc
from vividc.errors import ArgumentError

EDGES = (0, 1, -1, 2**31, -(2**31) - 1, 2**32, 2**62, -(2**62))


@vividc.kernel("int64(int64, int64)")
def mixes(a, b):
    return (a ^ b) + (a >> 5) if a < b else a - b


@vividc.kernel("uint64(uint64)")
def inverts(a):
    return ~a


@vividc.kernel("int64(int32[::1], int64)")
def weighted(x, weight):
    total = 0
    for i in range(len(x)):
        total += x[i] * weight
    return total


@vividc.kernel("int32(int32[::1], int64)")
def sums_some(x, count):
    total = np.int32(0)
    for i in range(count):
        total += x[i]
    return total


def saved(kernel: vividc.KernelFunction, folder: Path) -> vividc.Program:
    path = folder / "program.vivid"
    vividc.compile(kernel).save(path)
    return vividc.load(path)


def test_both_words_of_parameters_and_results(tmp_path: Path) -> None:
    program = saved(mixes, tmp_path)
    assert [param.words for param in program.params] == [2, 2]
    for a in EDGES:
        for b in EDGES:
            assert vividc.simulate(program, a, b).value == mixes(a, b)


def test_unsigned_results_stay_unsigned(tmp_path: Path) -> None:
    program = saved(inverts, tmp_path)
    for a in (0, 1, 2**63, 2**64 - 1):
        assert vividc.simulate(program, a).value == 2**64 - 1 - a


def test_a_wide_factor_in_a_loop(tmp_path: Path) -> None:
    program = saved(weighted, tmp_path)
    x = np.array([3, -(2**31), 2**31 - 1, 5], np.int32)
    for weight in (2**31, -(2**30) + 1, 7, np.int64(2**29)):
        assert vividc.simulate(program, x, weight).value == weighted(x, weight)


def test_what_does_not_fit_is_refused_at_launch(tmp_path: Path) -> None:
    wide, counting = saved(inverts, tmp_path), saved(sums_some, tmp_path)
    with pytest.raises(ArgumentError, match="does not fit uint64"):
        vividc.simulate(wide, -1)
    with pytest.raises(ArgumentError, match="does not fit uint64"):
        vividc.simulate(wide, 2**64)
    with pytest.raises(ArgumentError, match="does not fit 32 bits") as caught:
        vividc.simulate(counting, np.ones(4, np.int32), 2**31)
    assert "counts the iterations" in str(caught.value.hint)
    assert vividc.simulate(counting, np.ones(4, np.int32), -(2**31)).value == 0
