"""Python's integer division in SSA: from numba's calls to operations of their own.

The operations are `sfloordiv`, `sfloorrem`, `ufloordiv` and `ufloorrem`: of signed or unsigned
integers, rounded down, and 0 by zero (as numba's under the error model "numpy").
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

from vividc.frontend.llvm.calls import FLOOR_PREFIX
from vividc.frontend.ranges.interval import S32, U32, contains
from vividc.frontend.ranges.known import ranges_of
from vividc.ssa.edit import FreshIds, substitute
from vividc.ssa.ir import Block, Function, Instr, Int, Ref, Value
from vividc.ssa.rewrite.dead import remove_unused

FLOOR_DIVISIONS = ("sfloordiv", "sfloorrem", "ufloordiv", "ufloorrem")
_BITS = 64


def recover_divisions(function: Function) -> Function:
    """Replace numba's calls by operations, by powers of two by shifts and masks, and those of
    constants by their results.
    """
    function = remove_unused(_map_ops(function, lambda op, _: (_recovered(op),)))
    while known := _constants(function):
        function = remove_unused(substitute(function, known))
    return remove_unused(_map_ops(function, lambda op, _: (_by_constant(op),)))


def sign_quotients(function: Function) -> Function:
    """Write the one quotient of words that is none, 2**31, by its operands' signs; the same object
    if there is none.
    """

    ranges, ids = ranges_of(function), FreshIds(function)

    def rewrite(op: Instr, block: str) -> tuple[Instr, ...]:
        if op.op not in FLOOR_DIVISIONS:
            return (op,)
        if not all(_fits_word(op, ranges.at(arg, block)) for arg in op.operands):
            return (op,)
        is_signed = all(contains(S32, ranges.at(arg, block)) for arg in op.operands)
        if is_signed and not contains(S32, ranges.at(Ref(op.id), block)):
            return tuple(_with_sign(op, ids))
        return (op,)

    return _map_ops(function, rewrite)


def _fits_word(op: Instr, interval: tuple[int, int]) -> bool:
    return contains(U32, interval) or (op.mnemonic[0] == "s" and contains(S32, interval))


def _with_sign(op: Instr, ids: FreshIds) -> Iterator[Instr]:
    """The quotient of two negative words is positive even where its word's sign bit is set."""
    quotient = replace(op, id=ids())
    word = Instr(ids(), "trunc", "i32", (Ref(quotient.id),), source="i64", loc=op.loc)
    signed = Instr(ids(), "sext", "i64", (Ref(word.id),), source="i32", loc=op.loc)
    unsigned = replace(signed, id=ids(), op="zext")
    signs = Instr(ids(), "and", op.type, op.operands, loc=op.loc)
    tested = (Ref(signs.id), Int(0))
    positive = Instr(ids(), "icmp", op.type, tested, pred="slt", loc=op.loc)
    yield from (quotient, word, signed, unsigned, signs, positive)
    chosen = (Ref(positive.id), Ref(unsigned.id), Ref(signed.id))
    yield replace(op, op="select", operands=chosen)


def _map_ops(function: Function, change: Callable[[Instr, str], tuple[Instr, ...]]) -> Function:
    """The function with `change` applied to every instruction; the same object if nothing does."""

    def changed(block: Block) -> Block:
        ops = tuple(new for op in block.instrs for new in change(op, block.name))
        return block if ops == block.instrs else replace(block, instrs=ops)

    blocks = tuple(changed(block) for block in function.blocks)
    same = all(new is old for new, old in zip(blocks, function.blocks, strict=True))
    return function if same else replace(function, blocks=blocks)


def _recovered(op: Instr) -> Instr:
    if op.op != "call" or not op.pred.startswith(FLOOR_PREFIX):
        return op
    kind = op.pred.removeprefix(FLOOR_PREFIX)
    return replace(op, op=f"{kind[0]}floor{kind[1:]}", pred="")


def _constants(function: Function) -> dict[int, Value]:
    """Divisions whose result is a constant or their dividend."""
    known: dict[int, Value] = {}
    for op in (op for block in function.blocks for op in block.instrs):
        value = _result(op) if op.op in FLOOR_DIVISIONS else None
        if value is not None:
            known[op.id] = value
    return known


def _result(op: Instr) -> Value | None:
    dividend, divisor = op.operands
    is_quotient = op.mnemonic.endswith("div")
    if not isinstance(divisor, Int):
        return None
    if divisor.value in (0, 1):
        return dividend if divisor.value and is_quotient else Int(0)
    if not isinstance(dividend, Int):
        return None
    values = (dividend.value, divisor.value)
    if op.mnemonic[0] == "u":
        values = (values[0] % 2**_BITS, values[1] % 2**_BITS)
    result = values[0] // values[1] if is_quotient else values[0] % values[1]
    return Int((result + 2 ** (_BITS - 1)) % 2**_BITS - 2 ** (_BITS - 1))


def _by_constant(op: Instr) -> Instr:
    """By a power of two, or by a constant without sign."""
    if (
        op.op not in FLOOR_DIVISIONS
        or not isinstance(op.operands[1], Int)
        or op.operands[1].value <= 0
    ):
        return op
    dividend, by = op.operands[0], op.operands[1].value
    is_quotient, is_signed = op.mnemonic.endswith("div"), op.mnemonic[0] == "s"
    if by & (by - 1) == 0:
        if not is_quotient:
            return replace(op, op="and", operands=(dividend, Int(by - 1)))
        return replace(
            op, op="ashr" if is_signed else "lshr", operands=(dividend, Int(by.bit_length() - 1))
        )
    return op if is_signed else replace(op, op="udiv" if is_quotient else "urem")
