"""Large regular loops as tables: what each slot does, in entries that short native loops run.

Every result has a place by time and PE, in a window of rows that slides along with the cycles: row
t holds what the PEs issued in cycle t. An operand is then an offset from the present row, the same
in every iteration. Multiply-adds of neighbouring PEs whose operands are neighbours, too, share an
entry; words that neighbours read one cycle after the other (they travel along a row of PEs) are
neighbours in a second copy of the results, ordered by PE and age.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vividc.machine.opcodes import Opcode
from vividc.machine.words import WORD_BYTES
from vividc.program import Use
from vividc.program.dataflow import Constant, Counter, FlowOp, Read, RegionFlow, Result

LANES: Final = 16
"""Operations of one entry."""
BULK_OPS: Final = 400
"""Loops with more operations become tables, where they can: straight code of thousands of
operations takes LLVM minutes.
"""
ROWS: Final = 512
"""Cycles, about, between two moves of the window."""
VECTORS: Final = frozenset({Opcode.FMA, Opcode.DOT_F16X2, Opcode.DOT_E4M3X4, Opcode.DOT_E5M2X4})
"""Operations of which one entry holds several."""


class Kind(IntEnum):
    """What the offset of an operand counts from."""

    ROW = 0  # results by time and PE, from the present row
    DIAGONAL = 1  # results by PE and age, from the present cycle
    CONSTANT = 2  # the copy of the constant stores
    COUNTER = 3  # no address: the operation's stage


@dataclass(frozen=True, slots=True)
class Variant:
    """Operations that one loop of native code runs.

    An entry is the PE (its lane 0), an offset for each operand, and more: of multiply-adds a mask
    of lanes; of loads and stores the offset of the base address among the constants, the byte
    offset, the stage, and of loads whose results are kept by age the place in that copy.

    Attributes
    ----------
    kinds
        Of the operands.
    shift, array
        Of loads and stores.
    kept
        Whether results are kept by age, too.
    """

    op: Opcode
    kinds: tuple[Kind, ...]
    shift: int = 0
    array: str = ""
    kept: bool = False

    @property
    def is_memory(self) -> bool:
        """Whether it accesses the scratchpad."""
        return self.op in (Opcode.LOAD, Opcode.STORE)

    @property
    def width(self) -> int:
        """Words of an entry."""
        if self.is_memory:
            return 1 + len(self.kinds) + 3 + self.kept
        return 1 + len(self.kinds) + (self.op in VECTORS)


@dataclass(frozen=True, slots=True)
class Section:
    """Places of a variant in a region's tables: for each slot the number of its first entry (and
    behind the last slot the end), and the entries.
    """

    variant: Variant
    starts: int
    entries: int


@dataclass(frozen=True)
class BulkTables:
    """A loop region as tables.

    Attributes
    ----------
    pes
        Results of a row.
    reach
        Rows before the present one that are read.
    rows
        Rows of the window.
    kept
        PEs whose results are kept by age, too.
    constants
        Place of each constant-store entry that is read.
    sections
        In the order in which a slot runs them.
    words
        int32.
    """

    pes: int
    reach: int
    rows: int
    kept: tuple[int, ...]
    constants: dict[Constant, int]
    sections: tuple[Section, ...]
    words: NDArray[np.int32]

    @property
    def constant_words(self) -> int:
        """Words of the copy of the constant stores."""
        return max(self.constants.values(), default=0) + LANES

    @property
    def row_words(self) -> int:
        """Words of all rows."""
        return self.rows * self.pes + LANES

    @property
    def kept_words(self) -> int:
        """Words for one of the PEs in `kept`."""
        return self.rows + LANES


def bulk_tables(flow: RegionFlow, pes: int) -> BulkTables | None:
    """Return a region's tables; None: it is small, or does something that tables cannot express."""
    if len(flow.ops) <= BULK_OPS or not _is_plain(flow):
        return None
    return _Tables(flow, pes).build()


