"""Integers that a launch decides, as exact formulas; `launch_sizes` has bounds."""

from __future__ import annotations

from typing import Final

from vividc.machine.params import Formula
from vividc.ssa.ir import Function, Input, Instr, Int, Value, definition_of

_DEPTH: Final = 16
_LONGEST: Final = 60
_OPERATORS: Final = {"add": "+", "sub": "+", "mul": "*", "shl": "*"}
_CHOICES: Final = {"llvm.smax": "max", "llvm.smin": "min"}


def exact_formula(function: Function, value: Value) -> Formula | None:
    """The value of an integer of 64 bits as a formula; None: the run decides it, or nobody knows.

    Integers of 64 bits are taken not to overflow: as sizes they could not be those of an array.
    """
    formula = _formula(function, value, _DEPTH)
    return None if formula is None or len(formula) > _LONGEST else formula


def _formula(function: Function, value: Value, depth: int) -> Formula | None:
    if isinstance(value, Int):
        return (value.value,)
    if isinstance(value, Input):
        wide = dict(function.inputs).get(value.key) == "i64"
        return (f"s:{value.key}",) if wide else None
    op = definition_of(function, value)
    if not isinstance(op, Instr) or not depth:
        return None
    if op.op in ("zext", "sext"):
        return _extended(function, op)
    return _computed(function, op, depth) if op.type == "i64" else None


def _computed(function: Function, op: Instr, depth: int) -> Formula | None:
    """A sum, product, difference, minimum or maximum."""
    operator = _OPERATORS.get(op.mnemonic)
    if op.op == "call":
        operator = next((o for name, o in _CHOICES.items() if op.pred.startswith(name)), None)
    if operator is None:
        return None
    left, right = op.operands[:2]
    if op.op == "shl":
        right = Int(1 << right.value) if isinstance(right, Int) else Input("")
    one, other = (_formula(function, operand, depth - 1) for operand in (left, right))
    if one is None or other is None:
        return None
    return (*one, *other, -1, "*", "+") if op.op == "sub" else (*one, *other, operator)


def _extended(function: Function, op: Instr) -> Formula | None:
    """An input of one word, read as it is extended."""
    value = op.operands[0]
    if not isinstance(value, Input):
        return None
    kind = dict(function.inputs).get(value.key)
    if op.op == "zext":
        return (f"u:{value.key}",) if kind in ("i1", "i8", "i16", "i32") else None
    return (f"s:{value.key}",) if kind == "i32" else None
