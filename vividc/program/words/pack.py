"""Entries to 32-bit words: the packing of the configuration word (`decode` is the inverse)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from vividc.errors import InternalError
from vividc.machine.words import WORD_BITS, WORD_MASK
from vividc.program.words.entry import (
    OPERAND_NAMES,
    Capture,
    Entry,
    Issue,
    Operand,
    Sel,
    Select,
    Use,
)
from vividc.program.words.layout import OFFSET_BITS, OPCODE_NUMBERS, WIDTHS, WordLayout

USES: Final = (Use.NONE, Use.EXIT, Use.BRANCH, Use.TRIP)


def pack(layout: WordLayout, entry: Entry) -> tuple[int, ...]:
    """The 32-bit words of one entry, lowest bits first.

    Raises
    ------
    InternalError
        A value does not fit its field, or a source cannot be selected there.
    """
    bits = 0
    for name, value in _values(layout, entry):
        field = layout.by_name.get(name)
        if field is None or not 0 <= value < field.limit:
            raise InternalError(f"configuration field {name} cannot hold {value}")
        bits |= value << field.offset
    return tuple(bits >> WORD_BITS * k & WORD_MASK for k in range(layout.words_per_entry))


def _values(layout: WordLayout, entry: Entry) -> Iterator[tuple[str, int]]:
    if entry.issue is not None:
        yield from _issue_values(layout, entry.issue)
    for k, select in enumerate(entry.links):
        yield f"link{k}.source", _code(layout, "link_sources", select)
    for j, register in enumerate(entry.reads):
        yield f"read{j}.register", register
    for j, write in enumerate(entry.writes):
        yield f"write{j}.source", _code(layout, "drive_sources", write.select)
        yield f"write{j}.register", write.register
    if entry.capture is not None:
        yield from _capture_values(layout, entry.capture)


def _issue_values(layout: WordLayout, issue: Issue) -> Iterator[tuple[str, int]]:
    if issue.op not in OPCODE_NUMBERS:
        raise InternalError(f"no FU executes {issue.op.value}")
    half = 1 << OFFSET_BITS - 1
    if not -half <= issue.offset < half:
        raise InternalError(f"offset {issue.offset} does not fit {OFFSET_BITS} bits")
    yield "op", OPCODE_NUMBERS.index(issue.op)
    yield "stage", issue.stage
    yield "control", USES.index(issue.use)
    yield "unless_exit", int(issue.unless_exit)
    yield "shift", issue.shift
    yield "offset", issue.offset % (1 << OFFSET_BITS)
    yield "width", _width_code(issue.width)
    yield "signed", int(issue.signed)
    yield "base", issue.base
    for name, operand in zip(OPERAND_NAMES, (*issue.operands, issue.predicate), strict=True):
        yield from _operand_values(layout, name, operand)


def _width_code(width: int) -> int:
    if width not in WIDTHS:
        raise InternalError(f"no access is {width} bytes wide")
    return WIDTHS.index(width)


def _operand_values(layout: WordLayout, name: str, operand: Operand) -> Iterator[tuple[str, int]]:
    select = operand.select
    if select.kind is Sel.CONST:
        yield f"{name}.const", select.index
        select = Select(Sel.CONST)
    yield f"{name}.source", _code(layout, "operand_sources", select)
    if operand.first is not None:
        yield f"{name}.first", 1
        yield f"{name}.first_const", operand.first


def _capture_values(layout: WordLayout, capture: Capture) -> Iterator[tuple[str, int]]:
    yield "store.source", _code(layout, "capture_sources", capture.select)
    yield "store.entry", capture.entry
    yield "store.stage", capture.stage
    yield "store.unless_exit", int(capture.unless_exit)


def _code(layout: WordLayout, name: str, select: Select) -> int:
    try:
        return layout.code(name, select)
    except KeyError:
        raise InternalError(f"no multiplexer input for {select} here") from None
