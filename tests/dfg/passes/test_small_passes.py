"""What each pass does to small graphs, in the text form."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from vividc.dfg.check import check
from vividc.dfg.forms.text import parse, to_text
from vividc.dfg.ir import DFG
from vividc.dfg.passes import (
    contract_fma,
    eliminate_common_subexpressions,
    fold_constants,
    fold_selects,
    recognize_min_max,
    remove_dead_nodes,
)

SOURCES = """%0 = iv
%1 = live_in "a"
%2 = live_in "&x"
%3 = load "x" %0 shift 2 base %2 !k.py:1
%4 = load "x" %1 shift 2 base %2
"""


def result(steps: tuple[Callable[[DFG], DFG], ...], body: str) -> list[str]:
    """The lines below the sources after the passes."""
    dfg = parse(f'dfg "d"\n{SOURCES}{body}')
    assert check(dfg) == []
    for step in steps:
        dfg = step(dfg)
        assert check(dfg) == []
    lines = to_text(dfg).splitlines()[1:]
    skipped = (*SOURCES.splitlines(), "edges")
    return [line for line in lines if not line.startswith(skipped)]


def folded(body: str) -> list[str]:
    return result((fold_constants, remove_dead_nodes), body)


def unchanged(step: Callable[[DFG], DFG], body: str) -> bool:
    dfg = parse(f'dfg "d"\n{SOURCES}{body}')
    assert check(dfg) == []
    return step(dfg) is dfg


@pytest.mark.parametrize(
    ("constant", "operation", "expected"),
    [
        ("0x00000000", "add %3, %5", "%3"),
        ("0x00000000", "add %5, %3", "%3"),
        ("0x00000000", "sub %3, %5", "%3"),
        ("0x00000001", "mul %3, %5", "%3"),
        ("0x00000000", "shl %3, %5", "%3"),
        ("0x00000020", "lshr %3, %5", "%3"),
        ("0xffffffff", "and %3, %5", "%3"),
        ("0x00000000", "or %5, %3", "%3"),
        ("0x00000000", "xor %3, %5", "%3"),
        ("0x80000000", "smax %3, %5", "%3"),
        ("0x00000001", "select %5, %3, %4", "%3"),
        ("0x00000000", "select %5, %3, %4", "%4"),
        ("0x00000000", "select %0, %3, %3", "%3"),
        ("0x00000000", "mov %3", "%3"),
        ("0x00000000", "and %3, %3", "%3"),
    ],
)
def test_an_identity_forwards_the_operand(constant: str, operation: str, expected: str) -> None:
    lines = folded(f'%5 = const {constant}\n%6 = {operation}\n%7 = live_out "%v" %6\n')
    assert lines[-1] == f'%7 = live_out "%v" {expected}'


@pytest.mark.parametrize(
    ("constant", "operation", "word"),
    [
        ("0x00000000", "mul %3, %5", "0x00000000"),
        ("0x00000000", "and %5, %3", "0x00000000"),
        ("0x00000000", "mulhs %5, %3", "0x00000000"),
        ("0x00000001", "mulhu %5, %3", "0x00000000"),
        ("0xffffffff", "or %3, %5", "0xffffffff"),
        ("0x7fffffff", "smax %3, %5", "0x7fffffff"),
        ("0x00000005", "xor %3, %3", "0x00000000"),
        ("0x00000005", "sub %3, %3", "0x00000000"),
        ("0x00000005", "icmp.ule %3, %3", "0x00000001"),
        ("0x00000005", "icmp.slt %3, %3", "0x00000000"),
        ("0x00000005", "mul %5, %5", "0x00000019"),
        ("0x40000000", "fma %5, %5, %5", "0x40c00000"),
        ("0x3f800000", "exp %5", "0x402df854"),
    ],
)
def test_an_operation_of_known_result_is_a_constant(
    constant: str, operation: str, word: str
) -> None:
    body = f'%5 = const {constant}\n%6 = {operation}\n%7 = store "x" %1, %6 base %2\n'
    lines = folded(body)
    (name,) = [line.split()[0] for line in lines if line.endswith(f"const {word}")]
    assert f'%7 = store "x" %1, {name} base %2' in lines
    assert not any(line.startswith("%6") for line in lines)


def test_a_live_out_of_a_constant_keeps_an_operation() -> None:
    body = '%5 = const 0x00000002\n%6 = mul %5, %5\n%7 = live_out "%v" %6\n'
    assert folded(body) == [
        "%6 = mov %8",
        '%7 = live_out "%v" %6',
        "%8 = const 0x00000004",
    ]


def test_cheaper_operations_and_nested_constants() -> None:
    body = """%5 = const 0x00000008
