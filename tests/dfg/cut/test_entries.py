"""What a nest does between its innermost loops is one region, and means the same."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings

import vividc
from tests.dfg.cut.test_build import meaning, memory_after
from tests.fuzz.witnesses import run_regions
from tests.programs import (
    Access,
    Assign,
    For,
    Load,
    Program,
    Store,
    lower,
    nests,
    programs,
)
from vividc.compiler.driver import lower as regions_of
from vividc.dfg.cut.build import SHAPING, build_kernel
from vividc.dfg.cut.entries import join_entries
from vividc.dfg.regions import Kernel
from vividc.host.watch import run_passes
from vividc.machine.opcodes import Opcode
from vividc.ssa.check import check_function
from vividc.ssa.interpret import interpret
from vividc.ssa.rewrite.normalize import normalize
from vividc.ssa.text import parse


@settings(max_examples=150)
@given(nests() | programs())
def test_joined_nests_mean_what_they_meant(program: Program) -> None:
    shaped = run_passes(SHAPING, lower(program))
    joined = join_entries(shaped, {})
    for function in (joined.function, joined.explained):
        assert check_function(function) == []
        memory = np.arange(16, dtype=np.int32)
        interpret(function, memory)
        assert [int(word) for word in memory.view(np.uint32)] == meaning(program)


@settings(max_examples=100)
@given(nests())
def test_regions_of_joined_nests_mean_what_they_meant(program: Program) -> None:
    assert memory_after(build_kernel(lower(program))) == meaning(program)


def _longest_way(kernel: Kernel) -> int:
    """Straight regions between two runs of a loop, on the longest way without one in between."""

    def ways(index: int | None, seen: tuple[int, ...]) -> Sequence[int]:
        if index is None:
            return []
        if kernel.regions[index].kind == "loop":
            return [len(seen)]
        if index in seen:
            return []
        after = (kernel.regions[index].next, kernel.regions[index].branch)
        return [n for target in after for n in ways(target, (*seen, index))]

    loops = [region for region in kernel.regions if region.kind == "loop"]
    return max(n for loop in loops for n in ways(loop.next, ()))


@vividc.kernel("void(float32[:, ::1], float32[:, ::1])")
def row_sums(a, out):
    for i in range(a.shape[0]):
        total = np.float32(0.0)
        for j in range(a.shape[1]):
            total += a[i, j]
        out[i, 0] = total
        out[i, 1] = 1.0


def test_the_end_of_one_entry_and_the_start_of_the_next_are_one_region() -> None:
    kernel = regions_of(row_sums)
    assert _longest_way(kernel) == 1
    behind = next(r.next for r in kernel.regions if r.kind == "loop")
    assert behind is not None
    region = kernel.regions[behind]
    assert region.branch is not None or region.next is not None
    assert sum(node.op is Opcode.STORE for node in region.dfg.nodes) == 2


def test_what_the_next_entry_loads_does_not_wait_for_what_this_one_stores() -> None:
    """Addresses that one entry has computed for the next are told apart in a region of both."""

    @vividc.kernel("void(float32[:, ::1], float32[:, ::1])")
    def in_place(a, b):
        for i in range(a.shape[0]):
            total = a[i, 0]
            for j in range(b.shape[1]):
                total += b[i, j]
            a[i, 0] = total

    kernel = regions_of(in_place)
    joined = [
        region.dfg
        for region in kernel.regions
        if {Opcode.LOAD, Opcode.STORE} <= {n.op for n in region.dfg.nodes if n.name == "a"}
    ]
    assert joined
    ordered = [edge for dfg in joined for edge in dfg.edges if not edge.is_data]
    assert ordered == []


@pytest.mark.parametrize("count", [0, 1, 3])
def test_what_would_follow_the_last_iteration_does_not_happen(count: int) -> None:
    """Stores and loads in front of the inner loop happen for iterations that there are."""
    inner = For(1, 0, 2, (Load(2, 1), Assign(2, "add", 2, 0, None), Store(1, 2)))
    program: Program = (
        For(0, 0, count, (Assign(2, "set", 2, 2, 0), Access("store", 1, 0, 5), inner)),
    )
    assert memory_after(build_kernel(lower(program)), 64) == meaning(program, 64)


@pytest.mark.parametrize("count", [0, 1, 3])
def test_a_loop_behind_a_nest_starts_with_what_the_nest_leaves(count: int) -> None:
    """It reads values of the nest by the names that they have in the nest."""
    inner = For(1, 0, 2, (Assign(2, "add", 2, 2, 3),))
    behind = For(1, 0, 2, (Assign(2, "add", 2, 0, None), Store(1, 2)))
    program: Program = (For(0, 0, count, (inner,)), behind)
    assert memory_after(build_kernel(lower(program))) == meaning(program)


@vividc.kernel("void(int32[::1], int32[::1])")
def handed_on(x, y):
    """What one iteration computes in front of the inner loop is read by the next one alone."""
    state = np.int32(1)
    for i in range(len(x)):
        before = state
        state = np.int32(state * 5 + x[i])
        for j in range(before & 3):
            y[j] += before


def test_what_only_the_next_iteration_reads_is_kept() -> None:
    x = np.arange(7, dtype=np.int32)
    mine, numbas = np.zeros(4, np.int32), np.zeros(4, np.int32)
    run_regions(build_kernel(normalize(handed_on.lower())), [x, mine])
    handed_on(x, numbas)
    np.testing.assert_array_equal(mine, numbas)


STORES_FIRST = """\
function "f"
param "a" int32[1]
param "n" int32
entry:
  jump outer
outer:
  %1 i32 = phi [entry: 0x00000000, latch: %9]
  %2 none = store $"&a", %1, $"n" array "a" shift 2
  %3 pred = icmp.slt %1, $"n"
  branch %3 inner else out
inner:
  %4 i32 = phi [outer: 0x00000000, inner: %7]
  %5 i32 = load $"&a", %4 array "a" shift 2
  %6 i32 = add %5, %1
  %11 none = store $"&a", %4, %6 array "a" shift 2
  %7 i32 = add %4, 0x00000001
  %8 pred = icmp.slt %7, $"n"
  branch %8 inner else latch
latch:
  %9 i32 = add %1, 0x00000001
  jump outer
out:
  return
"""


def test_a_store_of_a_header_has_no_value_behind_it() -> None:
    """It goes to the ends of the blocks before, and leaves no phi."""
    joined = join_entries(run_passes(SHAPING, parse(STORES_FIRST)), {})
    assert check_function(joined.function) == []
    assert [phi.id for block in joined.function.blocks for phi in block.phis] == [4, 1]
