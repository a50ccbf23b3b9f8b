"""Functions on float32, and `**` of complex numbers, that neither LLVM nor the array has, in
operations that both have.

They stand in for numba's on our target only, where numba would call a library that the array has
not. Of a float64 they are the same operations, which run in float32 with a warning.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numba.core import types
from numba.extending import overload, register_jitable

from vividc.lang.operations import bitcast_f32, bitcast_i32, fma

_overload: Callable[..., Callable[[Callable[..., Any]], Callable[..., Any]]] = functools.partial(
    overload, target="vividc"
)
_helper: Callable[[Callable[..., Any]], Callable[..., Any]] = register_jitable
_fma: Callable[..., Any] = fma
_F: Any = np.float32
_int32: Any = np.int32
_ONE, _TWO, _HALF = _F(1), _F(2), _F(0.5)
_LOG_2 = _F(math.log(2))
_NAN = _F(np.nan)
_HUGE = _F(1e8)
"""From here on 1 is nothing beside a square."""

# Chebyshev fits, by interpolation at 400 nodes, rounded to float32: of erf(x) / x over x * x in
# 0 .. 1, and, as Shepherd and Laframboise (1981) have it, of (1 + 2 x) exp(x * x) erfc(x) over
# (x - 4) / (x + 4) for x in 0 .. 10.5.
_ERF = tuple(
    _F(c)
    for c in (
        1.128379225730896,
        -0.37612637877464294,
        0.11283782869577408,
        -0.026865437626838684,
        0.005221053492277861,
        -0.0008484396385028958,
        0.00011268253729213029,
        -9.673590284364764e-06,
    )
)
_ERFC = tuple(
    _F(c)
    for c in (
        1.2329951524734497,
        -0.13962113857269287,
        0.015379617922008038,
        0.06809793412685394,
        -0.10103739798069,
        0.09372067451477051,
        -0.06635884940624237,
        0.037218961864709854,
        -0.01601421646773815,
        0.0050646173767745495,
        -0.0011211108649149537,
        -0.0006378956022672355,
    )
)
# Of gamma(x) over 2 x - 3 in 1 .. 2, likewise.
_GAMMA = tuple(
    _F(c)
    for c in (
        0.8862269245597361,
        0.016169141811899792,
        0.1037034270582266,
        -0.013410727584344527,
        0.009039603120085194,
        -0.0024287589045513362,
        0.0009188422605159385,
        -0.0002832634416576403,
        9.523930239131618e-05,
        -4.638636454454116e-05,
        1.5962751816532482e-05,
    )
)
_GAMMA_HIGH, _GAMMA_LOW = _F(36), _F(-43)
"""gamma is infinite in float32 from before here on, and 0 down to here."""
_THREE = _F(3)
_CENTRE = _F(4)
_VANISHED = _F(11)
"""erfc is 0 in float32 from before here on."""
_ERF_FROM, _ERFC_FROM = _F(0.9), _F(0.5)
_LEAST_NORMAL = _F(2.0**-126)
_SCALE = _F(2.0**25)
_LARGE = _F(2.0**100)
_UP, _DOWN = _F(2.0**24), _F(2.0**-24)
_ROOT_UP, _ROOT_DOWN = _F(2.0**8), _F(2.0**-8)
_INVERSE_ROOT = 0x54A21D2A
"""This less a third of a number's bits are those of its inverse cube root, within a twentieth."""
_THIRD = _F(1 / 3)


def _is_float32(x: Any) -> bool:
    return bool(x == types.float32)


def _is_number(x: Any) -> bool:
    """Whether the function of it is a float; of an integer numba computes that of a float64."""
    return isinstance(x, types.Float | types.Integer | types.Boolean)


def _of_floats(function: Callable[..., Any], x: Any) -> Callable[..., Any] | None:
    """What stands in for a function of `x`: of integers, that of a float64."""
    if isinstance(x, types.Float):
        return function
    if not _is_number(x):
        return None
    of_float = _helper(function)

    def of_integer(x: Any) -> Any:
        return of_float(float(x))

    return of_integer


@_overload(math.erf)
def _overload_erf(x: Any) -> Any:
    """Within 3 ulp."""

    def erf(x: Any) -> Any:
        a = abs(x)
        if a < _ERF_FROM:
            return x * _near_zero(_F(x * x))
        return math.copysign(_ONE - _upper(_F(a)), x)

    return _of_floats(erf, x)


