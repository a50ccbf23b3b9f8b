"""What messages about refused functions of numpy advise: it compiles, and gives their values."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from tests.e2e.constructs.registry import Construct
from tests.e2e.test_constructs import interpreted
from vividc.frontend import KernelFunction
from vividc.frontend.refused.numpy import hints

X = np.array([3, 1, 4, 1, 5, 9, 2, 6], np.float32)
Y = np.array([2, 7, 1, 8], np.float32)
PLACES = np.array([3, 0, 3], np.int64)


@dataclass(frozen=True)
class Instead:
    """A kernel of (x, y, out) that does what a hint says, and what numpy gives."""

    function: Callable[..., None]
    expected: Callable[[Any, Any], Any]


INSTEAD: dict[str, Instead] = {}


def instead(
    of: str, expected: Callable[[Any, Any], Any]
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Register the kernel for numpy's functions of these names."""

    def register(function: Callable[..., None]) -> Callable[..., None]:
        for name in of.split():
            assert name not in INSTEAD
            INSTEAD[name] = Instead(function, expected)
        return function

    return register


@instead("argsort argpartition", lambda x, _: np.argsort(x, kind="stable"))
def order_by_insertion(x, y, out):
    order = np.arange(len(x))
    for i in range(1, len(x)):
        k = i
        while k > 0 and x[order[k - 1]] > x[i]:
            order[k] = order[k - 1]
            k -= 1
        order[k] = i
    for i in range(len(x)):
        out[i] = order[i]


