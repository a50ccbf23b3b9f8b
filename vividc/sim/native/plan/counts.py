"""Activity without counting: how often an operation issues and a word moves follows from the number
of live iterations of each run of a region.

With n live iterations of which the last one ends the loop, an operation at `time` has issued
n + extra times: speculative iterations issue until the exit acts. A word that moves `age` cycles
after its operation issues moves with every issue whose move is before the region ends.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vividc.machine.opcodes import MEMORY
from vividc.program.dataflow import Constant, FlowOp, Move, RegionFlow, Result
from vividc.sim.engine import Activity, RegionRun
from vividc.sim.native.plan.layout import Sum


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


_TIMES: Final = ("entries", "iterations", "cycles", "stalls")
_ACTIVITY: Final = tuple(Activity.__dataclass_fields__)
_FIELDS: Final = (*_TIMES, *_ACTIVITY)


class Totals:
    """Sums over all runs of one region, however they were run.

    Parameters
    ----------
    fields
        Values of `_FIELDS`: entries, iterations, cycles, stalls, and the fields of `Activity`.
    issued
        Issues by opcode name, all positive.
    """

    __slots__ = ("fields", "issued")

    def __init__(
        self, fields: Sequence[int] = (0,) * len(_FIELDS), issued: Mapping[str, int] | None = None
    ) -> None:
        self.fields = fields
        self.issued = {} if issued is None else issued

    def __add__(self, other: Totals) -> Totals:
        fields = [a + b for a, b in zip(self.fields, other.fields, strict=True)]
        return Totals(fields, Counter(self.issued) + Counter(other.issued))

    def region_run(self) -> RegionRun:
        """The part of a run's result."""
        if not self.fields[0]:
            return _NEVER_RAN
        entries, iterations, cycles, stalls = self.fields[: len(_TIMES)]
        issued = dict(sorted(self.issued.items()))
        moved = Activity(*self.fields[len(_TIMES) :])
        return RegionRun(entries, iterations, cycles, stalls, issued, moved)


_NEVER_RAN: Final = RegionRun(0, 0, 0, 0, {})


_NOTHING: Final = Totals()
"""Of a region that was never entered."""
_NO_TOTALS: Final[Mapping[int, Totals]] = {}


@dataclass(frozen=True, slots=True)
class RegionCounts:
    """Counts of a region as linear functions of its sums.

    Attributes
    ----------
    classes
        Sums beside the fixed ones.
    ops
        Names of the opcodes that issue.
    matrix
        int64 [`_FIELDS` and opcodes, sums].
    """

    classes: tuple[CountClass, ...]
    ops: tuple[str, ...]
    matrix: NDArray[np.int64]

    def totals(self, sums: Vector) -> Totals:
        """What the code of the region counted; `sums` begins with the region's."""
        if not sums[Sum.ENTRIES]:
            return _NOTHING
        values = (self.matrix @ sums[: self.matrix.shape[1]]).tolist()
        issues = zip(self.ops, values[len(_FIELDS) :], strict=True)
        return Totals(values[: len(_FIELDS)], {op: count for op, count in issues if count})


def count_classes(flow: RegionFlow) -> tuple[CountClass, ...]:
    """The sums that a region's code keeps beside the fixed ones."""
    classes: dict[CountClass, None] = {}
    for op in flow.ops:
        if _most(flow, op):
            classes[Speculation(_most(flow, op))] = None
    for move in flow.moves:
        tail = _tail(flow, move)
        if tail is not None and flow.row.kind == "loop":
            classes[tail] = None
    return tuple(classes)


def region_counts(flow: RegionFlow) -> RegionCounts:
    """What the sums of a region tell."""
    classes = count_classes(flow)
    unit = np.identity(len(Sum) + len(classes), np.int64)
    vectors: dict[str, Vector] = dict.fromkeys(_FIELDS, 0 * unit[0])
    vectors |= {name: unit[place] for name, place in _DIRECT.items()}
    of_class = dict(zip(classes, unit[len(Sum) :], strict=True))
    _Counter(flow, unit, of_class, vectors).count()
    ops = tuple(name.removeprefix(_ISSUED) for name in vectors if name.startswith(_ISSUED))
    return RegionCounts(classes, ops, np.array([*vectors.values()]))


class _Counter:
    """Every count as a vector of coefficients of the sums."""

    def __init__(
        self,
        flow: RegionFlow,
        unit: NDArray[np.int64],
        of_class: dict[CountClass, Vector],
        vectors: dict[str, Vector],
    ) -> None:
        self._flow = flow
        self._nothing: Vector = 0 * unit[0]
        self._runs, self._iterations = unit[Sum.NONEMPTY], unit[Sum.ITERATIONS]
        self._of_class = of_class
        self._vectors = vectors

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
        self._vectors[name] = np.add(self._vectors.get(name, self._nothing), times)

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


@dataclass(frozen=True, slots=True, eq=False)
class Sums:
    """What native code counted in a run, or in several of one program: counts are made of its sums
    when they are asked for.

    Attributes
    ----------
    of_regions
        What the sums of each region tell; None: it has no code.
    starts
        Its first sum among `words`.
    """

    of_regions: Sequence[RegionCounts | None]
    starts: Sequence[int]
    words: Vector

    def regions(self, elsewhere: Mapping[int, Totals] = _NO_TOTALS) -> tuple[RegionRun, ...]:
        """One per row of the region table, with what was counted elsewhere."""
        totals = [
            _NOTHING if counts is None else counts.totals(self.words[start:])
            for counts, start in zip(self.of_regions, self.starts, strict=True)
        ]
        for region, done in elsewhere.items():
            totals[region] += done
        return tuple(total.region_run() for total in totals)


def together(runs: Sequence[Sums], iis: Sequence[int]) -> tuple[tuple[RegionRun, ...], list[int]]:
    """What runs of one program counted in each region, and of its cycles those that iterations at
    its II took: of each run no more than there are without stalls.
    """
    first, words = runs[0], np.stack([run.words for run in runs])
    starts = np.array(first.starts)
    own = words[:, starts + Sum.CYCLES] - words[:, starts + Sum.STALLS]
    steady = np.minimum(words[:, starts + Sum.ITERATIONS] * np.array(iis), own).sum(axis=0)
    whole = Sums(first.of_regions, first.starts, words.sum(axis=0))
    return whole.regions(), steady.tolist()


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
