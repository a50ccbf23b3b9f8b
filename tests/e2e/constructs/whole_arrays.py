"""Whole arrays at once: numpy's reductions, products, expressions, copies and arrays of launch
sizes.
"""

import math

import numpy as np

from tests.e2e.constructs.registry import A, construct, floats, unsigned, words

V, W = floats(9), floats(9)[::-1].copy()
MATRIX, TURNED = floats(3, 5), floats(5, 3)
COLUMN, ROW = floats(3), floats(5)
BYTES = np.arange(200, 217).astype(np.uint8)
NONE = floats(0)
ONE = floats(1)
LARGE = np.full((9, 4), 2**31 - 7, np.int32)


@construct("float32(float32[::1], float32[::1])", V, W, mapped=True)
def inner_product(a, b):
    return np.dot(a, b)


@construct("float32(float32[::1], float32[::1])", NONE, NONE)
def inner_product_of_nothing(a, b):
    return a @ b


@construct("void(float32[:, ::1], float32[::1], float32[::1])", MATRIX, ROW, COLUMN, mapped=True)
def matrix_times_vector(a, x, y):
    y[:] = a @ x


@construct("void(float32[:, ::1], float32[::1], float32[::1])", MATRIX, COLUMN, ROW)
def vector_times_matrix(a, x, y):
    y[:] = np.dot(x, a)


@construct("void(float32[:, ::1], float32[:, ::1], float32[:, ::1])", MATRIX, TURNED, floats(3, 3))
def product_of_matrices(a, b, c):
    c[:] = a @ b


@construct("void(float32[:, ::1], float32[:, ::1], float32[:, ::1])", MATRIX, TURNED, floats(3, 3))
def product_into(a, b, c):
    np.dot(a, b, c)


@construct("void(float32[:, ::1], float32[::1], float32[::1])", MATRIX, ROW, COLUMN)
def rows_times_vector(a, x, y):
    for i in range(len(y)):
        y[i] = a[i] @ x


@construct("float32(float32[::1])", V, mapped=True)
def largest_less_smallest(x):
    return np.max(x) - x.min()


@construct("float32(float32[:, ::1])", MATRIX)
def reductions_of_a_matrix(m):
    return np.sum(m) + m.mean() + m.max() * np.amin(m)


@construct("int32(float32[::1], int32[::1])", V, A)
def places_of_extremes(x, y):
    return np.int32(np.argmax(x) + 100 * y.argmin())


@construct("int32(int32[::1])", A)
def any_and_all(x):
    return np.int32(np.any(x > 8)) + 2 * np.int32(np.all(x)) + 4 * np.int32((x > 3).sum())


@construct("float32(float32[::1], float32[::1])", V, W)
def distance(a, b):
    return math.sqrt(np.sum((a - b) ** 2))


@construct("void(float32[::1], float32[::1], float32)", V, W, 1.5, mapped=True)
def scaled_sum(x, y, a):
    y[:] = a * x + y


@construct("void(float32[::1], float32[::1], float32)", NONE, NONE, 1.5)
def scaled_sum_of_nothing(x, y, a):
    y[:] = a * x + y


@construct("void(float32[::1], float32[::1], float32)", ONE, V, 1.5)
def broadcast_of_one(x, y, a):
    y += a * x


@construct("void(float32[::1], float32[::1])", V, W)
def differences(x, y):
    y[:-1] = x[1:] - x[:-1]


@construct("void(float32[::1], float32[::1])", ONE, floats(1))
def differences_of_one(x, y):
    y[:-1] = x[1:] - x[:-1]


@construct("void(float32[:, ::1], float32[:, ::1])", MATRIX, floats(3, 5))
def five_point_stencil(x, y):
    y[1:-1, 1:-1] = x[:-2, 1:-1] + x[2:, 1:-1] + x[1:-1, :-2] + x[1:-1, 2:] - 4 * x[1:-1, 1:-1]


@construct("void(float32[:, ::1], float32[::1], float32[::1])", MATRIX, COLUMN, ROW)
def column_times_row(a, x, y):
    a[:] = x.reshape(-1, 1) * y


@construct("void(float32[::1], float32[::1])", V, W)
def softmax(x, y):
    y[:] = np.exp(x - np.max(x))
    y /= np.sum(y)


