"""Loads of fixed addresses before a loop: which move, and that the loop means the same."""

from __future__ import annotations

import copy

import numpy as np
import pytest

import vividc
from vividc.dfg.cut.build import build_kernel
from vividc.machine.opcodes import Opcode


@vividc.kernel("void(int32[::1], int32[::1], int32[::1])")
def mixed(x, w, y):
    for i in range(x.shape[0]):
        y[i] = (x[i] + w[0]) ^ (w[1] * w[2]) - w[3]


@vividc.kernel("void(int32[::1], int32[::1])")
def stored(x, w):
    for i in range(x.shape[0]):
        x[i] = x[i] + w[0] ^ w[1] * w[2]
        w[1] = x[i]


@vividc.kernel("void(int32[:, ::1], int32[::1])")
def other_row(w, x):
    for i in range(w.shape[1]):
        w[1, i] = w[0, 0] + w[0, 1] * w[0, 2]


@vividc.kernel("void(int32[::1], int32[::1], int32[::1])")
def perhaps(x, w, y):
    for i in range(x.shape[0]):
        if x[i] > 0:
            y[i] = x[i] + w[0] * w[1] ^ w[2]


@vividc.kernel("void(int32[::1], int32[::1], int32[::1])")
def after_break(x, w, y):
    for i in range(x.shape[0]):
        if x[i] < 0:
            break
        y[i] = x[i] + w[0] * w[1] ^ w[2]


@vividc.kernel("void(int32[::1], int32[::1], int32[::1])")
def until_zero(x, w, y):
    i = 0
    while x[i] != 0:
        y[i] = x[i] + w[0] * w[1] ^ w[2]
        i += 1


@vividc.kernel("void(int32[::1], int32[::1], int32[::1])")
def down(x, w, y):
    i = x.shape[0] - 1
    while i >= 0:
        y[i] = w[w[0]] + w[1] ^ w[2]
        i -= 1


@vividc.kernel("void(int32[::1], int32[::1], int32[::1])")
def few(x, w, y):
    for i in range(x.shape[0]):
        y[i] = x[i] * w[0] + w[1]


def loads_in_loop(kernel: vividc.KernelFunction) -> int:
    (loop,) = (r for r in build_kernel(kernel.lower()).regions if r.kind == "loop")
    return sum(node.op is Opcode.LOAD for node in loop.dfg.nodes)


@pytest.mark.parametrize(
    ("kernel", "left"),
    [
        (mixed, 1),
        (stored, 4),
        (other_row, 0),
        (perhaps, 4),
        (after_break, 4),
        (until_zero, 2),
        (down, 1),
        (few, 3),
    ],
)
def test_what_every_iteration_reads_from_the_same_place_moves(
    kernel: vividc.KernelFunction, left: int
) -> None:
    """Not what the loop may store, nor what only some iterations read."""
    assert loads_in_loop(kernel) == left


@pytest.mark.parametrize("length", [0, 1, 5])
@pytest.mark.parametrize("kernel", [mixed, stored, perhaps, after_break, down, few])
def test_the_loop_means_the_same(kernel: vividc.KernelFunction, length: int) -> None:
    """A loop that does not run reads nothing: `w` may be empty then."""
    x = np.arange(-2, length - 2, dtype=np.int32)[::-1].copy()
    w = np.array([3, -5, 7, 11] if length else [], np.int32)
    arrays = [x, w] if kernel is stored else [x, w, np.zeros(length, np.int32)]
    expected = copy.deepcopy(arrays)
    kernel(*expected)
    program = vividc.compile(kernel, time_limit_s=20.0)
    vividc.simulate(program, *arrays)
    for one, other in zip(expected, arrays, strict=True):
        assert np.array_equal(one, other)