@_overload(math.erfc)
def _overload_erfc(x: Any) -> Any:
    """Within 6 ulp where the result is normal, else between it and 0."""

    def erfc(x: Any) -> Any:
        a = abs(x)
        if a < _ERFC_FROM:
            return _ONE - x * _near_zero(_F(x * x))
        tail = _upper(_F(a))
        return _TWO - tail if x < 0 else tail

    return _of_floats(erfc, x)


@_helper
def _near_zero(z: Any) -> Any:
    """erf(x) / x for z = x * x up to 1."""
    result = _ERF[7]
    result = _fma(result, z, _ERF[6])
    result = _fma(result, z, _ERF[5])
    result = _fma(result, z, _ERF[4])
    result = _fma(result, z, _ERF[3])
    result = _fma(result, z, _ERF[2])
    result = _fma(result, z, _ERF[1])
    return _fma(result, z, _ERF[0])


@_helper
def _upper(a: Any) -> Any:
    """erfc of a number that is not negative; NaN of NaN."""
    x = _VANISHED if a > _VANISHED else a
    t = (x - _CENTRE) / (x + _CENTRE)
    result = _ERFC[11]
    result = _fma(result, t, _ERFC[10])
    result = _fma(result, t, _ERFC[9])
    result = _fma(result, t, _ERFC[8])
    result = _fma(result, t, _ERFC[7])
    result = _fma(result, t, _ERFC[6])
    result = _fma(result, t, _ERFC[5])
    result = _fma(result, t, _ERFC[4])
    result = _fma(result, t, _ERFC[3])
    result = _fma(result, t, _ERFC[2])
    result = _fma(result, t, _ERFC[1])
    result = _fma(result, t, _ERFC[0])
    square = x * x
    rest = _fma(x, x, -square)
    return result / (_ONE + _TWO * x) * (math.exp(-square) * (_ONE - rest))


@_overload(math.asinh)
def _overload_asinh(x: Any) -> Any:
    """Within 4 ulp."""

    def asinh(x: Any) -> Any:
        a = abs(x)
        if a > _HUGE:
            return math.copysign(math.log(a) + _LOG_2, x)
        square = a * a
        return math.copysign(math.log1p(a + square / (_ONE + math.sqrt(_ONE + square))), x)

    return _of_floats(asinh, x)


@_overload(math.acosh)
def _overload_acosh(x: Any) -> Any:
    """Within 4 ulp; NaN below 1."""

    def acosh(x: Any) -> Any:
        if x < _ONE:
            return _NAN
        if x > _HUGE:
            return math.log(x) + _LOG_2
        t = x - _ONE
        return math.log1p(t + math.sqrt(t * (t + _TWO)))

    return _of_floats(acosh, x)


@_overload(math.atanh)
def _overload_atanh(x: Any) -> Any:
    """Within 4 ulp; NaN outside -1 .. 1, infinity at its ends."""

    def atanh(x: Any) -> Any:
        a = abs(x)
        return math.copysign(_HALF * math.log1p(_TWO * a / (_ONE - a)), x)

    return _of_floats(atanh, x)


@_overload(math.gamma)
def _overload_gamma(x: Any) -> Any:
    """Within 20 ulp: a product of numbers down to 1 .. 2, or quotient up to there. NaN of negative
    integers.
    """

    def gamma(x: Any) -> Any:
        if x > _GAMMA_HIGH:
            return x * _LARGE * _LARGE
        if x <= _F(0) and x == np.floor(x):
            return _ONE / x if x == _F(0) else _NAN
        if x < _GAMMA_LOW:
            return x * _F(0)
        scale = _DOWN if x < -_ONE else _ONE  # the factors below 1 come last
        z, over, under = _F(x), _ONE, scale
        while z >= _TWO:
            z -= _ONE
            over *= z
        while z < _ONE:
            under *= z
            z += _ONE
        return over * _near_one(_TWO * z - _THREE) / under * scale

    return _of_floats(gamma, x)


