"""Kernels of slices and whole arrays, and arguments of sizes that agree or do not."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

import vividc
from vividc.frontend import KernelFunction

M, V = "float32[:, ::1]", "float32[::1]"


@vividc.kernel(f"void(float32, {M}, {M})")
def ranked(alpha, c, a):
    """syrk: rows up to the diagonal, which may be cut off or stretched."""
    for i in range(a.shape[0]):
        for k in range(a.shape[1]):
            c[i, : i + 1] += alpha * a[i, k] * a[: i + 1, k]


@vividc.kernel(f"void({M})")
def factors(a):
    """lu: inner products of slices."""
    for i in range(a.shape[0]):
        for j in range(i):
            a[i, j] -= a[i, :j] @ a[:j, j]
        for j in range(i, a.shape[0]):
            a[i, j] -= a[i, :i] @ a[:i, j]


@vividc.kernel(f"void(float32, {M}, {M})")
def behind(alpha, a, b):
    """trmm: slices behind the diagonal, whose lengths have to agree; effects before they do not."""
    b *= alpha
    for i in range(b.shape[0]):
        for j in range(b.shape[1]):
            b[i, j] += np.dot(a[i + 1 :, i], b[i + 1 :, j])


@vividc.kernel(f"void(float32, float32, {M}, {M}, {M})")
def products(alpha, beta, c, a, b):
    """gemm: arrays between products and sums."""
    c[:] = alpha * a @ b + beta * c


@vividc.kernel(f"{V}(float32, {M}, {V}, {V})")
def returned(alpha, a, x, y):
    return alpha * a @ x + y


@vividc.kernel(f"void({M}, {M})")
def apart(a, b):
    """fdtd: slices from both ends."""
    a[1:, :] -= b[1:, :] - b[:-1, :]


@vividc.kernel(f"void({M}, {V})")
def stretched(a, x):
    """Rows with one element less or more are refused, one element alone is stretched."""
    a[:] = a * np.float32(2) + x


@vividc.kernel(f"void({V}, {V}, {V})")
def changed_between(x, y, z):
    """What the array between is made of changes before it is read."""
    t = x * np.float32(2)
    x[:] = y
    z[:] = t + y


KERNELS = (
    ranked,
    factors,
    behind,
    products,
    returned,
    apart,
    stretched,
    changed_between,
)


def arguments(kernel: KernelFunction) -> Iterator[list[object]]:
    """Arguments with sizes that agree, then with others."""
    make: Callable[[np.random.Generator, Callable[[], int]], list[object]] = _MAKERS[kernel.name]
    rng = np.random.default_rng(3)
    for size in (0, 1, 2, 5):
        yield make(rng, lambda size=size: size)
    for _ in range(12):
        yield make(rng, lambda: int(rng.integers(0, 5)))


def _array(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return rng.integers(-3, 4, shape).astype(np.float32)


_TWO, _THREE = np.float32(2), np.float32(3)
_MAKERS = {
    "ranked": lambda rng, n: [_TWO, _array(rng, 6, n()), _array(rng, n(), n())],
    "factors": lambda rng, n: [_array(rng, n(), n())],
    "behind": lambda rng, n: [_TWO, _array(rng, n(), 6), _array(rng, n(), n())],
    "products": lambda rng, n: [_TWO, _THREE, *(_array(rng, n(), n()) for _ in range(3))],
    "returned": lambda rng, n: [_TWO, _array(rng, n(), n()), _array(rng, n()), _array(rng, n())],
    "apart": lambda rng, n: [_array(rng, n(), n()), _array(rng, n(), n())],
    "stretched": lambda rng, n: [_array(rng, n(), n()), _array(rng, n())],
    "changed_between": lambda rng, n: [_array(rng, n()) for _ in range(3)],
}
