"""The table of operation names in other tools' graphs; `docs/dfg-formats.md` shows it.

Names are compared without regard to case. An operation that is no memory access and no constant
becomes `generic`, keeps its name and runs on every PE whose FU has its latency class.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from vividc.machine.opcodes import CLASS_OF_NAME as OWN_CLASSES
from vividc.machine.opcodes import LatencyClass, Opcode


@dataclass(frozen=True, slots=True)
class NameRow:
    """Names with one meaning.

    Attributes
    ----------
    names
        In lower case.
    opcode
        What a node of that name becomes.
    latency_class
        Which latency of the fabric applies, and which FUs have the operation.
    width
        Bytes accessed by a memory operation.
    """

    names: tuple[str, ...]
    opcode: Opcode
    latency_class: LatencyClass
    width: int = 4


def _memory(opcode: Opcode, stem: str, extra: tuple[str, ...]) -> tuple[NameRow, ...]:
    """Morpher's `O` operations access memory outside the loop; a suffix gives the width."""
    latency = LatencyClass(opcode.value)
    words = (*extra, stem, f"{stem}w", f"o{stem}", f"o{stem}w")
    return (
        NameRow(words, opcode, latency, 4),
        NameRow((f"{stem}h", f"o{stem}h"), opcode, latency, 2),
        NameRow((f"{stem}b", f"o{stem}b"), opcode, latency, 1),
    )


def _generic(names: str, latency_class: LatencyClass) -> NameRow:
    return NameRow(tuple(names.split()), Opcode.GENERIC, latency_class)


NAME_ROWS: Final[tuple[NameRow, ...]] = (
    *_memory(Opcode.LOAD, "load", ("ld",)),
    *_memory(Opcode.STORE, "store", ("st",)),
    NameRow(("const", "constant", "cst", "imm"), Opcode.CONST, LatencyClass.SOURCE),
    _generic(
        "add iadd sub isub rsub neg and or xor not nand nor xnor shl shr shra shrl lshr ashr asr"
        " lsl lsr ls rs ars sl sr sra srl sll shift rot abs min max cat sext zext trunc ext"
        " bitcast gep getelementptr mov movc movcl copy pass route",
        LatencyClass.INT,
    ),
    _generic("mul mult imul mulh smul umul mac madd", LatencyClass.IMUL),
    _generic(
        "cmp icmp fcmp eq ne lt le gt ge ceq cne clt cle cgt cge slt sle sgt sge ult ule ugt uge",
        LatencyClass.COMPARE,
    ),
    _generic("select sel mux merge cmerge phi", LatencyClass.SELECT),
    _generic("fadd fsub", LatencyClass.FADD),
    _generic("fmul", LatencyClass.FMUL),
    _generic("fma fmac fmadd fmuladd fms fmsub fnma fnmadd fnmsub", LatencyClass.FMA),
    _generic("sitofp uitofp fptosi fptoui fpext fptrunc", LatencyClass.CONVERT),
    _generic(
        "input in output out div idiv sdiv udiv rem srem urem mod fdiv frem sqrt exp nop br jump"
        " jumpl jmp ret call",
        LatencyClass.GENERIC,
    ),
)

CLASS_OF_NAME: Final[dict[str, LatencyClass]] = {
    name: row.latency_class for row in NAME_ROWS for name in row.names
} | OWN_CLASSES
"""Latency class of a foreign operation by its name in lower case; vividc's own names are known."""

_ROW_OF: Final = {name: row for row in NAME_ROWS for name in row.names}


def row_of(name: str) -> NameRow | None:
    """The row of a foreign name, or None if the table does not have it."""
    return _ROW_OF.get(name.lower())


def is_known(name: str) -> bool:
    """Whether the table, or vividc itself, has an operation of this name."""
    return name.lower() in CLASS_OF_NAME
