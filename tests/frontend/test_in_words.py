"""Lines whose 64-bit integers are taken to be cast to int32: what casts themselves would make."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

import vividc
from vividc.ssa.interpret import interpret
from vividc.ssa.ir import Function


@vividc.kernel("void(int32[::1], int32[::1], int64)")
def wide(x, y, n):
    """A sum, a shift, a minimum and a division in 64 bits."""
    for i in range(len(x)):
        a = (x[i] + i) % n
        b = min(x[i] * 3 + n, n)
        y[i] = a + (b >> 1)


@vividc.kernel("void(int32[::1], int32[::1], int64)")
def cast(x, y, n):
    """The same in words."""
    m = np.int32(n)
    for i in range(len(x)):
        a = np.int32(np.int32(x[i] + np.int32(i)) % m)
        b = np.int32(min(np.int32(np.int32(x[i] * np.int32(3)) + m), m))
        y[i] = np.int32(a + np.int32(b >> np.int32(1)))


def instructions(function: Function) -> Counter[int]:
    locs = (instr.loc for block in function.blocks for instr in block.instrs)
    return Counter(loc.line - wide.line for loc in locs if loc is not None)


SUM, MINIMUM, STORE = (wide.line + line for line in (4, 5, 6))


@pytest.mark.parametrize("lines", [(), (SUM,), (MINIMUM,), (SUM, MINIMUM), (SUM, MINIMUM, STORE)])
def test_values_that_fit_stay_the_same(lines: tuple[int, ...]) -> None:
    x = np.array([-(2**28), -7, -1, 0, 5, 99, 2**28], np.int32)
    for n in (7, 100, 1 << 20, -3):
        expected, got = np.zeros_like(x), np.zeros_like(x)
        wide(x, expected, n)
        interpret(wide.lower(words_at=frozenset(lines)), x.copy(), got, n)
        assert np.array_equal(got, expected)


def test_a_line_alone_takes_fewer_instructions() -> None:
    plain = instructions(wide.lower())
    for line in (SUM, MINIMUM):
        fewer = instructions(wide.lower(words_at=frozenset({line})))
        assert fewer[line - wide.line] < plain[line - wide.line] / 2


def test_all_lines_take_as_many_as_with_casts_in_the_source() -> None:
    taken = instructions(wide.lower(words_at=frozenset({SUM, MINIMUM, STORE})))
    assert sum(taken.values()) <= sum(instructions(cast.lower()).values())
