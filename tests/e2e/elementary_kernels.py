"""Kernels with elementary functions, in straight code and in loops."""

import math

import numpy as np

import vividc


@vividc.kernel("void(float32[::1])")
def logarithms(x):
    x[0] = math.log(x[0])
    x[1] = math.log2(x[1])
    x[2] = math.log10(x[2])
    x[3] = math.log1p(x[3])
    x[4] = math.expm1(x[4])


@vividc.kernel("void(float32[::1])")
def waves(x):
    x[0] = math.sin(x[0])
    x[1] = math.cos(x[1])
    x[2] = math.tan(x[2])


@vividc.kernel("void(float32[::1])")
def arcs(x):
    x[0] = math.asin(np.float32(1) / x[0])
    x[1] = math.acos(np.float32(0.9) / x[1])
    x[2] = math.atan(x[2])
    x[3] = math.atan2(x[3], -x[4])


@vividc.kernel("void(float32[::1])")
def hyperbolic(x):
    x[0] = math.sinh(x[0])
    x[1] = math.cosh(x[1])
    x[2] = math.tanh(x[2])
    x[3] = math.hypot(x[3], x[4])


@vividc.kernel("void(float32[::1])")
def powers(x):
    x[0] = x[0] ** x[1]
    x[1] = x[1] ** np.float32(-2.0)
    x[2] = x[2] ** np.float32(3.0)
    x[3] = x[3] ** np.float32(0.5)


@vividc.kernel("void(float32[::1])")
def remainders(x):
    x[0] = -x[0] % x[1]
    x[1] = x[1] % np.float32(-2.0)
    x[2] = x[2] // np.float32(0.75)
    x[3] = np.fmod(x[3], np.float32(1.25))


@vividc.kernel("void(float32[::1])")
def quotient_and_remainder(x):
    quotient, rest = divmod(x[0], -x[1])
    x[2] = quotient
    x[3] = rest


@vividc.kernel("void(float32[::1])")
def roundings(x):
    x[0] = np.float32(np.int32(round(x[0])))
    x[1] = np.rint(-x[1])
    x[2] = np.trunc(-x[2])
    x[3] = np.floor(x[3]) + np.ceil(x[3])
    x[4] = np.round(x[4])


@vividc.kernel("void(float32[::1])")
def signs(x):
    x[0] = np.copysign(x[0], x[1] - x[2])
    x[1] = np.sign(x[1] - x[0]) + math.fabs(x[1])
    x[2] = math.degrees(x[2]) + math.radians(x[3])
    x[3] = np.maximum(x[3], x[4]) - np.minimum(x[3], x[4])
    x[4] = (
        np.float32(math.isnan(x[4])) + np.float32(np.isfinite(x[4])) + np.float32(math.isinf(x[4]))
    )


@vividc.kernel("void(float32[::1])")
def numpy_spellings(x):
    x[0] = np.log(x[0]) + np.exp(x[0])
    x[1] = np.tanh(x[1])
    x[2] = np.arctan(x[2])
    x[3] = np.power(x[3], x[4])


@vividc.kernel("void(float32[::1])")
def quotients(x):
    x[0] = x[0] / np.float32(3)
    x[1] = x[1] / np.float32(-0.3)
    x[2] = np.float32(1) / x[2]


STRAIGHT = (
    quotients,
    logarithms,
    waves,
    arcs,
    hyperbolic,
    powers,
    roundings,
    signs,
    numpy_spellings,
)
EXACT = (remainders, quotient_and_remainder, roundings)


@vividc.kernel("void(float32[::1])")
def softplus(x):
    for i in range(len(x)):
        x[i] = math.log1p(math.exp(x[i]))


@vividc.kernel("void(float32[::1])")
def small_angles(x):
    for i in range(len(x)):
        angle = min(max(x[i], np.float32(-1000)), np.float32(1000))
        x[i] = math.sin(angle) * math.cos(angle)


@vividc.kernel("void(float32[::1])")
def halves(x):
    for i in range(len(x)):
        x[i] = x[i] / np.float32(8) + np.float32(2) / np.float32(3)


@vividc.kernel("void(float32[::1])")
def literals(x):
    for i in range(len(x)):
        x[i] = math.log(x[i] * 0.25)


LOOPS = (softplus, small_angles, halves)