def _is_plain(flow: RegionFlow) -> bool:
    row = flow.row
    if row.kind != "loop" or not row.counted or flow.exit is not None or flow.captures:
        return False
    return all(_is_plain_op(op) for op in flow.ops)


def _is_plain_op(op: FlowOp) -> bool:
    issue = op.issue
    memory = issue.op in (Opcode.LOAD, Opcode.STORE)
    unconditional = op.predicate is None and issue.use is Use.NONE
    firsts = any(read.first is not None for read in op.reads)
    return unconditional and not firsts and (not memory or issue.width == WORD_BYTES)


Entry = tuple[int, ...]


class _Tables:
    def __init__(self, flow: RegionFlow, pes: int) -> None:
        self._flow = flow
        self._pes = pes
        ages = [source.age for op in flow.ops for source in _results(op)]
        self._reach = max(ages, default=0) + LANES
        ii = flow.row.ii
        self._rows = self._reach + ii * -(-ROWS // ii)
        self._constants = self._constant_places()
        self._diagonal = self._read_along_rows()
        self._kept = {pe: k for k, pe in enumerate(self._kept_pes())}
        self._found: dict[Variant, list[list[Entry]]] = defaultdict(lambda: [[] for _ in range(ii)])

    def build(self) -> BulkTables | None:
        ii = self._flow.row.ii
        slots: list[list[FlowOp]] = [[] for _ in range(ii)]
        for op in self._flow.ops:
            slots[op.time % ii].append(op)
        for slot, ops in enumerate(slots):
            self._slot(slot, sorted(ops, key=lambda op: op.pe))
        # Of two stores of a cycle to one place that of the later PE stays; two sections of stores
        # would lose that.
        if sum(variant.op is Opcode.STORE for variant in self._found) > 1:
            return None
        sections, words = self._packed()
        return BulkTables(
            pes=self._pes,
            reach=self._reach,
            rows=self._rows,
            kept=tuple(self._kept),
            constants=self._constants,
            sections=sections,
            words=words,
        )

    def _constant_places(self) -> dict[Constant, int]:
        """By entry, then PE: what neighbours read from the same entry lies side by side."""
        constants: dict[Constant, None] = {}
        for op in self._flow.ops:
            if op.issue.op in (Opcode.LOAD, Opcode.STORE):
                constants[Constant(op.pe, op.issue.base)] = None
            constants |= {r.source: None for r in op.reads if isinstance(r.source, Constant)}
        entries = {entry: k for k, entry in enumerate(dict.fromkeys(c.entry for c in constants))}
        return {
            constant: entries[constant.entry] * self._pes + constant.pe for constant in constants
        }

    def _read_along_rows(self) -> set[int]:
        """Loads that several multiply-adds read: these may come one cycle after the other."""
        readers: dict[int, int] = defaultdict(int)
        for op in self._flow.ops:
            if op.issue.op in VECTORS:
                for source in set(_results(op)):
                    readers[source.op] += 1
        ops = self._flow.ops
        return {k for k, count in readers.items() if count > 1 and ops[k].issue.op is Opcode.LOAD}

    def _kept_pes(self) -> list[int]:
        return sorted({self._flow.ops[k].pe for k in self._diagonal})

    # Entries of a slot

    def _slot(self, slot: int, ops: Sequence[FlowOp]) -> None:
        vectors = [op for op in ops if op.issue.op in VECTORS]
        for op_ in sorted({op.issue.op for op in vectors}, key=lambda op: op.value):
            same = [op for op in vectors if op.issue.op is op_]
            for variant, entry in self._vectors(op_, same):
                self._found[variant][slot].append(entry)
        for op in ops:
            if op.issue.op in VECTORS:
                continue
            kinds = tuple(_scalar_kind(read) for read in op.reads)
            offsets = [
                self._offset(op, read, kind) for read, kind in zip(op.reads, kinds, strict=True)
            ]
            if op.issue.op in (Opcode.LOAD, Opcode.STORE):
                self._access(slot, op, kinds, offsets)
            else:
                self._found[Variant(op.issue.op, kinds)][slot].append((op.pe, *offsets))

    def _access(self, slot: int, op: FlowOp, kinds: tuple[Kind, ...], offsets: list[int]) -> None:
        issue = op.issue
        base = self._constants[Constant(op.pe, issue.base)]
        entry = (op.pe, *offsets, base, issue.offset, op.time // self._flow.row.ii)
        kept = issue.op is Opcode.LOAD and op.pe in self._kept
        if kept:
            entry += (self._aged(op.pe, 0),)
        variant = Variant(issue.op, kinds, issue.shift, op.array, kept)
        self._found[variant][slot].append(entry)

    def _vectors(self, op: Opcode, ops: list[FlowOp]) -> Iterator[tuple[Variant, Entry]]:
        """Operations of one kind, as many to an entry as go together."""
        places = [self._ways(op) for op in ops]
        left = list(range(len(ops)))
        while left:
            first = left[0]
            near = [k for k in left if ops[k].pe < ops[first].pe + LANES]
            best: list[int] = []
            chosen: tuple[tuple[Kind, int], ...] = ()
            for ways in product(*places[first]):
                start = ops[first].pe
                together = [
                    k
                    for k in near
                    if all(
                        (kind, offset + ops[k].pe - start) in way
                        for (kind, offset), way in zip(ways, places[k], strict=True)
                    )
                ]
                if len(together) > len(best):
                    best, chosen = together, ways
            mask = sum(1 << ops[k].pe - ops[first].pe for k in best)
            kinds, offsets = zip(*chosen, strict=True)
            yield Variant(op, kinds), (ops[first].pe, *offsets, mask)
            taken = set(best)
            left = [k for k in left if k not in taken]

    def _ways(self, op: FlowOp) -> list[list[tuple[Kind, int]]]:
        """Kinds and offsets that each operand may have."""
        return [
            [(kind, self._offset(op, read, kind)) for kind in self._kinds(read)]
            for read in op.reads
        ]

    def _kinds(self, read: Read) -> tuple[Kind, ...]:
        if isinstance(read.source, Result) and read.source.op in self._diagonal:
            return Kind.ROW, Kind.DIAGONAL
        return (_scalar_kind(read),)

    def _offset(self, op: FlowOp, read: Read, kind: Kind) -> int:
        source = read.source
        if isinstance(source, Constant):
            return self._constants[source]
        if isinstance(source, Counter):
            return op.time // self._flow.row.ii
        pe = self._flow.ops[source.op].pe
        if kind is Kind.DIAGONAL:
            return self._aged(pe, source.age)
        return pe - source.age * self._pes

    def _aged(self, pe: int, age: int) -> int:
        return self._kept[pe] * (self._rows + LANES) + age

    # The tables as words

    def _packed(self) -> tuple[tuple[Section, ...], NDArray[np.int32]]:
        """Results first, then loads, then stores, as the schedule of bodies has it."""
        sections: list[Section] = []
        words: list[int] = []
        for variant in sorted(self._found, key=_order):
            slots = self._found[variant]
            starts = len(words)
            counts = np.cumsum([0, *(len(entries) for entries in slots)])
            words += counts.tolist()
            sections.append(Section(variant, starts, len(words)))
            words += [word for entries in slots for entry in entries for word in entry]
        return tuple(sections), np.array(words, np.int32)


def _order(variant: Variant) -> tuple[int, str]:
    return {Opcode.LOAD: 1, Opcode.STORE: 2}.get(variant.op, 0), repr(variant)


def _results(op: FlowOp) -> Iterable[Result]:
    return [read.source for read in op.reads if isinstance(read.source, Result)]


def _scalar_kind(read: Read) -> Kind:
    if isinstance(read.source, Constant):
        return Kind.CONSTANT
    return Kind.COUNTER if isinstance(read.source, Counter) else Kind.ROW