@construct("void(float32[:, ::1], float32[:, ::1])", MATRIX, floats(3, 5))
def normalised_rows(x, y):
    for i in range(x.shape[0]):
        mean = np.mean(x[i])
        variance = np.mean((x[i] - mean) ** 2)
        y[i] = (x[i] - mean) / np.sqrt(variance + np.float32(1e-5))


@construct("void(float32[:, ::1])", floats(5, 5))
def eliminated(a):
    n = a.shape[0]
    for k in range(n):
        for i in range(k + 1, n):
            a[i, k] /= a[k, k]
            a[i, k + 1 :] -= a[i, k] * a[k, k + 1 :]


@construct("void(int32[::1], int32[::1])", A, words(*range(8)), mapped=True)
def copied(x, y):
    y[:] = x


@construct("void(int32[::1])", A, mapped=True)
def moved_by_one(x):
    x[1:] = x[:-1]


@construct("void(int32[::1])", A)
def moved_back(x):
    x[:-2] = x[2:]


@construct("void(int32[::1])", A)
def turned_around(x):
    x[:] = x[::-1]


@construct("void(uint8[::1])", BYTES)
def moved_bytes(x):
    x[3:] = x[:-3]


@construct("void(uint8[::1])", BYTES)
def inverted_bytes(x):
    x[:] = 255 - x


@construct("void(float32[::1])", V)
def shifted_window(x):
    window = np.zeros(4, np.float32)
    for i in range(len(x)):
        window[1:] = window[:-1]
        window[0] = x[i]
        x[i] = window.sum()


@construct("void(float32[:, ::1], float32[:, ::1])", MATRIX, floats(5, 3))
def transposed_copy(a, b):
    b[:] = a.T


@construct("void(float32[:, ::1])", floats(4, 4))
def transposed_in_place(a):
    a[:] = a.T


@construct("void(float32[::1], int32)", V, 5, mapped=True)
def array_of_a_scalar_size(x, n):
    t = np.zeros(2 * n + 1, np.float32)
    for i in range(n):
        t[2 * i] = x[i]
    for i in range(n):
        x[i] = t[n - i]


@construct("void(float32[::1], int64)", V, 5)
def array_of_a_wide_size(x, n):
    t = np.zeros(n + 2, np.float32)
    for i in range(n):
        t[i] = x[i]
    for i in range(n):
        x[i] = t[n - i]


@construct("void(float32[::1], int32)", V, -3)
def slice_from_the_end(x, n):
    t = x[:n] * np.float32(2)
    for i in range(len(t)):
        x[i] = t[len(t) - 1 - i]


@construct("void(float32[::1])", V)
def array_like_another(x):
    t = np.empty_like(x)
    for i in range(len(x)):
        t[i] = x[len(x) - 1 - i]
    x[:] = t


@construct("void(float32[::1])", V)
def array_copied(x):
    t = x.copy()
    for i in range(len(x)):
        x[i] = t[len(x) - 1 - i]


@construct("int64(int32[::1])", words(1, 2, -(2**31), 2**31 - 1, 5), mapped=True)
def wide_local_array(x):
    t = np.zeros(4, np.int64)
    for v in x:
        t[v & 3] += v * 3
    return t[0] + t[1] * t[2] - t[3]


@construct("uint64(uint32[::1])", unsigned(2**32 - 1, 5, 2**31, 77, 3), mapped=True)
def unsigned_wide_local_array(x):
    t = np.empty(4, np.uint64)
    t[:] = np.uint64(1) << np.uint64(63)
    for i in range(len(x)):
        t[i & 3] ^= np.uint64(x[i]) * np.uint64(x[i])
    return t[0] ^ t[1] ^ t[2] ^ t[3]


@construct("void(float32[::1], uint32)", V, 7)
def wide_array_of_a_scalar_size(x, n):
    t = np.zeros(n * 2, np.int64)
    for i in range(n):
        t[i] = i * 3000000000
    for i in range(n):
        x[i] = t[i] // 1000000000


@construct("float32(float32[::1])", V, mapped=True)
def double_local_array(x):
    t = np.zeros(4)
    t[0] = 0.1
    for i in range(len(x)):
        t[i & 3] += x[i]
    return t.sum()


