"""Kinds of operations as costs and statistics see them: latency class and precision."""

from __future__ import annotations

from typing import Final

from vividc.machine.opcodes import MEMORY, OPCODES, LatencyClass, Opcode, Type

_PRECISIONS: Final = (
    *((type_, type_.value) for type_ in (Type.F16, Type.E4M3, Type.E5M2)),
    (Type.F32, "f32"),
    (Type.I32, "i32"),
)
_NOT_EXECUTED: Final = (LatencyClass.SOURCE, LatencyClass.SINK, LatencyClass.GENERIC)


def kind_of(opcode: Opcode) -> tuple[str, str]:
    """Latency class and precision: a float's format, "i32", or "word" for what moves words of any
    type.
    """
    info = OPCODES[opcode]
    if opcode in MEMORY:
        return info.latency_class.value, "word"
    types = (*info.operands, info.result)
    names = (name for type_, name in _PRECISIONS if type_ in types)
    return info.latency_class.value, next(names, "word")


KINDS: Final = tuple(
    sorted(
        {
            ".".join(kind_of(info.opcode))
            for info in OPCODES.values()
            if info.latency_class not in _NOT_EXECUTED
        }
    )
)
"""The kinds of all operations that an FU executes, as "fma.f32"."""
