"""Every operation of an FU as LLVM IR on 32-bit words: the second writing of `machine.semantics`.

No fast-math flag is set, so LLVM keeps round to nearest even, subnormals and the order of
operations; an arithmetic NaN becomes the canonical one by a select.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from vividc.machine.opcodes import Opcode
from vividc.machine.words import CANONICAL_NAN, INT_MAX, SIGN_BIT
from vividc.sim.native.write.lanes import LANE_DECLARATIONS, LANE_LOWERINGS, Lowering
from vividc.sim.native.write.text import Code

DECLARATIONS: Final = (
    "declare float @llvm.fma.f32(float, float, float)\n"
    "declare i32 @llvm.fptosi.sat.i32.f32(float)\n"
    "declare i32 @llvm.smin.i32(i32, i32)\n"
    "declare i32 @llvm.smax.i32(i32, i32)\n"
) + LANE_DECLARATIONS


def lower(code: Code, op: Opcode, words: Sequence[str]) -> str:
    """The i32 result of `op`, not a memory operation, on i32 operands."""
    return _LOWERINGS[op](code, words)


def _signed32(number: int) -> int:
    return number - ((number & SIGN_BIT) << 1)


def _float(code: Code, word: str) -> str:
    return code.value(f"bitcast i32 {word} to float")


def _floats(code: Code, words: Sequence[str]) -> list[str]:
    return [_float(code, word) for word in words]


def _word(code: Code, number: str) -> str:
    """Bits of an arithmetic result, NaN canonical."""
    bits = code.value(f"bitcast float {number} to i32")
    is_nan = code.value(f"fcmp uno float {number}, {number}")
    return code.choose(is_nan, "i32", str(CANONICAL_NAN), bits)


def _value(pattern: str) -> Lowering:
    """One instruction on the words."""
    return lambda code, words: code.value(pattern.format(*words))


def _binary(name: str) -> Lowering:
    return _value(f"{name} i32 {{}}, {{}}")


def _intrinsic(name: str) -> Lowering:
    return _value(f"call i32 @llvm.{name}.i32(i32 {{}}, i32 {{}})")


def _with_bits(name: str, mask: int) -> Lowering:
    return _value(f"{name} i32 {{}}, {_signed32(mask)}")


def _shift(name: str) -> Lowering:
    def lowering(code: Code, words: Sequence[str]) -> str:
        amount = code.value(f"and i32 {words[1]}, 31")
        return code.value(f"{name} i32 {words[0]}, {amount}")

    return lowering


def _high(extend: str) -> Lowering:
    def lowering(code: Code, words: Sequence[str]) -> str:
        a, b = (code.value(f"{extend} i32 {word} to i64") for word in words)
        product = code.value(f"mul i64 {a}, {b}")
        high = code.value(f"lshr i64 {product}, 32")
        return code.value(f"trunc i64 {high} to i32")

    return lowering


def _compared(comparison: str) -> Lowering:
    def lowering(code: Code, words: Sequence[str]) -> str:
        operands = ", ".join(_floats(code, words) if "fcmp" in comparison else words)
        holds = code.value(f"{comparison} {operands}")
        return code.value(f"zext i1 {holds} to i32")

    return lowering


def _arithmetic(name: str) -> Lowering:
    def lowering(code: Code, words: Sequence[str]) -> str:
        x, y = _floats(code, words)
        return _word(code, code.value(f"{name} float {x}, {y}"))

    return lowering


def _converted(name: str) -> Lowering:
    def lowering(code: Code, words: Sequence[str]) -> str:
        number = code.value(f"{name} i32 {words[0]} to float")
        return code.value(f"bitcast float {number} to i32")

    return lowering


def _extremum(comparison: str, if_equal: str) -> Lowering:
    """minimumNumber or maximumNumber; equal numbers share all bits but the sign of zero."""

    def lowering(code: Code, words: Sequence[str]) -> str:
        a, b = words
        x, y = _floats(code, words)
        first = code.value(f"fcmp {comparison} float {x}, {y}")
        equal = code.value(f"fcmp oeq float {x}, {y}")
        x_is_nan = code.value(f"fcmp uno float {x}, {x}")
        y_is_nan = code.value(f"fcmp uno float {y}, {y}")
        merged = code.value(f"{if_equal} i32 {a}, {b}")
        result = code.choose(first, "i32", a, b)
        result = code.choose(equal, "i32", merged, result)
        if_y_is_nan = code.choose(x_is_nan, "i32", str(CANONICAL_NAN), a)
        return code.choose(y_is_nan, "i32", if_y_is_nan, result)

    return lowering


def _select(code: Code, words: Sequence[str]) -> str:
    holds = code.value(f"icmp ne i32 {words[0]}, 0")
    return code.choose(holds, "i32", words[1], words[2])


def _fused(negated: int | None = None) -> Lowering:
    """A product and an addend, of which one operand may be negated."""

    def lowering(code: Code, words: Sequence[str]) -> str:
        numbers = _floats(code, words)
        if negated is not None:
            numbers[negated] = code.value(f"fneg float {numbers[negated]}")
        arguments = ", ".join(f"float {number}" for number in numbers)
        return _word(code, code.value(f"call float @llvm.fma.f32({arguments})"))

    return lowering


def _fptosi(code: Code, words: Sequence[str]) -> str:
    return code.value(f"call i32 @llvm.fptosi.sat.i32.f32(float {_float(code, words[0])})")


_LOWERINGS: Final[dict[Opcode, Lowering]] = {
    Opcode.MOV: lambda _, words: words[0],
    Opcode.ADD: _binary("add"),
    Opcode.SUB: _binary("sub"),
    Opcode.MUL: _binary("mul"),
    Opcode.MULHS: _high("sext"),
    Opcode.MULHU: _high("zext"),
    Opcode.AND: _binary("and"),
    Opcode.OR: _binary("or"),
    Opcode.XOR: _binary("xor"),
    Opcode.SHL: _shift("shl"),
    Opcode.LSHR: _shift("lshr"),
    Opcode.ASHR: _shift("ashr"),
    Opcode.SMIN: _intrinsic("smin"),
    Opcode.SMAX: _intrinsic("smax"),
    Opcode.ICMP_EQ: _compared("icmp eq i32"),
    Opcode.ICMP_NE: _compared("icmp ne i32"),
    Opcode.ICMP_SLT: _compared("icmp slt i32"),
    Opcode.ICMP_SLE: _compared("icmp sle i32"),
    Opcode.ICMP_ULT: _compared("icmp ult i32"),
    Opcode.ICMP_ULE: _compared("icmp ule i32"),
    Opcode.SELECT: _select,
    Opcode.FADD: _arithmetic("fadd"),
    Opcode.FSUB: _arithmetic("fsub"),
    Opcode.FMUL: _arithmetic("fmul"),
    Opcode.FMA: _fused(),
    Opcode.FMS: _fused(negated=2),
    Opcode.FNMA: _fused(negated=0),
    Opcode.FNEG: _with_bits("xor", SIGN_BIT),
    Opcode.FABS: _with_bits("and", INT_MAX),
    Opcode.FMIN: _extremum("olt", "or"),
    Opcode.FMAX: _extremum("ogt", "and"),
    Opcode.FCMP_OEQ: _compared("fcmp oeq float"),
    Opcode.FCMP_UNE: _compared("fcmp une float"),
    Opcode.FCMP_OLT: _compared("fcmp olt float"),
    Opcode.FCMP_OLE: _compared("fcmp ole float"),
    Opcode.FCMP_ULT: _compared("fcmp ult float"),
    Opcode.FCMP_ULE: _compared("fcmp ule float"),
    Opcode.FCMP_ONE: _compared("fcmp one float"),
    Opcode.FCMP_UEQ: _compared("fcmp ueq float"),
    Opcode.FCMP_ORD: _compared("fcmp ord float"),
    Opcode.FCMP_UNO: _compared("fcmp uno float"),
    Opcode.SITOFP: _converted("sitofp"),
    Opcode.UITOFP: _converted("uitofp"),
    Opcode.FPTOSI: _fptosi,
    **LANE_LOWERINGS,
}

LOWERED: Final = frozenset(_LOWERINGS)
"""Operations with a lowering here; loads and stores are the region's."""
