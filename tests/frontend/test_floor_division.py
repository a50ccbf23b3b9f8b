"""Python's division in SSA: constants fold, powers of two are shifts, the rest stays."""

from __future__ import annotations

import itertools
from dataclasses import replace

import pytest

from vividc.frontend.llvm.calls import FLOOR_PREFIX
from vividc.frontend.narrow.floor_division import FLOOR_DIVISIONS, recover_divisions, sign_quotients
from vividc.ssa.ir import Block, Branch, Function, Input, Instr, Int, Key, Named, Ref, Value

VALUES = (0, 1, -1, 2, -2, 7, -7, 10**12, -(10**12), 2**62, -(2**63) + 1)
KINDS = ("sdiv", "srem", "udiv", "urem")


def function(kind: str, dividend: Value, divisor: Value) -> Function:
    call = Instr(0, "call", "i64", (dividend, divisor), pred=FLOOR_PREFIX + kind)
    block = Block("entry", (), (call,), Branch(value=Ref(0)))
    return Function("f", (), (block,), inputs=(("a", "i64"), ("b", "i64")), result="i64")


def divided(kind: str, a: int, b: int) -> int:
    if kind[0] == "u":
        a, b = a % 2**64, b % 2**64
    if b == 0:
        return 0
    return wrapped(a // b if kind.endswith("div") else a % b)


def wrapped(value: int) -> int:
    return (value + 2**63) % 2**64 - 2**63


def evaluate(changed: Function, a: int, b: int) -> int:
    """The function of 64-bit integers, instruction by instruction."""
    values: dict[Key, int] = {"a": a, "b": b}

    def value(operand: Value | None) -> int:
        assert isinstance(operand, Named | Int)
        return operand.value if isinstance(operand, Int) else values[operand.key]

    [block] = changed.blocks
    for op in block.instrs:
        values[op.id] = _step(op, [value(arg) for arg in op.operands])
    return value(block.branch.value)


def _step(op: Instr, args: list[int]) -> int:
    x, y = args[0], args[-1]
    ux, uy = x % 2**64, y % 2**64
    quotient = abs(x) // abs(y) * (1 if (x < 0) == (y < 0) else -1) if y else 0
    if op.op in FLOOR_DIVISIONS:
        return divided(f"{op.op[0]}{op.op[-3:]}", x, y)
    results = {
        "icmp": lambda: {"eq": x == y, "ne": x != y, "slt": x < y}[op.pred],
        "select": lambda: args[1] if x else args[2],
        "sdiv": lambda: quotient,
        "srem": lambda: x - y * quotient,
        "udiv": lambda: ux // uy,
        "urem": lambda: ux % uy,
        "and": lambda: x & y,
        "ashr": lambda: x >> y,
        "lshr": lambda: ux >> y,
    }
    return wrapped(int(results[op.op]()))


@pytest.mark.parametrize("kind", KINDS)
def test_what_fits_no_word_stays_for_the_rules_of_two_words(kind: str) -> None:
    wide = recover_divisions(function(kind, Input("a"), Input("b")))
    [op] = wide.blocks[0].instrs
    assert op.op == f"{kind[0]}floor{kind[1:]}"
    assert sign_quotients(wide) is wide


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("divisor", [0, 1, 2, 8, 2**31, 2**32, 2**62, 10, -3])
def test_divisors_that_are_constant(kind: str, divisor: int) -> None:
    wide = recover_divisions(function(kind, Input("a"), Int(divisor)))
    if divisor in (2, 8, 2**31, 2**32, 2**62):
        assert {op.op for op in wide.blocks[0].instrs} <= {"ashr", "lshr", "and"}
    changed = sign_quotients(wide)
    for a in VALUES:
        assert evaluate(changed, a, 0) == divided(kind, a, divisor), a


@pytest.mark.parametrize("kind", KINDS)
def test_constants_fold(kind: str) -> None:
    for a, b in itertools.product(VALUES, VALUES):
        wide = recover_divisions(function(kind, Int(a), Int(b)))
        assert wide.blocks[0].branch.value == Int(divided(kind, a, b))


def test_what_fits_words_stays() -> None:
    wide = recover_divisions(function("srem", Input("a"), Input("b")))
    words = replace(wide, inputs=(("a", "i16"), ("b", "i16")))
    assert sign_quotients(words) is words
