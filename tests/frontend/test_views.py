"""Views of parameters: slices reach what Python's do, accesses keep their subscripts through LLVM,
and what is computed through views is what numba computes.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import vividc
from tests.fuzz.witnesses import words_in_blocks
from vividc.errors import SimulationError
from vividc.frontend.numba.expressions.numbers import Numbers
from vividc.machine.opcodes import MEMORY
from vividc.ssa.interpret import interpret
from vividc.ssa.polyhedral.subscripts import subscripts_of


@dataclass(frozen=True)
class Word:
    """A number that is known when the kernel runs; stands for LLVM's."""

    number: int

    def type(self, number: int) -> Word:
        return Word(number)


class Builder:
    """Computes instead of emitting."""

    def icmp_signed(self, how: str, one: Any, other: Any) -> bool:
        return {"<": operator.lt, ">": operator.gt}[how](_int(one), _int(other))

    def select(self, which: bool, one: Any, other: Any) -> Word:
        return Word(_int(one if which else other))

    def add(self, one: Any, other: Any, flags: object = ()) -> Word:
        return Word(_int(one) + _int(other))

    def sub(self, one: Any, other: Any, flags: object = ()) -> Word:
        return Word(_int(one) - _int(other))

    @contextmanager
    def goto_block(self, _block: object) -> Iterator[None]:
        yield


def _int(one: Any) -> int:
    return (
        int(one) if isinstance(one, int) else one.number if isinstance(one, Word) else one.constant
    )


BOUNDS = (None, *range(-6, 7))


@pytest.mark.parametrize("step", [1, -1])
@pytest.mark.parametrize("kinds", [(int, int), (int, Word), (Word, int), (Word, Word)])
def test_slices_reach_what_pythons_do(step: int, kinds: tuple[Any, Any]) -> None:
    numbers = Numbers(Builder())  # type: ignore[arg-type]
    along = numbers.up if step > 0 else numbers.down
    for size in range(5):
        for start in BOUNDS:
            for stop in BOUNDS:
                given = (
                    None if b is None else kind(b)
                    for b, kind in zip((start, stop), kinds, strict=True)
                )
                first, length = along(*given, Word(size))
                expected = range(size)[slice(start, stop, step)]
                assert _int(length) == len(expected)
                if expected:
                    assert _int(first) == expected[0]


SIGNATURE = "(float32[:, ::1], float32[:, ::1], int32)"


def stencil(a, b, n):
    b[1:-1, 1:-1] = a[1:-1, :-2] + a[1:-1, 2:] + a[2:, 1:-1] * a[:-2, 1:-1]


def whole(a, b, n):
    b[:] = a * a + b


def added(a, b, n):
    b += a * a


def by_a_parameter(a, b, n):
    b[n:] = a[:-n] * a[n:] + a[n:]


def turned(a, b, n):
    v = a[1:, :]
    b[:, 1:] = v.T + b[::-1, :-1]


def copied(a, b, n):
    b[1:-1] = a[2:]
    b[:, ::2] = a[1:2, ::-2]


@pytest.mark.parametrize("function", [stencil, whole, added])
def test_accesses_keep_their_subscripts(function: Callable[..., object]) -> None:
    lowered = vividc.kernel(SIGNATURE)(function).lower()
    subscripts = subscripts_of(lowered)
    accesses = [
        item
        for block in lowered.blocks
        for item in block.instrs
        if item.op in MEMORY and not item.array.startswith("raise.")
    ]
    assert accesses
    found = [subscripts.of(access) for access in accesses]
    assert all(parts is not None and len(parts) == 2 for parts in found)
    assert all(one.name.startswith("raise.") for one in lowered.locals)


def rows(a, b, n):
    for i in range(n):
        v = a[i]
        w = v[1:]
        b[i, :-1] = w * v[0]
        b[i, -1] = w[i]


def numbers(a, b, n):
    b[:, 0] = n
    b[1:n, -2:] = 0.5
    b[-9:9, 2:2] = 7
    b[n:0:-1] += True


