"""Small branches outside pipelined loops: one straight region instead of three or four."""

from __future__ import annotations

from dataclasses import replace

from hypothesis import given, settings

from tests.dfg.cut.test_build import meaning, memory_after
from tests.dfg.programs import Assign, For, If, Load, Store, lower, programs
from vividc.dfg.check import check
from vividc.dfg.cut.build import build_kernel
from vividc.machine.opcodes import PRED, Opcode, Type
from vividc.ssa.check import check_function
from vividc.ssa.flow import find_loops
from vividc.ssa.ir import Block, Branch, Const, Function, Input, Instr, Phi, Ref
from vividc.ssa.rewrite.diamonds import merge_diamonds
from vividc.ssa.rewrite.normalize import normalize

STORES = If(0, 1, (Store(0, 1), Load(2, 1)), (Store(1, 2), Assign(2, "add", 0, 1, None)))


@settings(max_examples=100, deadline=None, derandomize=True)
@given(programs())
def test_merging_keeps_the_function_well_formed(program: tuple[object, ...]) -> None:
    function = normalize(lower(program))
    merged = merge_diamonds(function)
    assert check_function(merged) == []
    assert merge_diamonds(merged) is merged
    assert len(merged.blocks) <= len(function.blocks)


def test_both_arms_run_under_predicates() -> None:
    (region,) = build_kernel(lower((STORES,))).regions
    assert check(region.dfg) == []
    guarded = {e.dst for e in region.dfg.edges if e.port == PRED}
    assert sorted(region.dfg.by_id[node].op.value for node in guarded) == ["load", "store", "store"]
    assert memory_after(build_kernel(lower((STORES,)))) == meaning((STORES,))


def test_an_arm_in_an_arm_runs_under_both_predicates() -> None:
    program = (Load(1, 0), If(0, 1, (Store(0, 1), STORES), ()), If(1, 0, (STORES,), (STORES,)))
    kernel = build_kernel(lower(program))
    assert len(kernel.regions) == 1
    assert memory_after(kernel) == meaning(program)


def test_a_loop_that_runs_block_by_block_has_fewer_blocks() -> None:
    program = (For(0, 0, 6, (Load(1, 0), STORES)),)
    function = lower(program)
    headers = frozenset(loop.header for loop in find_loops(function))
    kernel = build_kernel(replace(function, sequential=headers))
    assert len(kernel.regions) == 4  # before, header, body, after
    assert memory_after(kernel) == meaning(program)


def quotient(op: Opcode) -> Function:
    """x[0] = x[0] op 3 where x[0] < 9, else x[0]."""
    load = Instr(0, Opcode.LOAD, Type.I32, (Input("&x"), Const(0)), "x", 2)
    test = Instr(1, Opcode.ICMP_SLT, Type.PRED, (Ref(0), Const(9)))
    work = Instr(2, op, Type.I32, (Ref(0), Const(3)))
    phi = Phi(3, Type.I32, (("top", Ref(0)), ("arm", Ref(2))))
    store = Instr(4, Opcode.STORE, Type.NONE, (Input("&x"), Const(0), Ref(3)), "x", 2)
    return Function(
        "quotient",
        (),
        (
            Block("top", (), (load, test), Branch("arm", Ref(1), "end")),
            Block("arm", (), (work,), Branch("end")),
            Block("end", (phi,), (store,), Branch()),
        ),
    )


def test_an_arm_with_a_division_stays_a_region() -> None:
    assert len(merge_diamonds(normalize(quotient(Opcode.MUL))).blocks) == 1
    divided = normalize(quotient(Opcode.SDIV))
    assert merge_diamonds(divided) is divided
