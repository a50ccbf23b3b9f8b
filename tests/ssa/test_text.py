"""The text form of functions: what is printed is read back, and what is malformed is a message."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.c_kernels import WORKLOADS as C_KERNELS
from benchmarks.workloads import WORKLOADS, Workload
from tests.programs import Nest, affine_nests, lower
from vividc.errors import SourceLoc, SSAError
from vividc.machine.lanes import Lane
from vividc.machine.opcodes import Opcode, Type
from vividc.machine.params import DType, LocalArray, Param
from vividc.ssa.check import check_function
from vividc.ssa.ir import Block, Branch, Const, Function, Input, Instr, Phi, Ref, Undefined
from vividc.ssa.rewrite.normalize import normalize
from vividc.ssa.text import parse, to_text

EVERYTHING = Function(
    'odd "name"\n',
    (
        Param("n", DType.I64, words=2),
        Param("m", DType.I32, known=(-7,)),
        Param("x", DType.F16, 2, longest=7, known=(3, 0)),
        Param("y", DType.U8, 1, True),
    ),
    (
        Block("entry", (), (), Branch("a block", loc=SourceLoc("a file: 3 !.py", 2))),
        Block(
            "a block",
            (
                Phi(
                    1, Type.F32, (("entry", Undefined()), ("a block", Ref(-2))), SourceLoc('"q"', 1)
                ),
            ),
            (
                Instr(
                    -2,
                    Opcode.LOAD,
                    Type.I32,
                    (Input("&x"), Ref(1), Const(1)),
                    "x",
                    1,
                    -8,
                    2,
                    True,
                    subscript=(None, 3),
                    distinct="a block",
                    loc=SourceLoc("", 0),
                    lane=Lane(3, -7, 1, ("entry", "a block")),
                ),
                Instr(3, Opcode.ADD, Type.I32, (Ref(1), Const(0xFFFFFFFF)), exact=True),
            ),
            Branch("a block", Input("n"), "entry2"),
        ),
        Block("entry2", (), (), Branch(value=Ref(3), high=Const(0))),
    ),
    DType.I64,
    "päth\\k.py",
    frozenset({"a block", "entry"}),
    (
        LocalArray("t", 2, (1, 2)),
        LocalArray("u", 0, size=("s:n", 4, "*"), loops=(SourceLoc("k.py", 3), SourceLoc("l", 4))),
    ),
)


@pytest.mark.parametrize("workload", [*WORKLOADS, *C_KERNELS], ids=lambda one: one.name)
def test_kernels_are_read_back(workload: Workload) -> None:
    function = workload.kernel().lower()
    for one in (function, normalize(function)):
        assert repr(parse(to_text(one))) == repr(one)


def test_every_field_is_read_back() -> None:
    assert repr(parse(to_text(EVERYTHING))) == repr(EVERYTHING)


@given(affine_nests())
def test_random_nests_are_read_back(nest: Nest) -> None:
    function = lower(nest.program)
    assert repr(parse(to_text(function))) == repr(function)


@given(st.randoms(use_true_random=False))
def test_damaged_text_is_read_or_refused(rng: random.Random) -> None:
    lines = to_text(EVERYTHING).split("\n")
    at = rng.randrange(len(lines))
    tokens = lines[at].split(" ")
    which = rng.randrange(len(tokens))
    tokens[which : which + rng.randrange(2)] = rng.choices(
        ("%4", "0x1", "=", "[", "phi", "load", '"', "-", "i32", "!k.py:1", "9" * 5000, ""),
        k=rng.randrange(1, 3),
    )
    lines[at] = " ".join(tokens)
    try:
        function = parse("\n".join(lines))
    except SSAError:
        return
    check_function(function)
    assert repr(parse(to_text(function))) == repr(function)


@pytest.mark.parametrize(
    ("text", "line", "what"),
    [
        ("", None, "the text is empty"),
        ('function "f"\nentry:', None, "block 'entry' has no end"),
        ('function "f"\nentry:\n  %1 i32 = frob %2', 3, "expected an operation, found frob"),
        ('function "f"\nentry:\n  %1 i32 = add %2, 5000000000', 3, "is not a 32-bit word"),
        ('function "f"\nentry:\n  %1 i32 = add %2 shift 1 shift 2', 3, "is not a clause"),
        ('function "f"\nentry:\n  return\n  return', 4, "expected :, found"),
        ('function "f"\nentry:\n  %1 i32 = add %2\n  %3 i32 = phi []', 4, "phis come before"),
        ('function "f"\nparam "x" int32[99999999]', 2, "an array of 99999999 dimensions"),
        ('function "f"\nentry:\n  jump ?', 3, "cannot read"),
        ('function "f" returns i32', 1, "expected a type, found i32"),
    ],
)
def test_malformed_text_names_its_line(text: str, line: int | None, what: str) -> None:
    with pytest.raises(SSAError, match=what.replace("[", r"\[")) as refusal:
        parse(text, "f.ssa")
    assert str(refusal.value).startswith("f.ssa" if line is None else f"f.ssa:{line}")


def test_comments_and_empty_lines_are_passed_over() -> None:
    text = to_text(EVERYTHING).replace("\n", "\n# a comment\n\n")
    assert parse(text) == EVERYTHING


def test_sequential_loops_are_named_in_order() -> None:
    one = replace(EVERYTHING, sequential=frozenset({"b", "a"}))
    assert "sequential a, b" in to_text(one)
