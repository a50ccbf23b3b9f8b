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
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vividc.dfg.opcodes import MEMORY
from vividc.sim.engine import Activity
from vividc.sim.native.layout import Sum
from vividc.sim.native.trace import Constant, FlowOp, Move, RegionFlow, Result


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
Vector = NDArray[np.int64]

_ISSUED: Final = "issued "
_DIRECT: Final = {
    "entries": Sum.ENTRIES,
    "iterations": Sum.ITERATIONS,
    "cycles": Sum.CYCLES,
    "stalls": Sum.STALLS,
    "constant_writes": Sum.CONSTANT_WRITES,
    "register_reads": Sum.CAPTURE_READS,
    "scratchpad_reads": Sum.READS,
    "scratchpad_writes": Sum.WRITES,
}


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


@dataclass(frozen=True, slots=True)
class RegionCounts:
    """Counts of a region as linear functions of its sums.

    Attributes
    ----------
    classes
        Sums beside the fixed ones.
    names
        Fields of `Totals`, and issues by opcode.
    matrix
        int64 [names, sums].
    """

    classes: tuple[CountClass, ...]
    names: tuple[str, ...]
    matrix: NDArray[np.int64]

    def add_to(self, totals: Totals, sums: Vector) -> None:
        """Add what the code of the region counted; `sums` begins with the region's."""
        values = (self.matrix @ sums[: self.matrix.shape[1]]).tolist()
        for name, value in zip(self.names, values, strict=True):
            if not name.startswith(_ISSUED):
                setattr(totals, name, getattr(totals, name) + value)
            elif value:
                totals.issued[name.removeprefix(_ISSUED)] += value


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


def region_counts(flow: RegionFlow) -> RegionCounts:
    """What the sums of a region tell."""
    classes = count_classes(flow)
    unit = np.identity(len(Sum) + len(classes), np.int64)
    found: dict[str, Vector] = {name: unit[place] for name, place in _DIRECT.items()}
    of_class = dict(zip(classes, unit[len(Sum) :], strict=True))
    _Counter(flow, unit, of_class, found).count()
    return RegionCounts(classes, tuple(found), np.array([*found.values()]))


class _Counter:
    """Every count as a vector of coefficients of the sums."""

    def __init__(
        self,
        flow: RegionFlow,
        unit: NDArray[np.int64],
        of_class: dict[CountClass, Vector],
        found: dict[str, Vector],
    ) -> None:
        self._flow = flow
        self._nothing: Vector = 0 * unit[0]
        self._runs, self._iterations = unit[Sum.NONEMPTY], unit[Sum.ITERATIONS]
        self._of_class = of_class
        self._found = found

    def count(self) -> None:
        """Count operations and moves."""
        for op in self._flow.ops:
            issues = self._issues(op)
            self._add(_ISSUED + op.issue.op.value, issues)
            self._add_reads(op, issues - self._runs)
        for move in self._flow.moves:
            words = self._words(move)
            self._add("link_words" if move.is_link else "register_writes", words)
            if move.from_register:
                self._add("register_reads", words)

    def _add(self, name: str, times: Vector) -> None:
        self._found[name] = np.add(self._found.get(name, self._nothing), times)

    def _issues(self, op: FlowOp) -> Vector:
        most = _most(self._flow, op)
        extra = self._of_class[Speculation(most)] if most else self._nothing
        issues: Vector = self._iterations + extra
        return issues

    def _words(self, move: Move) -> Vector:
        tail = _tail(self._flow, move)
        if tail is None:
            return self._issues(self._flow.ops[move.op])
        return self._of_class.get(tail, self._nothing)

    def _add_reads(self, op: FlowOp, later: Vector) -> None:
        issues = later + self._runs
        if op.issue.op in MEMORY:
            self._add("constant_reads", issues)
        for read in (*op.reads, *(() if op.predicate is None else (op.predicate,))):
            times = issues
            if read.first is not None:
                self._add("constant_reads", self._runs)
                times = later
            if isinstance(read.source, Constant):
                self._add("constant_reads", times)
            elif isinstance(read.source, Result) and read.from_register:
                self._add("register_reads", times)


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
