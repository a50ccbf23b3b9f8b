"""Kernels that name elements by constants, and others that only seem to."""

from __future__ import annotations

from random import Random

import numba
import numpy as np

from vividc.frontend import kernel

COLUMN = 2


@numba.njit
def first_two(rows, i):
    return rows[i, 0] + rows[i, 1]


@kernel("void(int32[:, ::1], int32[:, ::1])")
def columns(a, b):
    for i in range(a.shape[0]):
        b[i, 0] = a[i, 1] + a[0, COLUMN]
        b[i, COLUMN] += a[i, 2]


@kernel("void(int32[:, :, ::1])")
def planes(a):
    for i in range(a.shape[1]):
        a[0, i, 1] = a[1, i, 1] + a[0, 0, i]


@kernel("void(int32[:, ::1], int32[::1], int32)")
def others(a, x, n):
    """A view, a helper's parameter, a subscript from the end, a slice, flat indices."""
    row = a[1]
    row[0] = row[2]
    x[0] = first_two(a, 1)
    x[1] = a[n, -1]
    a[0, :] = a[n, 0]
    flat = a.reshape(a.size)
    flat[n * a.shape[1] + 2] = flat[1]
    x[n * 2 + 3] = x[n * 2 + 1]


@kernel("int32(int32[::1], int32)")
def overlapping_rows(x, n):
    """Rows of n words, of which column 5 may be in a later row: legal, for the index is flat."""
    for i in range(n):
        x[i * n + 5] = x[i * n + 1] + 7
        x[i * n] = x[i * n + 3] ^ i
    return x[0]


HEADER = """import numba
import numpy as np
from vividc.frontend import kernel


@numba.njit
def helper(rows, i):
    rows[i, 1] += 3
    return rows[i, 0]


@kernel("int32(int32[:, ::1], int32[:, :, ::1], int32[::1], int32)")
def program(a, b, x, n):
    acc = 0
    for i in range(n):
{body}    return np.int32(acc & 0x7FFFFFFF)
"""
# a has at least 3 rows and 3 columns, b 2 planes of 3 rows and 3 columns, i and n stay below 3.
PLACES = (
    "a[{i}, {k}]",
    "a[{k}, {i}]",
    "a[{k}, {l}]",
    "b[{p}, {i}, {k}]",
    "b[{p}, {k}, {l}]",
    "b[{p}, {k}, {i}]",
    "x[{k}]",
    "x[{i} * 3 + {k}]",
    "a[{i}][{k}]",
    "b[{p}][{i}, {k}]",
    "a.reshape(a.size)[{i} * a.shape[1] + {k}]",
    "a[{i}, -1]",
)
VALUES = ("acc", "i", "{c}", "n", "helper(a, {i})")


def random_program(seed: int) -> str:
    """Source of a module whose `program` is a kernel."""
    random = Random(seed)
    body = "".join(_statement(random, " " * 8, 2) for _ in range(random.randint(2, 6)))
    return HEADER.format(body=body)


def _fill(random: Random, text: str) -> str:
    place = {"i": random.choice(("i", "n - 1", "i & 1")), "p": random.choice(("0", "1", "i & 1"))}
    return text.format(
        k=random.randint(0, 2), l=random.randint(0, 2), c=random.randint(-9, 9), **place
    )


def _place(random: Random) -> str:
    return _fill(random, random.choice(PLACES))


def _value(random: Random) -> str:
    return _place(random) if random.random() < 0.7 else _fill(random, random.choice(VALUES))


def _statement(random: Random, indent: str, depth: int) -> str:
    kind = random.random()
    if depth and kind < 0.2:
        inner = indent + "    "
        text = f"{indent}if {_value(random)} > {_value(random)}:\n"
        text += _statement(random, inner, depth - 1)
        return text + f"{indent}else:\n" + _statement(random, inner, depth - 1)
    if depth and kind < 0.3:
        return f"{indent}for i in range(3):\n" + _statement(random, indent + "    ", depth - 1)
    if kind < 0.45:
        return f"{indent}acc ^= {_value(random)}\n"
    operator = random.choice(("=", "=", "+=", "^="))
    return f"{indent}{_place(random)} {operator} {_value(random)} + {_value(random)}\n"


def arguments(seed: int, columns: int = 3) -> tuple[np.ndarray | np.int32, ...]:
    """Arguments of a random program, in order."""
    rng = np.random.default_rng(seed)
    shapes = ((3, columns), (2, 3, columns), (12,))
    arrays = [rng.integers(-99, 99, shape).astype(np.int32) for shape in shapes]
    return (*arrays, np.int32(3))