%6 = const 0x00000003
%7 = mul %3, %5
%8 = sub %7, %6
%9 = add %5, %8
%10 = live_out "%v" %9
"""
    assert folded(body) == [
        "%6 = const 0x00000003",
        "%7 = shl %3, %6",
        "%9 = add %7, %12",
        '%10 = live_out "%v" %9',
        "%12 = const 0x00000005",
    ]


@pytest.mark.parametrize(
    ("operation", "constant", "shift", "amount"),
    [
        ("mulhu", "0x80000000", "lshr", "0x00000001"),
        ("mulhu", "0x00000010", "lshr", "0x0000001c"),
        ("mulhs", "0x00000010", "ashr", "0x0000001c"),
        ("mulhs", "0x00000001", "ashr", "0x0000001f"),
    ],
)
def test_high_products_by_powers_of_two_are_shifts(
    operation: str, constant: str, shift: str, amount: str
) -> None:
    lines = folded(f'%5 = const {constant}\n%6 = {operation} %3, %5\n%7 = live_out "%v" %6\n')
    [by] = [line.split()[0] for line in lines if line.endswith(f"const {amount}")]
    assert f"%6 = {shift} %3, {by}" in lines


def test_constants_of_an_index_go_into_the_address() -> None:
    body = """%5 = const 0x00000003
%6 = add %0, %5
%7 = load "x" %6 shift 2 offset 4 base %2
%8 = shl %1, %5
%9 = store "x" %8, %7 base %2
"""
    assert folded(body) == [
        '%7 = load "x" %0 shift 2 offset 16 base %2',
        '%9 = store "x" %1, %7 shift 3 base %2',
    ]


def test_an_offset_that_no_immediate_holds_stays_in_the_index() -> None:
    body = """%5 = const 0x00008000
%6 = add %0, %5
%7 = store "x" %6, %1 shift 2 base %2
"""
    assert unchanged(fold_constants, body)


def test_constant_predicates() -> None:
    body = """%5 = const 0x00000001
%6 = const 0x00000000
%7 = add %3, %4 if %5
%8 = fadd %7, %7 if %6
%9 = load "x" %3 base %2 if %6
%10 = add %8, %9
%11 = store "x" %8, %10 base %2 if %5
"""
    assert folded(body) == ["%7 = add %3, %4", '%11 = store "x" %7, %7 base %2']


def test_comparisons_and_selects_by_an_inverted_predicate() -> None:
    body = """%5 = const 0x00000001
%6 = fcmp.olt %3, %4
%7 = xor %6, %5
%8 = select %7, %3, %4
%9 = live_out "%v" %8
%10 = live_out "%p" %7
"""
    assert folded(body) == [
        "%7 = fcmp.ule %4, %3",
        "%8 = select %7, %3, %4",
        '%9 = live_out "%v" %8',
        '%10 = live_out "%p" %7',
    ]


def test_signs_cancel() -> None:
    body = """%5 = fneg %3
%6 = fneg %5
%7 = fabs %5
%8 = live_out "%v" %6
%9 = live_out "%w" %7
"""
    assert folded(body) == [
        "%7 = fabs %3",
        '%8 = live_out "%v" %3',
        '%9 = live_out "%w" %7',
    ]


def test_float_identities_hold_for_arithmetic_results_only() -> None:
    body = """%5 = const 0x3f800000
%6 = {operation}
%7 = fmul %6, %5
%8 = live_out "%v" %7
"""
    assert folded(body.format(operation="fadd %3, %4"))[-1] == '%8 = live_out "%v" %6'
    # A loaded NaN may have a payload, which the multiplication removes.
    assert folded(body.format(operation="fneg %3"))[-1] == '%8 = live_out "%v" %7'
    assert unchanged(fold_constants, "%5 = const 0x00000000\n%6 = fadd %3, %5\n")


def test_adding_zero_keeps_the_sign_of_zero() -> None:
    body = """%5 = const {zero}
%6 = fmul %3, %4
%7 = {operation}
%8 = live_out "%v" %7
"""
    kept = '%8 = live_out "%v" %6'
    assert folded(body.format(zero="0x80000000", operation="fadd %6, %5"))[-1] == kept
    assert folded(body.format(zero="0x00000000", operation="fsub %6, %5"))[-1] == kept
    assert folded(body.format(zero="0x00000000", operation="fadd %6, %5"))[-1] != kept
    assert folded(body.format(zero="0x80000000", operation="fsub %6, %5"))[-1] != kept


def test_a_copy_across_two_distances_stays() -> None:
    body = """%5 = const 0x00000000
%6 = const 0x00000001
%7 = mov %3@1(init=%5)
%8 = add %4, %7@1(init=%6)
%9 = live_out "%v" %8
"""
    assert unchanged(fold_constants, body)


def test_a_copy_the_controller_reads_stays() -> None:
    assert unchanged(fold_constants, "%5 = mov %1 trip\n")


def test_dead_nodes_go_and_effects_stay() -> None:
    body = """%5 = const 0x00000001
