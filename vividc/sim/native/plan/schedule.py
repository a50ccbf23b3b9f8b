"""A region's operations in the order in which native code does them, body by body.

The code of a loop repeats a body of II cycles. A loop with an exit node begins its bodies at the
slot in which the exit decision acts, so that the iterations that are live change only between
bodies: every time is shifted by `offset`, less than II.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from vividc.machine.opcodes import Opcode
from vividc.program import Use
from vividc.program.dataflow import Constant, FlowCapture, FlowOp, RegionFlow, Result


@dataclass(frozen=True, slots=True)
class Schedule:
    """When what happens in the bodies of a region.

    Attributes
    ----------
    ops, captures
        Those of each slot; controlling operations first, then loads, then stores, by PE.
    depth
        Bodies for which each operation's result is kept.
    stages
        Largest stage.
    exit_stage, exit_lag
        The exit decision that acts at the start of body b is that of iteration b - exit_stage, and
        it was made exit_lag bodies before.
    """

    flow: RegionFlow
    offset: int
    ops: tuple[tuple[int, ...], ...]
    captures: tuple[tuple[FlowCapture, ...], ...]
    depth: tuple[int, ...]
    stages: int
    exit_stage: int
    exit_lag: int

    def stage(self, time: int) -> int:
        """Stage, counted in bodies."""
        return (time + self.offset) // self.flow.row.ii

    def slot(self, time: int) -> int:
        """Slot of the body."""
        return (time + self.offset) % self.flow.row.ii

    def lag(self, time: int, age: int) -> int:
        """Bodies since what happened `age` cycles before something at `time`."""
        return -((self.slot(time) - age) // self.flow.row.ii)


def schedule(flow: RegionFlow) -> Schedule:
    """Order the operations of a region."""
    ii = flow.row.ii
    offset = -flow.exit_delay % ii
    bare = Schedule(flow, offset, (), (), (), 0, 0, 0)
    ops: list[list[int]] = [[] for _ in range(ii)]
    for index, op in enumerate(flow.ops):
        ops[bare.slot(op.time)].append(index)
    captures: list[list[FlowCapture]] = [[] for _ in range(ii)]
    for capture in flow.captures:
        captures[bare.slot(capture.time)].append(capture)
    exit_stage = (flow.exit_delay + offset) // ii
    exit_lag = 0 if flow.exit is None else exit_stage - bare.stage(flow.ops[flow.exit].time)
    depth = [0] * len(flow.ops)
    if flow.exit is not None:
        depth[flow.exit] = exit_lag
    for time, source in _results_read(flow):
        depth[source.op] = max(depth[source.op], bare.lag(time, source.age))
    return Schedule(
        flow=flow,
        offset=offset,
        ops=tuple(tuple(sorted(indices, key=lambda i: _order(flow.ops[i]))) for indices in ops),
        captures=tuple(tuple(items) for items in captures),
        depth=tuple(depth),
        stages=max((bare.stage(time) for time in flow.times), default=0),
        exit_stage=exit_stage,
        exit_lag=exit_lag,
    )


def constants_read(flow: RegionFlow) -> list[Constant]:
    """Constant-store entries that operations of a region read."""
    constants: dict[Constant, None] = {}
    for op in flow.ops:
        if op.issue.op in (Opcode.LOAD, Opcode.STORE):
            constants[Constant(op.pe, op.issue.base)] = None
        for read in (*op.reads, op.predicate):
            if read is not None:
                constants |= {c: None for c in (read.source, read.first) if isinstance(c, Constant)}
    return list(constants)


def _order(op: FlowOp) -> tuple[int, int]:
    if op.issue.op is Opcode.STORE:
        return 3, op.pe
    if op.issue.op is Opcode.LOAD:
        return 2, op.pe
    return (0 if op.issue.use is Use.NONE else 1), op.pe


def _results_read(flow: RegionFlow) -> Iterator[tuple[int, Result]]:
    for op in flow.ops:
        for read in (*op.reads, op.predicate):
            if read is not None and isinstance(read.source, Result):
                yield op.time, read.source
    for capture in flow.captures:
        yield capture.time, capture.source
