"""Functions without loops that leave nothing behind but what they store."""

from __future__ import annotations

import vividc
from vividc.ssa.check import check_function
from vividc.ssa.flow import find_loops
from vividc.ssa.ir import Function
from vividc.ssa.loops.left_out import without_loops
from vividc.ssa.rewrite.tidy import tidy


@vividc.kernel("int32(int32[::1], int32[::1])")
def three(a, b):
    for i in range(len(a)):
        a[i] += 1
    total = 0
    for i in range(len(a)):
        total += a[i]
    for i in range(len(b)):
        b[i] = total
    return total


def outer(function: Function) -> list[str]:
    return [loop.header for loop in find_loops(function)]


def test_loops_whose_values_nobody_reads_are_left_out() -> None:
    function = tidy(three.lower())
    headers = outer(function)
    made, taken = without_loops(function, headers)
    assert check_function(made) == []
    assert len(headers) == 3
    assert len(outer(made)) == 1  # the sum is read behind its loop
    assert taken == {block.name for block in function.blocks} - {b.name for b in made.blocks}


def test_other_loops_stay() -> None:
    function = tidy(three.lower())
    first = outer(function)[0]
    made, taken = without_loops(function, [first])
    assert check_function(made) == []
    assert outer(made) == [header for header in outer(function) if header != first]
    assert without_loops(function, []) == (function, frozenset())
    assert first in taken


@vividc.kernel("void(int32[::1], int32[:, ::1])")
def inside(a, b):
    for i in range(b.shape[0]):
        for j in range(len(a)):
            a[j] += 1
        for j in range(b.shape[1]):
            b[i, j] = a[j]


def test_loops_beside_another_one_in_a_loop_are_left_out() -> None:
    function = tidy(inside.lower())
    first, second, around = outer(function)
    made, taken = without_loops(function, [first])
    assert check_function(made) == []
    assert outer(made) == [second, around]
    assert without_loops(function, [first, around])[1] > taken
