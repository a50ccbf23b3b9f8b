"""Phis of high words."""

from __future__ import annotations

from dataclasses import dataclass

from vividc.frontend.narrow.emit import Emitter
from vividc.frontend.narrow.wide.words import Words
from vividc.machine.opcodes import Type
from vividc.ssa.ir import Instr, Phi, Value


@dataclass(frozen=True, slots=True)
class HighPhi:
    """The phi of a high word, for the block of the low one, and what its predecessors compute."""

    block: str
    phi: Phi
    computed: dict[str, tuple[Instr, ...]]


def high_phis(emitter: Emitter, names: dict[str, str]) -> list[HighPhi]:
    """The phis of high words that something reads; `names` are the blocks' new names."""
    definitions = emitter.function.definitions
    phis = ((definitions.get(name), ident) for name, ident in emitter.high_ids.items())
    return [_high_phi(emitter, names, phi, ident) for phi, ident in phis if isinstance(phi, Phi)]


def _high_phi(emitter: Emitter, names: dict[str, str], phi: Phi, ident: int) -> HighPhi:
    incoming: list[tuple[str, Value]] = []
    computed: dict[str, tuple[Instr, ...]] = {}
    for source, operand in phi.incoming:
        emitter.start(source)
        # The sign of a word, where the high word is just that.
        high = Words(emitter, Instr(phi.id, "phi", phi.type, (), loc=phi.loc)).high(operand)
        incoming.append((names[source], high))
        computed[source] = tuple(emitter.instrs)
    block = emitter.function.block_of[phi.id]
    return HighPhi(block, Phi(ident, Type.I32, tuple(incoming), phi.loc), computed)
