"""The components of a fabric, as a cost table counts them."""

from __future__ import annotations

from collections import Counter
from typing import Final

from vividc.arch.fabric import PE, Fabric
from vividc.machine.opcodes import LatencyClass
from vividc.machine.words import WORD_BITS
from vividc.program.words.layout import word_layout

_OPERANDS: Final = 4
_FLOAT: Final = frozenset({LatencyClass.FADD, LatencyClass.FMUL, LatencyClass.FMA})
_INTEGER: Final = frozenset({LatencyClass.INT, LatencyClass.COMPARE, LatencyClass.SELECT})


def logic(fabric: Fabric) -> dict[str, int]:
    """Number of each part of `CostTable.area_um2` in a tile."""
    counts: Counter[str] = Counter()
    for pe in fabric.pes:
        counts["integer"] += not pe.classes.isdisjoint(_INTEGER)
        counts["multiplier"] += LatencyClass.IMUL in pe.classes
        counts["float" if pe.sliced else "fp32"] += not pe.classes.isdisjoint(_FLOAT)
        counts["address"] += pe.has_memory
        counts["crosspoint"] += _crosspoints(fabric, pe)
    return dict(counts)


def storage_bits(fabric: Fabric) -> int:
    """Bits of the register files and constant stores of a tile."""
    return WORD_BITS * sum(pe.registers + pe.constants for pe in fabric.pes)


def configuration_bits(fabric: Fabric) -> int:
    """Bits of the configuration memories of a tile: one entry a PE and context."""
    return len(fabric.pes) * fabric.controller.contexts * word_layout(fabric).bits


def _crosspoints(fabric: Fabric, pe: PE) -> int:
    """Sources times targets of the crossbar: incoming links, RF read ports and the FU lead to
    outgoing links, RF write ports and the FU's operands.
    """
    sources = len(fabric.links_to[pe.id]) + pe.read_ports + 1
    return sources * (len(fabric.links_from[pe.id]) + pe.write_ports + _OPERANDS)
