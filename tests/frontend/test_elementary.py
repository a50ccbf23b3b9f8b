"""Every spelling of an elementary function reaches its operation: against numba, in float32 and in
float64 that runs in float32.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable

import numba
import numpy as np
import pytest

from vividc.errors import VividcWarning
from vividc.frontend import KernelFunction
from vividc.ssa.interpret import interpret as run

UNARY: dict[str, Callable[..., object]] = {
    "math.log": lambda a, b: math.log(a),
    "math.log2": lambda a, b: math.log2(a),
    "math.log10": lambda a, b: math.log10(a),
    "math.log1p": lambda a, b: math.log1p(a),
    "math.exp": lambda a, b: math.exp(a),
    "math.expm1": lambda a, b: math.expm1(a),
    "math.sin": lambda a, b: math.sin(a),
    "math.cos": lambda a, b: math.cos(a),
    "math.tan": lambda a, b: math.tan(a),
    "math.sinh": lambda a, b: math.sinh(a),
    "math.cosh": lambda a, b: math.cosh(a),
    "math.tanh": lambda a, b: math.tanh(a),
    "math.asin": lambda a, b: math.asin(a),
    "math.acos": lambda a, b: math.acos(a),
    "math.atan": lambda a, b: math.atan(a),
    "math.sqrt": lambda a, b: math.sqrt(a),
    "math.fabs": lambda a, b: math.fabs(a - b),
    "math.degrees": lambda a, b: math.degrees(a),
    "math.radians": lambda a, b: math.radians(a),
    "math.isnan": lambda a, b: a if math.isnan(a) else b,
    "math.isinf": lambda a, b: a if math.isinf(a) else b,
    "math.isfinite": lambda a, b: a if math.isfinite(a) else b,
    "np.log": lambda a, b: np.log(a),
    "np.log2": lambda a, b: np.log2(a),
    "np.log10": lambda a, b: np.log10(a),
    "np.log1p": lambda a, b: np.log1p(a),
    "np.exp": lambda a, b: np.exp(a),
    "np.exp2": lambda a, b: np.exp2(a),
    "np.expm1": lambda a, b: np.expm1(a),
    "np.sin": lambda a, b: np.sin(a),
    "np.cos": lambda a, b: np.cos(a),
    "np.tan": lambda a, b: np.tan(a),
    "np.sinh": lambda a, b: np.sinh(a),
    "np.cosh": lambda a, b: np.cosh(a),
    "np.tanh": lambda a, b: np.tanh(a),
    "np.arcsin": lambda a, b: np.arcsin(a),
    "np.arccos": lambda a, b: np.arccos(a),
    "np.arctan": lambda a, b: np.arctan(a),
    "np.sqrt": lambda a, b: np.sqrt(a),
    "np.abs": lambda a, b: np.abs(a - b),
    "np.fabs": lambda a, b: np.fabs(a - b),
    "np.sign": lambda a, b: np.sign(a - b),
    "np.square": lambda a, b: np.square(a),
    "np.reciprocal": lambda a, b: np.reciprocal(a),
    "np.deg2rad": lambda a, b: np.deg2rad(a),
    "np.rint": lambda a, b: np.rint(a * b),
    "np.round": lambda a, b: np.round(a * b),
    "np.trunc": lambda a, b: np.trunc(-a * b),
    "np.floor": lambda a, b: np.floor(-a * b),
    "np.ceil": lambda a, b: np.ceil(a * b),
    "round": lambda a, b: round(a * b),
    "round to a digit": lambda a, b: round(a * b, 1),
    "math.trunc": lambda a, b: math.trunc(-a * b),
}
BINARY: dict[str, Callable[..., object]] = {
    "**": lambda a, b: a**b,
    "** 0.5": lambda a, b: a**0.5,
    "** -1.5": lambda a, b: a**-1.5,
    "math.pow": lambda a, b: math.pow(b, a),
    "math.atan2": lambda a, b: math.atan2(a, -b),
    "math.hypot": lambda a, b: math.hypot(b, a),
    "math.copysign": lambda a, b: math.copysign(a, -b),
    "np.power": lambda a, b: np.power(b, a),
    "np.arctan2": lambda a, b: np.arctan2(a, -b),
    "np.hypot": lambda a, b: np.hypot(b, a),
    "np.copysign": lambda a, b: np.copysign(a, -b),
    "np.maximum": lambda a, b: np.maximum(b, a),
    "np.minimum": lambda a, b: np.minimum(b, a),
    "np.fmax": lambda a, b: np.fmax(b, a),
    "np.fmod": lambda a, b: np.fmod(-b, a),
    "np.mod": lambda a, b: np.mod(-b, a),
    "np.floor_divide": lambda a, b: np.floor_divide(-b, a),
    "%": lambda a, b: -b % a,
    "//": lambda a, b: -b // a,
    "divmod": lambda a, b: divmod(b, -a)[1],
}
SPELLINGS = {**UNARY, **BINARY}
QUICK = ("math.log1p", "np.log2", "round", "%", "//", "divmod", "np.maximum", "math.isfinite")
NAMES = [pytest.param(name, marks=() if name in QUICK else pytest.mark.slow) for name in SPELLINGS]


def lowered_and_run(kernel: KernelFunction, rows: np.ndarray) -> np.ndarray:
    mine = rows.copy()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VividcWarning)
        function = kernel.lower()
    for row in mine:
        run(function, row)
    return mine


def assert_as_numba(kernel: KernelFunction, rtol: float) -> None:
    rng = np.random.default_rng(9)
    rows = np.stack([rng.uniform(0.05, 0.95, 12), rng.uniform(1, 7, 12)], 1).astype(np.float32)
    theirs = rows.copy()
    for row in theirs:
        kernel(row)
    np.testing.assert_allclose(lowered_and_run(kernel, rows), theirs, rtol=rtol, atol=rtol)


@pytest.mark.parametrize("name", NAMES)
def test_in_float32(name: str) -> None:
    helper = numba.njit(SPELLINGS[name])

    def function(x):
        x[0] = helper(x[0], x[1])

    assert_as_numba(KernelFunction(function, "void(float32[::1])", None), 3e-7)


@pytest.mark.slow
@pytest.mark.parametrize("name", SPELLINGS)
def test_in_float64_that_runs_in_float32(name: str) -> None:
    helper = numba.njit(SPELLINGS[name])

    def function(x):
        x[0] = helper(x[0] * 0.75, x[1] * 1.25)

    kernel = KernelFunction(function, "void(float32[::1])", None)
    assert_as_numba(kernel, 1e-5)


@pytest.mark.parametrize("kind", ["ldexp", "exp2 of an integer"])
def test_scales_are_exact(kind: str) -> None:
    """LLVM makes a scale of a power of two with a whole exponent, too."""

    def ldexp(x, n):
        x[0] = math.ldexp(x[0], n)

    def power(x, n):
        x[0] = np.float32(2.0) ** np.float32(n)

    function = ldexp if kind == "ldexp" else power
    kernel = KernelFunction(function, "void(float32[::1], int32)", None)
    lowered = kernel.lower()
    rng = np.random.default_rng(4)
    words = rng.integers(0, 1 << 32, 400, dtype=np.uint64).astype(np.uint32)
    for word in words:
        n = int(rng.integers(-300, 300))
        mine = np.array([word]).view(np.float32)
        theirs = mine.copy()
        run(lowered, mine, n)
        kernel(theirs, n)
        np.testing.assert_array_equal(mine, theirs)
