"""Kernels as nests of loops, and why others are none."""

from __future__ import annotations

import numpy as np
import pytest

import vividc
from vividc.errors import KernelError
from vividc.frontend import KernelFunction
from vividc.machine.parallel import Repeat
from vividc.ssa.check import check_function
from vividc.ssa.parallel.nests import nests_of

SIGNATURE = "void(int32[::1], int32[:, ::1], int32)"


@vividc.kernel(SIGNATURE)
def two(x, a, n):
    for i in range(len(x)):
        x[i] += n
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            a[i, j] -= x[j]


@vividc.kernel(SIGNATURE)
def repeated(x, a, n):
    for _ in range(n):
        for i in range(len(x)):
            for j in range(a.shape[1]):
                a[i, j] += x[i]


@vividc.kernel(SIGNATURE)
def shallow(x, a, n):
    """One loop is too little for a launch."""
    for _ in range(n):
        for i in range(len(x)):
            x[i] += 3


@vividc.kernel(SIGNATURE)
def stores_before(x, a, n):
    x[0] = n
    for i in range(1, len(x)):
        x[i] += n


@vividc.kernel(SIGNATURE)
def branches(x, a, n):
    if n > 3:
        x[0] = 1
    for i in range(1, len(x)):
        x[i] += n


@vividc.kernel(SIGNATURE)
def counts(x, a, n):
    """How long the second of the repeated nests is, the first has found."""
    for part in range(n):
        found = np.int32(0)
        for i in range(len(x)):
            if x[i] > part:
                a[0, np.uint32(found)] = x[i]
                found = np.int32(found + 1)
        for k in range(found):
            for j in range(4):
                x[j] += a[0, k]


@vividc.kernel("int32(int32[::1])")
def returns(x):
    for i in range(len(x)):
        x[i] += 1
    return x[0]


@pytest.mark.parametrize(
    ("kernel", "nests", "repeats"), [(two, 2, 0), (repeated, 1, 1), (shallow, 1, 0)]
)
def test_nests_are_functions_of_their_own(kernel: KernelFunction, nests: int, repeats: int) -> None:
    found = nests_of(kernel.lower())
    assert len(found.nests) == nests
    assert sum(isinstance(item, Repeat) for item in found.order.items) == repeats
    for nest in found.nests:
        assert check_function(nest.function) == []
        assert nest.header in nest.function.by_name


@pytest.mark.parametrize(
    ("kernel", "reason"),
    [
        (stores_before, "it stores outside its loops"),
        (branches, "it branches outside its loops"),
        (counts, "a loop reads a number that another one computes"),
        (returns, "it returns a value"),
    ],
    ids=lambda item: getattr(item, "name", ""),
)
def test_why_a_kernel_has_no_nests(kernel: KernelFunction, reason: str) -> None:
    with pytest.raises(KernelError, match=reason):
        nests_of(kernel.lower())
