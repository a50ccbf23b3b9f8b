"""Operations on float16 and float8, which numba's target calls by name, as operations of lanes.

A number is lane 0 of a word; the other lanes are 0, and stay so: a sum, product or fused product of
zeros is 0. Words with all lanes are those of `lang.lanes`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from vividc.formats import FORMATS, Format
from vividc.frontend.narrow.emit import Emitter
from vividc.lang.numba_types import symbol
from vividc.machine.opcodes import Opcode
from vividc.ssa.ir import Instr

Rule = Callable[[Emitter, Instr], None]


def _rule(opcode: Opcode) -> Rule:
    def rule(emitter: Emitter, op: Instr) -> None:
        emitter.emit(op, opcode, tuple(emitter.value(arg) for arg in op.operands))

    return rule


def _opcodes(fmt: Format) -> dict[str, Opcode]:
    """Opcodes of a format by the names of `lang.numba_types`."""
    packed = f"{fmt.name}x{fmt.lanes}"
    opcodes = {name: Opcode(f"f{name}.{packed}") for name in ("add", "sub", "mul")}
    opcodes["fma"] = Opcode(f"fma.{packed}")
    opcodes["from_f32"] = Opcode(f"fptrunc.{fmt.name}")
    opcodes["to_f32"] = Opcode(f"fpext.{fmt.name}")
    opcodes["pack"] = Opcode(f"pack.{packed}")
    opcodes["lanes_max"] = Opcode(f"fmax.{packed}")
    opcodes["dot"] = Opcode(f"dot.{packed}")
    if fmt.lanes > 2:  # noqa: PLR2004 - the lanes that `pack` fills
        opcodes["pack_high"] = Opcode(f"pack_high.{packed}")
    return opcodes


CALLS: Final[dict[str, Rule]] = {
    symbol(name, fmt): _rule(opcode)
    for fmt in FORMATS.values()
    for name, opcode in _opcodes(fmt).items()
}
