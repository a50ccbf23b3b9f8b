"""Words of a straight region parted into its own and those of the loop that ends while it begins.

A loop may end before its last iterations do: the words of the region behind it hold what is left of
them (docs/machine.md, "Drain"). What those words must be follows from the loop's. Here it is
checked that they are that, and that neither of the two changes what the other reads: whoever runs
the loop to its end and then the region's own words gets the same.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from vividc.errors import BundleError
from vividc.host.once import once_within
from vividc.machine.opcodes import MEMORY, OPCODES, Opcode
from vividc.program.dataflow import Constant, FlowOp, RegionFlow, trace
from vividc.program.program import Program
from vividc.program.words.entry import NOTHING, Entry, Issue, Operand, Sel, Select, Write

Contexts = list[list[Entry]]
"""Entries by context and PE."""


@dataclass(frozen=True, slots=True)
class Parts:
    """The words of a program's regions.

    Attributes
    ----------
    own
        Of each region: the contexts that are its own, without what is left of a loop before it.
    rests
        By loop that ends early: what is left of it, in the contexts of the region behind it.
    flows
        The dataflow of these loops and of the regions behind them.
    faults
        What contradicts the machine's rules; with any, nothing else holds.
    """

    own: tuple[Contexts, ...]
    rests: Mapping[int, Contexts]
    flows: Mapping[int, RegionFlow]
    faults: tuple[str, ...] = ()


@once_within
def parts(program: Program) -> Parts:
    """Part the words of a program."""
    own = [program.entries[row.context : row.context + row.ii] for row in program.table]
    rests: dict[int, Contexts] = {}
    flows: dict[int, RegionFlow] = {}
    faults: list[str] = []
    taken: set[int] = set()
    for loop, row in enumerate(program.table):
        if not row.drain:
            continue
        fault = _row_fault(program, loop)
        if fault is None and row.next in taken:
            fault = "another loop ends there, too"
        if fault is None:
            assert row.next is not None
            taken.add(row.next)
            try:
                pair = _Pair(program, loop, own[loop], own[row.next])
                rests[loop], own[row.next] = pair.rest, pair.own
                flows |= {loop: pair.loop, row.next: pair.behind}
            except _Contradiction as wrong:
                fault = str(wrong)
        if fault is not None:
            faults.append(f"region {loop} cannot end {row.drain} cycles early: {fault}")
    return Parts(tuple(own), rests, flows, tuple(faults))


def sound_parts(program: Program) -> Parts:
    """The parts of a program that may be run.

    Raises
    ------
    BundleError
        The words of a region do not fit the loop before it.
    """
    made = parts(program)
    for fault in made.faults:
        raise BundleError(f"{program.name}: {fault}", hint="compile the kernel again")
    return made


class _Contradiction(Exception):
    """What is wrong with a drain."""


def _row_fault(program: Program, loop: int) -> str | None:
    row, switch = program.table[loop], program.fabric.controller.switch_cycles
    behind = None if row.next is None else program.table[row.next]
    if row.kind != "loop" or not row.counted or row.has_exit:
        return "it is no loop that counts alone"
    if behind is None or behind.kind != "straight" or behind.ii < row.drain:
        return "no straight region is behind it that takes as long"
    if row.drain < 0 or row.span - row.drain < max(row.ii, switch):
        return "its last iteration has not run for so long"
    if not program.fabric.is_plain:
        return f"the fabric {program.fabric.name} does not support it"
    return None


class _Pair:
    """A loop and the straight region behind it: their dataflow, what is left of the loop and what
    is the region's own. `_begin`: the cycle of the last iteration in which the region begins.
    """

    def __init__(self, program: Program, loop: int, contexts: Contexts, merged: Contexts) -> None:
        row = program.table[loop]
        self._contexts = contexts
        self._arrays = {param.name for param in program.params if param.ndim}
        self._arrays |= {local.name for local in program.locals}
        self._ii, self._cycles, self._begin = row.ii, row.drain, row.span - row.drain
        self.loop = _regular(trace(program, loop, contexts), "its words")
        self.rest = self._rest(self.loop)
        self.own = [
            [_without(*pair) for pair in zip(entries, left, strict=True)]
            for entries, left in zip(merged, self.rest, strict=False)
        ]
        self.own += merged[self._cycles :]
        assert row.next is not None
        self.behind = _regular(trace(program, row.next, self.own), "the words behind it")
        moved = sum(1 for entries in self.own for entry in entries for _ in _driven(entry))
        ops, length = self.behind.ops, len(self.own)
        moves = [one for one in self.behind.moves if ops[one.op].time + one.age < length]
        _demand(moved == len(moves), "a word is passed on behind it that is not there")
        self._check_results(self.loop, self.behind)
        self._check_registers(self.rest, self.own)
        self._check_memory(self.loop, self.behind)
        self._check_constants(self.loop, self.behind)

    # --- parting ---

    def _rest(self, loop: RegionFlow) -> Contexts:
        """What the loop would do in each cycle of its drain."""
        times = {(move.slot, move.pe, move.is_link, move.port): 0 for move in loop.moves}
        for move in loop.moves:
            key = move.slot, move.pe, move.is_link, move.port
            times[key] = loop.ops[move.op].time + move.age
        return [
            [self._left(entry, cycle, pe, times) for pe, entry in enumerate(row)]
            for cycle, row in enumerate(
                self._contexts[(self._begin + cycle) % self._ii] for cycle in range(self._cycles)
            )
        ]

    def _left(
        self, entry: Entry, cycle: int, pe: int, times: Mapping[tuple[int, int, bool, int], int]
    ) -> Entry:
        """The part of an entry that is of iterations which have begun."""
        slot, now = (self._begin + cycle) % self._ii, self._begin + cycle

        def goes_on(is_link: bool, port: int) -> bool:
            return times.get((slot, pe, is_link, port), -1) >= now

        issue, capture = entry.issue, entry.capture
        stages = [
            self._stage(part.stage * self._ii + slot - now)
            for part in (issue, capture)
            if part is not None
        ]
        return Entry(
            replace(issue, stage=stages[0]) if issue is not None and stages[0] else None,
            tuple(
                select if goes_on(True, port) else NOTHING
                for port, select in enumerate(entry.links)
            ),
            entry.reads,
            tuple(
                write if goes_on(False, port) else Write()
                for port, write in enumerate(entry.writes)
            ),
            replace(capture, stage=stages[-1]) if capture is not None and stages[-1] else None,
        )

    def _stage(self, after: int) -> int:
        """Of what is so many cycles after the begin of the drain in the loop's last iteration: the
        number of its iteration from the end, the last one's being 1; 0: it has been done.
        """
        return after // self._ii + 1 if after >= 0 else 0

    # --- what the two have to do with each other ---

    def _check_results(self, loop: RegionFlow, flow: RegionFlow) -> None:
        rest = {
            (op.pe, cycle)
            for op in loop.ops
            for cycle in range(op.time + op.delay - self._begin, -1, -self._ii)
        }
        own = {(op.pe, op.time + op.delay) for op in flow.ops}
        _demand(not rest & own, "two operations complete in one cycle")

    def _check_registers(self, rest: Contexts, own: Contexts) -> None:
        """What one part reads is what it has written itself."""
        newest: dict[tuple[int, int], bool] = {}  # whether it is the region's own
        for cycle, row in enumerate(own):
            left = rest[cycle] if cycle < self._cycles else []
            for is_own, entries in ((True, row), (False, left)):
                for pe, entry in enumerate(entries):
                    for register in _registers_read(entry):
                        mine = newest.get((pe, register), False) is is_own
                        _demand(mine, f"register {register} of PE {pe} is written by both")
            written: set[tuple[int, int]] = set()
            for is_own, entries in ((True, row), (False, left)):
                for at in _registers_written(entries):
                    _demand(at not in written, f"both write register {at[1]} of PE {at[0]}")
                    written.add(at)
                    newest[at] = is_own

    def _check_memory(self, loop: RegionFlow, flow: RegionFlow) -> None:
        """No bank has accesses of both in a cycle, and no access of one can tell when those of the
        other happen: arrays that a program writes overlap no other, which each launch checks.
        """
        left: dict[int, list[FlowOp]] = {}
        for op in loop.ops:
            if op.issue.op in MEMORY:
                for cycle in range(op.time - self._begin, -1, -self._ii):
                    left.setdefault(cycle, []).append(op)
        for op in flow.ops:
            if op.issue.op not in MEMORY:
                continue
            _demand(op.time not in left, "both access memory in a cycle")
            for cycle, others in left.items():
                is_before = cycle > op.time
                apart = not is_before or all(self._are_apart(op, other) for other in others)
                _demand(apart, "it accesses memory before the loop is done with it")

    def _are_apart(self, one: FlowOp, other: FlowOp) -> bool:
        if Opcode.STORE not in (one.issue.op, other.issue.op):
            return True
        return one.array != other.array and self._arrays >= {one.array, other.array}

    def _check_constants(self, loop: RegionFlow, flow: RegionFlow) -> None:
        """Each reads the words that there would be if they ran one after the other."""
        read: dict[Constant, int] = {}
        written: dict[Constant, int] = {}
        for op in loop.ops:
            for entry in _entries_read(op):
                read[entry] = max(read.get(entry, 0), op.time - self._begin)
        for capture in loop.captures:
            after = capture.time - self._begin + 1
            written[capture.target] = max(written.get(capture.target, 0), after)
        for op in flow.ops:
            for entry in _entries_read(op):
                is_there = op.time >= written.get(entry, 0)
                _demand(is_there, f"entry {entry.entry} of PE {entry.pe} is read too early")
        for capture in flow.captures:
            first = max(read.get(capture.target, 0), written.get(capture.target, 0))
            _demand(capture.time >= first, f"a live-out of PE {capture.target.pe} comes too early")


def _regular(flow: RegionFlow | None, what: str) -> RegionFlow:
    if flow is None:
        raise _Contradiction(f"{what} are of no regular form")
    return flow


def _demand(holds: bool, otherwise: str) -> None:
    if not holds:
        raise _Contradiction(otherwise)


def _entries_read(op: FlowOp) -> Iterator[Constant]:
    """Entries of constant stores that an operation reads, in whatever iteration."""
    for read in (*op.reads, *(() if op.predicate is None else (op.predicate,))):
        if isinstance(read.source, Constant):
            yield read.source
        if read.first is not None:
            yield read.first
    if op.issue.op in MEMORY:
        yield Constant(op.pe, op.issue.base)


def _operands(issue: Issue) -> tuple[Operand, ...]:
    return (*issue.operands[: OPCODES[issue.op].arity], issue.predicate)


def _driven(entry: Entry) -> Iterator[Select]:
    """What drives links and registers."""
    for select in (*entry.links, *(write.select for write in entry.writes)):
        if select.kind is not Sel.NONE:
            yield select


def _registers_written(entries: Sequence[Entry]) -> list[tuple[int, int]]:
    """(PE, register) of each write in a context."""
    return [
        (pe, write.register)
        for pe, entry in enumerate(entries)
        for write in entry.writes
        if write.select.kind is not Sel.NONE
    ]


def _registers_read(entry: Entry) -> Iterator[int]:
    selects = [*_driven(entry)]
    if entry.issue is not None:
        selects += [operand.select for operand in _operands(entry.issue)]
    if entry.capture is not None:
        selects.append(entry.capture.select)
    for select in selects:
        if select.kind is Sel.RF:
            yield entry.reads[select.index]


def _without(merged: Entry, left: Entry) -> Entry:
    """An entry without a part, which it must have."""
    whole, part = _by_register(merged), _by_register(left)
    links = zip(whole.links, part.links, strict=True)
    has_links = all(p.kind is Sel.NONE or p == w for w, p in links)
    driven = {write for write in part.writes if write.select.kind is not Sel.NONE}
    _demand(
        (part.issue is None or part.issue == whole.issue)
        and (part.capture is None or part.capture == whole.capture)
        and has_links
        and driven <= set(whole.writes),
        "the words behind it do not hold what is left of it",
    )
    return replace(
        merged,
        issue=merged.issue if part.issue is None else None,
        capture=merged.capture if part.capture is None else None,
        links=tuple(
            select if other.kind is Sel.NONE else NOTHING
            for select, other in zip(merged.links, part.links, strict=True)
        ),
        writes=tuple(
            Write() if named in driven else write
            for write, named in zip(merged.writes, whole.writes, strict=True)
        ),
    )


def _by_register(entry: Entry) -> Entry:
    """An entry whose selections name registers and not read ports."""

    def named(select: Select) -> Select:
        return Select(Sel.RF, entry.reads[select.index]) if select.kind is Sel.RF else select

    issue, capture = entry.issue, entry.capture
    if issue is not None:
        a, b, c = (replace(o, select=named(o.select)) for o in issue.operands)
        predicate = replace(issue.predicate, select=named(issue.predicate.select))
        issue = replace(issue, operands=(a, b, c), predicate=predicate)
    return Entry(
        issue,
        tuple(named(select) for select in entry.links),
        entry.reads,
        tuple(replace(write, select=named(write.select)) for write in entry.writes),
        None if capture is None else replace(capture, select=named(capture.select)),
    )