@construct("void(int32[::1])", A)
def counted_array(x):
    for i in np.arange(len(x)):
        x[i] += i
    t = np.arange(2, 18, 2)
    x[0] = t[3]


@construct("void(float32[::1], float32[::1])", V, W)
def running_sum(x, y):
    y[:] = np.cumsum(x)


@construct("int32(uint8[::1])", (np.arange(32000) % 251).astype(np.uint8), mapped=True)
def many_bytes(x):
    total = 0
    for i in range(len(x) - 5, len(x)):
        total += x[i] * i
    return total


@construct("int32(int32[::1])", A, mapped=True)
def loop_that_never_ends_if_entered(x):
    while x[0] == 0:
        x[1] += 1
    return x[1]


@construct("void(float32[:, ::1], float32[::1], float32[::1])", MATRIX, ROW, COLUMN, mapped=True)
def sums_of_columns_and_rows(m, row, column):
    row[:] = m.sum(axis=0)
    column[:] = np.sum(m, 1) - m.sum() + row.sum(axis=-1)


@construct("void(int32[:, ::1], int32[::1], int32[::1])", LARGE, words(*range(4)), words(*range(9)))
def sums_along_an_axis_that_outgrow_a_word(m, high, low):
    sums = m.sum(0)
    for j in range(len(sums)):
        high[j] = sums[j] >> 16
    low[:] = np.sum(m, axis=-1)


@construct("float32(float32[:, :, ::1])", floats(3, 4, 5))
def sums_of_a_cube(x):
    middle = x.sum(axis=1)
    return middle[2, 4] - middle[0, 1] + x.sum(axis=(0, 1))[3]


@construct("int32(bool[:, ::1])", floats(5, 7) > 0)
def longest_row_of_flags(m):
    return np.int32(np.max(m.sum(axis=1)))


@construct("void(float32[::1], float32[::1], float32[:, ::1])", COLUMN, ROW, MATRIX, mapped=True)
def outer_product(x, y, m):
    np.outer(x, y, m)


@construct(
    "float32(float32[::1], uint8[::1], int32[:, ::1])", COLUMN, BYTES, np.ones((17, 17), np.int32)
)
def outer_products_of_other_types(x, b, m):
    m += np.outer(b, b)
    t = np.outer(x, b.astype(np.float32))
    return t[2, 16] + t[0, 1]


@construct("void(float32[::1], float32[::1])", V, W, mapped=True)
def where_larger(x, y):
    y[:] = np.where(x > y, x, np.float32(2) * y)


@construct("void(float32[:, ::1], float32[:, ::1])", MATRIX, floats(1, 5))
def where_rows_are_repeated(m, row):
    m[:] = np.where(m > 0.25, m, row)


@construct(
    "int32(int32[:, :, ::1], uint8)",
    np.arange(-9, 15, dtype=np.int32).reshape(2, 3, 4),
    np.uint8(200),
)
def where_of_scalars_and_types(x, b):
    t = np.where(x > 0, x, np.int32(-3))
    u = np.where(x[0] % 2 == 0, b, np.uint8(1))
    return t.sum() + u[2, 3] + u[1, 1]


UNORDERED = np.array([3, -1, 7, 7, 0, -5, 2, 9, 1, 4], np.int32)


@construct("void(int32[::1])", UNORDERED)
def sort_in_place(x):
    x.sort()


@construct("void(float32[::1], float32[::1])", np.float32([2, np.nan, -1, np.inf, 0.5]), floats(5))
def sorted_copy_with_a_nan(x, y):
    y[:] = np.sort(x)


@construct("void(uint8[::1], float32[::1], int32[::1])", BYTES, NONE, np.int32([5]))
def sorts_of_bytes_nothing_and_one(b, none, one):
    b[::-1].sort()
    none.sort()
    one.sort()


@construct("void(float32[:, ::1], float32[::1], float32[::1])", MATRIX, ROW, floats(5))
def columns_mean_and_largest(m, mean, largest):
    for j in range(m.shape[1]):
        mean[j] = m[:, j].mean()
        largest[j] = m[:, j].max()
