"""Divisions by zero follow the kernel's error model, as numba's do, on all witnesses."""

from __future__ import annotations

import operator

import numba
import numpy as np
import pytest

import vividc
from tests.fuzz.witnesses import run_regions
from tests.sim.native.agreement import assert_engines_agree, launch
from vividc.compiler.driver import lower
from vividc.errors import SimulationError
from vividc.frontend import KernelFunction

INTS = "void(int32[::1], int32[::1], int32[::1])"
WIDE = "void(int32[::1], int64, int32[::1])"
FLOATS = "void(float32[::1], float32[::1], float32[::1])"


def quotients(a, b, y):
    for i in range(len(y)):
        y[i] = a[i] // b[i]


def remainders(a, b, y):
    for i in range(len(y)):
        y[i] = a[i] % b[i]


def both(a, b, y):
    for i in range(len(y)):
        q, r = divmod(a[i], b[i])
        y[i] = q - r


def by_a_wide_one(a, n, y):
    for i in range(len(y)):
        y[i] = a[i] % n


def ratios(a, b, y):
    for i in range(len(y)):
        y[i] = a[i] / b[i]


def floored(a, b, y):
    for i in range(len(y)):
        y[i] = a[i] // b[i]


def moduli(a, b, y):
    for i in range(len(y)):
        y[i] = a[i] % b[i]


CASES = [
    (quotients, INTS, "integer division by zero"),
    (remainders, INTS, "integer modulo by zero"),
    (both, INTS, "integer divmod by zero"),
    (by_a_wide_one, WIDE, "integer modulo by zero"),
    (ratios, FLOATS, "division by zero"),
    (floored, FLOATS, "division by zero"),
    (moduli, FLOATS, "modulo by zero"),
]
IDS = [f"{function.__name__}" for function, *_ in CASES]


def made(function, signature, model):
    return KernelFunction(function, signature, None, model)


def arguments(signature, zero):
    dtype = np.float32 if signature is FLOATS else np.int32
    a, b = np.arange(-8, 8).astype(dtype), np.arange(1, 17).astype(dtype)
    if signature is WIDE:
        return a, np.int64(0 if zero else 7), np.zeros(16, dtype)
    if zero:
        b[11] = 0
    return a, b, np.zeros(16, dtype)


@pytest.mark.parametrize(("function", "signature", "text"), CASES, ids=IDS)
def test_python_raises_where_numba_does(function, signature, text):
    kernel = made(function, signature, "python")
    lowered = lower(kernel)
    with pytest.raises(ZeroDivisionError):
        kernel(*arguments(signature, zero=True))
    with pytest.raises(SimulationError) as caught:
        run_regions(lowered, arguments(signature, zero=True))
    first = function.__code__.co_firstlineno
    assert caught.value.loc.line == first + 2
    assert text.replace(" ", "_") in str(caught.value)
    mine, numbas = arguments(signature, zero=False), arguments(signature, zero=False)
    run_regions(lowered, mine)
    kernel(*numbas)
    np.testing.assert_array_equal(mine[2], numbas[2])


@pytest.mark.parametrize(("function", "signature"), [case[:2] for case in CASES], ids=IDS)
def test_numpy_goes_on_where_numba_does(function, signature):
    kernel = made(function, signature, "numpy")
    mine, numbas = arguments(signature, zero=True), arguments(signature, zero=True)
    run_regions(lower(kernel), mine)
    kernel(*numbas)
    np.testing.assert_array_equal(mine[2], numbas[2])


def test_a_run_ends_with_the_error_on_both_engines():
    program = vividc.compile(
        made(quotients, INTS, "python"), effort="fast", loops=vividc.LoopOptions(auto=False)
    )
    given = arguments(INTS, zero=True)
    with pytest.raises(
        SimulationError, match="raises ZeroDivisionError: integer division by zero"
    ) as caught:
        vividc.simulate(program, *given)
    assert caught.value.loc.line == quotients.__code__.co_firstlineno + 2
    assert not given[2].any()
    assert_engines_agree(program, *(launch(program, *arguments(INTS, zero)) for zero in (1, 0)))


def by_a_constant(a, b, y):
    for i in range(len(y)):
        y[i] = a[i] // 7 + a[i] % -3


def by_an_odd_one(a, b, y):
    for i in range(len(y)):
        y[i] = a[i] // (b[i] | 1)


def by_its_length(a, b, y):
    for i in range(len(y)):
        y[i] = a[(i * 5) % len(y)]


def behind_a_test(a, b, y):
    for i in range(len(y)):
        if b[i] > 0:
            y[i] = a[i] // b[i]


@pytest.mark.parametrize("function", [by_a_constant, by_an_odd_one, by_its_length, behind_a_test])
def test_a_divisor_that_is_not_zero_costs_nothing(function):
    plain, checked = (made(function, INTS, model).lower() for model in ("numpy", "python"))
    assert not checked.locals
    count = [sum(len(block.instrs) for block in one.blocks) for one in (plain, checked)]
    assert operator.eq(*count)


@pytest.mark.parametrize("signature", [WIDE, "void(int32[::1], int32, int32[::1])"])
def test_the_number_of_iterations_is_not_zero_in_one(signature):
    def within(a, n, y):
        for i in range(n):
            y[i] = a[(i * 5) % n]

    def beside(a, n, y):
        for i in range(len(y)):
            if i < 3:
                y[i] = n
            y[i] = a[i % n]

    assert not made(within, signature, "python").lower().locals
    assert made(beside, signature, "python").lower().locals


@numba.njit
def inheriting(a, b):
    return a // b


@numba.njit(error_model="numpy")
def own(a, b):
    return a // b


@numba.njit(error_model="python")
def strict(a, b):
    return a // b


def calls_inheriting(a, b, y):
    for i in range(len(y)):
        y[i] = inheriting(a[i], b[i])


def calls_own(a, b, y):
    for i in range(len(y)):
        y[i] = own(a[i], b[i])


def calls_strict(a, b, y):
    for i in range(len(y)):
        y[i] = strict(a[i], b[i])


@pytest.mark.parametrize(
    ("function", "model", "raises"),
    [
        (calls_inheriting, "python", True),
        (calls_inheriting, "numpy", False),
        (calls_own, "python", False),
        (calls_strict, "numpy", True),
    ],
)
def test_a_function_that_is_called_has_its_own_model_or_the_kernels(function, model, raises):
    lowered = made(function, INTS, model).lower()
    assert bool(lowered.locals) is raises


def test_a_raise_of_the_users_is_raised_by_the_run():
    def divides(a, b, y):
        if b[0] == 0:
            raise ZeroDivisionError("b")
        y[0] = a[0] // b[0]

    lowered = made(divides, INTS, "python").lower()
    assert [one.kind for one in lowered.results.raises] == ["ZeroDivisionError"]


def test_an_unknown_model_is_refused():
    with pytest.raises(vividc.VividcError, match="'fast' is no error model"):
        vividc.kernel(INTS, error_model="fast")


def test_jit_takes_the_model():
    @vividc.jit(error_model="python", effort="fast")
    def remainder(a, b):
        return a % b

    assert remainder(np.int32(-7), np.int32(3)) == remainder.reference(-7, 3) == 2
    with pytest.raises(SimulationError, match="ZeroDivisionError: integer modulo by zero"):
        remainder(np.int32(7), np.int32(0))
