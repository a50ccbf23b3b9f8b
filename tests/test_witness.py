"""What the tests compare kernels with is numba's own, though less of it is made."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
import pytest
from numba.core import codegen
from numba.core.extending import overload

import vividc


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of functions that machine code is made of."""
    names: list[str] = []
    make = codegen.JITCodeLibrary._finalize_specific

    def counted(library: Any) -> None:
        names.append(library.name)
        make(library)

    monkeypatch.setattr(codegen.JITCodeLibrary, "_finalize_specific", counted)
    return names


def test_machine_code_is_that_of_the_kernel(made: list[str]) -> None:
    @numba.njit("float64(float32[::1])", no_cfunc_wrapper=True)
    def spread(a):
        return np.std(a) + np.median(a)

    a = np.array([1.0, 2.0, 4.0], np.float32)
    assert spread(a) == pytest.approx(np.std(a) + 2.0)
    assert [name.rpartition(".")[2] for name in made] == ["spread"]


def _wrong(n: int) -> int:
    raise NotImplementedError


@overload(_wrong)
def _overload_wrong(n):
    def wrong(n):
        if n > 2:
            raise ValueError("wrong", n)
        return n

    return wrong


def test_what_a_helper_raises_is_told_with_its_values() -> None:
    @numba.njit("int64(int64)")
    def asked(n):
        return _wrong(n)

    assert asked(2) == 2
    with pytest.raises(ValueError, match="wrong") as caught:
        asked(3)
    assert caught.value.args == ("wrong", 3)


@numba.njit("int64(int64)")
def _factorial(n):
    return n * _factorial(n - 1) if n > 1 else 1


def test_a_helper_calls_itself_and_another_helper() -> None:
    @numba.njit("int64(int64)")
    def sum_of_two(n):
        return _factorial(n) + _factorial(n + 1)

    assert sum_of_two(3) == 6 + 24


def test_functions_have_addresses_where_they_are_asked_for() -> None:
    @numba.cfunc("float64(float64)")
    def root(x):
        return np.sqrt(x)

    @numba.njit
    def applied(f, x):
        return f(x) + np.float64(1.0)

    assert root.ctypes(4.0) == 2.0
    assert applied(root, 9.0) == 4.0


def test_a_kernel_that_another_one_calls_runs_by_itself_too() -> None:
    @vividc.kernel("float32(float32[::1])")
    def largest(a):
        return np.max(a)

    @vividc.kernel("void(float32[::1])")
    def scaled(a):
        a[:] = a / largest(a)

    a = np.array([1.0, 2.0, 4.0], np.float32)
    scaled(a)
    assert a.tolist() == [0.25, 0.5, 1.0]
    assert largest(a) == 1.0
