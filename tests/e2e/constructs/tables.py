"""Constants: numbers, tables and tuples."""

import numpy as np

from tests.e2e.constructs.registry import A, construct, floats, unsigned

TABLE = np.array([3, 1, 4, 1, 5, 9, 2, 6], np.int32)
SINES = np.sin(np.arange(8)).astype(np.float32)
GRID = np.arange(12, dtype=np.int32).reshape(3, 4)
BYTES = np.array([7, 250, 128, 3], np.uint8)
SHORTS = np.array([-7, 30000, -32768, 3], np.int16)
LONGS = np.array([-7, 2**31 - 1, -(2**31), 3], np.int64)
POLYNOMIALS = np.array([0xEDB88320, 0x04C11DB7, 2**32 - 1, 3], np.int64)
HALVES = np.array([0.5, -1.25, 3.0, 0.0])
FLAGS = np.array([True, False, True, True])
LIMIT = 5
SCALE = 0.5
WEIGHTS = (1, 2, 1)
MANY = (3, 1, 4, 1, 5, 9, 2, 6)
FRACTIONS = (np.float32(0.25), np.float32(0.5), np.float32(0.25))
EIGHTHS = (0.125, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, -4.0)
NESTED = ((1, 2), (3, 4), (5, 6))
MIXED = (2, np.float32(0.5), True)
FIRST, SECOND = 5, 8


@construct("void(int32[::1])", A, mapped=True)
def table_read(x):
    for i in range(len(x)):
        x[i] = TABLE[x[i] & 7]


@construct("void(float32[::1])", floats(8))
def table_of_floats(x):
    for i in range(len(x)):
        x[i] *= SINES[i]


@construct("void(int32[::1])", A)
def table_in_two_dimensions(x):
    for i in range(len(x)):
        x[i] = GRID[x[i] & 1, x[i] & 3] + GRID[2, 1]


@construct("int32(int32[::1])", A)
def table_row(x):
    row = GRID[1]
    total = np.int32(0)
    for value in row:
        total += value
    return total + np.int32(GRID.shape[1])


@construct("void(int32[::1])", A)
def table_of_bytes(x):
    for i in range(len(x)):
        x[i] = BYTES[i & 3] + SHORTS[x[i] & 3]


@construct("void(int32[::1], uint32[::1])", A, unsigned(0, 0, 0, 0, 0, 0, 0, 0))
def table_of_longs(x, y):
    for i in range(len(x)):
        x[i] = LONGS[x[i] & 3]
        y[i] = POLYNOMIALS[i & 3] >> 1


@construct("void(float32[::1])", floats(8))
def table_of_doubles(x):
    for i in range(len(x)):
        x[i] = np.float32(HALVES[i & 3])


@construct("void(int32[::1])", A)
def table_of_flags(x):
    for i in range(len(x)):
        x[i] = 1 if FLAGS[i & 3] else 0


@construct("void(float32[::1])", floats(8))
def global_scalars(x):
    for i in range(LIMIT):
        x[i] *= np.float32(SCALE)


@construct("void(int32[::1])", A, mapped=True)
def tuple_by_variable(x):
    for i in range(1, len(x) - 1):
        total = np.int32(0)
        for k in range(3):
            total += WEIGHTS[k] * x[i + k - 1]
        x[i] = total


@construct("void(int32[::1])", A)
def tuple_as_table(x):
    for i in range(len(x)):
        x[i] = MANY[x[i] & 7] + MANY[-1] + MANY[-1 - (i & 3)]


@construct("void(float32[::1])", floats(8))
def tuple_of_floats(x):
    for i in range(len(x)):
        x[i] *= FRACTIONS[min(i, 2)]


@construct("void(float32[::1])", floats(8))
def tuple_of_doubles(x):
    for i in range(len(x)):
        x[i] *= np.float32(EIGHTHS[i])


@construct("void(int32[::1])", A)
def tuple_nested(x):
    for i in range(3):
        x[i] = NESTED[i][i & 1] + NESTED[2][0]


@construct("void(int32[::1])", A)
def tuple_of_mixed_types(x):
    x[0] = MIXED[0] + int(MIXED[1] * np.float32(4)) + MIXED[2]


@construct("int32(int32[::1])", A)
def loop_over_tuple(x):
    total = np.int32(0)
    for position in (1, 4, 6):
        total += x[position]
    return total


@construct("int32(int32[::1])", A)
def loop_over_list_of_constants(x):
    total = np.int32(0)
    for position in [1, 4, 6]:
        total += x[position]
    return total


@construct("int32(int32[::1])", A)
def loop_over_nested_tuple(x):
    total = np.int32(0)
    for a, b in NESTED:
        total += x[a] * b
    return total


@construct("int32(int32[::1])", A)
def membership(x):
    count = 0
    for value in x:
        if value in (FIRST, SECOND, -9):
            count += 1
        if value not in WEIGHTS:
            count += 100
    return np.int32(count)


@construct("int32(int32)", 4)
def tuple_of_variables(n):
    m = n + 0
    t = (m, m + 1, m * 2, m - 5, m, m)
    total = 0
    for k in range(6):
        total += t[k] * (k + 1)
    return np.int32(total + len(t))


@construct("int32(int32)", 4)
def tuple_sum_and_extrema(n):
    m = (n + 0) & 255
    t = (m, m + 1, m * 3)
    return np.int32(sum(t) + max(t) + min(t))


@construct("int32(int32)", 4)
def tuple_slice_and_join(n):
    t = (n, 2, 3)
    u = t[1:] + (7,)  # noqa: RUF005 - the construct under test
    return np.int32(u[0] + u[2])


@construct("void(int32[::1])", A)
def unpack_global_tuple(x):
    a, b, c = WEIGHTS
    x[0] = a + b * 10 + c * 100
