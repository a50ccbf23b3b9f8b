"""Two regions that are under way in the same cycles: neither may change what the other reads."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

from vividc.machine.opcodes import MEMORY, Opcode
from vividc.program.dataflow import Constant, FlowCapture, FlowOp, RegionFlow
from vividc.program.overlaps.words import (
    Contexts,
    demand,
    driven,
    entries_read,
    registers_read,
    registers_written,
)
from vividc.program.program import Program


@dataclass(frozen=True, slots=True)
class Side:
    """One of the two, by the cycles of the straight region.

    Attributes
    ----------
    contexts
        Its part of the words, from the straight region's first cycle on.
    ops, captures
        (cycle, what happens): of operations and live-outs.
    completions
        (PE, cycle) in which an operation completes.
    first
        The stage of a loop's first iteration, if it goes on when the straight region has ended.
    """

    contexts: Contexts
    ops: Sequence[tuple[int, FlowOp]]
    captures: Sequence[tuple[int, FlowCapture]]
    completions: Collection[tuple[int, int]]
    first: int | None = None

    @staticmethod
    def of_straight(contexts: Contexts, flow: RegionFlow) -> Side:
        """The straight region itself.

        Raises
        ------
        Contradiction
            It passes on words that are not there.
        """
        moved = sum(1 for entries in contexts for entry in entries for _ in driven(entry))
        length = len(contexts)
        moves = [one for one in flow.moves if flow.ops[one.op].time + one.age < length]
        demand(moved == len(moves), "a word is passed on that is not there")
        return Side(
            contexts,
            [(op.time, op) for op in flow.ops],
            [(capture.time, capture) for capture in flow.captures],
            {(op.pe, op.time + op.delay) for op in flow.ops},
        )

    @property
    def last_stage(self) -> int:
        """Of its operations and live-outs."""
        entries = [entry for row in self.contexts for entry in row]
        marks = [mark for one in entries for mark in (one.issue, one.capture) if mark is not None]
        return max((mark.stage for mark in marks), default=0)

    def accesses(self) -> Iterator[tuple[int, FlowOp]]:
        """Its accesses to the scratchpad."""
        return ((cycle, op) for cycle, op in self.ops if op.issue.op in MEMORY)

    def read(self) -> Iterator[tuple[int, Constant]]:
        """(cycle, entry) of what it reads of constant stores."""
        return ((cycle, entry) for cycle, op in self.ops for entry in entries_read(op))


def demand_apart(program: Program, first: Side, second: Side) -> None:
    """It makes no difference whether the second begins before the first has ended, or after.

    Raises
    ------
    Contradiction
        It does.
    """
    both = set(first.completions) & set(second.completions)
    demand(not both, "two operations complete in one cycle")
    _check_registers(first, second)
    _check_memory(program, first, second)
    _check_constants(first, second)


def _check_registers(first: Side, second: Side) -> None:
    """What one reads is what it has written itself, also when the first is over."""
    newest: dict[tuple[int, int], bool] = {}  # whether it is the second's
    kept: set[tuple[int, int]] = set()  # what the second may read later
    sides = ((False, first), (True, second))
    for cycle in range(max(len(side.contexts) for _, side in sides)):
        now = [(n, side.contexts[cycle]) for n, side in sides if cycle < len(side.contexts)]
        for which, entries in now:
            for pe, entry in enumerate(entries):
                for register in registers_read(entry, second.first if which else first.first):
                    mine = newest.get((pe, register), which) is which
                    demand(mine, f"register {register} of PE {pe} is written by both")
        written: set[tuple[int, int]] = set()
        for which, entries in now:
            for at in registers_written(entries):
                lost = at in written or (not which and at in kept)
                demand(not lost, f"both write register {at[1]} of PE {at[0]}")
                written.add(at)
                newest[at] = which
                if which and second.first is not None:
                    kept.add(at)


def _check_memory(program: Program, first: Side, second: Side) -> None:
    """No bank has accesses of both in a cycle, and no access of one can tell when those of the
    other happen: arrays that a program writes overlap no other, which each launch checks.
    """
    arrays = {param.name for param in program.params if param.ndim}
    arrays |= {local.name for local in program.locals}
    earlier: dict[int, list[FlowOp]] = {}
    for cycle, op in first.accesses():
        earlier.setdefault(cycle, []).append(op)
    for now, op in second.accesses():
        demand(now not in earlier, "both access memory in a cycle")
        for cycle, others in earlier.items():
            apart = cycle < now or all(_are_apart(op, other, arrays) for other in others)
            demand(apart, "memory is accessed before the one before is done with it")


def _are_apart(one: FlowOp, other: FlowOp, arrays: set[str]) -> bool:
    if Opcode.STORE not in (one.issue.op, other.issue.op):
        return True
    return one.array != other.array and arrays >= {one.array, other.array}


def _check_constants(first: Side, second: Side) -> None:
    """Each reads the words that there would be if they ran one after the other."""
    read: dict[Constant, int] = {}
    written: dict[Constant, int] = {}
    for cycle, entry in first.read():
        read[entry] = max(read.get(entry, 0), cycle)
    for cycle, capture in first.captures:
        written[capture.target] = max(written.get(capture.target, 0), cycle + 1)
    for cycle, entry in second.read():
        is_there = cycle >= written.get(entry, 0)
        demand(is_there, f"entry {entry.entry} of PE {entry.pe} is read too early")
    for cycle, capture in second.captures:
        least = max(read.get(capture.target, 0), written.get(capture.target, 0))
        demand(cycle >= least, f"a live-out of PE {capture.target.pe} comes too early")
