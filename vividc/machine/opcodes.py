"""The opcode table: name, arity, types and latency class of every operation; semantics are beside
it.

Values are 32-bit words. A predicate is a word that is 0 or 1. Operand ports are numbered 0, 1, 2;
`PRED`, `BASE` and `ORDER` are the ports of predication, of a memory base address, and of an edge
that carries no value. An operation whose predicate is 0 passes its last data operand through (`fma
a, b, c` gives `c`); a store or load whose predicate is 0 does not access memory (a load gives 0).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Final

PRED: Final = 3
BASE: Final = 4
ORDER: Final = -1


class Named(Enum):
    """An enum whose members hash by identity: they are keys of the busiest tables."""

    __hash__ = object.__hash__


class Type(Named):
    """What the bits of a word mean to an operation."""

    I32 = "i32"
    F32 = "f32"
    F16 = "f16"  # one number, or two in the lanes of a word (`vividc.formats`)
    E4M3 = "e4m3"  # one to four
    E5M2 = "e5m2"
    PRED = "pred"
    ANY = "any"
    NONE = "none"


class LatencyClass(Named):
    """Operations that share a latency; a fabric gives the cycles of each class."""

    SOURCE = "source"  # not executed: constant, live-in, induction value
    SINK = "sink"  # not executed by the FU: live-out
    INT = "int"
    IMUL = "imul"
    COMPARE = "compare"
    SELECT = "select"
    FADD = "fadd"
    FMUL = "fmul"
    FMA = "fma"
    CONVERT = "convert"
    DOT = "dot"
    LOAD = "load"
    STORE = "store"
    GENERIC = "generic"  # an operation of a foreign DFG, known by its name only


class Opcode(Named):
    """Every operation of the IR; the value is its name in text, JSON and DOT."""

    CONST = "const"
    LIVE_IN = "live_in"
    IV = "iv"
    LIVE_OUT = "live_out"
    MOV = "mov"
    ADD = "add"
    SUB = "sub"
    MUL = "mul"
    MULHS = "mulhs"  # high word of the signed product
    MULHU = "mulhu"
    AND = "and"
    OR = "or"
    XOR = "xor"
    SHL = "shl"
    LSHR = "lshr"
    ASHR = "ashr"
    SMIN = "smin"
    SMAX = "smax"
    ICMP_EQ = "icmp.eq"
    ICMP_NE = "icmp.ne"
    ICMP_SLT = "icmp.slt"
    ICMP_SLE = "icmp.sle"
    ICMP_ULT = "icmp.ult"
    ICMP_ULE = "icmp.ule"
    SELECT = "select"
    FADD = "fadd"
    FSUB = "fsub"
    FMUL = "fmul"
    FMA = "fma"  # a * b + c
    FMS = "fms"  # a * b - c
    FNMA = "fnma"  # c - a * b
    FNEG = "fneg"
    FABS = "fabs"
    FMIN = "fmin"
    FMAX = "fmax"
    FCMP_OEQ = "fcmp.oeq"
    FCMP_UNE = "fcmp.une"
    FCMP_OLT = "fcmp.olt"
    FCMP_OLE = "fcmp.ole"
    FCMP_ULT = "fcmp.ult"
    FCMP_ULE = "fcmp.ule"
    FCMP_ONE = "fcmp.one"
    FCMP_UEQ = "fcmp.ueq"
    FCMP_ORD = "fcmp.ord"
    FCMP_UNO = "fcmp.uno"
    SITOFP = "sitofp"
    UITOFP = "uitofp"
    FPTOSI = "fptosi"
    # Lanes of a word: two f16, or four e4m3 or e5m2 (`machine.lane_semantics`).
    SELECT_X2 = "select.x2"
    SELECT_X4 = "select.x4"
    MERGE_X2 = "merge.x2"
    MERGE_X4 = "merge.x4"
    EXTRACT_X2 = "extract.x2"
    EXTRACT_X4 = "extract.x4"
    FADD_F16X2 = "fadd.f16x2"
    FSUB_F16X2 = "fsub.f16x2"
    FMUL_F16X2 = "fmul.f16x2"
    FMA_F16X2 = "fma.f16x2"
    FMS_F16X2 = "fms.f16x2"
    FNMA_F16X2 = "fnma.f16x2"
    FMIN_F16X2 = "fmin.f16x2"
    FMAX_F16X2 = "fmax.f16x2"
    FCMP_OEQ_F16X2 = "fcmp.oeq.f16x2"
    FCMP_UNE_F16X2 = "fcmp.une.f16x2"
    FCMP_OLT_F16X2 = "fcmp.olt.f16x2"
    FCMP_OLE_F16X2 = "fcmp.ole.f16x2"
    FCMP_ULT_F16X2 = "fcmp.ult.f16x2"
    FCMP_ULE_F16X2 = "fcmp.ule.f16x2"
    FPTRUNC_F16 = "fptrunc.f16"
    FPEXT_F16 = "fpext.f16"
    PACK_F16X2 = "pack.f16x2"
    UNPACK_F16X2 = "unpack.f16x2"
    DOT_F16X2 = "dot.f16x2"
    FADD_E4M3X4 = "fadd.e4m3x4"
    FSUB_E4M3X4 = "fsub.e4m3x4"
    FMUL_E4M3X4 = "fmul.e4m3x4"
    FMA_E4M3X4 = "fma.e4m3x4"
    FMS_E4M3X4 = "fms.e4m3x4"
    FNMA_E4M3X4 = "fnma.e4m3x4"
    FMIN_E4M3X4 = "fmin.e4m3x4"
    FMAX_E4M3X4 = "fmax.e4m3x4"
    FCMP_OEQ_E4M3X4 = "fcmp.oeq.e4m3x4"
    FCMP_UNE_E4M3X4 = "fcmp.une.e4m3x4"
    FCMP_OLT_E4M3X4 = "fcmp.olt.e4m3x4"
    FCMP_OLE_E4M3X4 = "fcmp.ole.e4m3x4"
    FCMP_ULT_E4M3X4 = "fcmp.ult.e4m3x4"
    FCMP_ULE_E4M3X4 = "fcmp.ule.e4m3x4"
    FPTRUNC_E4M3 = "fptrunc.e4m3"
    FPEXT_E4M3 = "fpext.e4m3"
    PACK_E4M3X4 = "pack.e4m3x4"
    PACK_HIGH_E4M3X4 = "pack_high.e4m3x4"
    UNPACK_E4M3X4 = "unpack.e4m3x4"
    DOT_E4M3X4 = "dot.e4m3x4"
    FADD_E5M2X4 = "fadd.e5m2x4"
    FSUB_E5M2X4 = "fsub.e5m2x4"
    FMUL_E5M2X4 = "fmul.e5m2x4"
    FMA_E5M2X4 = "fma.e5m2x4"
    FMS_E5M2X4 = "fms.e5m2x4"
    FNMA_E5M2X4 = "fnma.e5m2x4"
    FMIN_E5M2X4 = "fmin.e5m2x4"
    FMAX_E5M2X4 = "fmax.e5m2x4"
    FCMP_OEQ_E5M2X4 = "fcmp.oeq.e5m2x4"
    FCMP_UNE_E5M2X4 = "fcmp.une.e5m2x4"
    FCMP_OLT_E5M2X4 = "fcmp.olt.e5m2x4"
    FCMP_OLE_E5M2X4 = "fcmp.ole.e5m2x4"
    FCMP_ULT_E5M2X4 = "fcmp.ult.e5m2x4"
    FCMP_ULE_E5M2X4 = "fcmp.ule.e5m2x4"
    FPTRUNC_E5M2 = "fptrunc.e5m2"
    FPEXT_E5M2 = "fpext.e5m2"
    PACK_E5M2X4 = "pack.e5m2x4"
    PACK_HIGH_E5M2X4 = "pack_high.e5m2x4"
    UNPACK_E5M2X4 = "unpack.e5m2x4"
    DOT_E5M2X4 = "dot.e5m2x4"
    LOAD = "load"
    STORE = "store"
    GENERIC = "generic"
    # Only before `expand_math`: no FU has one of the following.
    EXP = "exp"
    EXP2 = "exp2"
    FDIV = "fdiv"
    SQRT = "sqrt"
    FLOOR = "floor"
    CEIL = "ceil"
    SDIV = "sdiv"
    UDIV = "udiv"
    SREM = "srem"
    UREM = "urem"
    CTPOP = "ctpop"
    CTLZ = "ctlz"
    CTTZ = "cttz"
    BSWAP = "bswap"
    BITREVERSE = "bitreverse"
    TRUNC = "trunc"
    RINT = "rint"
    LOG = "log"
    LOG2 = "log2"
    LOG10 = "log10"
    LOG1P = "log1p"
    EXPM1 = "expm1"
    SIN = "sin"
    COS = "cos"
    TAN = "tan"
    SINH = "sinh"
    COSH = "cosh"
    TANH = "tanh"
    ASIN = "asin"
    ACOS = "acos"
    ATAN = "atan"
    ATAN2 = "atan2"
    HYPOT = "hypot"
    POW = "pow"
    FREM = "frem"


@dataclass(frozen=True, slots=True)
class OpInfo:
    """The contract of one opcode. `operands` are the types of ports 0, 1, ...; `commutes`: 0 and 1
    may swap.
    """

    opcode: Opcode
    operands: tuple[Type, ...]
    result: Type
    latency_class: LatencyClass
    commutes: bool = False

    @property
    def arity(self) -> int:
        """Number of data operands."""
        return len(self.operands)

    @property
    def sliced(self) -> bool:
        """Needs an FU whose float unit is made of slices: it works on numbers of 8 or 16 bits."""
        return not LANE_TYPES.isdisjoint((*self.operands, self.result))


LANE_TYPES: Final = frozenset({Type.F16, Type.E4M3, Type.E5M2})
"""Types of the formats of less than 32 bits."""
_FLOATS: Final = LANE_TYPES | {Type.F32, Type.PRED}


def never_meet(given: Type, wanted: Type) -> bool:
    """Whether a word of one type read as the other makes no sense: floats of two formats, or a
    float and a predicate.
    """
    return given is not wanted and given in _FLOATS and wanted in _FLOATS


def _lane_rows() -> list[OpInfo]:
    """Operations on lanes; those of the three formats are alike."""
    i, x, lat = Type.I32, Type.ANY, LatencyClass
    rows = []
    for op in Opcode:
        name, _, width = op.value.rpartition(".")
        kind = _LANES.get(width)
        if width in ("x2", "x4"):
            shapes = {
                "select": ((x, x, x), x, lat.SELECT),
                "merge": ((x, x), x, lat.INT),
                "extract": ((x, i), x, lat.INT),
            }
            rows.append(OpInfo(op, *shapes[name]))
        elif kind is not None:
            rows.append(_lane_row(op, name, kind))
    return rows


_LANES: Final = {
    "f16": Type.F16,
    "e4m3": Type.E4M3,
    "e5m2": Type.E5M2,
    "f16x2": Type.F16,
    "e4m3x4": Type.E4M3,
    "e5m2x4": Type.E5M2,
}
"""Type of the numbers of an operation by the last part of its name."""


_FUSED: Final = ("fma", "fms", "fnma")
_COMMUTING: Final = ("fadd", "fmul", *_FUSED, "dot")


def _lane_row(op: Opcode, name: str, n: Type) -> OpInfo:
    i, f, lat = Type.I32, Type.F32, LatencyClass
    if name.startswith("fcmp"):
        return OpInfo(op, (n, n), i, lat.COMPARE, name in ("fcmp.oeq", "fcmp.une"))
    shapes: dict[str, tuple[tuple[Type, ...], Type, LatencyClass]] = {
        "fadd": ((n, n), n, lat.FADD),
        "fsub": ((n, n), n, lat.FADD),
        "fmul": ((n, n), n, lat.FMUL),
        **dict.fromkeys(_FUSED, ((n, n, n), n, lat.FMA)),
        "fmin": ((n, n), n, lat.COMPARE),
        "fmax": ((n, n), n, lat.COMPARE),
        "fptrunc": ((f,), n, lat.CONVERT),
        "fpext": ((n,), f, lat.CONVERT),
        "pack": ((f, f), n, lat.CONVERT),
        "pack_high": ((f, f, n), n, lat.CONVERT),
        "unpack": ((n, i), f, lat.CONVERT),
        "dot": ((n, n, f), f, lat.DOT),
    }
    operands, result, latency_class = shapes[name]
    return OpInfo(op, operands, result, latency_class, name in _COMMUTING)


def _table() -> dict[Opcode, OpInfo]:
    i, f, p, x, none = Type.I32, Type.F32, Type.PRED, Type.ANY, Type.NONE
    lat = LatencyClass
    rows: list[OpInfo] = []

    def row(
        ops: tuple[Opcode, ...],
        operands: tuple[Type, ...],
        result: Type,
        latency_class: LatencyClass,
        *,
        commutes: bool = False,
    ) -> None:
        rows.extend(OpInfo(op, operands, result, latency_class, commutes) for op in ops)

    o = Opcode
    row((o.CONST, o.LIVE_IN), (), x, lat.SOURCE)
    row((o.IV,), (), i, lat.SOURCE)
    row((o.LIVE_OUT,), (x,), none, lat.SINK)
    row((o.MOV,), (x,), x, lat.INT)
    row((o.ADD, o.AND, o.OR, o.XOR), (i, i), i, lat.INT, commutes=True)
    row((o.SMIN, o.SMAX), (i, i), i, lat.INT, commutes=True)
    row((o.SUB, o.SHL, o.LSHR, o.ASHR), (i, i), i, lat.INT)
    row((o.MUL, o.MULHS, o.MULHU), (i, i), i, lat.IMUL, commutes=True)
    row((o.ICMP_EQ, o.ICMP_NE), (i, i), p, lat.COMPARE, commutes=True)
    row((o.ICMP_SLT, o.ICMP_SLE, o.ICMP_ULT, o.ICMP_ULE), (i, i), p, lat.COMPARE)
    row((o.SELECT,), (p, x, x), x, lat.SELECT)
    row((o.FADD,), (f, f), f, lat.FADD, commutes=True)
    row((o.FSUB,), (f, f), f, lat.FADD)
    row((o.FMUL,), (f, f), f, lat.FMUL, commutes=True)
    row((o.FMA, o.FMS, o.FNMA), (f, f, f), f, lat.FMA, commutes=True)
    row((o.FNEG, o.FABS), (f,), f, lat.INT)
    row((o.FMIN, o.FMAX), (f, f), f, lat.COMPARE)
    symmetric = (o.FCMP_OEQ, o.FCMP_UNE, o.FCMP_ONE, o.FCMP_UEQ, o.FCMP_ORD, o.FCMP_UNO)
    row(symmetric, (f, f), p, lat.COMPARE, commutes=True)
    row((o.FCMP_OLT, o.FCMP_OLE, o.FCMP_ULT, o.FCMP_ULE), (f, f), p, lat.COMPARE)
    row((o.SITOFP, o.UITOFP), (i,), f, lat.CONVERT)
    row((o.FPTOSI,), (f,), i, lat.CONVERT)
    row((o.LOAD,), (i,), x, lat.LOAD)
    row((o.STORE,), (i, x), none, lat.STORE)
    row((o.GENERIC,), (), x, lat.GENERIC)
    row((o.EXP, o.EXP2, o.SQRT, o.FLOOR, o.CEIL, o.TRUNC, o.RINT), (f,), f, lat.GENERIC)
    row((o.LOG, o.LOG2, o.LOG10, o.LOG1P, o.EXPM1), (f,), f, lat.GENERIC)
    row((o.SIN, o.COS, o.TAN, o.SINH, o.COSH, o.TANH), (f,), f, lat.GENERIC)
    row((o.ASIN, o.ACOS, o.ATAN), (f,), f, lat.GENERIC)
    row((o.FDIV, o.FREM, o.ATAN2, o.POW), (f, f), f, lat.GENERIC)
    row((o.HYPOT,), (f, f), f, lat.GENERIC, commutes=True)
    row((o.SDIV, o.UDIV, o.SREM, o.UREM), (i, i), i, lat.GENERIC)
    row((o.CTPOP, o.CTLZ, o.CTTZ, o.BSWAP, o.BITREVERSE), (i,), i, lat.GENERIC)
    return {info.opcode: info for info in (*rows, *_lane_rows())}


OPCODES: Final[dict[Opcode, OpInfo]] = _table()
CLASS_OF_NAME: Final[dict[str, LatencyClass]] = {
    "imul": LatencyClass.IMUL,
    "icmp": LatencyClass.COMPARE,
    "fcmp": LatencyClass.COMPARE,
}
CLASS_OF_NAME.update(
    (info.opcode.value, info.latency_class)
    for info in OPCODES.values()
    if info.latency_class not in (LatencyClass.SOURCE, LatencyClass.SINK)
)
"""Latency class of an operation of a foreign DFG, by its name in lower case; others: GENERIC."""
MEMORY: Final = frozenset({Opcode.LOAD, Opcode.STORE})
ELEMENTARY: Final = frozenset(
    info.opcode
    for info in OPCODES.values()
    if info.latency_class is LatencyClass.GENERIC and info.opcode is not Opcode.GENERIC
)
"""Operations that `expand_math` replaces."""
EXPANDED_FLOATS: Final = frozenset(op for op in ELEMENTARY if OPCODES[op].result is Type.F32)
"""Those of them that may give other bits than `machine.semantics`, as `atan(1)` does: constants go
through the expansion, too, so that it does not show where they are known.
"""
SOURCES: Final = frozenset({Opcode.CONST, Opcode.LIVE_IN, Opcode.IV})
FUSED: Final = {
    (Opcode.FADD, 0): Opcode.FMA,
    (Opcode.FADD, 1): Opcode.FMA,
    (Opcode.FSUB, 0): Opcode.FMS,
    (Opcode.FSUB, 1): Opcode.FNMA,
}
"""The one operation that is a sum or difference with a product as operand 0 or 1."""
NEGATED_FACTOR: Final = {Opcode.FMA: Opcode.FNMA, Opcode.FNMA: Opcode.FMA}
NEGATED_ADDEND: Final = {Opcode.FMA: Opcode.FMS, Opcode.FMS: Opcode.FMA}
"""The fused operation that another one is with one operand negated."""
