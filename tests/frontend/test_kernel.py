"""The `@kernel` decorator: signatures, parameters, running through numba."""

from __future__ import annotations

import numpy as np
import pytest

from vividc.dfg.cfg import DType, Param
from vividc.errors import KernelError, SourceLoc
from vividc.frontend import KernelFunction, kernel


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
        ("void(float32[::1])", "has 1 parameters, the function 2"),
        ("void(float64[::1], int32)", "float64"),
        ("void(float32[::1], float64)", "float64"),
        ("void(int64[::1], int32)", "int64"),
        ("void(float32[:], int32)", "not contiguous"),
        ("void(float32[::1, :], int32)", "not contiguous"),
        ("void(float32[:, :, :, ::1], int32)", "4 dimensions"),
        ("void(unicode_type, int32)", "unicode_type"),
    ],
)
def test_a_bad_signature_is_the_users_error(signature: str, reason: str) -> None:
    with pytest.raises(KernelError, match=reason) as caught:
        kernel(signature)(nothing)
    assert caught.value.loc == SourceLoc(__file__, nothing.__code__.co_firstlineno)
    assert caught.value.hint


def test_a_signature_must_be_a_string() -> None:
    with pytest.raises(KernelError, match="not a string"):
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
