"""What the kernels start from: PolyBench's values, or such as keep the numbers of the same size."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Arguments = tuple[object, ...]
Floats = NDArray[np.float32]

ALPHA, BETA = np.float32(1.5), np.float32(1.2)


def ramp(*shape: int, shift: int = 0, by: int = 0) -> Floats:
    """The product of the subscripts (each from 1) and a shift, modulo `by`, as a fraction of it."""
    by = by or shape[0]
    product = np.ones(shape, np.int64)
    for axis, extent in enumerate(shape):
        product *= np.arange(1, extent + 1).reshape(
            [-1 if a == axis else 1 for a in range(len(shape))]
        )
    return ((product + shift) % by / by).astype(np.float32)


def zeros(*shape: int) -> Floats:
    """Where results go."""
    return np.zeros(shape, np.float32)


def definite(n: int) -> Floats:
    """A well-conditioned symmetric matrix, whose factors need no pivots."""
    lower = np.tril(-ramp(n, n, by=n) / n) + np.eye(n)
    return (lower @ lower.T).astype(np.float32)


def gemm(ni: int, nj: int, nk: int) -> Arguments:
    return ALPHA, BETA, ramp(ni, nj), ramp(ni, nk, by=nk), ramp(nk, nj, by=nj)


def gemver(n: int) -> Arguments:
    vectors = (ramp(n, shift=shift) for shift in range(4))
    return ALPHA, BETA, ramp(n, n), *vectors, zeros(n), zeros(n), ramp(n, shift=4), ramp(n, shift=5)


def gesummv(n: int) -> Arguments:
    return ALPHA, BETA, ramp(n, n), ramp(n, n, shift=1), zeros(n), ramp(n), zeros(n)


def symm(m: int, n: int) -> Arguments:
    return ALPHA, BETA, ramp(m, n, by=100), ramp(m, m, by=100), ramp(m, n, shift=n, by=100)


def syr2k(n: int, m: int) -> Arguments:
    return ALPHA, BETA, ramp(n, n, by=m), ramp(n, m), ramp(n, m, shift=2, by=m)


def syrk(n: int, m: int) -> Arguments:
    return ALPHA, BETA, ramp(n, n, by=m), ramp(n, m)


def trmm(m: int, n: int) -> Arguments:
    return ALPHA, ramp(m, m), ramp(m, n, shift=n, by=n)


def two_mm(ni: int, nj: int, nk: int, nl: int) -> Arguments:
    a, b, c, d = ramp(ni, nk), ramp(nk, nj, by=nj), ramp(nj, nl, by=nl), ramp(ni, nl, by=nk)
    return ALPHA, BETA, zeros(ni, nj), a, b, c, d


def three_mm(ni: int, nj: int, nk: int, nl: int, nm: int) -> Arguments:
    a, b, c, d = ramp(ni, nk), ramp(nk, nj, by=nj), ramp(nj, nm, by=nl), ramp(nm, nl, by=nk)
    return zeros(ni, nj), a, b, zeros(nj, nl), c, d, zeros(ni, nl)


def atax(m: int, n: int) -> Arguments:
    return ramp(m, n, by=5 * m), ramp(n), zeros(n), zeros(m)


def bicg(n: int, m: int) -> Arguments:
    return ramp(n, m), zeros(m), zeros(n), ramp(m), ramp(n)


def doitgen(nr: int, nq: int, np_: int) -> Arguments:
    return ramp(nr, nq, np_, by=np_), ramp(np_, np_), zeros(np_)


def mvt(n: int) -> Arguments:
    return *(ramp(n, shift=shift) for shift in range(4)), ramp(n, n)


def cholesky(n: int) -> Arguments:
    return (definite(n),)


def durbin(n: int) -> Arguments:
    """Correlations that decay."""
    return (0.7 ** np.arange(1, n + 1) + 0.01).astype(np.float32), zeros(n), zeros(n)


def gramschmidt(m: int, n: int) -> Arguments:
    a = ramp(m, n) + 2 * np.eye(m, n, dtype=np.float32)
    return a, zeros(n, n), zeros(m, n)


lu = cholesky


def ludcmp(n: int) -> Arguments:
    return definite(n), ramp(n, by=2 * n) + np.float32(4.0), zeros(n), zeros(n)


def trisolv(n: int) -> Arguments:
    return np.tril(ramp(n, n, by=2 * n) / n + np.eye(n, dtype=np.float32)), zeros(n), ramp(n)


def correlation(n: int, m: int) -> Arguments:
    data = ramp(n, m, by=m) + np.arange(n, dtype=np.float32)[:, None] / np.float32(n)
    return np.float32(n), data, zeros(m, m), zeros(m), zeros(m)


def covariance(n: int, m: int) -> Arguments:
    return np.float32(n), ramp(n, m, by=m), zeros(m, m), zeros(m)


def deriche(w: int, h: int) -> Arguments:
    image = (np.arange(w)[:, None] * 313 + np.arange(h) * 991) % 65536 / 65535
    return np.float32(0.25), image.astype(np.float32), zeros(w, h), zeros(w, h), zeros(w, h)


def floyd_warshall(n: int) -> Arguments:
    i, j = np.ogrid[:n, :n]
    paths = i * j % 7 + 1
    paths[((i + j) % 13 == 0) | ((i + j) % 7 == 0) | ((i + j) % 11 == 0)] = 999
    return (paths.astype(np.int32),)


def nussinov(n: int) -> Arguments:
    return (np.arange(1, n + 1, dtype=np.int32) % 4, np.zeros((n, n), np.int32))


def adi(steps: int, n: int) -> Arguments:
    i, j = np.ogrid[:n, :n]
    u = ((i + n - j) / n).astype(np.float32)
    return np.int32(steps), u, zeros(n, n), zeros(n, n), zeros(n, n)


def fdtd_2d(steps: int, nx: int, ny: int) -> Arguments:
    fields = (ramp(nx, ny, shift=shift) for shift in range(3))
    return *fields, np.arange(steps, dtype=np.float32)


def heat_3d(steps: int, n: int) -> Arguments:
    i, j, k = np.ogrid[:n, :n, :n]
    a = ((i + j + n - k) * 10 / n).astype(np.float32)
    return np.int32(steps), a, a.copy()


def jacobi_1d(steps: int, n: int) -> Arguments:
    i = np.arange(n, dtype=np.float32)
    return np.int32(steps), (i + 2) / np.float32(n), (i + 3) / np.float32(n)


def jacobi_2d(steps: int, n: int) -> Arguments:
    i, j = np.ogrid[:n, :n]
    a, b = (i * (j + 2) + 2) / n, (i * (j + 3) + 3) / n
    return np.int32(steps), a.astype(np.float32), b.astype(np.float32)


def seidel_2d(steps: int, n: int) -> Arguments:
    return jacobi_2d(steps, n)[:2]


def bilateral(n: int) -> Arguments:
    y, x = np.ogrid[-2:3, -2:3]
    near = np.exp(-(x * x + y * y) / 4).astype(np.float32)
    return np.float32(3.0), near, ramp(n + 4, n + 4), zeros(n, n)


def bicubic(n: int) -> Arguments:
    return np.float32(0.5), ramp(n // 2 + 3, n // 2 + 3), zeros(n, n)


def separable_blur(n: int, taps: int) -> Arguments:
    image = ramp(n + taps - 1, n + taps - 1)
    return ramp(taps), image, zeros(n + taps - 1, n), zeros(n, n)


def sphere_tracer(n: int) -> Arguments:
    spheres = [[0, 0, 4, 1], [1.5, 0.5, 5, 0.75], [-1.5, 0, 3, 0.5], [0, -1.5, 4, 0.5]]
    return np.array(spheres, np.float32), zeros(n, n)


INPUTS: dict[str, Callable[..., Arguments]] = {
    maker.__name__: maker
    for maker in (
        gemm, gemver, gesummv, symm, syr2k, syrk, trmm,
        two_mm, three_mm, atax, bicg, doitgen, mvt,
        cholesky, durbin, gramschmidt, ludcmp, trisolv,
        correlation, covariance,
        deriche, floyd_warshall, nussinov,
        adi, fdtd_2d, heat_3d, jacobi_1d, jacobi_2d, seidel_2d,
        bilateral, bicubic, separable_blur, sphere_tracer,
    )
}  # fmt: skip
"""By the name of the kernel; each takes its sizes and makes the same arguments at every call."""
INPUTS["lu"] = lu
