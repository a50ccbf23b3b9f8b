"""`vividc.jit`: compiled for the types of a call, run on the array, compared with numba."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np
import pytest

import vividc
from vividc import LoopOptions
from vividc.compiler.jit import JitFunction
from vividc.errors import ArgumentError, KernelError, VividcError

QUICK = {"loops": LoopOptions(auto=False), "effort": "fast"}


def saxpy(a, x, y, n=4):
    total = y[0]
    for i in range(n):
        y[i] += a * x[i]
        total += y[i]
    return total


def fresh(dtype: type = np.float32) -> tuple[np.ndarray, np.ndarray]:
    return np.arange(8, dtype=dtype), np.ones(8, dtype)


@pytest.fixture(scope="module")
def jitted() -> JitFunction:
    return vividc.jit(**QUICK)(saxpy)


def test_a_call_runs_on_the_array_as_numba_would(jitted: JitFunction) -> None:
    x, y = fresh()
    value = jitted(2.0, x, y)
    again, expected = fresh()
    assert value == jitted.reference(2.0, again, expected) == saxpy(np.float32(2), *fresh())
    assert np.array_equal(y, expected)
    assert jitted.report is not None
    assert jitted.report.cycles > 0
    assert jitted.program is not None
    assert jitted.program.name == "saxpy"


def test_each_signature_is_compiled_once(jitted: JitFunction) -> None:
    for _ in range(2):
        jitted(2.0, *fresh())
        jitted(np.int32(3), *fresh(np.int32), n=8)
    assert len(jitted.programs) == 2
    assert repr(jitted) == "<vividc.jit saxpy: compiled for 2 signatures>"
    x, y = fresh(np.int32)
    assert jitted(np.int32(3), x, y, n=8) == 1 + sum(1 + 3 * i for i in range(8))


def test_a_function_of_numba_is_taken_as_it_was_written() -> None:
    jitted = vividc.jit(numba.njit(saxpy))
    assert jitted.py_func is saxpy
    assert str(jitted.kernel(2.0, *fresh()).params[1].type_text) == "float32[::1]"


class Box(NamedTuple):
    low: float
    high: float


def clipped(arrays, box, first=None, mode="both", arrays_0=0):
    x, y = arrays
    for i in range(arrays_0, len(x) if first is None else first):
        y[i] = max(x[i], box.low)
        if mode == "both":
            y[i] = min(y[i], box.high)
    return box, y.sum()


@pytest.mark.parametrize("rest", [(), (3,), (None, "low"), (2, "low", 1)])
def test_tuples_none_and_strings_are_arguments(rest: tuple[object, ...]) -> None:
    jitted = vividc.jit(numba.njit(clipped), **QUICK)
    box = Box(2.5, 5.5)
    (x, mine), (_, theirs) = fresh(), fresh()
    got, total = jitted((x, mine), box, *rest)
    expected, sum_ = numba.njit(clipped)((x, theirs), box, *rest)
    assert (got, total) == (expected, sum_)
    np.testing.assert_array_equal(mine, theirs)
    assert jitted.reference(fresh(), box, *rest) == (got, total)
    assert jitted.kernel((x, mine), box, *rest).line == clipped.__code__.co_firstlineno


def test_signatures_of_a_function_that_takes_tuples_are_not_its_kernels() -> None:
    @numba.njit("float64(UniTuple(float64, 2), float64)")
    def scaled(by, x):
        return by[0] * x + by[1]

    assert vividc.jit(scaled, **QUICK)((2.0, 1.0), 3.0) == scaled((2.0, 1.0), 3.0) == 7


def test_a_program_is_of_its_constants() -> None:
    jitted = vividc.jit(clipped, **QUICK)
    for mode in ("both", "low", "both"):
        jitted(fresh(), Box(2.5, 5.5), None, mode)
    assert len(jitted.programs) == 2


def test_it_runs_on_an_accelerator() -> None:
    x, y = fresh()
    jitted = vividc.jit(fabric="vivid", **QUICK)(saxpy)
    expected = y.copy()
    jitted.reference(2.0, x, expected)
    jitted(2.0, x, y)
    assert np.array_equal(y, expected)
    assert jitted.report is not None
    assert jitted.report.stats["runs"] == 1  # type: ignore[typeddict-item]


@pytest.mark.parametrize(
    ("args", "text"),
    [
        ((2.0, "x", np.ones(3, np.float32)), "cannot be an argument of saxpy"),
        ((2.0, {}, np.ones(3, np.float32)), "cannot be an argument of saxpy"),
        ((2.0, ([1.0],), np.ones(3, np.float32)), "x_0, .* cannot be an argument of saxpy"),
        ((2.0, [1.0], np.ones(3, np.float32)), "cannot be an argument of saxpy"),
        ((2.0,), "saxpy: missing a required argument: 'x'"),
        ((2.0, np.ones(3), np.ones(3)), "float64"),
        ((2.0, np.ones((3, 3), np.float32)[:, 0], np.ones(3, np.float32)), "C order"),
        ((np.complex128(1j), *fresh()), "complex128"),
    ],
)
def test_arguments_that_no_kernel_takes(
    jitted: JitFunction, args: tuple[object, ...], text: str
) -> None:
    with pytest.raises(VividcError, match=text):
        jitted(*args)


def test_mistakes_at_the_decorator() -> None:
    with pytest.raises(KernelError, match="a kernel cannot be made of 3"):
        vividc.jit(3)  # type: ignore[call-overload]
    with pytest.raises(ArgumentError, match="jit has no option effrot"):
        vividc.jit(effrot="fast")
    with pytest.raises(VividcError, match="fabric"):
        vividc.jit(fabric=3)  # type: ignore[call-overload]


def test_names_of_parameters_are_not_those_of_what_passes_them_on() -> None:
    """A named tuple that is called `given`, numbers that are called as parts and classes are."""

    @vividc.jit
    def shifted(x, given, _given, given_0, _given_):
        x[0] = given.by + _given * given_0 + _given_[0]

    @vividc.jit
    def _given(x, move):
        x[0] = move.by

    for run in (shifted, shifted.reference):
        x = np.zeros(1, np.int32)
        run(x, Move(by=1), 20, 5, Move(by=3))
        assert x[0] == 104
    _given(x, Move(by=7))
    assert x[0] == 7


def test_a_vectorized_function_of_any_name_is_called() -> None:
    @numba.vectorize
    def _vectorized(_vectorized_):
        return _vectorized_ + np.float32(1)

    assert vividc.jit(_vectorized)(np.float32([1, 2])).tolist() == [2, 3]


class Move(NamedTuple):
    by: int
