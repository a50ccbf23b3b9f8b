"""Arrays: shapes, indices, slices, arrays of the kernel's own."""

import numpy as np

from tests.e2e.constructs.registry import A, construct, floats

SIZE = 8
MATRIX = np.arange(12, dtype=np.int32).reshape(3, 4)
CUBE = np.arange(24, dtype=np.int32).reshape(2, 3, 4)


@construct("int32(int32[:, ::1])", MATRIX)
def shape_unpacking(m):
    rows, columns = m.shape
    return np.int32(rows * 100 + columns)


@construct("int32(int32[:, :, ::1])", CUBE)
def shape_fields(m):
    return np.int32(
        m.shape[0] + 10 * m.shape[1] + 100 * m.shape[-1] + 1000 * m.ndim + 10000 * m.size
    )


@construct("int32(int32[:, ::1])", MATRIX)
def length_of_rows(m):
    return np.int32(len(m) * 10 + len(m[0]))


@construct("void(int32[:, ::1])", MATRIX, mapped=True)
def index_pair(m):
    for i in range(m.shape[0]):
        for j in range(m.shape[1]):
            m[i, j] += i - j


@construct("void(int32[:, ::1])", MATRIX)
def index_chain(m):
    for i in range(m.shape[0]):
        for j in range(m.shape[1]):
            m[i][j] *= 2


@construct("void(int32[:, :, ::1])", CUBE)
def index_triple(m):
    for i in range(m.shape[0]):
        for j in range(m.shape[1]):
            for k in range(m.shape[2]):
                m[i, j, k] += m[i][j][k]


@construct("void(int32[:, ::1])", MATRIX)
def row_as_array(m):
    for i in range(m.shape[0]):
        row = m[i]
        for j in range(row.shape[0]):
            row[j] = row[j] + i


@construct("void(int32[:, ::1])", MATRIX)
def row_slice(m):
    for i in range(m.shape[0]):
        row = m[i, :]
        for j in range(row.size):
            row[j] = -row[j]


@construct("void(int32[:, ::1])", MATRIX)
def column_slice(m):
    column = m[:, 1]
    for i in range(len(column)):
        column[i] = 100 + i


@construct("void(int32[::1])", A)
def constant_slice(x):
    part = x[2:6]
    for i in range(len(part)):
        part[i] = i


@construct("void(int32[::1], int32)", A, 3)
def open_slice(x, n):
    part = x[n:]
    for i in range(len(part)):
        part[i] += 10


@construct("void(int32[::1])", A)
def stepped_slice(x):
    part = x[::2]
    for i in range(len(part)):
        part[i] = 0


@construct("void(int32[::1])", A)
def negative_index(x):
    x[-1] = x[-2] + x[0]


@construct("void(int32[::1])", A)
def negative_variable_index(x):
    for i in range(1, len(x)):
        x[-i] += i


@construct("void(int32[::1])", A, mapped=True)
def fill_by_slice(x):
    x[:] = 3


@construct("void(int32[::1])", A)
def fill_part_by_slice(x):
    x[1:4] = 7


@construct("void(int32[::1])", A)
def fill_method(x):
    x.fill(4)


@construct("void(int32[:, ::1])", MATRIX)
def fill_row(m):
    m[1] = 5
    m[2, :] = 6


@construct("int32(int32[::1])", A)
def sum_function(x):
    return np.int32(np.sum(x))


@construct("int32(int32[::1])", A)
def sum_method(x):
    return np.int32(x.sum())


@construct("float32(float32[::1])", floats(9))
def float_sum(x):
    return np.float32(x.sum())


@construct("void(int32[:, ::1])", MATRIX)
def ravel(m):
    flat = m.ravel()
    for i in range(len(flat)):
        flat[i] += 1


@construct("void(int32[::1])", A)
def local_reshaped(x):
    a = np.zeros(8, np.int32)
    m = a.reshape(2, 4)
    for i in range(8):
        a[i] = x[i]
    for j in range(4):
        x[j] = m[1, j] - m[0, j]


@construct("void(int32[:, ::1], int32[:, ::1])", MATRIX, np.zeros((4, 3), np.int32))
def transposed(m, out):
    t = m.T
    for i in range(t.shape[0]):
        for j in range(t.shape[1]):
            out[i, j] = t[i, j]


