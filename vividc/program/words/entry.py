"""One decoded configuration word: what one PE does in one context."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from typing import Final

from vividc.arch.fabric import PE, Fabric
from vividc.machine.opcodes import MEMORY, OPCODES, Opcode

OPERAND_NAMES: Final = ("a", "b", "c", "p")


class Sel(Enum):
    """Kinds of source that a multiplexer of a PE can select (docs/machine.md)."""

    NONE = "none"
    RES = "res"
    OUT = "out"
    CONST = "const"
    IV = "iv"
    LINK = "link"
    WIRE = "wire"
    RF = "rf"


class Use(Enum):
    """What the tile controller does with the result of an operation."""

    NONE = "none"
    EXIT = "exit"
    BRANCH = "branch"
    TRIP = "trip"


@dataclass(frozen=True, slots=True)
class Select:
    """A multiplexer's setting.

    `index` is the PE's incoming link (its place in `Fabric.links_to`) for LINK and for WIRE (the
    word that is driven onto it in the same cycle), the read port for RF, the constant-store entry
    for CONST, and 0 otherwise.
    """

    kind: Sel
    index: int = 0

    def __str__(self) -> str:
        return f"{self.kind.value}{self.index}" if self.kind in _INDEXED else self.kind.value


_INDEXED: Final = frozenset({Sel.CONST, Sel.LINK, Sel.WIRE, Sel.RF})
NOTHING: Final = Select(Sel.NONE)


@dataclass(frozen=True, slots=True)
class Operand:
    """Where an operand comes from; in iteration 0 from constant-store entry `first`, if given."""

    select: Select = NOTHING
    first: int | None = None


@dataclass(frozen=True, slots=True)
class Issue:
    """The operation an FU issues.

    Attributes
    ----------
    operands
        a, b, c.
    predicate
        p; nothing selected: the operation is not predicated.
    base
        Constant-store entry with the base address of a load or store.
    width, signed
        Bytes that a load or store accesses; whether a load of less than a word sign-extends.
    stage
        Live bit that gates the operation.
    """

    op: Opcode
    operands: tuple[Operand, Operand, Operand]
    predicate: Operand = Operand()
    base: int = 0
    shift: int = 0
    offset: int = 0
    width: int = 4
    signed: bool = False
    stage: int = 0
    use: Use = Use.NONE
    unless_exit: bool = False


@dataclass(frozen=True, slots=True)
class Write:
    """An RF write port: `register` takes the word of `select`."""

    select: Select = NOTHING
    register: int = 0


@dataclass(frozen=True, slots=True)
class Capture:
    """The constant-store write port (a live-out): `entry` takes the word of `select`."""

    select: Select
    entry: int
    stage: int = 0
    unless_exit: bool = False


@dataclass(frozen=True, slots=True)
class Entry:
    """Everything one PE does in one context; tuples are as long as the fabric's largest PE needs.

    Attributes
    ----------
    links
        Source of each outgoing link (by place in `Fabric.links_from`).
    reads
        Register on each RF read port.
    """

    issue: Issue | None
    links: tuple[Select, ...]
    reads: tuple[int, ...]
    writes: tuple[Write, ...]
    capture: Capture | None = None

    @property
    def is_idle(self) -> bool:
        """Nothing is issued, driven or written."""
        moves = (*self.links, *(write.select for write in self.writes))
        quiet = all(select.kind is Sel.NONE for select in moves)
        return self.issue is None and self.capture is None and quiet


def faults(entry: Entry, fabric: Fabric, pe: int) -> list[str]:
    """List what `entry` demands that PE `pe` does not have; empty: the PE can execute it."""
    return [*_structure_faults(entry, fabric, pe), *_operation_faults(entry, fabric, pe)]


def _structure_faults(entry: Entry, fabric: Fabric, pe: int) -> Iterator[str]:
    size = fabric.pes[pe]
    for select in _selects(entry):
        yield from _select_faults(select, entry, fabric, pe)
    for k, select in enumerate(entry.links):
        if select.kind is not Sel.NONE and k >= len(fabric.links_from[pe]):
            yield f"outgoing link {k}"
    yield from _write_faults(entry, size)
    for index in _constants(entry):
        if index >= size.constants:
            yield f"constant-store entry {index}"


def _select_faults(select: Select, entry: Entry, fabric: Fabric, pe: int) -> Iterator[str]:
    if select.kind in (Sel.LINK, Sel.WIRE) and select.index >= len(fabric.links_to[pe]):
        yield f"incoming link {select.index}"
    if select.kind is not Sel.RF:
        return
    if select.index >= fabric.pes[pe].read_ports:
        yield f"RF read port {select.index}"
    elif entry.reads[select.index] >= fabric.pes[pe].registers:
        yield f"register {entry.reads[select.index]}"


def _write_faults(entry: Entry, size: PE) -> Iterator[str]:
    active = [(j, w) for j, w in enumerate(entry.writes) if w.select.kind is not Sel.NONE]
    for j, write in active:
        if j >= size.write_ports:
            yield f"RF write port {j}"
        if write.register >= size.registers:
            yield f"register {write.register}"
    registers = [write.register for _, write in active]
    if len(set(registers)) < len(registers):
        yield "two writes of one register"


def _operation_faults(entry: Entry, fabric: Fabric, pe: int) -> Iterator[str]:
    stages = [part.stage for part in (entry.issue, entry.capture) if part is not None]
    for stage in stages:
        if stage >= fabric.controller.max_stages:
            yield f"stage {stage}"
    issue = entry.issue
    if issue is None:
        return
    info = OPCODES[issue.op]
    if not fabric.pes[pe].executes(info):
        yield f"operation {issue.op.value}"
    for port in range(info.arity):
        if issue.operands[port].select.kind is Sel.NONE:
            yield f"{issue.op.value} without operand {OPERAND_NAMES[port]}"
    if issue.predicate.select.kind is Sel.NONE and issue.predicate.first is not None:
        yield f"{issue.op.value} with a predicate in its first iteration only"


def _selects(entry: Entry) -> Iterator[Select]:
    if entry.issue is not None:
        for operand in (*entry.issue.operands, entry.issue.predicate):
            yield operand.select
    yield from entry.links
    for write in entry.writes:
        yield write.select
    if entry.capture is not None:
        yield entry.capture.select


def _constants(entry: Entry) -> Iterator[int]:
    if entry.issue is not None:
        if entry.issue.op in MEMORY:
            yield entry.issue.base
        for operand in (*entry.issue.operands, entry.issue.predicate):
            if operand.select.kind is Sel.CONST:
                yield operand.select.index
            if operand.first is not None:
                yield operand.first
    if entry.capture is not None:
        yield entry.capture.entry
