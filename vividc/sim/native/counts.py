"""Activity without counting: how often an operation issues and a word moves follows from the number
of live iterations of each run of a region.

With n live iterations of which the last one ends the loop, an operation at `time` has issued
n + extra times: speculative iterations issue until the exit acts. A word that moves `age` cycles
after its operation issues moves with every issue whose move is before the region ends.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

from vividc.dfg.opcodes import MEMORY
from vividc.sim.engine import Activity
from vividc.sim.native.layout import Sum
from vividc.sim.native.trace import Constant, FlowOp, Move, Read, RegionFlow, Result


@dataclass(frozen=True, slots=True)
class Speculation:
    """Sum over the runs of the extra issues, at most `most` in a run."""

    most: int


@dataclass(frozen=True, slots=True)
class Tail:
    """Sum over the runs of max(0, n + min(extra, last)), the extra issues being at most `most`."""

    most: int
    last: int


CountClass = Speculation | Tail


@dataclass
class Totals:
    """Sums over all runs of one region, however they were run."""

    entries: int = 0
    iterations: int = 0
    cycles: int = 0
    stalls: int = 0
    issued: Counter[str] = field(default_factory=Counter)
    link_words: int = 0
    register_reads: int = 0
    register_writes: int = 0
    constant_reads: int = 0
    constant_writes: int = 0
    scratchpad_reads: int = 0
    scratchpad_writes: int = 0


def count_classes(flow: RegionFlow) -> tuple[CountClass, ...]:
    """The sums that a region's code keeps beside the fixed ones."""
    found: dict[CountClass, None] = {}
    for op in flow.ops:
        if _most(flow, op):
            found[Speculation(_most(flow, op))] = None
    for move in flow.moves:
        tail = _tail(flow, move)
        if tail is not None and flow.row.kind == "loop":
            found[tail] = None
    return tuple(found)


def add_counts(
    totals: Totals, flow: RegionFlow, classes: Sequence[CountClass], sums: Sequence[int]
) -> None:
    """Add what the code of a region counted: its words from `Layout.sums` on."""
    of_class = dict(zip(classes, sums[len(Sum) :], strict=True))
    totals.entries += sums[Sum.ENTRIES]
    totals.iterations += sums[Sum.ITERATIONS]
    totals.cycles += sums[Sum.CYCLES]
    totals.stalls += sums[Sum.STALLS]
    totals.constant_writes += sums[Sum.CONSTANT_WRITES]
    totals.register_reads += sums[Sum.CAPTURE_READS]
    totals.scratchpad_reads += sums[Sum.READS]
    totals.scratchpad_writes += sums[Sum.WRITES]
    nonempty, iterations = sums[Sum.NONEMPTY], sums[Sum.ITERATIONS]
    if not nonempty:
        return
    for op in flow.ops:
        most = _most(flow, op)
        issues = iterations + (of_class[Speculation(most)] if most else 0)
        totals.issued[op.issue.op.value] += issues
        _add_reads(totals, op, nonempty, issues - nonempty)
    for move in flow.moves:
        _add_words(totals, move, _words(flow, move, of_class, iterations))


def activity(totals: Sequence[Totals]) -> Activity:
    """The activity of a whole run."""
    names = Activity.__dataclass_fields__
    return Activity(**{name: sum(getattr(total, name) for total in totals) for name in names})


def _most(flow: RegionFlow, op: FlowOp) -> int:
    """Iterations after the exiting one that may have issued `op` before the exit acts."""
    if flow.exit is None:
        return 0
    return max(0, -((op.time - flow.exit_delay) // flow.row.ii) - 1)


def _tail(flow: RegionFlow, move: Move) -> Tail | None:
    """Class of a move; None: it happens with every issue."""
    op = flow.ops[move.op]
    most = _most(flow, op)
    last = -((op.time + move.age - flow.row.span) // flow.row.ii) - 1
    return None if last >= most else Tail(most, last)


def _words(flow: RegionFlow, move: Move, of_class: dict[CountClass, int], iterations: int) -> int:
    tail = _tail(flow, move)
    if tail is not None:
        return of_class.get(tail, 0)
    most = _most(flow, flow.ops[move.op])
    return iterations + (of_class[Speculation(most)] if most else 0)


def _add_words(totals: Totals, move: Move, words: int) -> None:
    if move.is_link:
        totals.link_words += words
    else:
        totals.register_writes += words
    if move.from_register:
        totals.register_reads += words


def _add_reads(totals: Totals, op: FlowOp, firsts: int, later: int) -> None:
    base = 1 if op.issue.op in MEMORY else 0
    totals.constant_reads += base * (firsts + later)
    for read in (*op.reads, *(() if op.predicate is None else (op.predicate,))):
        if read.first is not None:
            totals.constant_reads += firsts
            _add_read(totals, read, later)
        else:
            _add_read(totals, read, firsts + later)


def _add_read(totals: Totals, read: Read, times: int) -> None:
    if isinstance(read.source, Constant):
        totals.constant_reads += times
    elif isinstance(read.source, Result) and read.from_register:
        totals.register_reads += times
