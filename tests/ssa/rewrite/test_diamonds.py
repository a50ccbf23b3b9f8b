"""Small branches outside pipelined loops: one straight region instead of three or four."""

from __future__ import annotations

from dataclasses import replace

from hypothesis import given, settings

from tests.dfg.cut.test_build import meaning, memory_after
from tests.programs import Assign, For, If, Load, Store, lower, programs
from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS, demand_same
from vividc.dfg.check import check
from vividc.dfg.cut.build import build_kernel
from vividc.machine.opcodes import PRED
from vividc.ssa.check import check_function
from vividc.ssa.flow import find_loops
from vividc.ssa.rewrite.diamonds import merge_diamonds
from vividc.ssa.rewrite.normalize import normalize

STORES = If(0, 1, (Store(0, 1), Load(2, 1)), (Store(1, 2), Assign(2, "add", 0, 1, None)))


@settings(max_examples=100)
@given(programs())
def test_merging_keeps_the_function_well_formed(program: tuple[object, ...]) -> None:
    function = normalize(lower(program))
    merged = merge_diamonds(function)
    assert check_function(merged) == []
    demand_same(function, merged, tries=2)
    assert merge_diamonds(merged) is merged
    assert len(merged.blocks) <= len(function.blocks)


def test_both_arms_run_under_predicates() -> None:
    (region,) = build_kernel(lower((STORES,))).regions
    assert check(region.dfg) == []
    guarded = {e.dst for e in region.dfg.edges if e.port == PRED}
    assert sorted(region.dfg.by_id[node].op.value for node in guarded) == ["load", "store", "store"]
    assert memory_after(build_kernel(lower((STORES,)))) == meaning((STORES,))


def test_a_loop_that_runs_block_by_block_has_fewer_blocks() -> None:
    program = (For(0, 0, 6, (Load(1, 0), STORES)),)
    function = lower(program)
    headers = frozenset(loop.header for loop in find_loops(function))
    kernel = build_kernel(replace(function, sequential=headers))
    assert len(kernel.regions) == 4  # before, header, body, after
    assert memory_after(kernel) == meaning(program)


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, merge_diamonds)
