"""Random kernels of array expressions with ends of slices from scalars, and arguments for them."""

from __future__ import annotations

import linecache
import random
from collections.abc import Iterator

import numpy as np

import vividc
from vividc.frontend import KernelFunction

_M, _V = "float32[:, ::1]", "float32[::1]"
_SIGNATURE = f"void(int64, int64, {_M}, {_M}, {_V}, {_V})"
_LOOPS = (
    "for i in range(n):",
    "for i in range(1, n - 1):",
    "for i in range(n - 2, 0, -1):",
    "for i in range(a.shape[0]):",
)
_LINES = (
    "a[1:n, 1:m] = b[: n - 1, : m - 1] * np.float32(2)",
    "a[1 : n - 1, 0] = x[: n - 2]",
    "b[:n, :m] += a[:n, :m] + b[:n, :m]",
    "y[:n] = a[:n, :m] @ x[:m]",
    "y[1:] = y[:-1] - y[1:]",
    "x[:] = np.sum(a, axis=0)",
    "t = x * np.float32(3)",
    "x[:] = t - x",
    "b -= t",
    "y += np.float32(2) * a @ x + b @ x",
    "x += y @ b",
    "a[:] = b + np.outer(y, x)",
    "b[0, 1 : m - 1] = np.float32(1)",
)
_INSIDE = (
    "a[i, :m] = a[i, :m] * np.float32(2) - b[i, :m]",
    "b[i, i:m] = a[:, i] @ b[:, i:m]",
    "a[i + 1 : n, i] = a[i, i + 1 : m] = b[i, i + 1 : m]",
    "y[i] = a[i, :i] @ x[:i]",
    "a[i, : i + 1] += b[i, i] * b[: i + 1, i]",
    "b[1 : n - 1, i] = a[1 : n - 1, i - 1] + b[1 : n - 1, i - 1]",
    "x[i] += y[i]",
    "a[i, 1 : m - 1] = a[i - 1, 1 : m - 1] - b[i, : m - 2] * b[i, 2:m]",
)


def kernel_of(seed: int) -> KernelFunction:
    """A kernel of a few such statements, in a loop or not."""
    chance = random.Random(seed)
    lines = ["def kernel(n, m, a, b, x, y):", "    t = x * np.float32(5)"]
    for _ in range(chance.randint(1, 4)):
        if chance.random() < 0.5:
            lines.append(f"    {chance.choice(_LOOPS)}")
            inside = chance.choices(_INSIDE, k=chance.randint(1, 2))
            lines += [f"        {line}" for line in inside]
        else:
            lines += [f"    {line}" for line in chance.choices(_LINES, k=chance.randint(1, 3))]
    source, name = "\n".join(lines) + "\n", f"<array expressions {seed}>"
    linecache.cache[name] = (len(source), None, source.splitlines(keepends=True), name)
    scope: dict[str, object] = {"np": np}
    exec(compile(source, name, "exec"), scope)
    return vividc.kernel(_SIGNATURE)(scope["kernel"])  # type: ignore[no-any-return, arg-type]


def arguments_of(seed: int) -> Iterator[list[object]]:
    """Sizes that agree, then others: scalars that are not the sizes, arrays that do not fit; no
    loop's index is outside an array, which means nothing.
    """
    rng = np.random.default_rng(seed)
    sizes = [(size,) * 6 for size in (1, 2, 3, 6)]
    sizes += [(5, 5, 6, 6, 6, 6), (-1, 2, 4, 4, 4, 4), (3, 4, 3, 4, 4, 3), (3, 9, 4, 4, 4, 4)]
    sizes += [tuple(int(one) for one in rng.integers(0, 5, 6)) for _ in range(4)]
    for n, m, rows, columns, of_x, of_y in sizes:
        least = min(rows, columns, of_x, of_y)
        shapes = ((rows, columns), (rows, columns), (of_x,), (of_y,))
        arrays = [rng.integers(-3, 4, shape).astype(np.float32) for shape in shapes]
        yield [min(n, least), m, *arrays]
