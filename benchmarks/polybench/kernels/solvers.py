"""Factorisations and solvers."""

import math

import numpy as np

import vividc

V, M = "float32[::1]", "float32[:, ::1]"


@vividc.kernel(f"void({M})")
def cholesky(a):
    """The lower factor of a positive definite matrix, in place."""
    for i in range(a.shape[0]):
        for j in range(i):
            for k in range(j):
                a[i, j] -= a[i, k] * a[j, k]
            a[i, j] /= a[j, j]
        for k in range(i):
            a[i, i] -= a[i, k] * a[i, k]
        a[i, i] = math.sqrt(a[i, i])


@vividc.kernel(f"void({V}, {V}, {V})")
def durbin(r, y, z):
    """Solves a Yule-Walker system of equations."""
    y[0] = -r[0]
    beta = np.float32(1.0)
    alpha = -r[0]
    for k in range(1, len(r)):
        beta = (np.float32(1.0) - alpha * alpha) * beta
        total = np.float32(0.0)
        for i in range(k):
            total += r[k - i - 1] * y[i]
        alpha = -(r[k] + total) / beta
        for i in range(k):
            z[i] = y[i] + alpha * y[k - i - 1]
        for i in range(k):
            y[i] = z[i]
        y[k] = alpha


@vividc.kernel(f"void({M}, {M}, {M})")
def gramschmidt(a, r, q):
    """a = q @ r by the modified Gram-Schmidt process."""
    m, n = a.shape
    for k in range(n):
        norm = np.float32(0.0)
        for i in range(m):
            norm += a[i, k] * a[i, k]
        r[k, k] = math.sqrt(norm)
        for i in range(m):
            q[i, k] = a[i, k] / r[k, k]
        for j in range(k + 1, n):
            r[k, j] = np.float32(0.0)
            for i in range(m):
                r[k, j] += q[i, k] * a[i, j]
            for i in range(m):
                a[i, j] = a[i, j] - q[i, k] * r[k, j]


@vividc.kernel(f"void({M})")
def lu(a):
    """The factors of a matrix without pivoting, in place."""
    n = a.shape[0]
    for i in range(n):
        for j in range(i):
            for k in range(j):
                a[i, j] -= a[i, k] * a[k, j]
            a[i, j] /= a[j, j]
        for j in range(i, n):
            for k in range(i):
                a[i, j] -= a[i, k] * a[k, j]


@vividc.kernel(f"void({M}, {V}, {V}, {V})")
def ludcmp(a, b, x, y):
    """Solves a @ x = b by factors without pivoting."""
    n = a.shape[0]
    for i in range(n):
        for j in range(i):
            w = a[i, j]
            for k in range(j):
                w -= a[i, k] * a[k, j]
            a[i, j] = w / a[j, j]
        for j in range(i, n):
            w = a[i, j]
            for k in range(i):
                w -= a[i, k] * a[k, j]
            a[i, j] = w
    for i in range(n):
        w = b[i]
        for j in range(i):
            w -= a[i, j] * y[j]
        y[i] = w
    for i in range(n - 1, -1, -1):
        w = y[i]
        for j in range(i + 1, n):
            w -= a[i, j] * x[j]
        x[i] = w / a[i, i]


@vividc.kernel(f"void({M}, {V}, {V})")
def trisolv(lower, x, b):
    """Solves lower @ x = b for a lower triangular matrix."""
    for i in range(len(x)):
        x[i] = b[i]
        for j in range(i):
            x[i] -= lower[i, j] * x[j]
        x[i] = x[i] / lower[i, i]