%6 = add %3, %5
%7 = icmp.eq %4, %6 exit
%8 = add %6, %6
%9 = add %8, %9@1(init=%5)
"""
    assert result((remove_dead_nodes,), body) == [
        "%5 = const 0x00000001",
        "%6 = add %3, %5",
        "%7 = icmp.eq %4, %6 exit",
    ]


def test_order_through_a_dead_load_is_kept() -> None:
    body = """%5 = store "x" %0, %1 base %2
%6 = load "x" %1 base %2 after %5
%7 = store "x" %1, %1 base %2 after %6
"""
    assert result((remove_dead_nodes,), body)[-1] == '%7 = store "x" %1, %1 base %2 after %5'


def test_equal_operations_merge_into_the_first() -> None:
    body = """%5 = const 0x00000001
%6 = const 0x00000001
%7 = add %3, %5
%8 = add %6, %3
%9 = sub %7, %8
%10 = mov %9@1(init=%6)
%11 = live_out "%v" %10
"""
    assert result((eliminate_common_subexpressions,), body) == [
        "%5 = const 0x00000001",
        "%7 = add %3, %5",
        "%9 = sub %7, %7",
        "%10 = mov %9@1(init=%5)",
        '%11 = live_out "%v" %10',
    ]


def test_loads_merge_only_from_arrays_that_nothing_stores() -> None:
    body = """%5 = load "{array}" %0 shift 2 base %2
%6 = store "y" %0, %5 shift 2 base %1
"""
    merged = result((eliminate_common_subexpressions,), body.format(array="x"))
    assert merged == ['%6 = store "y" %0, %3 shift 2 base %1']
    body = '%7 = load "y" %0 base %1\n%8 = load "y" %0 base %1\n' + body.format(array="y")
    assert unchanged(eliminate_common_subexpressions, body)


def test_others_merge_into_the_node_the_controller_reads() -> None:
    body = """%5 = icmp.slt %3, %4
%6 = icmp.slt %3, %4 exit
%7 = live_out "%v" %5
"""
    assert result((eliminate_common_subexpressions,), body) == [
        "%6 = icmp.slt %3, %4 exit",
        '%7 = live_out "%v" %6',
    ]


def test_a_predicate_distinguishes_the_order_of_operands() -> None:
    body = """%5 = icmp.slt %3, %4
%6 = add %3, %4 if %5
%7 = add %4, %3 if %5
%8 = live_out "%v" %6
%9 = live_out "%w" %7
"""
    assert unchanged(eliminate_common_subexpressions, body)


@pytest.mark.parametrize(
    ("body", "fma"),
    [
        ("%6 = fmul %3, %4\n%7 = fadd %6, %1\n", "%7 = fma %3, %4, %1"),
        ("%6 = fmul %3, %4\n%7 = fadd %1, %6\n", "%7 = fma %3, %4, %1"),
        ("%6 = fmul %3, %4\n%7 = fadd %6, %7@1(init=%1)\n", "%7 = fma %3, %4, %7@1(init=%1)"),
        ("%5 = const 0x3f800000\n%6 = fmul %3, %4\n%7 = fsub %6, %5\n", "%7 = fma %3, %4, %8"),
        ("%5 = const 0x40000000\n%6 = fmul %3, %5\n%7 = fsub %1, %6\n", "%7 = fma %3, %8, %1"),
        ("%5 = fneg %3\n%6 = fmul %5, %4\n%7 = fsub %1, %6\n", "%7 = fma %4, %3, %1"),
        (
            "%5 = icmp.eq %0, %0\n%6 = fmul %3, %4\n%7 = fadd %6, %1 if %5\n",
            "%7 = fma %3, %4, %1 if %5",
        ),
    ],
)
def test_products_contract(body: str, fma: str) -> None:
    lines = result((contract_fma,), body)
    assert fma in lines
    assert not any("fmul" in line for line in lines)


@pytest.mark.parametrize(
    "body",
    [
        "%6 = fmul %3, %4\n%7 = fadd %6, %6\n",
        '%6 = fmul %3, %4\n%7 = fadd %6, %1\n%8 = live_out "%v" %6\n',
        "%6 = fmul %3, %4\n%7 = fsub %6, %1\n",
        "%6 = fmul %3, %4\n%7 = fsub %1, %6\n",
        "%6 = fmul %3, %4\n%7 = fadd %1, %6@1(init=%1)\n",
        "%5 = icmp.eq %0, %0\n%6 = fmul %3, %4\n%7 = fadd %1, %6 if %5\n",
        "%5 = icmp.eq %0, %0\n%6 = fmul %3, %4 if %5\n%7 = fadd %1, %6\n",
        "%5 = icmp.eq %0, %0\n%8 = const 0x40000000\n%6 = fmul %3, %4\n%7 = fsub %6, %8 if %5\n",
    ],
)
def test_products_that_stay(body: str) -> None:
    assert unchanged(contract_fma, body)


@pytest.mark.parametrize(
    ("comparison", "select", "expected"),
    [
        ("icmp.slt %3, %4", "select %6, %3, %4", "smin %3, %4"),
        ("icmp.sle %3, %4", "select %6, %4, %3", "smax %3, %4"),
        ("fcmp.olt %3, %5", "select %6, %3, %5", "fmin %3, %5"),
        ("fcmp.olt %5, %3", "select %6, %3, %5", "fmax %5, %3"),
        ("fcmp.ult %5, %3", "select %6, %5, %3", "fmin %5, %3"),
        ("fcmp.olt %8, %3", "select %6, %3, %8", "fmax %8, %3"),
        # A NaN is kept, and a zero of the wrong sign.
        ("fcmp.ult %3, %5", "select %6, %3, %5", None),
        ("fcmp.olt %3, %8", "select %6, %3, %8", None),
        ("fcmp.olt %3, %4", "select %6, %3, %4", None),
        ("fcmp.olt %3, %5", "select %6, %3, %4", None),
        ("icmp.ult %3, %4", "select %6, %3, %4", None),
    ],
)
def test_minima_and_maxima(comparison: str, select: str, expected: str | None) -> None:
    body = f"""%5 = const 0x3f7d70a4
