"""Variables that share their places: words that are needed stay."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from hypothesis import given, settings

import vividc
from tests.dfg.cut.test_build import memory_after
from tests.programs import Assign, For, If, Load, Store, lower, programs
from vividc import arch
from vividc.compiler.regions.shared_variables import with_shared_variables
from vividc.dfg.check import check
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.regions import RETURN_VARIABLE, Kernel, is_variable
from vividc.machine.opcodes import Opcode
from vividc.ssa.flow import find_loops

ARMS = If(0, 1, (For(0, 0, 3, (Load(2, 0),)),), (For(0, 0, 2, (Assign(2, "add", 0, 1, None),)),))
ONE_AFTER_THE_OTHER = (
    For(0, 0, 4, (Load(1, 0), ARMS, Store(0, 2))),
    For(0, 0, 5, (Load(1, 0), ARMS, Store(1, 2))),
    For(0, 0, 6, (Load(1, 0), ARMS, Store(2, 2))),
)


@vividc.kernel("int32(int32[::1], int32)")
def sums(x: Any, n: Any) -> Any:
    """Loops whose lengths depend on data, and what is computed between them."""
    total = 0
    for k in range(n):
        a = x[k]
        b = a * 3
        c = b ^ a
        if a > 5:
            for i in range(a):
                total += x[i] * b - c
        d = total + c
        e = d * b
        f = e - a
        if d > 7:
            for i in range(b & 7):
                total += x[i] ^ e
        g = f * d
        h = g ^ e
        q = h + f
        if q > 9:
            for i in range(q & 7):
                total ^= x[i] + h
        r = g + q
        s = r * h
        t = s ^ q
        if t & 1:
            for _ in range(t & 3):
                total += s ^ r
        x[k] = total + r * s + t
    return total


def block_by_block(program: tuple[object, ...]) -> Kernel:
    """Loops are straight regions, too: all variables are theirs."""
    function = lower(program)
    headers = frozenset(loop.header for loop in find_loops(function))
    return build_kernel(replace(function, sequential=headers))


def variables(kernel: Kernel) -> set[str]:
    return {
        node.name
        for region in kernel.regions
        for node in region.dfg.nodes
        if node.op in {Opcode.LIVE_IN, Opcode.LIVE_OUT} and is_variable(node.name)
    }


@settings(max_examples=100)
@given(programs())
def test_a_kernel_leaves_the_same_memory(program: tuple[object, ...]) -> None:
    for kernel in (build_kernel(lower(program)), block_by_block(program)):
        shared = with_shared_variables(kernel)
        assert memory_after(shared) == memory_after(kernel)
        assert variables(shared) <= variables(kernel)
        assert not any(check(region.dfg) for region in shared.regions)


def test_loops_one_after_the_other_have_their_variables_in_one_place() -> None:
    kernel = block_by_block(ONE_AFTER_THE_OTHER)
    shared = with_shared_variables(kernel)
    assert memory_after(shared) == memory_after(kernel)
    assert len(variables(shared)) <= len(variables(kernel)) / 2


def test_what_loops_read_or_write_and_results_keep_their_places() -> None:
    kernel = build_kernel(lower(ONE_AFTER_THE_OTHER))
    loops = [region for region in kernel.regions if region.kind == "loop"]
    shared = with_shared_variables(kernel)
    assert [region for region in shared.regions if region.kind == "loop"] == loops
    assert RETURN_VARIABLE not in variables(kernel) or RETURN_VARIABLE in variables(shared)
    again = with_shared_variables(shared)
    assert variables(again) == variables(shared)


def test_a_kernel_runs_on_a_tile_whose_stores_do_not_hold_all_variables_at_once() -> None:
    whole = arch.load("vivid-tile")
    pes = tuple(replace(pe, constants=4) for pe in whole.pes)
    program = vividc.compile(sums, replace(whole, pes=pes), loops=vividc.LoopOptions(auto=False))
    mine, numbas = (np.arange(12, dtype=np.int32) % 9 for _ in range(2))
    assert vividc.simulate(program, mine, 12).value == sums(numbas, 12)
    assert (mine == numbas).all()
