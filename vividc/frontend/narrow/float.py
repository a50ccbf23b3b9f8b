"""Floating-point instructions in float32."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from vividc.errors import KernelError
from vividc.frontend.advice import Advice
from vividc.frontend.narrow.emit import Emitter
from vividc.frontend.narrow.small import emit_masked, is_small, sign_extended
from vividc.frontend.ranges.interval import width
from vividc.machine.opcodes import Opcode, Type
from vividc.machine.words import WORD_MASK
from vividc.ssa.ir import Const, Float, Instr, Named, Value

Rule = Callable[[Emitter, Instr], None]

_O = Opcode
_COMPARE: dict[str, tuple[Opcode, bool]] = {
    "oeq": (_O.FCMP_OEQ, False),
    "one": (_O.FCMP_ONE, False),
    "ueq": (_O.FCMP_UEQ, False),
    "une": (_O.FCMP_UNE, False),
    "ord": (_O.FCMP_ORD, False),
    "uno": (_O.FCMP_UNO, False),
    "olt": (_O.FCMP_OLT, False),
    "ole": (_O.FCMP_OLE, False),
    "ult": (_O.FCMP_ULT, False),
    "ule": (_O.FCMP_ULE, False),
    "ogt": (_O.FCMP_OLT, True),
    "oge": (_O.FCMP_OLE, True),
    "ugt": (_O.FCMP_ULT, True),
    "uge": (_O.FCMP_ULE, True),
}
_SIGN = 0x80000000


def _direct(opcode: Opcode) -> Rule:
    def rule(emitter: Emitter, op: Instr) -> None:
        _check_type(op)
        emitter.emit(op, opcode, tuple(emitter.value(arg) for arg in op.operands))

    return rule


def _arithmetic(opcode: Opcode) -> Rule:
    """As `_direct`, and a double's result is rounded differently."""
    plain = _direct(opcode)

    def rule(emitter: Emitter, op: Instr) -> None:
        if op.type == "double":
            _check_literals(op)
            emitter.demote(op)
        plain(emitter, op)

    return rule


def _check_literals(op: Instr) -> None:
    """A literal that float32 would turn into infinity or zero is refused, not rounded."""
    for arg in op.operands:
        if not isinstance(arg, Float) or not math.isfinite(arg.value) or arg.value == 0:
            continue
        with np.errstate(over="ignore", under="ignore"):
            rounded = float(np.float32(arg.value))
        if rounded == 0 or math.isinf(rounded):
            raise KernelError(
                f"{arg.value!r} does not fit float32, and the array has no float64",
                loc=op.loc,
                hint="scale the values so that all stay between 1.2e-38 and 3.4e38",
            )


def _check_type(op: Instr) -> None:
    if op.type not in ("float", "double"):
        hint = Advice("use float32", c="use float")
        raise KernelError(f"arithmetic on {op.type}", loc=op.loc, hint=hint)


def _compare(emitter: Emitter, op: Instr) -> None:
    if op.type == "double" and not all(_is_float32(emitter, arg) for arg in op.operands):
        _check_literals(op)
        emitter.demote(op)
    opcode, swap = _COMPARE[op.pred]
    left, right = (emitter.value(arg) for arg in op.operands)
    emitter.emit(op, opcode, (right, left) if swap else (left, right))


def _is_float32(emitter: Emitter, operand: Value) -> bool:
    """Whether a double is a float32 exactly."""
    if isinstance(operand, Float):
        with np.errstate(over="ignore"):
            rounded = float(np.float32(operand.value))
        return rounded == operand.value or operand.value != operand.value
    definition = (
        emitter.function.definitions.get(operand.key) if isinstance(operand, Named) else None
    )
    return isinstance(definition, Instr) and definition.op == "fpext"


def _from_int(emitter: Emitter, op: Instr) -> None:
    """The conversion rounds once, from the exact integer."""
    [operand] = op.operands
    source = op.source
    if source == "i1":
        word = emitter.value(operand)
        if op.op == "sitofp":
            word = emitter.helper(op, Opcode.SUB, Const(0), word)
        emitter.emit(op, Opcode.SITOFP, (word,))
        return
    if op.op == "sitofp" and is_small(source):
        emitter.emit(op, Opcode.SITOFP, (sign_extended(emitter, op, operand, width(source)),))
        return
    if op.type == "double":
        low, high = emitter.range(operand)
        if max(-low, high) > 2**24:
            emitter.demote(op)
    unsigned_word = op.op == "uitofp" and source == "i32"
    nonnegative = emitter.range(operand)[0] >= 0
    if emitter.signed(operand) and (op.op == "sitofp" or nonnegative):
        emitter.emit(op, Opcode.SITOFP, (emitter.value(operand),))
    elif unsigned_word or (nonnegative and emitter.unsigned(operand)):
        emitter.emit(op, Opcode.UITOFP, (emitter.value(operand),))
    else:
        hint = Advice(
            "convert the integer first: np.float32(np.int32(...))",
            c="cast the integer first: (float)(int32_t)n",
        )
        emitter.require_signed(operand, op.loc, "the integer converted to a float", hint)
        raise KernelError("a negative integer, converted as unsigned", loc=op.loc, hint=hint)


def _to_signed(emitter: Emitter, op: Instr) -> None:
    if op.type == "i64":
        emitter.saturated.append(op.loc)
    emit_masked(emitter, op, Opcode.FPTOSI, emitter.value(op.operands[0]))


