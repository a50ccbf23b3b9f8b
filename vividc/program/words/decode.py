"""Configuration words back to entries: what the simulator and the disassembler read."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from vividc.arch.fabric import Fabric
from vividc.errors import BundleError
from vividc.machine.words import WORD_BITS
from vividc.program.words.entry import (
    OPERAND_NAMES,
    Capture,
    Entry,
    Issue,
    Operand,
    Sel,
    Select,
    Write,
    faults,
)
from vividc.program.words.layout import (
    OFFSET_BITS,
    OPCODE_NUMBERS,
    WIDTHS,
    WordLayout,
    word_layout,
)
from vividc.program.words.pack import USES
from vividc.program.words.wires import check_wires


def unpack(layout: WordLayout, words: Sequence[int]) -> Entry:
    """The entry that `words` (lowest bits first) encode; fields of absent parts are ignored.

    Raises
    ------
    BundleError
        A field holds a code that means nothing.
    """
    bits = sum(int(word) << WORD_BITS * k for k, word in enumerate(words))
    return _Reader(layout, bits).entry()


def decode(fabric: Fabric, words: NDArray[np.uint32]) -> list[list[Entry]]:
    """Every entry of a configuration memory, by context and PE.

    Parameters
    ----------
    words
        uint32, shape [contexts, PEs, words per entry].

    Raises
    ------
    BundleError
        An entry holds an illegal code, or asks a PE for something it does not have.
    """
    layout = word_layout(fabric)
    known: dict[tuple[int, ...], Entry] = {}
    table = []
    for context, row in enumerate(words.tolist()):
        entries = []
        for pe, raw in enumerate(row):
            key = tuple(raw)
            if key not in known:
                known[key] = unpack(layout, key)
            missing = faults(known[key], fabric, pe)
            if missing:
                reason = f"context {context} uses {missing[0]}, which PE {pe} does not have"
                raise BundleError(reason, hint="compile the kernel again for this fabric")
            entries.append(known[key])
        if fabric.routing.hops > 1:
            check_wires(fabric, entries, context)
        table.append(entries)
    return table


class _Reader:
    def __init__(self, layout: WordLayout, bits: int) -> None:
        self._layout = layout
        self._bits = bits

    def _value(self, name: str) -> int:
        field = self._layout.by_name[name]
        return self._bits >> field.offset & field.limit - 1

    def _select(self, name: str, sources: tuple[Select, ...]) -> Select:
        code = self._value(f"{name}.source")
        if code >= len(sources):
            raise BundleError(f"configuration field {name}.source holds the illegal code {code}")
        return sources[code]

    def entry(self) -> Entry:
        layout = self._layout
        drive = layout.drive_sources
        links = tuple(self._select(f"link{k}", layout.link_sources) for k in range(layout.links))
        reads = tuple(self._value(f"read{j}.register") for j in range(layout.reads))
        writes = tuple(
            Write(self._select(f"write{j}", drive), self._value(f"write{j}.register"))
            for j in range(layout.writes)
        )
        return Entry(self._issue(), links, reads, writes, self._capture())

    def _issue(self) -> Issue | None:
        number = self._value("op")
        if number >= len(OPCODE_NUMBERS):
            raise BundleError(f"configuration field op holds the illegal code {number}")
        op = OPCODE_NUMBERS[number]
        if op is None:
            return None
        a, b, c, p = (self._operand(name) for name in OPERAND_NAMES)
        offset = self._value("offset")
        width = self._value("width")
        if width >= len(WIDTHS):
            raise BundleError(f"configuration field width holds the illegal code {width}")
        return Issue(
            op,
            (a, b, c),
            p,
            base=self._value("base"),
            shift=self._value("shift"),
            offset=offset - (offset >> OFFSET_BITS - 1 << OFFSET_BITS),
            width=WIDTHS[width],
            signed=bool(self._value("signed")),
            stage=self._value("stage"),
            use=USES[self._value("control")],
            unless_exit=bool(self._value("unless_exit")),
        )

    def _operand(self, name: str) -> Operand:
        select = self._select(name, self._layout.operand_sources)
        if select.kind is Sel.CONST:
            select = Select(Sel.CONST, self._value(f"{name}.const"))
        has_first = bool(self._value(f"{name}.first"))
        return Operand(select, self._value(f"{name}.first_const") if has_first else None)

    def _capture(self) -> Capture | None:
        select = self._select("store", self._layout.capture_sources)
        if select.kind is Sel.NONE:
            return None
        return Capture(
            select,
            self._value("store.entry"),
            self._value("store.stage"),
            bool(self._value("store.unless_exit")),
        )
