"""Inverses of the comparisons: the operation that gives 1 exactly where another gives 0."""

from __future__ import annotations

from typing import Final

from vividc.machine.opcodes import OPCODES, LatencyClass, Opcode, Type

# (operation, whether its operands are swapped); not (a < b) is b <= a, or unordered.
_PAIRS: Final = (
    (Opcode.ICMP_EQ, Opcode.ICMP_NE, False),
    (Opcode.ICMP_SLT, Opcode.ICMP_SLE, True),
    (Opcode.ICMP_ULT, Opcode.ICMP_ULE, True),
    (Opcode.FCMP_OEQ, Opcode.FCMP_UNE, False),
    (Opcode.FCMP_OLT, Opcode.FCMP_ULE, True),
    (Opcode.FCMP_OLE, Opcode.FCMP_ULT, True),
    (Opcode.FCMP_ONE, Opcode.FCMP_UEQ, False),
    (Opcode.FCMP_ORD, Opcode.FCMP_UNO, False),
)
INVERSES: Final[dict[Opcode, tuple[Opcode, bool]]] = {
    **{a: (b, swapped) for a, b, swapped in _PAIRS},
    **{b: (a, swapped) for a, b, swapped in _PAIRS},
}


def is_comparison(op: Opcode) -> bool:
    """Whether the operation compares two words and so gives 0 or 1."""
    info = OPCODES[op]
    return info.latency_class is LatencyClass.COMPARE and info.result is Type.PRED