def _to_unsigned(emitter: Emitter, op: Instr) -> None:
    """Values from 2**31 on are converted less 2**31, which is exact."""
    if is_small(op.type):
        _to_signed(emitter, op)
        return
    if op.type == "i64":
        emitter.saturated.append(op.loc)
    value = emitter.value(op.operands[0])
    limit = Const(0x4F000000)  # 2**31 as a float32
    small = emitter.helper(op, Opcode.FCMP_OLT, value, limit, type_=Type.PRED)
    less = emitter.helper(op, Opcode.FSUB, value, limit, type_=Type.F32)
    chosen = emitter.helper(op, Opcode.SELECT, small, value, less, type_=Type.F32)
    word = emitter.helper(op, Opcode.FPTOSI, chosen)
    high = emitter.helper(op, Opcode.SELECT, small, Const(0), Const(_SIGN))
    emitter.emit(op, Opcode.XOR, (word, high))


def _copysign(emitter: Emitter, op: Instr) -> None:
    _check_type(op)
    magnitude, sign = (emitter.value(arg) for arg in op.operands)
    bits = emitter.helper(op, Opcode.AND, magnitude, Const(_SIGN - 1))
    top = emitter.helper(op, Opcode.AND, sign, Const(_SIGN))
    emitter.emit(op, Opcode.OR, (bits, top))


def _ldexp(emitter: Emitter, op: Instr) -> None:
    """x * 2**n, rounded once: factors of 2**127 and 2**-102 until n is a normal exponent. After the
    latter a number that lost bits vanishes with the rest of n.
    """
    _check_type(op)
    if op.type == "double":
        emitter.demote(op)
    x, n = (emitter.value(arg) for arg in op.operands)
    for step in (-102, -102, 127, 127):
        bounds = (n, Const(-126 & WORD_MASK)) if step < 0 else (Const(127), n)
        beyond = emitter.helper(op, Opcode.ICMP_SLT, *bounds, type_=Type.PRED)
        scale = Const((step + 127) << 23)
        scaled = emitter.helper(op, Opcode.FMUL, x, scale, type_=Type.F32)
        x = emitter.helper(op, Opcode.SELECT, beyond, scaled, x, type_=Type.F32)
        rest = emitter.helper(op, Opcode.ADD, n, Const(-step & WORD_MASK))
        n = emitter.helper(op, Opcode.SELECT, beyond, rest, n)
    n = emitter.helper(op, Opcode.SMAX, n, Const(-126 & WORD_MASK))
    n = emitter.helper(op, Opcode.SMIN, n, Const(127))
    power = emitter.helper(op, Opcode.SHL, emitter.helper(op, Opcode.ADD, n, Const(127)), Const(23))
    emitter.emit(op, Opcode.FMUL, (x, power))


RULES: dict[str, Rule] = {
    "fadd": _arithmetic(Opcode.FADD),
    "fsub": _arithmetic(Opcode.FSUB),
    "fmul": _arithmetic(Opcode.FMUL),
    "fneg": _direct(Opcode.FNEG),
    "fdiv": _arithmetic(Opcode.FDIV),
    "frem": _arithmetic(Opcode.FREM),
    "fcmp": _compare,
    "sitofp": _from_int,
    "uitofp": _from_int,
    "fptosi": _to_signed,
    "fptoui": _to_unsigned,
}
CALLS: dict[str, Rule] = {
    "fabs": _direct(Opcode.FABS),
    "minnum": _direct(Opcode.FMIN),
    "maxnum": _direct(Opcode.FMAX),
    "minimumnum": _direct(Opcode.FMIN),
    "maximumnum": _direct(Opcode.FMAX),
    "fma": _arithmetic(Opcode.FMA),
    "fmuladd": _arithmetic(Opcode.FMA),
    "copysign": _copysign,
    "ldexp": _ldexp,
    "ldexpf": _ldexp,
    "numba_ldexp": _ldexp,
    "numba_ldexpf": _ldexp,
}
_LIBRARY = {
    "exp": Opcode.EXP,
    "exp2": Opcode.EXP2,
    "sqrt": Opcode.SQRT,
    "floor": Opcode.FLOOR,
    "ceil": Opcode.CEIL,
    "trunc": Opcode.TRUNC,
    "rint": Opcode.RINT,
    "nearbyint": Opcode.RINT,
    "roundeven": Opcode.RINT,
    "log": Opcode.LOG,
    "log2": Opcode.LOG2,
    "log10": Opcode.LOG10,
    "log1p": Opcode.LOG1P,
    "expm1": Opcode.EXPM1,
    "sin": Opcode.SIN,
    "cos": Opcode.COS,
    "tan": Opcode.TAN,
    "sinh": Opcode.SINH,
    "cosh": Opcode.COSH,
    "tanh": Opcode.TANH,
    "asin": Opcode.ASIN,
    "acos": Opcode.ACOS,
    "atan": Opcode.ATAN,
    "atan2": Opcode.ATAN2,
    "hypot": Opcode.HYPOT,
    "pow": Opcode.POW,
    "fmod": Opcode.FREM,
}
for _name, _opcode in _LIBRARY.items():
    # The intrinsic or C's function for doubles, and C's for floats: numba emits either.
    CALLS[_name] = CALLS[f"{_name}f"] = _arithmetic(_opcode)
