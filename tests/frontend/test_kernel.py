"""The `@kernel` decorator: signatures, parameters, running through numba."""

from __future__ import annotations

import re
from collections.abc import Callable

import numba
import numpy as np
import pytest

import vividc
from tests.fuzz.witnesses import words_in_blocks
from vividc.errors import KernelError, SourceLoc
from vividc.frontend import KernelFunction, kernel
from vividc.machine.params import DType, Param


@kernel("float32(float32[:, ::1], int32[::1], uint32, int64, bool)", name="chosen")
def sample(x, index, mask, n, flag):
    """Docstring of the kernel."""
    total = np.float32(0)
    for i in range(n):
        if flag:
            total += x[i, index[i] & mask]
    return total


def test_a_kernel_knows_its_name_parameters_and_place() -> None:
    assert sample.name == "chosen"
    assert sample.__doc__ == "Docstring of the kernel."
    assert sample.file == __file__
    assert sample.params == (
        Param("x", DType.F32, 2),
        Param("index", DType.I32, 1),
        Param("mask", DType.U32),
        Param("n", DType.I64),
        Param("flag", DType.BOOL),
    )
    assert str(sample.signature.return_type) == "float32"


def test_a_kernel_runs_through_numba() -> None:
    x = np.arange(6, dtype=np.float32).reshape(3, 2)
    assert sample(x, np.array([1, 0, 3], np.int32), 1, 3, True) == 1.0 + 2.0 + 5.0


def test_lowering_is_done_once_per_option() -> None:
    assert sample.lower() is sample.lower()
    assert sample.lower(strict_fp=True) is sample.lower(strict_fp=True)
    assert sample.lower().name == "chosen"
    assert sample.lower().returns is DType.F32


def nothing(x, n):
    pass


@pytest.mark.parametrize(
    ("signature", "reason"),
    [
        ("void(float32[::1], int32", "cannot be read"),
        ("void(floaty[::1], int32)", "floaty"),
        ("float32[::1]", "cannot be read"),
        ("", "cannot be read"),
        ("void(float32[::1])", "the function have 1 and 2 parameters"),
        ("void(float64[::1], int32)", "float64"),
        ("void(float32[::1], float64)", "float64"),
        ("void(int64[::1], int32)", "int64"),
        ("void(float32[:], int32)", r"not contiguous in C order \(float32\[:\]\)"),
        ("void(float32[::1, :], int32)", "not contiguous"),
        ("void(float32[:, :, :, :, :, :, ::1], int32)", "7 dimensions"),
        ("void(unicode_type, int32)", "x has type str,"),
        ("void(float32[::1], optional(int32))", "n has type int32 or None"),
        ("void(float32[::1], UniTuple(int32, 2))", r"n has type \(int32, int32\)"),
        ("(float32[::1], str)", "expected a type instance, got str"),
    ],
)
def test_a_bad_signature_is_the_users_error(signature: str, reason: str) -> None:
    with pytest.raises(KernelError, match=reason) as caught:
        kernel(signature)(nothing)
    assert caught.value.loc == SourceLoc(__file__, nothing.__code__.co_firstlineno)
    assert caught.value.hint
    assert not re.search(r"<|Tuple|unicode_type|array\(\w+, \d", str(caught.value))


def test_a_kernel_without_a_signature_is_told_with_its_line() -> None:
    with pytest.raises(KernelError, match="without a signature") as caught:
        kernel(nothing)  # type: ignore[arg-type]
    assert caught.value.loc == SourceLoc(__file__, nothing.__code__.co_firstlineno)


def without_a_value(x, n):
    x[0] = n


def sometimes(x, n):
    if n:
        return 1


def two_values(x, n):
    return n, n


@pytest.mark.parametrize(
    ("signature", "function", "line", "reason"),
    [
        ("float32(float32[::1], int32)", without_a_value, 1, "returns nothing, .* says float32"),
        ("int32(float32[::1], int32)", sometimes, 1, "returns nothing, .* says int32"),
        ("void(float32[::1], int32)", sometimes, 2, "returns 1, .* says void"),
        ("int32(float32[::1], int32)", two_values, 1, r"returns \(int32, int32\), .* says int32"),
    ],
)
def test_what_is_returned_must_be_what_the_signature_says(
    signature: str, function: Callable[..., object], line: int, reason: str
) -> None:
    with pytest.raises(KernelError, match=reason) as caught:
        kernel(signature)(function).lower()
    assert isinstance(caught.value.loc, SourceLoc)
    assert caught.value.loc.line == function.__code__.co_firstlineno + line
    assert caught.value.hint


def test_a_signature_must_be_one() -> None:
    with pytest.raises(KernelError, match="the signature 3 cannot be read"):
        KernelFunction(nothing, 3, None)  # type: ignore[arg-type]


def test_only_ordinary_parameters_are_taken() -> None:
    def variadic(*args):
        pass

    with pytest.raises(KernelError, match="parameter args"):
        kernel("void(int32)")(variadic)


def test_an_untyped_result_is_inferred() -> None:
    def twice(x):
        return np.int32(x + x)

    doubled = KernelFunction(twice, "(int32,)", None)
    assert doubled(21) == 42
    assert doubled.lower().returns is DType.I32


@pytest.mark.parametrize(
    "signature",
    [
        numba.void(numba.float32[:, ::1], numba.int32),
        (numba.float32[:, ::1], numba.int32),
        "void(float32[:, ::1], int32)",
    ],
    ids=["object", "tuple", "text"],
)
def test_signatures_are_text_or_numbas_own(signature: object) -> None:
    made = kernel(signature)(nothing)  # type: ignore[arg-type]
    assert made.params == (Param("x", DType.F32, 2), Param("n", DType.I32))


def raised(x, by=3, scale=0.5):
    for i in range(len(x)):
        x[i] = x[i] * np.float32(scale) + np.float32(by)


@pytest.mark.parametrize("signature", ["void(float32[::1])", "void(float32[::1], int64, float32)"])
def test_what_a_caller_leaves_out_has_its_default(signature: str) -> None:
    made = kernel(signature)(raised)
    program = words_in_blocks(made.lower())
    for given in ({}, {"by": 7}, {"by": -1, "scale": 2.0}):
        theirs, mine = np.arange(4, dtype=np.float32), np.arange(4, dtype=np.float32)
        made(theirs, **given)
        vividc.simulate(program, mine, **given)
        assert np.array_equal(mine, theirs)
    with pytest.raises(vividc.VividcError, match="misses x"):
        vividc.simulate(program, by=3)


def test_a_function_that_numba_has_compiled_is_a_kernel() -> None:
    compiled = numba.njit(cache=False, fastmath=True)(raised)
    made = kernel("void(float32[::1])")(compiled)
    assert made.py_func is raised
    assert made.fastmath
    assert not kernel("void(float32[::1])")(numba.njit(raised)).fastmath
    assert not kernel("void(float32[::1])")(numba.njit(fastmath={"nnan"})(raised)).fastmath
    assert kernel("void(float32[::1])")(numba.njit(fastmath={"reassoc"})(raised)).fastmath
    assert [param.default for param in made.params] == [(), (3,), (0.5,)]
