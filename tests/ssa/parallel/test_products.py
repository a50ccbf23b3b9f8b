"""Which kernels are recognised as matrix products, and why others are not."""

from __future__ import annotations

import numpy as np
import pytest

import vividc
from vividc.frontend import KernelFunction
from vividc.machine.product import Product
from vividc.ssa.parallel.products import recognise
from vividc.ssa.rewrite.normalize import normalize

_MATRICES = "void(float32[:, ::1], float32[:, ::1], float32[::1], float32[:, ::1])"


def found(kernel: KernelFunction) -> Product | str:
    return recognise(normalize(kernel.lower()))


@vividc.kernel(_MATRICES)
def plain(a, b, bias, c):
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            total = np.float32(0)
            for k in range(a.shape[1]):
                total += a[i, k] * b[k, j]
            c[i, j] = total


@vividc.kernel(_MATRICES)
def biased_relu(a, b, bias, c):
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            total = np.float32(0)
            for k in range(a.shape[1]):
                total += b[k, j] * a[i, k]
            c[i, j] = max(bias[j] + total, np.float32(0))


@vividc.kernel(_MATRICES)
def transposed_columns_first(a, b, bias, c):
    for j in range(b.shape[0]):
        for i in range(a.shape[1]):
            total = bias[j]
            for k in range(a.shape[0]):
                total = a[k, i] * b[j, k] + total
            c[i, j] = total if total > 0 else np.float32(0)


@vividc.kernel("void(float32[:, ::1], float32[:, ::1], float32[:, ::1])")
def numpy_dot(a, b, c):
    np.dot(a, b, c)


@vividc.kernel("void(float32[:, ::1], float32[:, ::1], float32[:, ::1], int32)")
def part(a, b, c, depth):
    for i in range(a.shape[0]):
        for j in range(32):
            total = np.float32(0)
            for k in range(depth):
                total += a[i, k] * b[k, j]
            c[i, j] = total


def test_the_nest_as_written() -> None:
    product = found(plain)
    assert isinstance(product, Product)
    assert product.text == "c = a b"
    assert (product.rows, product.cols, product.depth) == ("a.shape0", "b.shape1", "a.shape1")
    assert product.starts
    assert not product.relu


def test_bias_and_relu_behind_the_sum() -> None:
    product = found(biased_relu)
    assert isinstance(product, Product)
    assert product.text == "c = max(a b + bias, 0)"
    assert not product.starts


def test_transposed_matrices_and_columns_in_the_outer_loop() -> None:
    product = found(transposed_columns_first)
    assert isinstance(product, Product)
    assert product.text == "c = max(a^T b^T + bias, 0)"
    assert product.starts


def test_np_dot_with_its_checks() -> None:
    product = found(numpy_dot)
    assert isinstance(product, Product)
    assert product.text == "c = a b"


def test_sizes_from_scalars_and_constants() -> None:
    product = found(part)
    assert isinstance(product, Product)
    assert (product.rows, product.cols, product.depth) == ("a.shape0", 32, "depth")


@vividc.kernel(_MATRICES)
def accumulates_in_memory(a, b, bias, c):
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            for k in range(a.shape[1]):
                c[i, j] += a[i, k] * b[k, j]


@vividc.kernel(_MATRICES)
def from_the_second(a, b, bias, c):
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            total = np.float32(0)
            for k in range(1, a.shape[1]):
                total += a[i, k] * b[k, j]
            c[i, j] = total


@vividc.kernel(_MATRICES)
def bias_by_row(a, b, bias, c):
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            total = np.float32(0)
            for k in range(a.shape[1]):
                total += a[i, k] * b[k, j]
            c[i, j] = total + bias[i]


@vividc.kernel(_MATRICES)
def two_biases(a, b, bias, c):
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            total = bias[j]
            for k in range(a.shape[1]):
                total += a[i, k] * b[k, j]
            c[i, j] = total + bias[j]


@vividc.kernel(_MATRICES)
def subtracts(a, b, bias, c):
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            total = np.float32(0)
            for k in range(a.shape[1]):
                total -= a[i, k] * b[k, j]
            c[i, j] = total


@vividc.kernel(_MATRICES)
def keeps_the_negative(a, b, bias, c):
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            total = np.float32(0)
            for k in range(a.shape[1]):
                total += a[i, k] * b[k, j]
            c[i, j] = min(total, np.float32(0))


@vividc.kernel(_MATRICES)
def leaky(a, b, bias, c):
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            total = np.float32(0)
            for k in range(a.shape[1]):
                total += a[i, k] * b[k, j]
            c[i, j] = total if total > 0 else np.float32(0.5) * total


@vividc.kernel(_MATRICES)
def same_row(a, b, bias, c):
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            total = np.float32(0)
            for k in range(a.shape[1]):
                total += a[i, k] * a[j, k]
            c[i, j] = total


@vividc.kernel(_MATRICES)
def in_place(a, b, bias, c):
    for i in range(c.shape[0]):
        for j in range(b.shape[1]):
            total = np.float32(0)
            for k in range(c.shape[1]):
                total += c[i, k] * b[k, j]
            c[i, j] = total


@vividc.kernel(_MATRICES)
def only_large_ones(a, b, bias, c):
    if a.shape[0] == 100:
        for i in range(a.shape[0]):
            for j in range(b.shape[1]):
                total = np.float32(0)
                for k in range(a.shape[1]):
                    total += a[i, k] * b[k, j]
                c[i, j] = total


@vividc.kernel(_MATRICES)
def some_rows(a, b, bias, c):
    for i in range(a.shape[0]):
        if bias[i] > 0:
            for j in range(b.shape[1]):
                total = np.float32(0)
                for k in range(a.shape[1]):
                    total += a[i, k] * b[k, j]
                c[i, j] = total


@vividc.kernel("float32(float32[:, ::1], float32[:, ::1], float32[:, ::1])")
def returns_something(a, b, c):
    total = np.float32(0)
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            total = np.float32(0)
            for k in range(a.shape[1]):
                total += a[i, k] * b[k, j]
            c[i, j] = total
    return total


@vividc.kernel("void(float32[:, ::1], float32[:, ::1], float32[:, :, ::1])")
def one_of_many(a, b, c):
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            total = np.float32(0)
            for k in range(a.shape[1]):
                total += a[i, k] * b[k, j]
            c[0, i, j] = total


@vividc.kernel("void(int32[:, ::1], int32[:, ::1], int32[:, ::1])")
def integers(a, b, c):
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            total = 0
            for k in range(a.shape[1]):
                total += a[i, k] * b[k, j]
            c[i, j] = total


@pytest.mark.parametrize(
    ("kernel", "reason"),
    [
        (accumulates_in_memory, "store"),
        (from_the_second, "count from 0"),
        (bias_by_row, "what it stores"),
        (two_biases, "two biases"),
        (subtracts, "add products"),
        (keeps_the_negative, "what it stores"),
        (leaky, "what it stores"),
        (in_place, "overwrites"),
        (only_large_ones, "condition around"),
        (some_rows, "condition inside"),
        (returns_something, "returns a value"),
        (one_of_many, "c[i, j]"),
        (integers, "c[i, j]"),
    ],
)
def test_what_is_none_has_a_reason(kernel: KernelFunction, reason: str) -> None:
    told = found(kernel)
    assert isinstance(told, str)
    assert reason in told


def test_a_matrix_times_its_own_transpose() -> None:
    product = found(same_row)
    assert isinstance(product, Product)
    assert product.text == "c = a a^T"
