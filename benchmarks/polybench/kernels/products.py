"""Products of several matrices and vectors."""

import numpy as np

import vividc

V, M = "float32[::1]", "float32[:, ::1]"


@vividc.kernel(f"void(float32, float32, {M}, {M}, {M}, {M}, {M})")
def two_mm(alpha, beta, tmp, a, b, c, d):
    """d = alpha * a @ b @ c + beta * d."""
    ni, nj = tmp.shape
    for i in range(ni):
        for j in range(nj):
            tmp[i, j] = np.float32(0.0)
            for k in range(a.shape[1]):
                tmp[i, j] += alpha * a[i, k] * b[k, j]
    for i in range(ni):
        for j in range(d.shape[1]):
            d[i, j] *= beta
            for k in range(nj):
                d[i, j] += tmp[i, k] * c[k, j]


@vividc.kernel(f"void({M}, {M}, {M}, {M}, {M}, {M}, {M})")
def three_mm(e, a, b, f, c, d, g):
    """g = (a @ b) @ (c @ d)."""
    ni, nj = e.shape
    nl = f.shape[1]
    for i in range(ni):
        for j in range(nj):
            e[i, j] = np.float32(0.0)
            for k in range(a.shape[1]):
                e[i, j] += a[i, k] * b[k, j]
    for i in range(nj):
        for j in range(nl):
            f[i, j] = np.float32(0.0)
            for k in range(c.shape[1]):
                f[i, j] += c[i, k] * d[k, j]
    for i in range(ni):
        for j in range(nl):
            g[i, j] = np.float32(0.0)
            for k in range(nj):
                g[i, j] += e[i, k] * f[k, j]


@vividc.kernel(f"void({M}, {V}, {V}, {V})")
def atax(a, x, y, tmp):
    """y = a.T @ (a @ x)."""
    m, n = a.shape
    for i in range(n):
        y[i] = np.float32(0.0)
    for i in range(m):
        tmp[i] = np.float32(0.0)
        for j in range(n):
            tmp[i] = tmp[i] + a[i, j] * x[j]
        for j in range(n):
            y[j] = y[j] + a[i, j] * tmp[i]


@vividc.kernel(f"void({M}, {V}, {V}, {V}, {V})")
def bicg(a, s, q, p, r):
    """s = a.T @ r, q = a @ p."""
    n, m = a.shape
    for i in range(m):
        s[i] = np.float32(0.0)
    for i in range(n):
        q[i] = np.float32(0.0)
        for j in range(m):
            s[j] = s[j] + r[i] * a[i, j]
            q[i] = q[i] + a[i, j] * p[j]


@vividc.kernel(f"void(float32[:, :, ::1], {M}, {V})")
def doitgen(a, c4, total):
    """a[r, q] = a[r, q] @ c4 for every r and q."""
    nr, nq, np_ = a.shape
    for r in range(nr):
        for q in range(nq):
            for p in range(np_):
                total[p] = np.float32(0.0)
                for s in range(np_):
                    total[p] += a[r, q, s] * c4[s, p]
            for p in range(np_):
                a[r, q, p] = total[p]


@vividc.kernel(f"void({V}, {V}, {V}, {V}, {M})")
def mvt(x1, x2, y1, y2, a):
    """x1 += a @ y1, x2 += a.T @ y2."""
    n = len(x1)
    for i in range(n):
        for j in range(n):
            x1[i] = x1[i] + a[i, j] * y1[j]
    for i in range(n):
        for j in range(n):
            x2[i] = x2[i] + a[j, i] * y2[j]