%8 = const 0x00000000
%6 = {comparison}
%7 = {select}
"""
    if expected is None:
        assert unchanged(recognize_min_max, body)
    else:
        assert f"%7 = {expected}" in result((recognize_min_max,), body)


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("%6 = fma %3, %4, %1\n%7 = select %5, %6, %1\n", ["%6 = fma %3, %4, %1 if %5"]),
        ("%6 = fadd %1, %4\n%7 = select %5, %6, %1\n", ["%6 = fadd %4, %1 if %5"]),
        (
            "%6 = fsub %3, %1\n%7 = select %5, %1, %6\n",
            ["%6 = fsub %3, %1 if %9", "%9 = icmp.sle %4, %3"],
        ),
    ],
)
def test_selects_become_predicates(body: str, expected: list[str]) -> None:
    lines = result((fold_selects,), f'%5 = icmp.slt %3, %4\n{body}%8 = live_out "%v" %7\n')
    assert not any("select" in line for line in lines)
    assert '%8 = live_out "%v" %6' in lines
    assert set(expected) <= set(lines)


def test_an_accumulator_under_a_condition_is_one_operation() -> None:
    body = """%5 = icmp.slt %3, %1
%6 = fma %3, %4, %7@1(init=%1)
%7 = select %5, %6, %7@1(init=%1)
%8 = live_out "%v" %7
"""
    assert result((fold_selects,), body) == [
        "%5 = icmp.slt %3, %1",
        "%6 = fma %3, %4, %6@1(init=%1) if %5",
        '%8 = live_out "%v" %6',
    ]


def test_selects_of_one_predicate_share_its_inverse() -> None:
    body = """%5 = fcmp.olt %3, %1
%6 = fadd %3, %7@1(init=%1)
%7 = select %5, %7@1(init=%1), %6
%8 = fadd %4, %9@1(init=%1)
%9 = select %5, %9@1(init=%1), %8
%10 = live_out "%v" %7
%11 = live_out "%w" %9
"""
    lines = result((fold_selects, remove_dead_nodes), body)
    assert "%6 = fadd %3, %6@1(init=%1) if %12" in lines
    assert "%8 = fadd %4, %8@1(init=%1) if %12" in lines
    assert [line for line in lines if "fcmp" in line] == ["%12 = fcmp.ule %1, %3"]


@pytest.mark.parametrize(
    "body",
    [
        # Another reader wants the word in any case.
        '%6 = fma %3, %4, %1\n%7 = select %5, %6, %1\n%9 = live_out "%w" %6\n',
        "%6 = fsub %1, %4\n%7 = select %5, %6, %1\n",
        "%6 = fma %3, %4, %1 if %5\n%7 = select %5, %6, %1\n",
        "%6 = fma %3, %4, %1\n%7 = select %5, %6, %3\n",
        # The predicate would wait for the multiplication in each iteration.
        "%10 = add %7@1(init=%1), %3\n%11 = icmp.slt %10, %3\n"
        "%6 = mul %3, %7@1(init=%1)\n%7 = select %11, %6, %7@1(init=%1)\n",
    ],
)
def test_selects_that_stay(body: str) -> None:
    assert unchanged(fold_selects, f'%5 = icmp.slt %3, %4\n{body}%8 = live_out "%v" %7\n')
