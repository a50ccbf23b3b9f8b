"""Aggregates of LLVM that paths join become their elements."""

from __future__ import annotations

import pytest

from vividc.frontend.llvm.reader import read_function
from vividc.ssa.ir import Float, Function, Input, Int, Phi, Ref

JOINED = """
define i32 @f(i32 %a, i1 %c, i32 %n) {{
entry:
  br i1 %c, label %one, label %two
one:
  {one}
  br label %end
two:
  br label %end
end:
  %t = phi {type} [ {first}, %one ], [ {second}, %two ]
  {rest}
  ret i32 %r
}}
"""


def read(type_: str, first: str, second: str, rest: str, one: str = "") -> Function:
    text = JOINED.format(type=type_, first=first, second=second, rest=rest, one=one)
    return read_function(text, "f", "f.py")


def phis(function: Function) -> list[Phi]:
    return list(function.by_name["end"].phis)


@pytest.mark.parametrize(
    ("constant", "values"),
    [
        ("[i32 7, i32 -1]", (7, -1)),
        ("zeroinitializer", (0, 0)),
        ("undef", (0, 0)),
    ],
)
def test_a_phi_of_constants_and_inserted_values(constant: str, values: tuple[int, int]) -> None:
    function = read(
        "[2 x i32]",
        "%u",
        constant,
        "%r = extractvalue [2 x i32] %t, 1",
        one="%u = insertvalue [2 x i32] [i32 4, i32 5], i32 %a, 1",
    )
    one, other = phis(function)
    assert one.incoming == (("one", Int(4)), ("two", Int(values[0])))
    assert other.incoming == (("one", Input("a")), ("two", Int(values[1])))
    assert function.by_name["end"].branch.value == Ref(other.id)


def test_bytes_are_printed_as_a_string() -> None:
    function = read(
        "[3 x i8]",
        r'c"\01A\FF"',
        "poison",
        "%b = extractvalue [3 x i8] %t, 2\n  %r = zext i8 %b to i32",
    )
    assert [phi.incoming[0][1] for phi in phis(function)] == [Int(1), Int(65), Int(255)]


def test_structures_in_arrays_have_elements_of_their_types() -> None:
    function = read(
        "[2 x { i32, float }]",
        "[{ i32, float } { i32 3, float 2.000000e+00 }, { i32, float } zeroinitializer]",
        "zeroinitializer",
        "%s = extractvalue [2 x { i32, float }] %t, 1\n  %r = extractvalue { i32, float } %s, 0",
    )
    assert [phi.type for phi in phis(function)] == ["i32", "float", "i32", "float"]
    assert [phi.incoming[0][1] for phi in phis(function)] == [
        Int(3),
        Float(2.0),
        Int(0),
        Float(0.0),
    ]
    assert function.by_name["end"].branch.value == Ref(phis(function)[2].id)


def test_a_choice_of_aggregates_is_one_of_each_element() -> None:
    function = read(
        "[2 x i32]",
        "[i32 1, i32 2]",
        "[i32 3, i32 4]",
        "%s = select i1 %c, [2 x i32] %t, [2 x i32] [i32 5, i32 6]\n"
        "  %z = freeze [2 x i32] %s\n  %r = extractvalue [2 x i32] %z, 0",
    )
    ops = [op for op in function.by_name["end"].instrs if op.op == "select"]
    assert [op.operands[2] for op in ops] == [Int(5), Int(6)]
    assert {op.type for op in function.by_name["end"].instrs} == {"i32"}


def test_what_a_call_gives_stays_whole() -> None:
    function = read(
        "{ i32, i1 }",
        "%u",
        "zeroinitializer",
        "%r = extractvalue { i32, i1 } %t, 0",
        one="%u = call { i32, i1 } @llvm.sadd.with.overflow.i32(i32 %a, i32 %n)",
    )
    assert [phi.type for phi in phis(function)] == ["{i32,i1}"]
    [part] = [i for b in function.blocks for i in b.instrs if i.op == "extractvalue"]
    assert function.by_name["end"].branch.value == Ref(part.id)
