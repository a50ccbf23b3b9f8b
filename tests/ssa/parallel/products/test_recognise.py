"""Kernels that are recognised as matrix products, in any order of loops, and why others are not."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import vividc
from vividc.compiler.products import products_of
from vividc.frontend import KernelFunction
from vividc.machine.product import Elementwise, is_mirror
from vividc.ssa.parallel.products import Found

_M = "float32[:, ::1]"
_THREE = f"void({_M}, {_M}, {_M})"
_SCALED = f"void(float32, float32, {_M}, {_M}, float32[::1], {_M})"
_RANGES = {"i": "range(c.shape[0])", "j": "range(c.shape[1])", "k": "range({depth})"}


def found(kernel: KernelFunction) -> Found:
    return products_of(kernel)


def text(kernel: KernelFunction) -> str:
    told = found(kernel)
    assert not told.reason
    return "; ".join(product.text for product in told.products)


def written(tmp_path: Path, signature: str, arguments: str, lines: list[str]) -> KernelFunction:
    """A kernel of these lines, in a file, as numba wants it."""
    source = ["import numpy as np", f"def kernel({arguments}):", *(f"    {line}" for line in lines)]
    path = tmp_path / "written.py"
    path.write_text("\n".join(source) + "\n")
    names: dict[str, Callable[..., None]] = {}
    exec(compile(path.read_text(), path, "exec"), names)
    return vividc.kernel(signature)(names["kernel"])


def nest(order: str, body: str, depth: str) -> list[str]:
    """Three loops in an order around a line."""
    lines = [
        f"{'    ' * n}for {name} in {_RANGES[name].format(depth=depth)}:"
        for n, name in enumerate(order)
    ]
    return [*lines, f"{'    ' * len(order)}{body}"]


_ORDERS = ["".join(order) for order in itertools.permutations("ijk")]
_FACTORS = {
    ("a[i, k]", "b[k, j]"): "c = a b + c",
    ("a[k, i]", "b[k, j]"): "c = a^T b + c",
    ("a[i, k]", "b[j, k]"): "c = a b^T + c",
    ("b[j, k]", "a[k, i]"): "c = a^T b^T + c",
}


@pytest.mark.parametrize("order", _ORDERS)
@pytest.mark.parametrize(("factors", "formula"), _FACTORS.items(), ids=str)
def test_any_order_of_loops_and_transposes(
    order: str, factors: tuple[str, str], formula: str, tmp_path: Path
) -> None:
    depth = "a.shape[1]" if "a[i, k]" in factors else "a.shape[0]"
    lines = nest(order, f"c[i, j] += {factors[0]} * {factors[1]}", depth)
    assert text(written(tmp_path, _THREE, "a, b, c", lines)) == formula


_SUM = ["s = np.float32(0)", "for k in range(a.shape[1]):", "    s += a[i, k] * b[k, j]"]
_ENDS = {
    "c[i, j] = s": "c = a b",
    "c[i, j] = alpha * s": "c = alpha * (a b)",
    "c[i, j] = alpha * s + beta * c[i, j]": "c = alpha * (a b) + (beta * c)",
    "c[i, j] = s + v[j]": "c = (a b) + v",
    "c[i, j] = max(s, np.float32(0))": "c = max(a b, 0)",
    "c[i, j] = max(s + v[j], np.float32(0))": "c = max((a b) + v, 0)",
    "c[i, j] = s + v[i]": "c = (a b) + v",
    "c[j, i] = s": "c = b^T a^T",
}


@pytest.mark.parametrize(("end", "formula"), _ENDS.items())
def test_what_follows_a_sum(end: str, formula: str, tmp_path: Path) -> None:
    inner = [f"        {line}" for line in (*_SUM, end)]
    loops = ["for i in range(a.shape[0]):", "    for j in range(b.shape[1]):"]
    kernel = written(tmp_path, _SCALED, "alpha, beta, a, b, v, c", [*loops, *inner])
    assert text(kernel) == formula


_STARTS = {
    "c[i, j] = np.float32(0)": "c = a b",
    "c[i, j] = v[j]": "c = a b + v",
    "c[i, j] *= beta": "c = a b + c * beta",
    "c[i, j] = np.float32(2.5)": "c = a b + 2.5",
}
_ROW = ["for i in range(c.shape[0]):", "    for j in range(c.shape[1]):"]


@pytest.mark.parametrize("order", ["ikj", "kij", "jki"])
@pytest.mark.parametrize(("start", "formula"), _STARTS.items())
def test_what_a_nest_before_sets(start: str, formula: str, order: str, tmp_path: Path) -> None:
    lines = [*_ROW, f"        {start}"]
    lines += nest(order, "c[i, j] += a[i, k] * b[k, j]", "a.shape[1]")
    assert text(written(tmp_path, _SCALED, "alpha, beta, a, b, v, c", lines)) == formula


_FACTORED = {
    "c[i, j] += alpha * a[i, k] * b[k, j]": "c = (alpha * a) b + c",
    "c[i, j] += a[i, k] * (b[k, j] * beta)": "c = a (b * beta) + c",
    "c[i, j] -= a[i, k] * b[k, j]": "c = (-a) b + c",
    "c[i, j] += a[i, k] * a[j, k]": "c = a a^T + c",
    "c[i, j] += a[i, 2 * k] * b[k, j]": "c = a b + c",
}


@pytest.mark.parametrize(("body", "formula"), _FACTORED.items())
def test_what_is_done_to_factors(body: str, formula: str, tmp_path: Path) -> None:
    lines = nest("ikj", body, "a.shape[1]")
    assert text(written(tmp_path, _SCALED, "alpha, beta, a, b, v, c", lines)) == formula


def test_sums_that_count_down(tmp_path: Path) -> None:
    lines = nest("kij", "c[i, j] += a[i, k] * b[k, j]", "a.shape[1] - 1, -1, -1")
    kernel = written(tmp_path, _THREE, "a, b, c", lines)
    assert text(kernel) == "c = a b + c"
    [product] = found(kernel).products
    assert product.left.view is not None
    assert [axis.factor for axis in product.left.view.axes] == [1, -1]


def test_a_triangle_of_the_result_and_a_row_at_a_time(tmp_path: Path) -> None:
    lines = [
        "for i in range(c.shape[0]):",
        "    for j in range(i + 1):",
        "        c[i, j] *= beta",
        "    for k in range(a.shape[1]):",
        "        for j in range(i + 1):",
        "            c[i, j] += alpha * a[i, k] * a[j, k]",
    ]
    kernel = written(tmp_path, _SCALED, "alpha, beta, a, b, v, c", lines)
    assert text(kernel) == "c = (alpha * a) a^T + c * beta"
    [product] = found(kernel).products
    assert [(edge.row, edge.col, edge.constant.constant) for edge in product.edges] == [(1, -1, 0)]


_MIRRORED = [
    "scale = beta - alpha",
    "for i in range(c.shape[0]):",
    "    for j in range({start}, c.shape[0]):",
    "        c[i, j] = np.float32(0)",
    "        for k in range(a.shape[0]):",
    "            c[i, j] += a[k, i] * a[k, j]",
    "        c[i, j] /= scale",
    "        c[j, i] = c[i, j]",
]


@pytest.mark.parametrize("start", ["i", "i + 1"])
def test_a_product_and_its_mirror_image(tmp_path: Path, start: str) -> None:
    lines = [line.format(start=start) for line in _MIRRORED]
    kernel = written(tmp_path, _SCALED, "alpha, beta, a, b, v, c", lines)
    assert text(kernel) == "c = (a^T a) / (beta - alpha)"
    assert [is_mirror(s) for s in found(kernel).steps if isinstance(s, Elementwise)] == [True]


@pytest.mark.parametrize("start", ["0", "i - 1", "1"])
def test_no_mirror_image_if_both_sides_are_read(tmp_path: Path, start: str) -> None:
    lines = [line.format(start=start) for line in _MIRRORED]
    kernel = written(tmp_path, _SCALED, "alpha, beta, a, b, v, c", lines)
    assert found(kernel).reason


@vividc.kernel(_THREE)
def numpy_dot(a, b, c):
    np.dot(a, b, c)


def test_np_dot_with_its_checks_takes_rows_to_be_as_long_as_a_launch_must_prove() -> None:
    assert text(numpy_dot) == "c = a b"
    assert [(name, size.text) for name, size in found(numpy_dot).strides] == [
        ("a", "a.shape1"),
        ("b", "b.shape1"),
        ("c", "b.shape1"),
    ]


@vividc.kernel(f"void({_M}, {_M}, {_M}, {_M}, {_M})")
def one_after_the_other(a, b, t, d, c):
    for i in range(t.shape[0]):
        for j in range(t.shape[1]):
            t[i, j] = np.float32(0)
            for k in range(a.shape[1]):
                t[i, j] += a[i, k] * b[k, j]
    for i in range(c.shape[0]):
        for k in range(t.shape[1]):
            for j in range(c.shape[1]):
                c[i, j] += t[i, k] * d[k, j]


def test_products_one_after_the_other() -> None:
    assert text(one_after_the_other) == "t = a b; c = t d + c"


@vividc.kernel(f"void({_M}, {_M}, {_M}, float32[::1])")
def inside_a_longer_kernel(a, b, c, v):
    for i in range(c.shape[0]):
        for k in range(a.shape[1]):
            for j in range(c.shape[1]):
                c[i, j] += a[i, k] * b[k, j]
    for i in range(1, v.shape[0]):
        v[i] += v[i - 1]


def test_a_product_in_a_longer_kernel_is_named() -> None:
    told = found(inside_a_longer_kernel)
    assert [product.text for product in told.products] == ["c = a b + c"]
    assert not told.steps
    assert "overwrites elements of v" in told.reason


_NONE = {
    "in place": (
        nest("ijk", "c[i, j] += c[i, k] * b[k, j]", "c.shape[1]"),
        "overwrites elements of c",
    ),
    "triangular sums": (
        nest("ijk", "c[i, j] += a[i, k] * b[k, j]", "i"),
        "how long its sums are",
    ),
    "two sums at once": (
        nest("ikj", "c[i, j] += a[j, k] * b[i, k] + b[j, k] * a[i, k]", "a.shape[1]"),
        "not to add a product to a sum",
    ),
    "a scalar behind the factors": (
        nest("ikj", "c[i, j] += a[i, k] * b[k, j] * alpha", "a.shape[1]"),
        "not elements of two matrices",
    ),
    "a maximum": (
        nest("ijk", "c[i, j] = max(c[i, j], a[i, k] * b[k, j])", "a.shape[1]"),
        "not to add a product to a sum",
    ),
    "a condition around": (
        ["if v[0] > 0:", *(f"    {x}" for x in nest("ijk", "c[i, j] += a[i, k] * b[k, j]", "9"))],
        "outside its loops",
    ),
    "a condition inside": (
        [
            "for i in range(c.shape[0]):",
            "    if v[i] > 0:",
            "        for j in range(c.shape[1]):",
            "            for k in range(a.shape[1]):",
            "                c[i, j] += a[i, k] * b[k, j]",
        ],
        "",
    ),
    "a condition on counters": (
        nest("ijk", "if k < i: c[i, j] += a[i, k] * b[k, j]", "a.shape[1]"),
        "branches",
    ),
    "a sum that is needed in turn": (
        [
            "for i in range(c.shape[0]):",
            "    for j in range(c.shape[1]):",
            "        s = np.float32(0)",
            "        for k in range(c.shape[1]):",
            "            s += c[i, k] * b[k, j]",
            "        c[i, j] = s",
        ],
        "each other's results in turn",
    ),
    "no sum": ([*_ROW, "        c[i, j] = a[i, j] + b[i, j]"], "no loop adds products"),
}


@pytest.mark.parametrize("case", _NONE)
def test_what_is_none_has_a_reason(case: str, tmp_path: Path) -> None:
    lines, reason = _NONE[case]
    told = found(written(tmp_path, _SCALED, "alpha, beta, a, b, v, c", lines))
    assert told.reason
    assert reason in told.reason
    assert not told.steps


@vividc.kernel(f"float32({_M}, {_M}, {_M})")
def returns_something(a, b, c):
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            for k in range(a.shape[1]):
                c[i, j] += a[i, k] * b[k, j]
    return np.float32(1)


@vividc.kernel("void(int32[:, ::1], int32[:, ::1], int32[:, ::1])")
def integers(a, b, c):
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            for k in range(a.shape[1]):
                c[i, j] += a[i, k] * b[k, j]


def test_a_returned_value_and_integers_are_told() -> None:
    assert found(returns_something).reason == "it returns a value"
    assert "add" in found(integers).reason or "float32" in found(integers).reason
