"""erf, gamma, inverse hyperbolic functions and frexp of float32, in units of the last place."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from tests.e2e.constructs.registry import Construct
from tests.e2e.test_constructs import interpreted
from tests.fuzz.witnesses import run_regions
from vividc.compiler.driver import lower
from vividc.errors import VividcWarning
from vividc.frontend import KernelFunction

SIGNATURE = "void(float32[::1], float32[::1])"
EDGES = (0.0, -0.0, np.inf, -np.inf, np.nan, 1e-45, -1e-45, 1e-38, 0.5, 0.9, 1.0, -1.0, 1e8, 3e38)
LIMITS = {"erf": 3.0, "erfc": 6.0, "asinh": 4.0, "acosh": 4.0, "atanh": 4.0, "cbrt": 0.6}
LIMITS |= {"gamma": 8.0}


def erf(x, y):
    for i in range(len(x)):
        y[i] = math.erf(x[i])


def erfc(x, y):
    for i in range(len(x)):
        y[i] = math.erfc(x[i])


def asinh(x, y):
    for i in range(len(x)):
        y[i] = math.asinh(x[i])


def acosh(x, y):
    for i in range(len(x)):
        y[i] = math.acosh(x[i])


def atanh(x, y):
    for i in range(len(x)):
        y[i] = math.atanh(x[i])


def arcsinh(x, y):
    y[:] = np.arcsinh(x)


def arccosh(x, y):
    y[:] = np.arccosh(x)


def arctanh(x, y):
    for i in range(len(x)):
        y[i] = np.arctanh(x[i])


def gamma(x, y):
    for i in range(len(x)):
        y[i] = math.gamma(x[i])


def cbrt(x, y):
    y[:] = np.cbrt(x)


def frexp(x, m, e):
    for i in range(len(x)):
        m[i], e[i] = math.frexp(x[i])


def points() -> np.ndarray:
    rng = np.random.default_rng(11)
    near = rng.uniform(-1, 1, 250)
    wide = rng.uniform(-11, 11, 250)
    far = rng.choice((-1.0, 1.0), 250) * 10 ** rng.uniform(-40, 38, 250)
    return np.concatenate([EDGES, near, wide, far, 1 + 10 ** rng.uniform(-7, 5, 50)]).astype(
        np.float32
    )


def exact(function: Callable[[float], float], x: np.ndarray) -> np.ndarray:
    def value(number: float) -> float:
        try:
            return function(number)
        except OverflowError:
            return math.copysign(math.inf, number)
        except ValueError:
            is_pole = function is math.atanh and abs(number) == 1
            is_pole |= function is math.gamma and number == 0
            return math.copysign(math.inf, number) if is_pole else math.nan

    found = np.array([value(float(number)) for number in x])
    return np.where(np.abs(found) > np.finfo(np.float32).max, np.copysign(np.inf, found), found)


KERNELS = [erf, erfc, asinh, acosh, atanh, arcsinh, arccosh, arctanh, gamma, cbrt]


@pytest.mark.parametrize("kernel", KERNELS)
def test_a_function_keeps_its_bound(kernel: Callable[..., None]) -> None:
    name = kernel.__name__.replace("arc", "a")
    x = points()
    construct = Construct(KernelFunction(kernel, SIGNATURE, None), (), False)
    y = np.zeros_like(x)
    interpreted(construct, (x, y))
    expected = exact(np.cbrt if name == "cbrt" else getattr(math, name), x)
    finite = np.isfinite(expected)
    np.testing.assert_array_equal(y[~finite], expected[~finite].astype(np.float32))
    unit = np.spacing(np.maximum(np.abs(expected[finite]), 2.0**-126).astype(np.float32))
    errors = np.abs(y[finite] - expected[finite]) / unit
    # Of what is less than the least normal erfc and gamma may be 0, as exp is.
    errors[np.abs(expected[finite]) < 2.0**-126] *= name not in ("erfc", "gamma")
    if name not in ("acosh", "gamma"):
        np.testing.assert_array_equal(np.signbit(y[finite]), np.signbit(expected[finite]))
    assert errors.max() <= LIMITS[name], (name, errors.max(), x[finite][errors.argmax()])


def of_doubles(x, y, n):
    for i in range(len(x)):
        y[0, i] = math.asinh(x[i] * 2.0)
        y[1, i] = np.arccosh(x[i] + 4.5)
        y[2, i] = np.arctanh(x[i] * 0.1)
        y[3, i] = math.erf(x[i] * 0.5)
        y[4, i] = math.erfc(x[i] * 0.5)
        y[5, i] = math.gamma(x[i] * 1.1)
    y[6, 0] = math.asinh(n)
    y[6, 1] = math.erf(n)
    y[6, 2] = math.gamma(n)


def test_functions_of_float64_and_integers_run_in_float32_with_a_warning() -> None:
    kernel = KernelFunction(of_doubles, "void(float32[::1], float32[:, ::1], int32)", None)
    x = np.linspace(-3.3, 3.2, 9).astype(np.float32)
    theirs, mine = np.zeros((7, 9), np.float32), np.zeros((7, 9), np.float32)
    kernel(x, theirs, 5)
    with pytest.warns(VividcWarning, match="float64 arithmetic runs in float32"):
        run_regions(lower(kernel), [x, mine, np.int32(5)])
    np.testing.assert_allclose(mine, theirs, rtol=3e-6)


def numpys(x, y):
    y[0] = np.arcsinh(x[0])
    y[1] = np.arccosh(x[1])
    y[2] = np.arctanh(x[2])
    y[3:6] = np.arcsinh(x)


def pythons(x, y):
    y[0] = math.asinh(x[0])
    y[1] = math.acosh(x[1])
    y[2] = math.atanh(x[2])
    for i in range(3):
        y[3 + i] = math.asinh(x[i])


def test_numpys_spellings_are_the_same_functions() -> None:
    x = np.array([-3, 2.5, 0.25], np.float32)
    results = []
    for kernel in (numpys, pythons):
        results.append(np.zeros(6, np.float32))
        interpreted(Construct(KernelFunction(kernel, SIGNATURE, None), (), False), (x, results[-1]))
    np.testing.assert_array_equal(*results)


def negative_powers(x, y):
    for i in range(len(x)):
        y[i] = np.float32(2) ** -i
        y[len(x) + i] = x[i] ** (3 - 4 * i)


@pytest.mark.filterwarnings("ignore::vividc.VividcWarning")
def test_a_float_to_a_negative_integer_raises_nothing() -> None:
    x = np.array([1.5, 0.5, -2, 3], np.float32)
    function = KernelFunction(negative_powers, SIGNATURE, None)
    ours, theirs = np.zeros(8, np.float32), np.zeros(8, np.float32)
    interpreted(Construct(function, (), False), (x, ours))
    function(x, theirs)
    np.testing.assert_allclose(ours, theirs, rtol=3e-7)


def shapes(x, y):
    column = x.reshape((len(x), 1))
    steps = np.diff(x)
    for i in range(len(x)):
        y[i] = column[i, 0] + 1
    for i in range(len(steps)):
        y[len(x) + i] = steps[i]


def test_reshapes_and_differences_need_no_heap() -> None:
    x, y = np.array([1, 4, 9, 25], np.float32), np.zeros(7, np.float32)
    interpreted(Construct(KernelFunction(shapes, SIGNATURE, None), (), False), (x, y))
    np.testing.assert_array_equal(y, [2, 5, 10, 26, 3, 5, 16])


def test_frexp_is_exact() -> None:
    x = points()
    signature = "void(float32[::1], float32[::1], int32[::1])"
    construct = Construct(KernelFunction(frexp, signature, None), (), False)
    m, e = np.zeros_like(x), np.zeros(len(x), np.int32)
    interpreted(construct, (x, m, e))
    for number, mantissa, exponent in zip(x, m, e, strict=True):
        np.testing.assert_equal((float(mantissa), int(exponent)), math.frexp(float(number)))
