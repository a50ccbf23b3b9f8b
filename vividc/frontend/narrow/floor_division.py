"""Python's integer division in SSA: from numba's calls to operations of their own.

The operations are `sfloordiv`, `sfloorrem`, `ufloordiv` and `ufloorrem`: of signed or unsigned
integers, rounded down, and 0 by zero (as numba's under the error model "numpy").
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

from vividc.frontend.llvm.calls import FLOOR_PREFIX
from vividc.frontend.llvm.ir import (
    Int,
    Local,
    Op,
    Operand,
    WideBlock,
    WideFunction,
    remove_dead,
    substitute,
)
from vividc.frontend.ranges.interval import S32, U32, contains
from vividc.frontend.ranges.ranges import Ranges

FLOOR_DIVISIONS = ("sfloordiv", "sfloorrem", "ufloordiv", "ufloorrem")
_BITS = 64


def recover_divisions(function: WideFunction) -> WideFunction:
    """Replace numba's calls by operations, by powers of two by shifts and masks, and those of
    constants by their results.
    """
    function = remove_dead(_map_ops(function, lambda op, _: (_recovered(op),)))
    while known := _constants(function):
        function = remove_dead(substitute(function, known))
    return remove_dead(_map_ops(function, lambda op, _: (_by_constant(op),)))


def sign_quotients(function: WideFunction, ranges: Ranges) -> WideFunction:
    """Write the one quotient of words that is none, 2**31, by its operands' signs; the same object
    if there is none.
    """

    def rewrite(op: Op, block: str) -> tuple[Op, ...]:
        if op.op not in FLOOR_DIVISIONS:
            return (op,)
        if not all(_fits_word(op, ranges.at(arg, block)) for arg in op.args):
            return (op,)
        is_signed = all(contains(S32, ranges.at(arg, block)) for arg in op.args)
        if is_signed and not contains(S32, ranges.at(Local(op.name), block)):
            return tuple(_with_sign(op))
        return (op,)

    return _map_ops(function, rewrite)


def _fits_word(op: Op, interval: tuple[int, int]) -> bool:
    return contains(U32, interval) or (op.op[0] == "s" and contains(S32, interval))


def _with_sign(op: Op) -> Iterator[Op]:
    """The quotient of two negative words is positive even where its word's sign bit is set."""
    names = ("quotient", "word", "signed", "unsigned", "signs", "positive")
    quotient, word, signed, unsigned, signs, positive = (_local(op, name) for name in names)
    yield replace(op, name=quotient.name)
    yield Op(word.name, "trunc", "i32", (quotient,), source="i64", loc=op.loc)
    yield Op(signed.name, "sext", "i64", (word,), source="i32", loc=op.loc)
    yield Op(unsigned.name, "zext", "i64", (word,), source="i32", loc=op.loc)
    yield Op(signs.name, "and", op.type, op.args, loc=op.loc)
    yield Op(positive.name, "icmp", op.type, (signs, Int(0)), pred="slt", loc=op.loc)
    yield replace(op, op="select", args=(positive, unsigned, signed))


def _map_ops(function: WideFunction, change: Callable[[Op, str], tuple[Op, ...]]) -> WideFunction:
    """The function with `change` applied to every instruction; the same object if nothing does."""

    def changed(block: WideBlock) -> WideBlock:
        ops = tuple(new for op in block.ops for new in change(op, block.name))
        return block if ops == block.ops else replace(block, ops=ops)

    blocks = tuple(changed(block) for block in function.blocks)
    same = all(new is old for new, old in zip(blocks, function.blocks, strict=True))
    return function if same else replace(function, blocks=blocks)


def _recovered(op: Op) -> Op:
    if op.op != "call" or not op.pred.startswith(FLOOR_PREFIX):
        return op
    kind = op.pred.removeprefix(FLOOR_PREFIX)
    return replace(op, op=f"{kind[0]}floor{kind[1:]}", pred="")


def _constants(function: WideFunction) -> dict[str, Operand]:
    """Divisions whose result is a constant or their dividend."""
    known: dict[str, Operand] = {}
    for op in (op for block in function.blocks for op in block.ops):
        value = _result(op) if op.op in FLOOR_DIVISIONS else None
        if value is not None:
            known[op.name] = value
    return known


def _result(op: Op) -> Operand | None:
    dividend, divisor = op.args
    is_quotient = op.op.endswith("div")
    if not isinstance(divisor, Int):
        return None
    if divisor.value in (0, 1):
        return dividend if divisor.value and is_quotient else Int(0)
    if not isinstance(dividend, Int):
        return None
    values = (dividend.value, divisor.value)
    if op.op[0] == "u":
        values = (values[0] % 2**_BITS, values[1] % 2**_BITS)
    result = values[0] // values[1] if is_quotient else values[0] % values[1]
    return Int((result + 2 ** (_BITS - 1)) % 2**_BITS - 2 ** (_BITS - 1))


def _by_constant(op: Op) -> Op:
    """By a power of two, or by a constant without sign."""
    if op.op not in FLOOR_DIVISIONS or not isinstance(op.args[1], Int) or op.args[1].value <= 0:
        return op
    dividend, by = op.args[0], op.args[1].value
    is_quotient, is_signed = op.op.endswith("div"), op.op[0] == "s"
    if by & (by - 1) == 0:
        if not is_quotient:
            return replace(op, op="and", args=(dividend, Int(by - 1)))
        return replace(
            op, op="ashr" if is_signed else "lshr", args=(dividend, Int(by.bit_length() - 1))
        )
    return op if is_signed else replace(op, op="udiv" if is_quotient else "urem")


def _local(op: Op, suffix: str) -> Local:
    return Local(f"{op.name}.{suffix}")
