"""Complex numbers: numba, the SSA interpreter and the simulator agree; what is refused says why."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from copy import deepcopy

import numpy as np
import pytest

import vividc
from tests.frontend.test_returned import same
from tests.fuzz.witnesses import words_in_blocks
from vividc.errors import ArgumentError, KernelError, SimulationError, VividcWarning
from vividc.program import from_bytes
from vividc.ssa.interpret import interpret
from vividc.ssa.text import parse, to_text

A = np.array([1 + 2j, -3 + 1j, 0.5 - 4j, 2j, -1, 4 - 1j], np.complex64)
M = np.outer(A[:3], A[2:]).astype(np.complex64)
TABLE = np.array([[1 + 2j, -1j], [3, 0.5 - 0.25j]], np.complex64)
SIGNATURE = "(complex64[::1], complex64[:, ::1], complex64)"


def arithmetic(a, m, c):
    for i in range(len(a)):
        a[i] = a[i] * c - a[i] + np.complex64(2)
        if a[i].real < a[i].imag or a[i] == c:
            a[i] = -np.conj(a[i])


def sums(a, m, c):
    total = np.complex64(0)
    for i in range(m.shape[0]):
        for j in range(m.shape[1]):
            total += m[i, j]
    return total, m.sum(), c.real


def whole_arrays(a, m, c):
    a[1:] = a[:-1] * c
    return a * a + c, m.T


def own_arrays(a, m, c):
    made = np.zeros((2, 3), np.complex64)
    other = np.full(2, c)
    for i in range(3):
        made[1, i] = a[i] + TABLE[i % 2, 1] + other[0]
    return made, TABLE[0, 0]


def products(a, m, c):
    return np.dot(a, a), np.vdot(a[1:], a[:-1])


def parts(a, m, c):
    made = np.zeros(len(a), np.complex64)
    for i in range(len(a)):
        made[i] = complex(a[i].imag, c.real)
    return made, a.real, a.imag[::2]


def maybe(a, m, c):
    if c.real > 0:
        return None
    return c


def doubles(a, m, c):
    made = np.zeros(3, np.complex128)
    for i in range(3):
        made[i] = a[i] * 1j
    return made, a[0] * 2.0


EXACT = (arithmetic, sums, whole_arrays, own_arrays, products, parts, maybe, doubles)


def lowered(function: Callable[..., object]) -> vividc.frontend.KernelFunction:
    made = vividc.kernel(SIGNATURE)(function)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VividcWarning)
        made.lower()
    return made


@pytest.mark.parametrize("function", EXACT)
def test_all_witnesses_agree_to_the_bit(function: Callable[..., object]) -> None:
    kernel = lowered(function)
    words = kernel.lower()
    assert parse(to_text(words)) == words
    program = words_in_blocks(words)
    assert from_bytes(program.to_bytes()) == program
    theirs = [A.copy(), M.copy(), np.complex64(1 - 2j)]
    expected = kernel(*theirs)
    mine = [A.copy(), M.copy(), np.complex64(1 - 2j)]
    same(interpret(words, *mine), expected)
    for engine in ("reference", "native"):
        mine = [A.copy(), M.copy(), 1 - 2j]
        same(vividc.simulate(program, *mine, engine=engine).value, expected)
        assert np.array_equal(mine[0], theirs[0])
        assert np.array_equal(mine[1], theirs[1])


def exponentials(a, m, c):
    for i in range(len(a)):
        a[i] = np.exp(a[i]) * abs(a[i])


def powers(a, m, c):
    for i in range(len(a)):
        a[i] = a[i] ** c


@pytest.mark.parametrize("function", [exponentials, powers])
def test_elementary_functions_are_near_numbas(function: Callable[..., object]) -> None:
    kernel = lowered(function)
    mine, theirs = A.copy(), A.copy()
    kernel(theirs, M, np.complex64(1 - 2j))
    vividc.simulate(words_in_blocks(kernel.lower()), mine, M, 1 - 2j)
    assert np.allclose(mine, theirs, rtol=2e-6)


def quotients(a, m, c):
    for i in range(len(a)):
        a[i] = a[i] / c


def test_quotients_are_numbas() -> None:
    kernel = lowered(quotients)
    program = words_in_blocks(kernel.lower())
    for c in (2 - 3j, -3 + 2j, 4j, 0.5, complex(np.inf, 1), complex(1, np.nan)):
        mine, theirs = A.copy(), A.copy()
        kernel(theirs, M, np.complex64(c))
        vividc.simulate(program, mine, M, c)
        assert np.allclose(mine, theirs, rtol=1e-6, equal_nan=True)


def test_a_complex_number_divided_by_zero_raises_as_numbas_does() -> None:
    program = words_in_blocks(lowered(quotients).lower())
    with pytest.raises(ZeroDivisionError):
        lowered(quotients)(A.copy(), M, np.complex64(0))
    with pytest.raises(SimulationError, match=r"ZeroDivisionError.*complex division by zero"):
        vividc.simulate(program, A.copy(), M, 0)


def test_rounded_complex_numbers_are_warned_of() -> None:
    with pytest.warns(VividcWarning, match="float64 arithmetic runs in float32"):
        vividc.kernel(SIGNATURE)(deepcopy(doubles)).lower()
    with pytest.raises(KernelError, match="float64 arithmetic"):
        vividc.kernel(SIGNATURE)(doubles).lower(strict_fp=True)


def test_parameters_of_128_bits_are_refused() -> None:
    with pytest.raises(KernelError, match="type complex128") as caught:
        vividc.kernel("(complex128[::1], complex64[:, ::1], complex64)")(sums)
    assert "complex64" in str(caught.value)


def test_shapes_may_be_known_and_numbers_never() -> None:
    kernel = lowered(arithmetic)
    sized = kernel.sized({"a": A, "m": M, "c": 1j})
    assert [param.known for param in sized.params] == [(6,), (3, 4), ()]
    mine, theirs = A.copy(), A.copy()
    kernel(theirs, M, np.complex64(2j))
    vividc.simulate(words_in_blocks(sized.lower()), mine, M, 2j)
    assert np.array_equal(mine, theirs)


def test_arguments_that_are_no_complex_numbers() -> None:
    program = words_in_blocks(lowered(arithmetic).lower())
    with pytest.raises(ArgumentError, match="expected a C-contiguous complex64 array"):
        vividc.simulate(program, A.real.copy(), M, 1j)
    with pytest.raises(ArgumentError, match="expected complex64, got str"):
        vividc.simulate(program, A.copy(), M, "1j")
    with pytest.raises(ArgumentError, match="does not fit float32"):
        vividc.simulate(program, A.copy(), M, 1e300j)


def test_jit_takes_a_python_number_for_a_complex64() -> None:
    jitted = vividc.jit(arithmetic)
    assert str(jitted.kernel(A, M, 1j).signature.args[2]) == "complex64"
    with pytest.raises(ArgumentError, match=r"np.ascontiguousarray\(a, np.complex64\)"):
        jitted.kernel(A.astype(np.complex128), M, 1j)


def copied(a, m, c):
    a[1:] += a[:-1]
    m[1:, 1:] = m[:-1, :-1]


def test_parts_that_overlap_are_copied_first() -> None:
    kernel = lowered(copied)
    mine, theirs = (A.copy(), M.copy()), (A.copy(), M.copy())
    kernel(*theirs, np.complex64(1))
    vividc.simulate(words_in_blocks(kernel.lower()), *mine, 1)
    for one, other in zip(mine, theirs, strict=True):
        assert np.array_equal(one, other)


def overlapping(a, m, c):
    for i in range(1, len(a)):
        a[i] = a[i - 1] * c
        a[i - 1] = np.complex64(complex(a[i].imag, a[i - 1].real))


def test_parts_of_elements_that_iterations_share() -> None:
    kernel = lowered(overlapping)
    program = vividc.compile(kernel, contract=False)
    mine, theirs = A.copy(), A.copy()
    kernel(theirs, M, np.complex64(1 + 1j))
    vividc.simulate(program, mine, M, 1 + 1j)
    assert np.array_equal(mine, theirs)
