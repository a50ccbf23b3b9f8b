"""Where each word comes from: moves through links, registers and output registers, resolved once.

A region repeats its contexts, so the word that a multiplexer selects in a slot always stems from
the same operation, issued the same number of cycles before. Whether there is a word at all depends
only on the iterations that are live. The configuration words thus determine a static dataflow, and
a native engine needs neither links nor registers, but can still count what moved over them.

A region that could break a rule of the machine by other than an address (a read of nothing, two
completions in a PE and cycle), or that no mapping has the form of, has no `RegionFlow`: the
reference engine runs it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from vividc.machine.opcodes import MEMORY, OPCODES, Opcode
from vividc.program.program import Program
from vividc.program.tables import RegionRow
from vividc.program.words.entry import Capture, Entry, Issue, Operand, Sel, Select, Use

_MEMORY_NAMES: Final = frozenset(op.value for op in MEMORY)
_LOOP_USES: Final = (Use.NONE, Use.EXIT)


@dataclass(frozen=True, slots=True)
class Result:
    """The result of operation `op` (its index in the region), issued `age` cycles before."""

    op: int
    age: int


@dataclass(frozen=True, slots=True)
class Constant:
    """Entry `entry` of the constant store of PE `pe`."""

    pe: int
    entry: int


@dataclass(frozen=True, slots=True)
class Counter:
    """The iteration number of the reading operation."""


Source = Result | Constant | Counter


@dataclass(frozen=True, slots=True)
class Read:
    """An operand: its source, what iteration 0 reads instead, and whether a register holds it."""

    source: Source
    first: Constant | None = None
    from_register: bool = False


@dataclass(frozen=True, slots=True)
class FlowOp:
    """An operation of a region.

    Attributes
    ----------
    time
        Cycles after the start of its iteration at which it issues.
    delay
        Cycles from issue to completion: latency - 1.
    reads
        Data operands.
    predicate
        None: the operation is not predicated.
    array
        Array that a memory operation is meant for.
    """

    time: int
    pe: int
    delay: int
    issue: Issue
    reads: tuple[Read, ...]
    predicate: Read | None
    array: str


@dataclass(frozen=True, slots=True)
class FlowCapture:
    """A live-out: constant-store entry `target` takes the word of `source`."""

    time: int
    target: Constant
    source: Result
    unless_exit: bool
    from_register: bool


@dataclass(frozen=True, slots=True)
class Move:
    """A link or a register that is driven in every iteration with a word of operation `op`.

    Attributes
    ----------
    age
        Cycles from the operation's issue to the move.
    is_link
        A link word; else a register write.
    from_register
        The word is read from a register.
    slot, pe, port
        The context, the PE and which of its links or write ports.
    """

    op: int
    age: int
    is_link: bool
    from_register: bool
    slot: int
    pe: int
    port: int


@dataclass(frozen=True, slots=True)
class RegionFlow:
    """The dataflow of a region's words, operations in the order of slot and PE.

    Attributes
    ----------
    exit
        Index of the exit node, if the region has one.
    exit_delay
        Cycles after the start of an iteration at which its exit decision acts.
    """

    row: RegionRow
    ops: tuple[FlowOp, ...]
    captures: tuple[FlowCapture, ...]
    moves: tuple[Move, ...]
    exit: int | None
    exit_delay: int

    @property
    def times(self) -> tuple[int, ...]:
        """Of all operations and live-outs."""
        return (*(op.time for op in self.ops), *(capture.time for capture in self.captures))


class _Irregular(Exception):
    """The region is left to the reference engine."""


def trace(program: Program, region: int, contexts: Sequence[Sequence[Entry]]) -> RegionFlow | None:
    """The dataflow of a region, None if it is left to the reference engine.

    Parameters
    ----------
    contexts
        Its own entries, without what they hold of loops before and behind it.
    """
    try:
        return _Tracer(program, region, contexts).flow()
    except _Irregular:
        return None


class _Tracer:
    def __init__(self, program: Program, region: int, contexts: Sequence[Sequence[Entry]]) -> None:
        self._fabric = program.fabric
        self._row = program.table[region]
        self._contexts = contexts
        self._issues = [
            (slot, pe, entry.issue)
            for slot, entries in enumerate(self._contexts)
            for pe, entry in enumerate(entries)
            if entry.issue is not None
        ]
        self._arrays = {
            (row.slot, row.pe): row.name
            for row in program.debug
            if row.region == region and row.role == "issue" and row.op in _MEMORY_NAMES
        }
        self._completing = self._completions()
        self._known: dict[tuple[int, int, Select, int], Result | None] = {}

    def flow(self) -> RegionFlow:
        """The whole region, or _Irregular."""
        row = self._row
        ops = tuple(self._op(slot, pe, issue) for slot, pe, issue in self._issues)
        captures = tuple(self._captures())
        exit_index, exit_delay = self._exit(ops)
        moves = tuple(self._moves())
        flow = RegionFlow(row, ops, captures, moves, exit_index, exit_delay)
        _demand(all(time < row.span for time in flow.times))
        _demand(not any(i.op is Opcode.STORE and i.use is not Use.NONE for _, _, i in self._issues))
        if row.kind == "straight":
            _demand(row.ii == row.span and not row.has_exit)
        else:
            _demand(all(op.issue.use in _LOOP_USES for op in ops))
            _demand(row.counted or row.has_exit)
        return flow

    def _delay(self, issue: Issue) -> int:
        return self._fabric.latencies[OPCODES[issue.op].latency_class] - 1

    def _completions(self) -> Mapping[tuple[int, int], int]:
        """Operation that completes on each (PE, slot)."""
        slots: dict[tuple[int, int], int] = {}
        for index, (slot, pe, issue) in enumerate(self._issues):
            key = pe, (slot + self._delay(issue)) % self._row.ii
            _demand(key not in slots)
            slots[key] = index
        return slots

    def _exit(self, ops: tuple[FlowOp, ...]) -> tuple[int | None, int]:
        exits = [index for index, op in enumerate(ops) if op.issue.use is Use.EXIT]
        _demand(len(exits) == self._row.has_exit)
        if not exits:
            return None, 0
        op = ops[exits[0]]
        acts = op.time + op.delay + 1 + self._fabric.controller.control_latency
        _demand(acts <= self._row.span)
        return exits[0], acts

    def _op(self, slot: int, pe: int, issue: Issue) -> FlowOp:
        used = issue.operands[: OPCODES[issue.op].arity]
        reads = tuple(self._read(slot, pe, issue, operand) for operand in used)
        predicate = None
        if issue.predicate.select.kind is not Sel.NONE or issue.predicate.first is not None:
            predicate = self._read(slot, pe, issue, issue.predicate)
        time = issue.stage * self._row.ii + slot
        array = self._arrays.get((slot, pe), "")
        return FlowOp(time, pe, self._delay(issue), issue, reads, predicate, array)

    def _read(self, slot: int, pe: int, issue: Issue, operand: Operand) -> Read:
        first = None if operand.first is None else Constant(pe, operand.first)
        select = operand.select
        if select.kind is Sel.CONST:
            return Read(Constant(pe, select.index), first)
        if select.kind is Sel.IV:
            return Read(Counter(), first)
        source = self._result(slot, pe, select)
        _demand(source is not None)
        assert source is not None
        distance = self._distance(slot, issue.stage, source)
        _demand(distance == 0 or (distance == 1 and first is not None))
        return Read(source, first, select.kind is Sel.RF)

    def _distance(self, slot: int, stage: int, source: Result) -> int:
        """Iterations from the one whose word is read to the reader's."""
        _, _, issue = self._issues[source.op]
        return issue.stage - (slot - source.age) // self._row.ii - stage

    def _captures(self) -> Iterator[FlowCapture]:
        for slot, entries in enumerate(self._contexts):
            for pe, entry in enumerate(entries):
                if entry.capture is not None:
                    yield self._capture(slot, pe, entry.capture)

    def _capture(self, slot: int, pe: int, capture: Capture) -> FlowCapture:
        source = self._result(slot, pe, capture.select)
        _demand(source is not None and self._distance(slot, capture.stage, source) == 0)
        assert source is not None
        return FlowCapture(
            capture.stage * self._row.ii + slot,
            Constant(pe, capture.entry),
            source,
            capture.unless_exit,
            capture.select.kind is Sel.RF,
        )

    def _moves(self) -> Iterator[Move]:
        for slot, entries in enumerate(self._contexts):
            for pe, entry in enumerate(entries):
                selects = [(select, True, port) for port, select in enumerate(entry.links)]
                selects += [(w.select, False, port) for port, w in enumerate(entry.writes)]
                for select, is_link, port in selects:
                    if select.kind is Sel.NONE:
                        continue
                    source = self._result(slot, pe, select)
                    if source is not None:
                        from_register = select.kind is Sel.RF
                        moved = (source.op, source.age, is_link, from_register)
                        yield Move(*moved, slot, pe, port)

    def _result(self, slot: int, pe: int, select: Select) -> Result | None:
        """What a multiplexer selects in a slot; None: never a word."""
        age = 0
        seen = []
        while True:
            key = (slot, pe, select, self._register(slot, pe, select))
            if key in self._known:
                source = self._known[key]
                result = None if source is None else Result(source.op, source.age + age)
                break
            seen.append((key, age))
            if key in {earlier for earlier, _ in seen[:-1]}:
                result = None
                break
            if select.kind in (Sel.RES, Sel.OUT):
                result = self._completed(slot, pe, select.kind, age)
                break
            step = self._before(slot, pe, select)
            if step is None:
                result = None
                break
            back, pe, select = step
            age += back
            slot = (slot - back) % self._row.ii
        for key, at in seen:
            self._known[key] = None if result is None else Result(result.op, result.age - at)
        return result

    def _register(self, slot: int, pe: int, select: Select) -> int:
        return self._contexts[slot][pe].reads[select.index] if select.kind is Sel.RF else 0

    def _completed(self, slot: int, pe: int, kind: Sel, age: int) -> Result | None:
        back = 1 if kind is Sel.OUT else 0
        index = self._completing.get((pe, (slot - back) % self._row.ii))
        if index is None or self._issues[index][2].op is Opcode.STORE:
            return None
        return Result(index, age + back + self._delay(self._issues[index][2]))

    def _before(self, slot: int, pe: int, select: Select) -> tuple[int, int, Select] | None:
        """What drove a link or wrote a register: (cycles before, PE, its selection)."""
        if select.kind in (Sel.LINK, Sel.WIRE):
            back = 1 if select.kind is Sel.LINK else 0
            link = self._fabric.links_to[pe][select.index]
            port = self._fabric.links_from[link.src].index(link)
            driven = self._contexts[(slot - back) % self._row.ii][link.src].links[port]
            return None if driven.kind is Sel.NONE else (back, link.src, driven)
        if select.kind is not Sel.RF:
            return None
        register = self._register(slot, pe, select)
        for back in range(1, self._row.ii + 1):
            written = _write_of(self._contexts[(slot - back) % self._row.ii][pe], register)
            if written is not None:
                return back, pe, written
        return None


def _write_of(entry: Entry, register: int) -> Select | None:
    for write in entry.writes:
        if write.select.kind is not Sel.NONE and write.register == register:
            return write.select
    return None


def _demand(regular: bool) -> None:
    if not regular:
        raise _Irregular