@_helper
def _near_one(t: Any) -> Any:
    """gamma(z) for t = 2 z - 3 and z in 1 .. 2."""
    result = _GAMMA[10]
    result = _fma(result, t, _GAMMA[9])
    result = _fma(result, t, _GAMMA[8])
    result = _fma(result, t, _GAMMA[7])
    result = _fma(result, t, _GAMMA[6])
    result = _fma(result, t, _GAMMA[5])
    result = _fma(result, t, _GAMMA[4])
    result = _fma(result, t, _GAMMA[3])
    result = _fma(result, t, _GAMMA[2])
    result = _fma(result, t, _GAMMA[1])
    return _fma(result, t, _GAMMA[0])


@_overload(math.frexp)
def _overload_frexp(x: Any) -> Any:
    """Exact, for numbers below the least normal, too."""

    def frexp(x: Any) -> Any:
        if x == 0 or not math.isfinite(x):
            return x, np.int32(0)
        is_small = abs(x) < _LEAST_NORMAL
        bits: Any = bitcast_i32(x * _SCALE if is_small else x)
        exponent = (bits >> 23 & 255) - (126 + 25 if is_small else 126)
        return bitcast_f32(bits & 0x807FFFFF | 126 << 23), np.int32(exponent)

    return frexp if _is_float32(x) else None


def cbrt(x: Any) -> Any:
    """The cube root of a float32, within 0.6 ulp.

    Newton's iteration of the inverse root takes no division; the last step is Newton's for the root
    itself, with the cube in two words.
    """
    a = abs(x)
    if a == 0 or not math.isfinite(a):
        return x
    factor, root_factor = _ONE, _ONE
    if a < _LEAST_NORMAL:
        factor, root_factor = _UP, _ROOT_DOWN
    elif a > _LARGE:
        factor, root_factor = _DOWN, _ROOT_UP
    a *= factor
    bits: Any = bitcast_i32(a)
    r: Any = bitcast_f32(_int32(_INVERSE_ROOT - np.uint32(bits) // np.uint32(3)))
    for _ in range(3):
        r = _fma(r * _THIRD, _ONE - a * r * (r * r), r)
    square_inverse = r * r
    root = a * square_inverse
    square = root * root
    cube = square * root
    low = _fma(square, root, -cube) + _fma(root, root, -square) * root
    root = _fma(-((cube - a) + low), square_inverse * _THIRD, root)
    return math.copysign(root * root_factor, x)


def _asinh(x: Any) -> Any:
    return math.asinh(x)


def _acosh(x: Any) -> Any:
    return math.acosh(x)


def _atanh(x: Any) -> Any:
    return math.atanh(x)


def _complex_power(x: Any, y: Any) -> Any:
    """A complex number to a complex power, as Python's but for its exceptions: infinite or NaN."""
    if y.real == 2 and y.imag == 0:  # noqa: PLR2004
        return x * x
    if y.real == 0 and y.imag == 0:
        return x * 0 + 1
    if x.real == 0 and x.imag == 0:
        return x if y.imag == 0 and y.real > 0 else x + complex(_NAN, _NAN)
    size = math.hypot(x.real, x.imag)
    angle = math.atan2(x.imag, x.real)
    length = size**y.real
    phase = angle * y.real
    if y.imag != 0:
        length *= math.exp(-(angle * y.imag))
        phase += y.imag * math.log(size)
    return complex(length * math.cos(phase), length * math.sin(phase))


def complex_power(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Of numba's `**` on complex numbers."""
    return context.compile_internal(builder, _complex_power, sig, args)


def _with(function: Callable[..., Any]) -> Callable[..., Any]:
    def loop(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return context.compile_internal(builder, function, sig, args)

    return loop


_LOOPS: dict[Any, dict[str, Callable[..., Any]]] = {
    np.cbrt: {"f->f": _with(cbrt)},
    np.arcsinh: {"f->f": _with(_asinh), "d->d": _with(_asinh)},
    np.arccosh: {"f->f": _with(_acosh), "d->d": _with(_acosh)},
    np.arctanh: {"f->f": _with(_atanh), "d->d": _with(_atanh)},
    np.power: {"FF->F": complex_power, "DD->D": complex_power},
}


def float_loops(ufunc: Any) -> dict[str, Callable[..., Any]]:
    """What stands in for numba's loops of a ufunc, by types: "f->f"."""
    return _LOOPS.get(ufunc, {})