def added_to_itself(a, b, n):
    b[1:] += b[:-1]
    a += a[::-1]
    a -= a[0]
    b *= n


def several_steps(a, b, n):
    v = a[::2, 1:]
    w = v[1:, ::-1]
    b[:2, :-1] = w[:2] + v[0]
    b[::3, None, 2][:, 0] = v[:2, n]


@pytest.mark.parametrize(
    "function",
    [*(by_a_parameter, turned, copied, rows, numbers, added_to_itself, several_steps)],
)
def test_views_are_numbas(function: Callable[..., object]) -> None:
    kernel = vividc.kernel(SIGNATURE)(function)
    program = words_in_blocks(kernel.lower())
    a = np.arange(36, dtype=np.float32).reshape(6, 6) / np.float32(4)
    mine, theirs = (a.copy(), a[::-1].copy()), (a.copy(), a[::-1].copy())
    kernel(*theirs, np.int32(2))
    vividc.simulate(program, *mine, 2)
    for one, other in zip(mine, theirs, strict=True):
        assert np.array_equal(one, other)


def test_sizes_of_copies_are_demanded() -> None:
    program = words_in_blocks(vividc.kernel(SIGNATURE)(copied).lower())
    with pytest.raises(SimulationError, match="ValueError"):
        vividc.simulate(program, np.ones((6, 5), np.float32), np.ones((6, 6), np.float32), 0)


def integers(a, b, n):
    b += a * n
    b[1:] -= a[:-1]
    b &= a
    b //= n


def test_integers_in_place_wrap_as_numbas() -> None:
    kernel = vividc.kernel("(int32[::1], int32[::1], int64)")(integers)
    program = words_in_blocks(kernel.lower())
    a = np.arange(1, 7, dtype=np.int32) * np.int32(123456789)
    mine, theirs = (a.copy(), a[::-1].copy()), (a.copy(), a[::-1].copy())
    kernel(*theirs, 777)
    vividc.simulate(program, *mine, 777)
    for one, other in zip(mine, theirs, strict=True):
        assert np.array_equal(one, other)


@vividc.kernel("void(boolean, float32[:, ::1], float32[:, ::1], boolean)")
def flagged(flag, a, b, other):
    if flag:
        b[1:-1, 1:-1] = a[1:-1, 1:-1] + a[:-2, 1:-1] * a[2:, 2:]
    if other:
        b += a * np.float32(2)


@pytest.mark.parametrize("flag", [False, True])
def test_arrays_may_follow_flags(flag: bool) -> None:
    """Numba branches on a flag where the function begins, before it has the arrays."""
    a = np.arange(36, dtype=np.float32).reshape(6, 6)
    mine, numbas = a[::-1].copy(), a[::-1].copy()
    vividc.simulate(words_in_blocks(flagged.lower()), flag, a, mine, not flag)
    flagged(flag, a, numbas, not flag)
    np.testing.assert_array_equal(mine, numbas)


def overlapping_in_place(a, b, n):
    b[n - 7 : -1, -3:-7:-1] *= b[:6][:2:-1, 4:0:-1] * a[n, n - 4 : 1 : -1]
    a[-8:-1, -8:] -= a[1:8] + a[-5, 5::-1]


def of_a_length_less_one(a, b, n):
    a[:1, :4] = a[n + 1 : -1, :4] * np.float32(2)


@pytest.mark.parametrize("function", [overlapping_in_place, of_a_length_less_one])
def test_arrays_between_have_known_sizes(function: Callable[..., object]) -> None:
    """What would need an array between as large as all operands' shapes together is not computed
    in place; of a slice's length LLVM makes `~start + size`.
    """
    kernel = vividc.kernel(SIGNATURE)(function)
    lowered = kernel.lower()
    a = np.arange(36, dtype=np.float32).reshape(6, 6)
    mine, theirs = (a.copy(), a[::-1].copy()), (a.copy(), a[::-1].copy())
    kernel(*theirs, np.int32(3))
    interpret(lowered, *mine, 3)
    for one, other in zip(mine, theirs, strict=True):
        assert np.array_equal(one, other)
