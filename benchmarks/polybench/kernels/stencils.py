"""Stencils."""

import numpy as np

import vividc

V, M, A = "float32[::1]", "float32[:, ::1]", "float32[:, :, ::1]"
ZERO, ONE, TWO = np.float32(0.0), np.float32(1.0), np.float32(2.0)
THIRD, FIFTH, EIGHTH = np.float32(0.33333), np.float32(0.2), np.float32(0.125)
HALF, SEVEN_TENTHS, NINE = np.float32(0.5), np.float32(0.7), np.float32(9.0)


@vividc.kernel(f"void(int32, {M}, {M}, {M}, {M})")
def adi(steps, u, v, p, q):
    """Heat in a plane, implicit by columns and by rows in turn."""
    n = u.shape[0]
    width = ONE / np.float32(n)
    mul1 = TWO / np.float32(steps) / (width * width)
    mul2 = ONE / np.float32(steps) / (width * width)
    a = -mul1 / TWO
    b = ONE + mul1
    d = -mul2 / TWO
    e = ONE + mul2
    for _ in range(steps):
        for i in range(1, n - 1):
            v[0, i] = ONE
            p[i, 0] = ZERO
            q[i, 0] = v[0, i]
            for j in range(1, n - 1):
                p[i, j] = -a / (a * p[i, j - 1] + b)
                right = -d * u[j, i - 1] + (ONE + TWO * d) * u[j, i] - d * u[j, i + 1]
                q[i, j] = (right - a * q[i, j - 1]) / (a * p[i, j - 1] + b)
            v[n - 1, i] = ONE
            for j in range(n - 2, 0, -1):
                v[j, i] = p[i, j] * v[j + 1, i] + q[i, j]
        for i in range(1, n - 1):
            u[i, 0] = ONE
            p[i, 0] = ZERO
            q[i, 0] = u[i, 0]
            for j in range(1, n - 1):
                p[i, j] = -d / (d * p[i, j - 1] + e)
                right = -a * v[i - 1, j] + (ONE + TWO * a) * v[i, j] - a * v[i + 1, j]
                q[i, j] = (right - d * q[i, j - 1]) / (d * p[i, j - 1] + e)
            u[i, n - 1] = ONE
            for j in range(n - 2, 0, -1):
                u[i, j] = p[i, j] * u[i, j + 1] + q[i, j]


@vividc.kernel(f"void({M}, {M}, {M}, {V})")
def fdtd_2d(ex, ey, hz, source):
    """An electromagnetic field in a plane, a step for each word of the source."""
    nx, ny = hz.shape
    for t in range(len(source)):
        for j in range(ny):
            ey[0, j] = source[t]
        for i in range(1, nx):
            for j in range(ny):
                ey[i, j] = ey[i, j] - HALF * (hz[i, j] - hz[i - 1, j])
        for i in range(nx):
            for j in range(1, ny):
                ex[i, j] = ex[i, j] - HALF * (hz[i, j] - hz[i, j - 1])
        for i in range(nx - 1):
            for j in range(ny - 1):
                curl = ex[i, j + 1] - ex[i, j] + ey[i + 1, j] - ey[i, j]
                hz[i, j] = hz[i, j] - SEVEN_TENTHS * curl


@vividc.kernel(f"void(int32, {A}, {A})")
def heat_3d(steps, a, b):
    """Heat in a volume, two steps at a time."""
    n = a.shape[0]
    for _ in range(steps):
        for i in range(1, n - 1):
            for j in range(1, n - 1):
                for k in range(1, n - 1):
                    b[i, j, k] = (
                        EIGHTH * (a[i + 1, j, k] - TWO * a[i, j, k] + a[i - 1, j, k])
                        + EIGHTH * (a[i, j + 1, k] - TWO * a[i, j, k] + a[i, j - 1, k])
                        + EIGHTH * (a[i, j, k + 1] - TWO * a[i, j, k] + a[i, j, k - 1])
                        + a[i, j, k]
                    )
        for i in range(1, n - 1):
            for j in range(1, n - 1):
                for k in range(1, n - 1):
                    a[i, j, k] = (
                        EIGHTH * (b[i + 1, j, k] - TWO * b[i, j, k] + b[i - 1, j, k])
                        + EIGHTH * (b[i, j + 1, k] - TWO * b[i, j, k] + b[i, j - 1, k])
                        + EIGHTH * (b[i, j, k + 1] - TWO * b[i, j, k] + b[i, j, k - 1])
                        + b[i, j, k]
                    )


@vividc.kernel(f"void(int32, {V}, {V})")
def jacobi_1d(steps, a, b):
    """Means of three neighbours, two steps at a time."""
    n = len(a)
    for _ in range(steps):
        for i in range(1, n - 1):
            b[i] = THIRD * (a[i - 1] + a[i] + a[i + 1])
        for i in range(1, n - 1):
            a[i] = THIRD * (b[i - 1] + b[i] + b[i + 1])


@vividc.kernel(f"void(int32, {M}, {M})")
def jacobi_2d(steps, a, b):
    """Means of five neighbours, two steps at a time."""
    n = a.shape[0]
    for _ in range(steps):
        for i in range(1, n - 1):
            for j in range(1, n - 1):
                b[i, j] = FIFTH * (a[i, j] + a[i, j - 1] + a[i, j + 1] + a[i + 1, j] + a[i - 1, j])
        for i in range(1, n - 1):
            for j in range(1, n - 1):
                a[i, j] = FIFTH * (b[i, j] + b[i, j - 1] + b[i, j + 1] + b[i + 1, j] + b[i - 1, j])


@vividc.kernel(f"void(int32, {M})")
def seidel_2d(steps, a):
    """Means of nine neighbours, in place."""
    n = a.shape[0]
    for _ in range(steps):
        for i in range(1, n - 1):
            for j in range(1, n - 1):
                above = a[i - 1, j - 1] + a[i - 1, j] + a[i - 1, j + 1]
                row = above + a[i, j - 1] + a[i, j] + a[i, j + 1]
                a[i, j] = (row + a[i + 1, j - 1] + a[i + 1, j] + a[i + 1, j + 1]) / NINE
