"""Linear algebra as BLAS has it."""

import numpy as np

import vividc

V, M = "float32[::1]", "float32[:, ::1]"


@vividc.kernel(f"void(float32, float32, {M}, {M}, {M})")
def gemm(alpha, beta, c, a, b):
    """c = alpha * a @ b + beta * c."""
    ni, nj = c.shape
    for i in range(ni):
        for j in range(nj):
            c[i, j] *= beta
        for k in range(a.shape[1]):
            for j in range(nj):
                c[i, j] += alpha * a[i, k] * b[k, j]


@vividc.kernel(f"void(float32, float32, {M}, {V}, {V}, {V}, {V}, {V}, {V}, {V}, {V})")
def gemver(alpha, beta, a, u1, v1, u2, v2, w, x, y, z):
    """Adds two outer products to a; x = beta * a.T @ y + z, w = alpha * a @ x."""
    n = len(x)
    for i in range(n):
        for j in range(n):
            a[i, j] = a[i, j] + u1[i] * v1[j] + u2[i] * v2[j]
    for i in range(n):
        for j in range(n):
            x[i] = x[i] + beta * a[j, i] * y[j]
    for i in range(n):
        x[i] = x[i] + z[i]
    for i in range(n):
        for j in range(n):
            w[i] = w[i] + alpha * a[i, j] * x[j]


@vividc.kernel(f"void(float32, float32, {M}, {M}, {V}, {V}, {V})")
def gesummv(alpha, beta, a, b, tmp, x, y):
    """y = alpha * a @ x + beta * b @ x."""
    n = len(x)
    for i in range(n):
        tmp[i] = np.float32(0.0)
        y[i] = np.float32(0.0)
        for j in range(n):
            tmp[i] = a[i, j] * x[j] + tmp[i]
            y[i] = b[i, j] * x[j] + y[i]
        y[i] = alpha * tmp[i] + beta * y[i]


@vividc.kernel(f"void(float32, float32, {M}, {M}, {M})")
def symm(alpha, beta, c, a, b):
    """c = alpha * a @ b + beta * c, a symmetric and stored below its diagonal."""
    m, n = c.shape
    for i in range(m):
        for j in range(n):
            total = np.float32(0.0)
            for k in range(i):
                c[k, j] += alpha * b[i, j] * a[i, k]
                total += b[k, j] * a[i, k]
            c[i, j] = beta * c[i, j] + alpha * b[i, j] * a[i, i] + alpha * total


@vividc.kernel(f"void(float32, float32, {M}, {M}, {M})")
def syr2k(alpha, beta, c, a, b):
    """The lower half of c = alpha * (a @ b.T + b @ a.T) + beta * c."""
    n, m = a.shape
    for i in range(n):
        for j in range(i + 1):
            c[i, j] *= beta
        for k in range(m):
            for j in range(i + 1):
                c[i, j] += a[j, k] * alpha * b[i, k] + b[j, k] * alpha * a[i, k]


@vividc.kernel(f"void(float32, float32, {M}, {M})")
def syrk(alpha, beta, c, a):
    """The lower half of c = alpha * a @ a.T + beta * c."""
    n, m = a.shape
    for i in range(n):
        for j in range(i + 1):
            c[i, j] *= beta
        for k in range(m):
            for j in range(i + 1):
                c[i, j] += alpha * a[i, k] * a[j, k]


@vividc.kernel(f"void(float32, {M}, {M})")
def trmm(alpha, a, b):
    """b = alpha * a.T @ b, a unit and lower triangular."""
    m, n = b.shape
    for i in range(m):
        for j in range(n):
            for k in range(i + 1, m):
                b[i, j] += a[k, i] * b[k, j]
            b[i, j] = alpha * b[i, j]
