"""Dense and sparse linear algebra."""

import numpy as np

import vividc


@vividc.kernel("void(float32[:, ::1], float32[:, ::1], float32[:, ::1])")
def gemm(a, b, c):
    """c += a @ b."""
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            total = c[i, j]
            for k in range(a.shape[1]):
                total += a[i, k] * b[k, j]
            c[i, j] = total


@vividc.kernel("void(int32[:, ::1], int32[:, ::1], int32[:, ::1])")
def gemm_rows(a, b, c):
    """c += a @ b in the row order, over integers: the inner loop has no recurrence."""
    n, m = c.shape
    for i in range(n):
        for k in range(a.shape[1]):
            scale = a[i, k]
            for j in range(m):
                c[i, j] += scale * b[k, j]


@vividc.kernel("void(float32, float32[:, ::1], float32[::1], float32, float32[::1])")
def gemv(alpha, a, x, beta, y):
    """y = alpha * a @ x + beta * y (BLAS level 2)."""
    for i in range(a.shape[0]):
        total = np.float32(0.0)
        for j in range(a.shape[1]):
            total += a[i, j] * x[j]
        y[i] = alpha * total + beta * y[i]


@vividc.kernel("void(float32[:, ::1], float32[::1])")
def trmv(a, x):
    """x = lower(a) @ x in place, from the last row up (BLAS level 2)."""
    for i in range(len(x) - 1, -1, -1):
        total = np.float32(0.0)
        for j in range(i + 1):
            total += a[i, j] * x[j]
        x[i] = total


@vividc.kernel("void(float32[:, ::1], float32[::1])")
def solve_unit_lower(a, x):
    """Solves a @ y = x in place for a lower triangular a with ones on its diagonal."""
    for i in range(len(x)):
        for j in range(i):
            x[i] -= a[i, j] * x[j]


@vividc.kernel("void(float32, float32[::1], float32[::1], float32[:, ::1])")
def outer_product(alpha, x, y, a):
    """a += alpha * outer(x, y) (BLAS level 2)."""
    for i in range(x.shape[0]):
        for j in range(y.shape[0]):
            a[i, j] += alpha * x[i] * y[j]


@vividc.kernel("void(float32[:, ::1])")
def transpose(a):
    """Transposes a square matrix in place."""
    for i in range(a.shape[0]):
        for j in range(i + 1, a.shape[0]):
            a[i, j], a[j, i] = a[j, i], a[i, j]


@vividc.kernel("float32(float32[:, ::1])")
def norm_inf(a):
    """The largest row sum of absolute values."""
    best = np.float32(0.0)
    for i in range(a.shape[0]):
        total = np.float32(0.0)
        for j in range(a.shape[1]):
            total += abs(a[i, j])
        best = max(best, total)
    return best


@vividc.kernel("void(int32[::1], int32[::1], float32[::1], float32[::1], float32[::1])")
def spmv_csr(row_start, column, value, x, y):
    """y = a @ x for a sparse matrix in compressed rows."""
    for i in range(len(y)):
        total = np.float32(0.0)
        for k in range(row_start[i], row_start[i + 1]):
            total += value[k] * x[column[k]]
        y[i] = total
