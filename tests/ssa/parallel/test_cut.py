"""The loop over prange is cut at two inputs, and its reductions are known."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
import pytest
from numba import prange

import vividc
from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS, term_text
from vividc.errors import KernelError
from vividc.machine.parallel import FIRST, LAST, Parallel
from vividc.ssa.edit import uses
from vividc.ssa.ir import Function, Input
from vividc.ssa.parallel.cut import cut_parallel_loop


def cut(kernel: Any) -> tuple[Any, Parallel]:
    return cut_parallel_loop(kernel.lower(spread=True), kernel.prange_lines)


def run(function: Function, *lines: str) -> object:
    """The function, and a line each for the bounds, accesses, reductions and the result."""
    try:
        made, found = cut_parallel_loop(function, [int(line) for line in lines])
    except KernelError as refusal:
        return str(refusal).replace("\n", " / ")

    def term(number: int | None) -> str:
        return "nothing" if number is None else term_text(found.terms, number)

    accesses = (
        f"{'store' if a.is_store else 'load'} {a.array} {term(a.term)} shift {a.shift}"
        f" offset {a.offset} width {a.width} counters {a.counters}"
        f"{'' if a.beside is None else f' beside {a.beside}'}{' leads' * a.leads}"
        f" {a.loc or ''}".rstrip()
        for a in found.accesses
    )
    beside = (
        f"beside from {term(b.first)} to {term(b.last)}{' before' * b.is_before}"
        for b in found.beside
    )
    reductions = (f"{r.op} from {term(r.start)}, {r.start_word}" for r in found.reductions)
    result = f"result {found.result}, unsigned {found.is_unsigned}, at {found.loc}"
    bounds = f"from {term(found.first)} to {term(found.last)}"
    sliced = (f"sliced {name}" for name in found.sliced)
    alike = (f"alike {name}" for name in found.alike)
    return made, bounds, *beside, *sliced, *alike, *accesses, *reductions, result


@cases(__file__)
def test_rules(case: Case) -> None:
    """The function computes a chunk: not what it computed."""
    FUNCTIONS.check(case, run, same=False)


@vividc.kernel("void(int32[::1], int32)")
def outer(x, n):
    for i in numba.prange(2, n):
        for j in prange(3):
            x[3 * i + j] = j


def test_the_outermost_loop_is_cut() -> None:
    function, parallel = cut(outer)
    values = [v for b in function.blocks for v in uses(b)]
    values += [v for b in function.blocks for phi in b.phis for _, v in phi.incoming]
    inputs = {v.key for v in values if isinstance(v, Input)}
    assert {FIRST, LAST} <= inputs
    assert "n" not in inputs
    assert [parallel.terms[t].op for t in (parallel.first, parallel.last)] == ["const", "input"]
    assert parallel.loc is not None
    assert parallel.loc.line in outer.prange_lines
    assert [(a.array, a.is_store, a.width) for a in parallel.accesses] == [("x", True, 4)]


@vividc.kernel("int32(int32[::1], int32)")
def adds(x, start):
    s = start
    for i in prange(len(x)):
        if x[i] > 3:
            s += x[i]
        s -= np.int32(1)
    return s


@vividc.kernel("float32(float32[:, ::1])")
def products(x):
    s = np.float32(2)
    for i in prange(x.shape[0]):
        for j in range(x.shape[1]):
            s *= x[i, j]
    return s


@vividc.kernel("float32(float32[::1])")
def least(x):
    s = np.float32(7)
    for i in prange(len(x)):
        s = min(s, x[i])
    return s


@vividc.kernel("int32(int32[::1])")
def parity(x):
    s = np.int32(0)
    for i in prange(len(x)):
        s ^= x[i]
    return s


@pytest.mark.parametrize(
    ("kernel", "op", "identity"),
    [
        (adds, "add", 0),
        (products, "fmul", 0x3F800000),
        (least, "fcmp.olt", None),
        (parity, "xor", 0),
    ],
    ids=lambda item: getattr(item, "name", None),
)
def test_reductions(kernel: Any, op: str, identity: int | None) -> None:
    _, parallel = cut(kernel)
    (reduction,) = parallel.reductions
    assert (reduction.op, reduction.identity, parallel.result) == (op, identity, 0)


@vividc.kernel("int32(int32[::1])")
def last(x):
    s = np.int32(0)
    for i in prange(len(x)):
        s = x[i]
    return s


@vividc.kernel("int32(int32[::1])")
def mixed(x):
    s = np.int32(0)
    for i in prange(len(x)):
        s = (s + x[i]) * np.int32(3)
    return s


@vividc.kernel("int32(int32[::1])")
def twice(x):
    s = np.int32(1)
    for _i in prange(len(x)):
        s += s
    return s


@vividc.kernel("int32(int32[::1])")
def indexed(x):
    s = np.int32(0)
    for _i in prange(len(x)):
        s += x[s & 3]
    return s


@vividc.kernel("float32(float32[::1])")
def nan_wins(x):
    s = np.float32(0)
    for i in prange(len(x)):
        s = s if s >= x[i] else x[i]
    return s


@pytest.mark.parametrize("kernel", [last, mixed, twice, indexed, nan_wins], ids=lambda k: k.name)
def test_what_is_no_reduction_is_refused(kernel: Any) -> None:
    with pytest.raises(KernelError, match=r"what an earlier one computed|used after it"):
        cut(kernel)


@vividc.kernel("void(int32[::1], uint32)")
def unsigned(x, n):
    for i in prange(n):
        x[i] = 1


def test_unsigned_bounds_are_marked() -> None:
    _, parallel = cut(unsigned)
    assert parallel.is_unsigned


@vividc.kernel("void(int32[::1], int32)")
def no_prange(x, n):
    for i in range(n):
        x[i] = 1


def test_range_is_not_prange() -> None:
    assert no_prange.prange_lines == frozenset()