@construct("void(int32[:, ::1])", MATRIX)
def ndindex(m):
    for i, j in np.ndindex(m.shape):
        m[i, j] = i * 10 + j


@construct("void(int32[::1])", A)
def ndenumerate(x):
    total = np.int32(0)
    for index, value in np.ndenumerate(x):
        total += value * np.int32(index[0])
    x[0] = total


@construct("void(int32[::1])", A, mapped=True)
def local_zeros(x):
    counts = np.zeros(16, np.int32)
    for i in range(len(x)):
        counts[x[i] & 15] += 1
    for i in range(len(x)):
        x[i] = counts[i]


@construct("void(int32[::1])", A, mapped=True)
def local_zeros_again(x):
    for i in range(len(x)):
        a = np.zeros(4, np.int32)
        a[i & 3] += x[i]
        a[1] += 1
        x[i] = a[0] + a[1] * 10 + a[2] * 100 + a[3] * 1000


@construct("void(int32[::1])", A)
def local_empty(x):
    a = np.empty(SIZE, np.int32)
    for i in range(SIZE):
        a[i] = x[SIZE - 1 - i]
    for i in range(SIZE):
        x[i] = a[i]


@construct("void(float32[::1])", floats(8))
def local_ones_and_full(x):
    a = np.ones(8, np.float32)
    b = np.full(8, np.float32(0.5), np.float32)
    for i in range(8):
        x[i] = x[i] * a[i] + b[i]


@construct("void(int32[::1])", A)
def local_matrix(x):
    m = np.zeros((2, 4), np.int32)
    for i in range(2):
        for j in range(4):
            m[i, j] = x[i * 4 + j] + i
    for j in range(4):
        x[j] = m[0, j] * m[1, j]


@construct("void(int32[::1])", A)
def local_like(x):
    a = np.full((2, 4), 3, np.int32)
    b = np.zeros_like(a)
    c = np.ones_like(a)
    b[1, 2] = 5
    for i in range(8):
        x[i] += a[i & 1, i & 3] + b[i & 1, i & 3] + c[0, 0]


@construct("void(int32[::1])", A)
def local_booleans(x):
    seen = np.zeros(16, np.bool_)
    for i in range(len(x)):
        seen[x[i] & 15] = True
    for i in range(len(x)):
        if seen[i]:
            x[i] = 1


@construct("void(int32[::1])", A)
def local_bytes(x):
    a = np.zeros(8, np.uint8)
    b = np.zeros(8, np.int16)
    for i in range(8):
        a[i] = x[i]
        b[i] = x[i] * 10000
    for i in range(8):
        x[i] = a[i] + b[i]


@construct("void(int32[::1])", A)
def local_row(x):
    m = np.zeros((3, 4), np.int32)
    m[1] = 4
    row = m[2]
    for j in range(4):
        row[j] = x[j]
    for j in range(4):
        x[j] = m[1, j] + m[2, j]


@construct("void(int32[::1])", A)
def local_copy(x):
    a = np.empty(8, np.int32)
    for i in range(8):
        a[i] = x[i]
    b = a.copy()
    c = np.empty(8, np.int32)
    c[:] = a
    c[2:4] = b[4:6]
    for i in range(8):
        a[i] = 0
        x[i] = a[i] + b[7 - i] + 10 * c[i]


@construct("void(int32[::1])", A)
def local_arange(x):
    a = np.arange(8, dtype=np.int32)
    for i in range(8):
        x[i] = np.int32(a[i]) * 3


@construct("void(int32[::1])", A)
def local_expression(x):
    a = np.full(4, 2, np.int32)
    b = np.full(4, 3, np.int32)
    c = a * b + a
    for i in range(4):
        x[i] = np.int32(c[i])


@construct("void(int32[::1])", A)
def local_stack(x):
    stack = np.empty(32, np.int32)
    top = 0
    for i in range(len(x)):
        stack[top] = x[i]
        top += 1
    i = 0
    while top > 0:
        top -= 1
        x[i] = stack[top]
        i += 1


@construct("void(float32[::1])", floats(6))
def whole_array_update(x):
    x += np.float32(1)
    x *= np.float32(2)


@construct("void(int32[::1])", A)
def array_attribute_of_argument(x):
    x[0] = x.size + x.ndim + x.itemsize + x.nbytes