@instead("median nanmedian percentile nanpercentile", lambda x, _: np.sort(x)[4])
@instead("quantile nanquantile", lambda x, _: np.sort(x)[4])
def element_of_the_sorted(x, y, out):
    s = np.sort(x)
    out[0] = s[len(s) // 2]


@instead("partition", lambda x, _: np.sort(x))
def sorted_whole(x, y, out):
    out[:] = np.sort(x)


@instead("unique union1d", lambda x, _: np.unique(x))
def distinct(x, y, out):
    s = np.sort(x)
    count = 0
    for i in range(len(s)):
        if i == 0 or s[i] != s[i - 1]:
            out[count] = s[i]
            count += 1


@instead("intersect1d in1d isin setdiff1d setxor1d", lambda x, y: x[np.isin(x, y)])
def members(x, y, out):
    count = 0
    for i in range(len(x)):
        if x[i] in y:
            out[count] = x[i]
            count += 1


@instead("argwhere extract flatnonzero nonzero where", lambda x, _: np.nonzero(x > 2)[0])
def places(x, y, out):
    found = np.zeros(len(x), np.int32)
    count = 0
    for i in range(len(x)):
        if x[i] > 2:
            found[count] = i
            count += 1
    for i in range(count):
        out[i] = found[i]


@instead("moveaxis rollaxis rot90", lambda x, _: x.reshape(2, 4).T.ravel())
def exchanged(x, y, out):
    m = x.reshape((2, 4))
    for i in range(4):
        for j in range(2):
            out[2 * i + j] = m[j, i]


@instead("bincount", lambda x, _: np.bincount(x.astype(int)))
def occurrences(x, y, out):
    counts = np.zeros(10, np.int32)
    x = x.astype(np.int32)
    for i in range(len(x)):
        counts[x[i]] += 1
    for i in range(10):
        out[i] = counts[i]


@instead("histogram", lambda x, _: np.histogram(x, 4, (1, 9))[0])
def bins_of_one_width(x, y, out):
    bins, low, scale = 4, np.float32(1), np.float32(0.5)
    counts = np.zeros(bins, np.int32)
    for i in range(len(x)):
        counts[min(int((x[i] - low) * scale), bins - 1)] += 1
    for i in range(bins):
        out[i] = counts[i]


@instead("digitize", lambda x, y: np.digitize(x, np.sort(y)))
def edges_below(x, y, out):
    edges = np.sort(y)
    for i in range(len(x)):
        out[i] = np.searchsorted(edges, x[i], side="right")


@instead("array_split hsplit split vsplit", lambda x, _: x[:4] + 2 * x[4:])
def halves(x, y, out):
    out[:4] = x[:4] + np.float32(2) * x[4:]


@instead("interp", lambda x, y: np.interp([1.5, 2.5, 6.5], np.sort(y), [0, 1, 4, 9]))
def interpolated(x, y, out):
    at = np.sort(y)
    y = np.array((0, 1, 4, 9), np.float32)
    wanted = np.array((1.5, 2.5, 6.5), np.float32)
    for i in range(3):
        v = wanted[i]
        k = np.searchsorted(at, v)
        out[i] = y[k - 1] + (y[k] - y[k - 1]) * (v - at[k - 1]) / (at[k] - at[k - 1])


@instead("convolve", np.convolve)
def convolved(x, h, y):
    for i in range(len(x)):
        for j in range(len(h)):
            y[i + j] += x[i] * h[j]


@instead("correlate", np.correlate)
def correlated(x, h, y):
    for i in range(len(x) - len(h) + 1):
        for j in range(len(h)):
            y[i] += x[i + j] * h[j]


@instead("delete", lambda x, _: np.delete(x, 3))
def without_one(x, _, y):
    at = 3
    for i in range(len(x) - 1):
        y[i] = x[i] if i < at else x[i + 1]


@instead("allclose isclose", lambda x, y: np.isclose(x[:4] + 1e-5 * (y > 3), y + (x[:4] > 3)))
def near(x, y, out):
    for i in range(len(y)):
        x[i] += np.float32(1e-5) * (y[i] > 3)
        y[i] += x[i] > 3.5
        out[i] = np.isclose(x[i], y[i])


@instead("take", lambda x, _: np.take(x, PLACES))
def taken(x, y, out):
    places = np.array((3, 0, 3))
    out[:3] = x[places]


@instead("sort", lambda x, _: np.sort(x.reshape(2, 4), axis=1).ravel())
def rows_sorted(x, y, out):
    m = x.reshape((2, 4))
    for i in range(2):
        out[4 * i : 4 * i + 4] = np.sort(m[i])


@instead(
    "all amax amin any argmax argmin cumprod cumsum max mean min prod",
    lambda x, _: np.concatenate([x.reshape(2, 4).max(axis=1), x.reshape(2, 4).argmin(axis=1)]),
)
def along_rows(x, y, out):
    m = x.reshape((2, 4))
    for i in range(2):
        out[i] = m[i].max()
        out[i + 2] = m[i].argmin()


@instead("resize tile", lambda x, _: np.resize(x, 13))
def repeated(x, _, y):
    for i in range(13):
        y[i] = x[i % len(x)]


@instead("einsum inner matmul tensordot", lambda x, y: np.inner(x[:4], y))
def product(x, y, out):
    a, b = x[:4], y
    out[0] = np.dot(a, b)


@instead("round", lambda x, _: np.round(x / 2))
def rounded(x, y, out):
    x = x / np.float32(2)
    out[: len(x)] = np.round(x)


@instead("heaviside", lambda x, _: np.heaviside(x - 3, 1))
def step(x, y, out):
    x = x - np.float32(3)
    out[: len(x)] = np.where(x < 0, 0, 1)


@instead("squeeze", lambda x, _: np.squeeze(x.reshape(1, 8)))
def one_row(x, y, out):
    m = x.reshape((1, 8))
    out[:8] = m[0]


@instead("pad", lambda x, _: np.pad(x, 1))
def padded(x, _, y):
    for i in range(len(x)):
        y[i + 1] = x[i]


@instead("clip", lambda x, _: np.clip(x[2], 1, 3))
def clipped(x, y, out):
    v, low, high = x[2], np.float32(1), np.float32(3)
    out[0] = min(max(v, low), high)


@instead("gradient", lambda x, _: np.concatenate([[0], np.gradient(x)[1:-1]]))
def slopes(x, _, y):
    for i in range(1, len(x) - 1):
        y[i] = (x[i + 1] - x[i - 1]) / 2


FUNCTIONS = list(dict.fromkeys(case.function for case in INSTEAD.values()))


def code_of(hint: str) -> list[str]:
    return re.findall("`([^`]+)`", hint)


def test_every_hint_with_code_is_run() -> None:
    assert {name for name, hint in hints().items() if code_of(hint)} == set(INSTEAD)


@pytest.mark.filterwarnings("ignore::vividc.VividcWarning")
@pytest.mark.parametrize(
    "function", list({case.function: 0 for case in INSTEAD.values()}), ids=lambda f: f.__name__
)
def test_a_hint_gives_what_the_refused_function_does(function: Callable[..., None]) -> None:
    names = [name for name, case in INSTEAD.items() if case.function is function]
    source = inspect.getsource(function)
    for name in names:
        missing = [code for code in code_of(hints()[name]) if code not in source]
        assert not missing, f"{name}: {missing}"
    case = INSTEAD[names[0]]
    expected = np.atleast_1d(case.expected(X, Y)).astype(np.float32)
    kernel = KernelFunction(function, "void(float32[::1], float32[::1], float32[::1])", None)
    size = len(X) if function in (sorted_whole,) else 16
    for run in (kernel, lambda *args: interpreted(Construct(kernel, (), False), args)):
        out = np.zeros(size, np.float32)
        run(X.copy(), Y.copy(), out)
        np.testing.assert_allclose(out[: len(expected)], expected, rtol=1e-6)
        assert not out[len(expected) :].any()
