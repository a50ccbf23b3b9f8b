"""Arithmetic, conversions and built-in functions of numbers."""

import math

import numpy as np

from tests.e2e.constructs.registry import A, construct, floats, unsigned, words
from vividc import lang


@construct("void(int32[::1])", A)
def builtin_abs(x):
    for i in range(len(x)):
        x[i] = abs(x[i])


@construct("void(float32[::1])", floats(6))
def float_abs(x):
    for i in range(len(x)):
        x[i] = abs(x[i])


@construct("void(int32[::1])", A, mapped=True)
def min_max_of_several(x):
    for i in range(1, len(x) - 1):
        x[i] = min(x[i - 1], x[i], x[i + 1]) + max(x[i - 1], x[i], x[i + 1])


@construct("void(float32[::1])", floats(6))
def clamp(x):
    for i in range(len(x)):
        x[i] = min(max(x[i], np.float32(-0.5)), np.float32(0.5))


@construct("void(int32[::1])", A)
def divmod_by_power(x):
    for i in range(len(x)):
        q, r = divmod(x[i], 4)
        x[i] = q * 100 + r


@construct("void(int32[::1])", A)
def floor_division(x):
    for i in range(len(x)):
        x[i] = x[i] // 2


@construct("void(int32[::1])", A)
def modulo(x):
    for i in range(len(x)):
        x[i] = x[i] % 4


@construct("void(int32[::1])", A)
def power(x):
    for i in range(len(x)):
        x[i] = x[i] ** 2 + x[i] ** 3


@construct("void(float32[::1])", floats(5))
def float_power(x):
    for i in range(len(x)):
        x[i] = x[i] ** 2


@construct("void(int32[::1])", A)
def unary(x):
    for i in range(len(x)):
        x[i] = -x[i] + (+x[i]) + (~x[i])


@construct("void(int32[::1])", A)
def not_operator(x):
    for i in range(len(x)):
        x[i] = not x[i]


@construct("void(int32[::1], float32[::1])", A, floats(8))
def numpy_casts(x, y):
    for i in range(len(x)):
        y[i] = np.float32(x[i]) * np.float32(0.5)
        x[i] = np.int32(y[i])


@construct("void(int32[::1], float32[::1])", A, floats(8), mapped=True)
def python_casts(x, y):
    for i in range(len(x)):
        y[i] += float(x[i])
        x[i] = int(np.float32(y[i]))


@construct("void(int32[::1])", A)
def bool_cast(x):
    for i in range(len(x)):
        x[i] = bool(x[i])


@construct("void(int32[::1])", A)
def int_of_bool(x):
    for i in range(len(x)):
        x[i] = int(x[i] > 2) + int(x[i] > 4)


@construct("void(int32[::1])", A)
def sum_of_comparisons(x):
    for i in range(1, len(x)):
        x[i] = (x[i] > 0) + (x[i] > 3)


@construct("void(uint32[::1])", unsigned(1, 2**31, 2**32 - 1))
def unsigned_arithmetic(x):
    for i in range(len(x)):
        x[i] = np.uint32(x[i] * np.uint32(3) + np.uint32(7)) >> np.uint32(3)


@construct("void(uint32[::1], int32[::1])", unsigned(1, 2**31, 2**32 - 1), words(0, 0, 0))
def unsigned_to_signed(x, y):
    for i in range(len(x)):
        y[i] = np.int32(x[i])


@construct("void(int32[::1])", A)
def shifts(x):
    for i in range(len(x)):
        x[i] = (x[i] << 3) ^ (x[i] >> 1)


@construct("void(uint32[::1])", unsigned(1, 2**31 + 5, 2**32 - 1))
def rotate(x):
    for i in range(len(x)):
        x[i] = (x[i] << np.uint32(7)) | (x[i] >> np.uint32(25))


@construct("void(float32[::1])", floats(6))
def numpy_scalar_functions(x):
    for i in range(len(x)):
        x[i] = np.abs(x[i]) + np.minimum(x[i], np.float32(0)) + np.maximum(x[i], np.float32(0))


@construct("void(float32[::1])", floats(6))
def numpy_sqrt(x):
    for i in range(len(x)):
        x[i] = np.sqrt(np.abs(x[i]))


@construct("void(float32[::1])", floats(6))
def math_functions(x):
    for i in range(len(x)):
        low, high = np.int32(math.floor(x[i])), np.int32(math.ceil(x[i]))
        x[i] = np.float32(np.int32(low * 10 + high)) + math.fabs(x[i])


@construct("void(float32[::1])", floats(6))
def math_constant(x):
    for i in range(len(x)):
        x[i] = x[i] * np.float32(math.pi) + np.float32(np.e)


@construct("void(float32[::1])", np.array([1, np.inf, -np.inf, np.nan, 0], np.float32))
def float_tests(x):
    for i in range(len(x)):
        if math.isnan(x[i]):
            x[i] = 1
        elif math.isinf(x[i]):
            x[i] = 2


@construct("void(float32[::1])", floats(4))
def infinity(x):
    best = np.float32(np.inf)
    for i in range(len(x)):
        best = min(best, x[i])
    x[0] = best


@construct("void(int32[::1])", A)
def bit_tests(x):
    for i in range(len(x)):
        x[i] = 1 if (x[i] >> 1) & 1 else 0


@construct("void(int32[::1])", A)
def mixed_int_float(x):
    for i in range(len(x)):
        x[i] = int(np.float32(x[i]) * np.float32(1.5))


@construct("void(float32[::1])", floats(6))
def comparison_to_float(x):
    for i in range(len(x)):
        x[i] = np.float32(x[i] > 0)


@construct("void(float32[::1], int32[::1])", floats(4), words(1, 1 << 30, 0x40490FDB, 0))
def language_bits(x, y):
    for i in range(len(x)):
        x[i] = lang.bitcast_f32(y[i])
        y[i] = lang.bitcast_i32(np.float32(i))


@construct("void(int32[::1], uint32[::1])", words(1, -(2**31), -1), unsigned(5, 2**31, 2**32 - 1))
def language_high_products(x, y):
    for i in range(len(x)):
        x[i] = lang.mulhi(x[i], y[i])
        y[i] = lang.mulhi_u(x[i], y[i])


@construct("void(float32[::1])", floats(6), mapped=True)
def language_fma(x):
    for i in range(len(x)):
        x[i] = lang.fma(x[i], x[i], x[0])


@construct("void(int32[::1])", A)
def underscore_and_hex(x):
    x[0] = 1_000
    x[1] = 0xFF
    x[2] = 0b101
    x[3] = True


@construct("void(int32[::1])", A)
def numpy_bool(x):
    for i in range(len(x)):
        flag = np.bool_(x[i] > 0)
        if flag:
            x[i] = 0


@construct("void(float32[::1])", floats(6))
def numpy_where_scalar(x):
    for i in range(len(x)):
        x[i] = x[i] if x[i] > 0 else np.float32(0.25) * x[i]
