"""Words as functions of iteration indices and of what is fixed."""

from __future__ import annotations

import itertools

import islpy as isl
import pytest

from tests.ssa.support import function
from vividc.machine.words import signed
from vividc.ssa.interpret import interpret
from vividc.ssa.ir import Block, Branch, Function, Input, Value
from vividc.ssa.polyhedral.values import Expression, Expressions, integer

LEAST, MOST = -(1 << 31), (1 << 31) - 1
NUMBERS = (LEAST, LEAST + 1, -7, -1, 0, 1, 2, 5, MOST - 1, MOST)


@pytest.mark.parametrize("operations", [1, 10, 50])
def test_a_value_that_took_too_long_once_is_not_unknown_from_then_on(operations: int) -> None:
    values = Expressions(Function("f", (), (Block("b0", (), (), Branch()),)))
    length = Input("x.shape0")
    context = isl.DEFAULT_CONTEXT
    context.reset_operations()
    context.set_max_operations(operations)
    try:
        with pytest.raises(isl.Error):
            values.of(length)
    finally:
        context.set_max_operations(0)
    assert values.of(length) is not None


def is_number(values: Expressions, found: Expression, number: int, given: dict[str, int]) -> bool:
    """Whether an expression is a number where inputs are these."""
    equal = found.aff.eq_set(values.constant(number).aff).params()
    for key, position in values.parameters(equal.get_space()):
        assert isinstance(key, Input)
        equal = equal.fix_val(isl.dim_type.param, position, isl.Val(given[key.key]))
    return not equal.is_empty() and found.low <= number <= found.high


STRAIGHT = {
    "sum": ['%0 i32 = add $"n", $"m"'],
    "difference": ['%0 i32 = sub $"n", $"m"'],
    "product": ['%0 i32 = mul $"n", 0xfffffffd'],
    "least": ['%0 i32 = smin $"n", $"m"'],
    "greatest": ['%0 i32 = smax $"n", $"m"'],
    "shifted": ['%0 i32 = shl $"n", 0x3'],
    "shifted back": ['%0 i32 = ashr $"n", 0x2'],
    "shifted as unsigned": ['%0 i32 = lshr $"n", 0x2'],
    "masked": ['%0 i32 = and $"n", 0x7'],
    "chosen": ['%1 pred = icmp.slt $"n", $"m"', '%0 i32 = select %1, $"n", 0x7'],
    "chosen as unsigned": ['%1 pred = icmp.ult $"n", $"m"', '%0 i32 = select %1, $"n", $"m"'],
    "chosen by both": [
        '%1 pred = icmp.sle $"n", $"m"',
        '%2 pred = icmp.eq $"n", 0x5',
        "%3 pred = and %1, %2",
        '%0 i32 = select %3, $"m", 0x3',
    ],
    "chosen by either": [
        '%1 pred = icmp.ne $"n", $"m"',
        '%2 pred = icmp.ule $"n", 0x5',
        "%3 pred = or %1, %2",
        '%0 i32 = select %3, $"m", 0x3',
    ],
}


@pytest.mark.parametrize("name", STRAIGHT)
def test_a_word_is_what_is_computed(name: str) -> None:
    lines = "\n".join(f"  {line}" for line in STRAIGHT[name])
    given = function(f"b0:\n{lines}\n  return %0\n")
    values = Expressions(given)
    found = values.of(_returned(given))
    assert found is not None
    for n, m in itertools.product(NUMBERS, repeat=2):
        inputs = {"n": n, "m": m}
        number = interpret(given, *(inputs[param.name] for param in given.params))
        assert isinstance(number, int)
        assert is_number(values, found, signed(number & 0xFFFFFFFF), inputs), inputs


def _returned(given: Function) -> Value:
    [value] = given.blocks[-1].branch.read
    return value


@pytest.mark.parametrize("name", ["product of two", "remainder"])
def test_what_is_not_affine_stands_for_itself(name: str) -> None:
    """In straight code all is fixed; in a loop around, it is unknown."""
    line = '%0 i32 = mul $"n", $"m"' if name == "product of two" else '%0 i32 = xor $"n", $"m"'
    given = function(f"b0:\n  {line}\n  return %0\n")
    value = _returned(given)
    values = Expressions(given)
    assert values.of(value) == values.symbol(value)


def test_a_number_needs_operations_to_be_written() -> None:
    number = isl.Val(1 << 40)
    assert integer(number) == 1 << 40
    context = isl.DEFAULT_CONTEXT
    context.reset_operations()
    context.set_max_operations(1)
    try:
        with pytest.raises(isl.Error, match="no operations are left"):
            [integer(number) for _ in range(3)]
    finally:
        context.set_max_operations(0)


def test_conditions_that_would_make_too_many_pieces_are_left_out() -> None:
    """Each of ten numbers that differ would double the pieces, and any order of them does."""
    tests = [
        f'b{n}:\n  %{n} pred = icmp.ne $"n", $"m{n}"\n  branch %{n} b{n + 1} else b10\n'
        for n in range(9)
    ]
    given = function("".join(tests) + "b9:\n  jump b10\nb10:\n  return\n")
    runs = Expressions(given).domain("b9")
    assert 1 < runs.n_basic_set() <= 16
