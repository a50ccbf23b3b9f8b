"""A recording as a value change dump (IEEE 1364), for wave viewers.

One unit of time is a cycle. Words show what a PE can read in the cycle; x: nothing valid.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vividc.machine.words import WORD_BITS
from vividc.program.words.layout import OPCODE_NUMBERS
from vividc.sim.reference.predecode import StateMap
from vividc.sim.view.recording import NOTHING, Recording

_FIRST_PRINTABLE: Final = 33
_PRINTABLE: Final = 94


@dataclass(frozen=True, slots=True)
class _Signal:
    """A variable of the dump; `values`: int64, one a cycle of the window."""

    scope: str
    name: str
    width: int
    values: NDArray[np.int64]


def to_vcd(recording: Recording) -> str:
    """The dump as text: the controller's signals, and those of each PE.

    Signals
    -------
    tile: region, slot, stall.
    pe_P: opcode of the operation that issues (0: none) and its iteration; out, rf_J, and
    link_from_Q for each incoming link.
    """
    signals = list(_signals(recording))
    ids = [_identifier(number) for number in range(len(signals))]
    lines = [*_header(recording), *_declarations(signals, ids), "$enddefinitions $end"]
    for offset in range(recording.end - recording.first):
        changes = [
            _change(signal, ident, offset)
            for signal, ident in zip(signals, ids, strict=True)
            if offset == 0 or signal.values[offset] != signal.values[offset - 1]
        ]
        if changes:
            lines.append(f"#{recording.first + offset}")
            lines += ["$dumpvars", *changes, "$end"] if offset == 0 else changes
    lines.append(f"#{recording.end}")
    return "\n".join(lines) + "\n"


def _header(recording: Recording) -> Iterator[str]:
    program = recording.program
    yield f"$comment {program.name} on {program.fabric_name}; one unit of time is a cycle $end"
    if recording.stopped is not None:
        yield f"$comment stopped: {recording.stopped.replace('$', ' ')} $end"
    for number, op in enumerate(OPCODE_NUMBERS):
        if op is not None:
            yield f"$comment opcode {number}: {op.value} $end"
    yield "$timescale 1 ns $end"


def _declarations(signals: list[_Signal], ids: list[str]) -> Iterator[str]:
    scope = ""
    yield "$scope module tile $end"
    for signal, ident in zip(signals, ids, strict=True):
        if signal.scope != scope:
            if scope:
                yield "$upscope $end"
            if signal.scope:
                yield f"$scope module {signal.scope} $end"
            scope = signal.scope
        yield f"$var wire {signal.width} {ident} {signal.name} $end"
    if scope:
        yield "$upscope $end"
    yield "$upscope $end"


def _signals(recording: Recording) -> Iterator[_Signal]:
    yield _Signal("", "region", WORD_BITS, _spread(recording, recording.regions))
    yield _Signal("", "slot", WORD_BITS, _spread(recording, recording.slots))
    yield _Signal("", "stall", 1, recording.stalled().astype(np.int64))
    fabric = recording.program.fabric
    cells = StateMap(fabric)
    opcodes, iterations = _issues(recording)
    for pe in fabric.pes:
        scope = f"pe_{pe.id}"
        yield _Signal(scope, "opcode", 8, _spread(recording, opcodes[:, pe.id], moves=True))
        yield _Signal(scope, "iteration", WORD_BITS, _spread(recording, iterations[:, pe.id]))
        if not recording.words.size:
            continue
        yield _Signal(scope, "out", WORD_BITS, _words(recording, cells.out_base + pe.id))
        for register in range(pe.registers):
            cell = cells.register(pe.id, register)
            yield _Signal(scope, f"rf_{register}", WORD_BITS, _words(recording, cell))
        for link in fabric.links_to[pe.id]:
            yield _Signal(scope, f"link_from_{link.src}", WORD_BITS, _words(recording, link.id))


def _issues(recording: Recording) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Opcode number and iteration of each sample and PE."""
    numbers = {op.value: number for number, op in enumerate(OPCODE_NUMBERS) if op is not None}
    shape = (len(recording.issued), len(recording.program.fabric.pes))
    opcodes = np.zeros(shape, np.int64)
    iterations = np.full(shape, NOTHING, np.int64)
    for sample, issued in enumerate(recording.issued):
        for one in issued:
            opcodes[sample, one.pe] = numbers[one.op]
            iterations[sample, one.pe] = one.iteration
    return opcodes, iterations


def _words(recording: Recording, cell: int) -> NDArray[np.int64]:
    return _spread(recording, recording.words[:, cell])


def _spread(
    recording: Recording, samples: NDArray[np.int64], *, moves: bool = False
) -> NDArray[np.int64]:
    """One value a cycle. In a stall that of the sample before, between regions none; what `moves`
    is 0 in both.
    """
    size = recording.end - recording.first
    values = np.full(size, 0 if moves else NOTHING, np.int64)
    places = recording.cycles - recording.first
    values[places] = samples
    if moves or not places.size:
        return values
    latest = np.full(size, -1, np.int64)
    latest[places] = np.arange(places.size)
    latest = np.maximum.accumulate(latest)
    stalled = recording.stalled() & (latest >= 0)
    values[stalled] = samples[latest[stalled]]
    return values


def _change(signal: _Signal, ident: str, offset: int) -> str:
    value = int(signal.values[offset])
    if signal.width == 1:
        return f"{value}{ident}"
    return f"bx {ident}" if value == NOTHING else f"b{value:b} {ident}"


def _identifier(number: int) -> str:
    text = ""
    while True:
        number, digit = divmod(number, _PRINTABLE)
        text += chr(_FIRST_PRINTABLE + digit)
        if number == 0:
            return text
