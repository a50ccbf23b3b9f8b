"""Calls: other kernels, numba functions, closures."""

import numba
import numpy as np

import vividc
from tests.e2e.constructs.registry import A, construct, floats


@numba.njit
def plus(a, b=1, c=0):
    return a + b + c


@numba.njit
def pair(a, b):
    return b, a


@numba.njit
def triple_sum(row):
    total = np.int32(0)
    for value in row:
        total += value
    return total


@numba.njit
def clear(row, value):
    for i in range(len(row)):
        row[i] = value


@numba.njit("int32(int32)")
def low_byte(v):
    return v & 255


@numba.njit
def find(x, wanted):
    for i in range(len(x)):
        if x[i] == wanted:
            return i
    return -1


@numba.njit
def scratch(n):
    a = np.zeros(4, np.int32)
    for i in range(4):
        a[i] = n + i
    return a


@numba.njit(inline="always")
def squared(v):
    return v * v


@numba.njit
def applied(function, v):
    return function(v)


@vividc.kernel("float32(float32, int32)")
def weighted(v, n):
    return v * np.float32(0.5) + n


@vividc.kernel("void(float32[::1], int32)")
def scaled(x, n):
    for i in range(n):
        x[i] = weighted(x[i], i)


@construct("void(float32[::1])", floats(6), mapped=True)
def calls_a_kernel(x):
    scaled(x, 4)
    for i in range(4, len(x)):
        x[i] = weighted(x[i], 2.9)


@construct("void(int32[::1])", A)
def calls_with_defaults(x):
    for i in range(len(x)):
        x[i] = plus(x[i]) + plus(x[i], 5) + plus(x[i], c=2) + plus(b=3, a=x[i])


@construct("void(int32[::1])", A)
def tuple_return(x):
    for i in range(0, len(x) - 1, 2):
        x[i], x[i + 1] = pair(x[i], x[i + 1])


@construct("void(int32[:, ::1])", np.arange(12, dtype=np.int32).reshape(3, 4), mapped=True)
def passes_rows(m):
    for i in range(m.shape[0]):
        m[i, 0] = triple_sum(m[i]) + triple_sum(m[i, 1:])


@construct("void(int32[:, ::1])", np.arange(12, dtype=np.int32).reshape(3, 4))
def helper_writes_row(m):
    clear(m[1, :], 9)


@construct("void(int32[::1])", A)
def helper_with_signature(x):
    for i in range(len(x)):
        x[i] = low_byte(x[i] + 2.7)


@construct("int32(int32[::1])", A)
def helper_with_early_return(x):
    return np.int32(find(x, 7) * 100 + find(x, 1))


@construct("void(int32[::1])", A)
def helper_returns_array(x):
    a = scratch(x[0])
    b = scratch(x[1])
    for i in range(4):
        x[i] = a[i] * b[i]


@construct("void(int32[::1])", A)
def helper_takes_local(x):
    a = np.empty(6, np.int32)
    clear(a, 3)
    clear(a[2:4], 5)
    for i in range(6):
        x[i] = a[i]


@construct("void(int32[::1])", A)
def helper_inlined_by_numba(x):
    for i in range(len(x)):
        x[i] = squared(x[i])


@construct("void(int32[::1])", A)
def helper_as_argument(x):
    for i in range(len(x)):
        x[i] = applied(squared, x[i])


@construct("void(int32[::1])", A)
def closure(x):
    offset = len(x)

    def shifted(v):
        return v + offset

    for i in range(len(x)):
        x[i] = shifted(x[i])


@construct("void(int32[::1])", A)
def lambda_function(x):
    double = lambda v: v * 2  # noqa: E731 - the construct under test
    for i in range(len(x)):
        x[i] = double(x[i])


def _made(factor):
    @construct("void(int32[::1])", A)
    def free_variable(x):
        for i in range(len(x)):
            x[i] *= factor

    return free_variable


_made(3)
