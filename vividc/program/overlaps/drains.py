"""What a straight region's words hold of the loop that ends while it begins.

A loop may end before its last iterations do: the words of the region behind it hold what is left of
them (docs/machine.md, "Drain"). What those words must be follows from the loop's.
"""

from __future__ import annotations

from vividc.program.dataflow import RegionFlow
from vividc.program.overlaps.sides import Side
from vividc.program.overlaps.words import Contexts, part_of, times_of_moves
from vividc.program.program import Program
from vividc.program.reloads import overlap_fault
from vividc.program.tables import RegionRow
from vividc.program.words.entry import Entry


def drain_fault(program: Program, loop: int) -> str | None:
    """Why a loop cannot end so early, by the region table alone."""
    row, switch = program.table[loop], program.fabric.controller.switch_cycles
    after = row.next
    behind = None if after is None else program.table[after]
    if not row.counts_alone:
        return "it is no loop that counts alone"
    if after is None or behind is None or behind.kind != "straight" or behind.ii < row.drain:
        return "no straight region is behind it that takes as long"
    if row.drain < 0 or row.span - row.drain < max(row.ii, switch):
        return "its last iteration has not run for so long"
    if not program.fabric.is_plain:
        return f"the fabric {program.fabric.name} does not support it"
    return overlap_fault(program, loop, after)


def rest_of(row: RegionRow, contexts: Contexts, flow: RegionFlow) -> Side:
    """What a loop would do in each cycle of its drain, stages counted from its end: the number of
    an iteration from the end, the last one's being 1.
    """
    begin, times = row.span - row.drain, times_of_moves(flow)

    def left(now: int, pe: int, entry: Entry) -> Entry:
        """What an entry holds of iterations that have begun in cycle `now` of the last one."""
        slot = now % row.ii

        def stage_of(stage: int) -> int | None:
            after = stage * row.ii + slot - now
            return after // row.ii + 1 if after >= 0 else None

        def goes_on(is_link: bool, port: int) -> bool:
            return times.get((slot, pe, is_link, port), -1) >= now

        return part_of(entry, stage_of, goes_on)

    return Side(
        [
            [left(now, pe, entry) for pe, entry in enumerate(contexts[now % row.ii])]
            for now in range(begin, begin + row.drain)
        ],
        [(cycle, op) for op in flow.ops for cycle in range(op.time - begin, -1, -row.ii)],
        [(cycle, one) for one in flow.captures for cycle in range(one.time - begin, -1, -row.ii)],
        {
            (op.pe, cycle)
            for op in flow.ops
            for cycle in range(op.time + op.delay - begin, -1, -row.ii)
        },
    )
