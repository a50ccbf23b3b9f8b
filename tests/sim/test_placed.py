"""Launch words of programs whose arrays are in place: as `bind` gives them, value by value."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.launch.kernels import double, program
from vividc.errors import ArgumentError
from vividc.machine.params import DType, Param
from vividc.sim.bind import scalar_words
from vividc.sim.placed import At, Signature

VALUES = [
    *(0, 1, -1, 127, 128, -128, -129, 255, 256, 32767, 32768, -32769, 65535, 65536),
    *(2**31 - 1, 2**31, -(2**31), -(2**31) - 1, 2**32 - 1, 2**32, 2**63, -(2**63) - 1),
    *(True, False, 0.0, -0.0, 0.1, -3.5e38, 3.4e38, 3.4028236e38, 1e-46, 1e308),
    *(math.inf, -math.inf, math.nan, 2 + 3j, None, "1", [1]),
    *(np.int8(-3), np.uint32(2**32 - 1), np.int64(2**40), np.float32(0.1), np.float64(0.1)),
    *(np.bool_(True), np.float32("nan"), np.ones(1, np.float32)),
]


def outcome(words, *given: object) -> object:
    """Words, or the error's text."""
    try:
        return words(*given)
    except ArgumentError as error:
        return str(error)


@pytest.mark.parametrize(
    ("dtype", "words"),
    [
        *((dtype, 1) for dtype in DType if dtype is not DType.F16),
        *((dtype, 2) for dtype in (DType.I64, DType.U64, DType.C64)),
    ],
)
def test_scalars_have_the_words_that_bind_gives_them(dtype: DType, words: int) -> None:
    param = Param("s", dtype, words=words)
    signature = Signature(replace(program(double), params=(param,)))
    for value in VALUES:
        found = outcome(lambda value=value: signature.bound({"s": value})[0])
        assert found == outcome(scalar_words, param, value), value


def test_arrays_have_addresses_and_sizes() -> None:
    params = (Param("a", DType.U8, 2), Param("n", DType.I32), Param("b", DType.F32, 1))
    signature = Signature(replace(program(double), params=params))
    inputs, extents = signature.bound({"n": -1, "b": At(np.int64(8), (0,)), "a": At(40, (3, 5))})
    wanted = {"n": 2**32 - 1, "&b": 8, "b.shape0": 0, "&a": 40, "a.shape0": 3, "a.shape1": 5}
    assert inputs == wanted
    assert extents == {"a": (40, 55), "b": (8, 8)}


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({}, "misses n"),
        ({"x": At(0, (3,))}, "misses n"),
        ({"n": 1, "m": 2, "x": At(0, (3,))}, "no scalar 'm'"),
        ({"n": 1, "x": 3}, "no scalar 'x'"),
        ({"n": 1}, r"x of double is given as At\(address, shape\) with 1"),
        ({"n": 1, "x": At(0, (3, 3))}, "with 1 dimension"),
        ({"n": 1, "x": At(-4, (3,))}, "with 1 dimension"),
        ({"n": 1, "x": At(0, (3.0,))}, "with 1 dimension"),
        ({"n": 1, "x": At(0, (2**40,))}, "has shape"),
    ],
)
def test_what_does_not_fit_is_refused(given: dict[str, object], says: str) -> None:
    with pytest.raises(ArgumentError, match=says):
        Signature(program(double)).bound(given)
