"""The configuration word of a fabric as named bit fields, computed from the fabric's numbers.

Every PE of a fabric has the same word, wide enough for the largest PE; a PE ignores what it lacks.
`docs/machine.md` gives the meaning of the fields; this module only gives their places.

=====================  =====================================================================
field                  meaning
=====================  =====================================================================
``op``                 opcode number; 0: the FU issues nothing
``stage``              stage (live bit) of the FU operation
``control``            0 none, 1 exit, 2 branch, 3 trip: the controller takes the result
``unless_exit``        store: suppressed in the iteration that exits; load: may miss there
``shift``, ``offset``  byte address = base + (index << shift) + offset; offset is signed
``width``, ``signed``  bytes accessed: 0 four, 1 one, 2 two; 1: a narrow load sign-extends
``base``               constant-store entry of the base address
``a b c p .source``    operand multiplexer: `WordLayout.operand_sources`
``a b c p .const``     constant-store entry the operand reads when its source is CONST
``a b c p .first``     1: in iteration 0 read entry ``.first_const`` instead
``link{k}.source``     outgoing link k: `WordLayout.link_sources`
``read{j}.register``   register on RF read port j
``write{j}.source``    RF write port j: `WordLayout.drive_sources`; 0: no write
``write{j}.register``  register it writes
``store.source``       constant-store write port: `WordLayout.capture_sources`; 0: no write
``store.entry``        entry it writes
``store.stage``        stage (live bit) of the live-out
``store.unless_exit``  suppressed in the iteration that exits
=====================  =====================================================================
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Final

from vividc.arch.fabric import Fabric
from vividc.machine.opcodes import OPCODES, LatencyClass, Opcode
from vividc.machine.words import WORD_BITS
from vividc.program.words.entry import OPERAND_NAMES, Sel, Select

_NOT_EXECUTED: Final = frozenset({LatencyClass.SOURCE, LatencyClass.SINK, LatencyClass.GENERIC})

OPCODE_NUMBERS: Final[tuple[Opcode | None, ...]] = (
    None,
    *(op for op in Opcode if OPCODES[op].latency_class not in _NOT_EXECUTED),
)
"""Opcode of each value of field ``op``. A bundle records the names: a changed table is noticed."""

OFFSET_BITS: Final = 16
SHIFT_BITS: Final = 5
WIDTHS: Final = (4, 1, 2)
"""Bytes of each value of field ``width``."""


@dataclass(frozen=True, slots=True)
class Field:
    """Bits `offset` .. `offset` + `width` - 1 of the configuration word, bit 0 being the lowest."""

    name: str
    offset: int
    width: int

    @property
    def limit(self) -> int:
        """Values of the field are below this."""
        return 1 << self.width


@dataclass(frozen=True)
class WordLayout:
    """Fields of a fabric's configuration word, lowest bit first, and what its multiplexers select.

    Attributes
    ----------
    fields
        Every field; they are adjacent and do not overlap.
    operand_sources, link_sources, drive_sources, capture_sources
        What each code of an operand's, of a link's, of a register write's, and of the constant-
        store write port's ``source`` field selects.
    links, reads, writes
        Outgoing links, RF read ports and RF write ports of the largest PE.
    """

    fields: tuple[Field, ...]
    operand_sources: tuple[Select, ...]
    link_sources: tuple[Select, ...]
    drive_sources: tuple[Select, ...]
    capture_sources: tuple[Select, ...]
    links: int
    reads: int
    writes: int

    def code(self, name: str, select: Select) -> int:
        """The number of a source among those called `name`, such as `link_sources`.

        Raises
        ------
        KeyError
            It is none of them.
        """
        return self._codes[name][select]

    @cached_property
    def _codes(self) -> dict[str, dict[Select, int]]:
        names = ("operand_sources", "link_sources", "drive_sources", "capture_sources")
        return {name: _numbered(getattr(self, name)) for name in names}

    @cached_property
    def by_name(self) -> dict[str, Field]:
        """Field of each name."""
        return {field.name: field for field in self.fields}

    @property
    def bits(self) -> int:
        """Width of the configuration word in bits."""
        last = self.fields[-1]
        return last.offset + last.width

    @property
    def words_per_entry(self) -> int:
        """32-bit words that hold one configuration word."""
        return -(-self.bits // WORD_BITS)


def word_layout(fabric: Fabric) -> WordLayout:
    """Layout of the configuration word of `fabric`; a fabric always gives the same layout."""
    links_in = max((len(links) for links in fabric.links_to), default=0)
    links_out = max((len(links) for links in fabric.links_from), default=0)
    reads = max(pe.read_ports for pe in fabric.pes)
    writes = max(pe.write_ports for pe in fabric.pes)
    carried = (
        *(Select(Sel.LINK, k) for k in range(links_in)),
        *(Select(Sel.RF, j) for j in range(reads)),
    )
    none = Select(Sel.NONE)
    operand = (none, Select(Sel.OUT), Select(Sel.CONST), Select(Sel.IV), *carried)
    drive = (none, Select(Sel.RES), *carried)
    capture = (none, Select(Sel.OUT), *carried)
    passes = range(links_in if fabric.routing.hops > 1 else 0)
    link = (*drive, *(Select(Sel.WIRE, k) for k in passes))
    codes = (len(operand), len(link), len(drive), len(capture))
    widths = _widths(fabric, codes, links_out, (reads, writes))
    fields = []
    offset = 0
    for name, width in widths:
        fields.append(Field(name, offset, width))
        offset += width
    return WordLayout(tuple(fields), operand, link, drive, capture, links_out, reads, writes)


def _widths(
    fabric: Fabric, codes: tuple[int, int, int, int], links: int, ports: tuple[int, int]
) -> Iterator[tuple[str, int]]:
    operand, link, drive, capture = (_width(count) for count in codes)
    stage = _width(fabric.controller.max_stages)
    entry = _width(max(pe.constants for pe in fabric.pes))
    register = _width(max(pe.registers for pe in fabric.pes))
    yield from (("op", _width(len(OPCODE_NUMBERS))), ("stage", stage), ("control", 2))
    yield from (("unless_exit", 1), ("shift", SHIFT_BITS), ("offset", OFFSET_BITS))
    yield from (("width", _width(len(WIDTHS))), ("signed", 1), ("base", entry))
    for name in OPERAND_NAMES:
        yield from ((f"{name}.source", operand), (f"{name}.const", entry))
        yield from ((f"{name}.first", 1), (f"{name}.first_const", entry))
    for k in range(links):
        yield (f"link{k}.source", link)
    for j in range(ports[0]):
        yield (f"read{j}.register", register)
    for j in range(ports[1]):
        yield from ((f"write{j}.source", drive), (f"write{j}.register", register))
    yield from (("store.source", capture), ("store.entry", entry))
    yield from (("store.stage", stage), ("store.unless_exit", 1))


def _width(values: int) -> int:
    return max(1, (values - 1).bit_length())


def _numbered(sources: tuple[Select, ...]) -> dict[Select, int]:
    """The first number of each."""
    return {select: number for number, select in reversed(list(enumerate(sources)))}
