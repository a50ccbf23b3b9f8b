"""Other kinds of arguments change nothing; what no launch may take is a find if it is taken."""

from __future__ import annotations

from collections.abc import Callable
from random import Random

import numpy as np
import pytest

from tests.fuzz.arguments import Difference
from tests.fuzz.kinds import Args, Kinds, share
from vividc.errors import ArgumentError


def add(args: Args) -> object:
    a, b = args[:2]
    a += b
    return a.sum()


def strict(args: Args) -> object:
    """Takes what `vividc.simulate` takes."""
    a, b = args[:2]
    if not all(
        x.flags.c_contiguous and x.dtype == np.int32 and x.dtype.isnative and x.ndim == 2
        for x in (a, b)
    ) or np.may_share_memory(a, b):
        raise ArgumentError("no")
    return add(args)


def given() -> Args:
    return [np.arange(6, dtype=np.int32).reshape(2, 3), np.ones((2, 3), np.int32), np.int32(3)]


def test_kinds_that_are_read_as_they_should() -> None:
    kinds = Kinds(strict, add, frozenset({0}))
    tried = {name for seed in range(20) for name in kinds.check(given(), Random(seed))}
    assert "arguments: read-only arrays" in tried
    assert "arguments: Fortran order" in tried


def careless(args: Args) -> object:
    return add([np.ascontiguousarray(args[0]), *args[1:]])


@pytest.mark.parametrize("launch", [add, careless, lambda args: strict(args) + 1])
def test_what_takes_anything_is_a_find(launch: Callable[[Args], object]) -> None:
    with pytest.raises(Difference):
        Kinds(launch, add, frozenset({0})).check(given(), Random(1))


def test_arrays_that_are_read_share_memory() -> None:
    shared = share(given(), frozenset())
    assert shared is not None
    assert np.may_share_memory(shared[0], shared[1])
    assert share(given(), frozenset({0})) is None
