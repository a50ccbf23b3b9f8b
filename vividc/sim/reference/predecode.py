"""Turns decoded entries into short lists of what is active in each slot.

A run of the machine keeps every word a PE can read in one list, `state`; None is "nothing".
Multiplexer settings become indices into it once, here, so that a cycle is a walk over short lists.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from operator import itemgetter
from typing import NamedTuple

from vividc.arch.fabric import Fabric
from vividc.machine.opcodes import MEMORY, OPCODES, Opcode
from vividc.machine.semantics import SEMANTICS
from vividc.program import (
    Entry,
    Issue,
    Operand,
    Program,
    RegionRow,
    Sel,
    Select,
    Use,
    loop_behind,
)
from vividc.program.overlaps.parts import Parts, sound_parts
from vividc.program.overlaps.words import Contexts
from vividc.program.words.wires import driver

_MEMORY_NAMES = frozenset(op.value for op in MEMORY)

State = list[int | None]
Fetch = Callable[[State], tuple[int | None, ...]]


class StateMap:
    """Index in `state` of every readable word.

    Links, registers, output registers, results of this cycle and iteration counters come first
    (`volatile` of them: a region starts with none), then the constant stores and the constant 1.
    """

    def __init__(self, fabric: Fabric) -> None:
        pes = len(fabric.pes)
        self._registers = max(pe.registers for pe in fabric.pes)
        self.constants = max(pe.constants for pe in fabric.pes)
        self._register_base = len(fabric.links)
        self.out_base = self._register_base + pes * self._registers
        self.res_base = self.out_base + pes
        self._iv_base = self.res_base + pes
        self.volatile = self._iv_base + fabric.controller.max_stages
        self.true = self.volatile + pes * self.constants
        self.size = self.true + 1

    def register(self, pe: int, register: int) -> int:
        """A register."""
        return self._register_base + pe * self._registers + register

    def iv(self, stage: int) -> int:
        """The iteration counter of a stage."""
        return self._iv_base + stage

    def constant(self, pe: int, entry: int) -> int:
        """A constant-store entry."""
        return self.volatile + pe * self.constants + entry


class Op(NamedTuple):
    """An operation of a slot; a tuple because the engine unpacks one per operation and cycle.

    Attributes
    ----------
    delay
        Cycles from issue to completion: latency - 1.
    function
        Word of the result from the fetched words (unused by loads and stores).
    fetch, fetch_first
        Operand words, in iteration 0 and else. A load fetches (base, index, predicate), a store
        (base, index, value, predicate).
    array
        Name of the array that a memory operation is meant for.
    """

    stage: int
    delay: int
    pe: int
    function: Callable[..., int]
    fetch: Fetch
    fetch_first: Fetch
    issue: Issue
    array: str


class LiveOut(NamedTuple):
    """A live-out of a slot: constant-store cell `target` takes the word of cell `source`."""

    stage: int
    pe: int
    source: int
    target: int
    unless_exit: bool
    from_register: bool


@dataclass(frozen=True, slots=True)
class Moves:
    """Ungated moves of a slot: the cells `targets` take the words that `fetch` reads."""

    targets: tuple[int, ...]
    fetch: Fetch


@dataclass(frozen=True, slots=True)
class Slot:
    """Everything active in one context.

    Attributes
    ----------
    fades
        Link cells that are driven in the slot before and not in this one.
    """

    alu: tuple[Op, ...]
    control: tuple[Op, ...]
    loads: tuple[Op, ...]
    stores: tuple[Op, ...]
    links: Moves
    links_from_registers: Moves
    writes: Moves
    writes_from_registers: Moves
    live_outs: tuple[LiveOut, ...]
    fades: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class OpCount:
    """What one issue of an operation costs in reads, for the statistics."""

    op: str
    time: int
    register_reads: int
    constant_reads: int
    first_register_reads: int
    first_constant_reads: int


@dataclass(frozen=True, slots=True)
class Ahead:
    """What the last words of a straight region hold of the loop behind it.

    Attributes
    ----------
    loop, least
        The loop, by its index, and the fewest iterations with which it begins early.
    slots
        By cycles of the loop, stages counted as the straight region's words have them.
    counters
        (state cell, stage) of the iteration counters that are read.
    """

    loop: int
    least: int
    slots: tuple[Slot, ...]
    counters: tuple[tuple[int, int], ...]


@dataclass(frozen=True, slots=True)
class RegionCode:
    """A region ready to run.

    Attributes
    ----------
    counters
        (state cell, stage) of the iteration counters it reads.
    rest, rest_counters
        What the words of the region behind a loop hold of it, by that region's cycles, stages
        counted from the loop's end.
    ahead
        Of a loop that begins while it ends; None: none does.
    """

    index: int
    row: RegionRow
    slots: tuple[Slot, ...]
    counters: tuple[tuple[int, int], ...]
    counts: tuple[OpCount, ...]
    rest: tuple[Slot, ...]
    rest_counters: tuple[tuple[int, int], ...]
    ahead: Ahead | None


def predecode(program: Program, cells: StateMap) -> tuple[RegionCode, ...]:
    """Every region of `program`, decoded from its words.

    Raises
    ------
    BundleError
        The words of a region do not fit the loops around it.
    """
    parts = sound_parts(program)
    return tuple(_region(program, index, cells, parts) for index in range(len(parts.own)))


def _region(program: Program, index: int, cells: StateMap, parts: Parts) -> RegionCode:
    row, contexts, rest = program.table[index], parts.own[index], parts.rests.get(index, [])
    coder = _Coder(program.fabric, cells, _array_names(program, index))
    driven = [coder.driven(entries) for entries in contexts]
    slots = tuple(
        coder.slot(slot, entries, driven[slot - 1] - driven[slot])
        for slot, entries in enumerate(contexts)
    )
    begin = row.span - row.drain
    held = [driven[(begin - 1) % row.ii], *map(coder.driven, rest)]
    left = tuple(
        coder.slot((begin + cycle) % row.ii, entries, held[cycle] - held[cycle + 1])
        for cycle, entries in enumerate(rest)
    )
    counts = tuple(
        coder.count(slot, row.ii, entry)
        for slot, entries in enumerate(contexts)
        for entry in entries
        if entry.issue is not None
    )
    counters, of_rest = (_counters(cells, some) for some in (contexts, rest))
    ahead = _ahead(program, index, cells, parts) if index in parts.aheads else None
    return RegionCode(index, row, slots, counters, counts, left, of_rest, ahead)


def _ahead(program: Program, index: int, cells: StateMap, parts: Parts) -> Ahead:
    loop, contexts = loop_behind(program.table, index), parts.aheads[index]
    assert loop is not None
    row = program.table[loop]
    coder = _Coder(program.fabric, cells, _array_names(program, loop))
    driven = [frozenset[int](), *map(coder.driven, contexts)]
    slots = tuple(
        coder.slot(cycle % row.ii, entries, driven[cycle] - driven[cycle + 1])
        for cycle, entries in enumerate(contexts)
    )
    least = row.least_trips(program.table[index].fill)
    return Ahead(loop, least, slots, _counters(cells, contexts))


def _counters(cells: StateMap, contexts: Contexts) -> tuple[tuple[int, int], ...]:
    stages = {issue.stage for entries in contexts for issue in _reads_counter(entries)}
    return tuple((cells.iv(stage), stage) for stage in sorted(stages))


def _reads_counter(entries: Iterable[Entry]) -> Iterator[Issue]:
    for entry in entries:
        issue = entry.issue
        if issue is not None and any(o.select.kind is Sel.IV for o in _operands(issue)):
            yield issue


def _operands(issue: Issue) -> tuple[Operand, ...]:
    """The operands that the operation reads, predicate last."""
    used = issue.operands[: OPCODES[issue.op].arity]
    if issue.predicate.select.kind is Sel.NONE and issue.predicate.first is None:
        return used
    return (*used, issue.predicate)


def _array_names(program: Program, region: int) -> dict[tuple[int, int], str]:
    """Array of each memory operation of a region, by slot and PE."""
    rows = (row for row in program.debug if row.region == region and row.role == "issue")
    return {(row.slot, row.pe): row.name for row in rows if row.op in _MEMORY_NAMES}


class _Coder:
    def __init__(
        self, fabric: Fabric, cells: StateMap, arrays: Mapping[tuple[int, int], str]
    ) -> None:
        self._arrays = arrays
        self._fabric = fabric
        self._cells = cells

    def driven(self, entries: list[Entry]) -> frozenset[int]:
        """Link cells that a context drives."""
        return frozenset(
            self._fabric.links_from[pe][k].id
            for pe, entry in enumerate(entries)
            for k, select in enumerate(entry.links)
            if driver(self._fabric, entries, pe, select)[1].kind is not Sel.NONE
        )

    def slot(self, slot: int, entries: list[Entry], fades: frozenset[int]) -> Slot:
        """One context."""
        ops = [
            self._op(slot, pe, entry) for pe, entry in enumerate(entries) if entry.issue is not None
        ]
        links = [move for pe in range(len(entries)) for move in self._links(pe, entries)]
        writes = [move for pe, entry in enumerate(entries) for move in self._writes(pe, entry)]
        return Slot(
            alu=tuple(op for op in ops if _group(op) == "alu"),
            control=tuple(op for op in ops if _group(op) == "control"),
            loads=tuple(op for op in ops if _group(op) == "load"),
            stores=tuple(op for op in ops if _group(op) == "store"),
            links=_moves(links, from_registers=False),
            links_from_registers=_moves(links, from_registers=True),
            writes=_moves(writes, from_registers=False),
            writes_from_registers=_moves(writes, from_registers=True),
            live_outs=tuple(self._live_outs(entries)),
            fades=tuple(sorted(fades)),
        )

    def count(self, slot: int, ii: int, entry: Entry) -> OpCount:
        """Reads of the operation that `entry` issues."""
        issue = entry.issue
        assert issue is not None
        operands = _operands(issue)
        base = 1 if issue.op in MEMORY else 0
        kinds = [operand.select.kind for operand in operands]
        later = [o.select.kind for o in operands if o.first is None]
        firsts = len(operands) - len(later)
        return OpCount(
            op=issue.op.value,
            time=issue.stage * ii + slot,
            register_reads=kinds.count(Sel.RF),
            constant_reads=kinds.count(Sel.CONST) + base,
            first_register_reads=later.count(Sel.RF),
            first_constant_reads=later.count(Sel.CONST) + base + firsts,
        )

    def _op(self, slot: int, pe: int, entry: Entry) -> Op:
        issue = entry.issue
        assert issue is not None
        operands = _operands(issue)
        later = [self._cell(pe, operand.select, entry) for operand in operands]
        first = [
            cell if operand.first is None else self._cells.constant(pe, operand.first)
            for cell, operand in zip(later, operands, strict=True)
        ]
        if issue.op in MEMORY:
            base = self._cells.constant(pe, issue.base)
            unpredicated = len(operands) == OPCODES[issue.op].arity
            tail = [self._cells.true] if unpredicated else []
            later, first = [base, *later, *tail], [base, *first, *tail]
        delay = self._fabric.latencies[OPCODES[issue.op].latency_class] - 1
        fetch = _fetch(later)
        fetch_first = fetch if first == later else _fetch(first)
        array = self._arrays.get((slot, pe), "")
        return Op(issue.stage, delay, pe, _function(issue), fetch, fetch_first, issue, array)

    def _cell(self, pe: int, select: Select, entry: Entry) -> int:
        cells = self._cells
        match select.kind:
            case Sel.LINK:
                return self._fabric.links_to[pe][select.index].id
            case Sel.RF:
                return cells.register(pe, entry.reads[select.index])
            case Sel.OUT:
                return cells.out_base + pe
            case Sel.RES:
                return cells.res_base + pe
            case Sel.CONST:
                return cells.constant(pe, select.index)
            case Sel.IV:
                assert entry.issue is not None
                return cells.iv(entry.issue.stage)
            case Sel.NONE | Sel.WIRE:
                raise AssertionError("decode lets no used operand select nothing, or a wire")

    def _links(self, pe: int, entries: list[Entry]) -> Iterator[tuple[int, int, bool]]:
        """Links with what drives them; a register is read for the first of a cycle's links only."""
        for k, select in enumerate(entries[pe].links):
            at, driven_by, _ = driver(self._fabric, entries, pe, select)
            if driven_by.kind is not Sel.NONE:
                target = self._fabric.links_from[pe][k].id
                yield self._cell(at, driven_by, entries[at]), target, select.kind is Sel.RF

    def _writes(self, pe: int, entry: Entry) -> Iterator[tuple[int, int, bool]]:
        for write in entry.writes:
            if write.select.kind is not Sel.NONE:
                target = self._cells.register(pe, write.register)
                source = self._cell(pe, write.select, entry)
                yield source, target, write.select.kind is Sel.RF

    def _live_outs(self, entries: list[Entry]) -> Iterator[LiveOut]:
        for pe, entry in enumerate(entries):
            capture = entry.capture
            if capture is not None:
                source = self._cell(pe, capture.select, entry)
                target = self._cells.constant(pe, capture.entry)
                from_register = capture.select.kind is Sel.RF
                yield LiveOut(capture.stage, pe, source, target, capture.unless_exit, from_register)


def _group(op: Op) -> str:
    if op.issue.op is Opcode.STORE:
        return "store"
    if op.issue.op is Opcode.LOAD:
        return "load"
    return "alu" if op.issue.use is Use.NONE else "control"


def _function(issue: Issue) -> Callable[..., int]:
    if issue.op in MEMORY:
        return _no_function
    function = SEMANTICS[issue.op]
    if len(_operands(issue)) == OPCODES[issue.op].arity:
        return function

    def predicated(*words: int) -> int:
        return function(*words[:-1]) if words[-1] else words[-2]

    return predicated


def _no_function(*_: int) -> int:
    raise AssertionError("the engine computes loads and stores itself")


def _moves(moves: list[tuple[int, int, bool]], *, from_registers: bool) -> Moves:
    chosen = [(source, target) for source, target, register in moves if register is from_registers]
    return Moves(tuple(target for _, target in chosen), _fetch([source for source, _ in chosen]))


def _fetch(cells: list[int]) -> Fetch:
    if not cells:
        return _fetch_nothing
    if len(cells) == 1:
        cell = cells[0]
        return lambda state: (state[cell],)
    return itemgetter(*cells)


def _fetch_nothing(_: State) -> tuple[int | None, ...]:
    return ()
