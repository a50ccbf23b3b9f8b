"""What a straight region's words hold of the loop that begins while it ends.

A loop may begin before the straight region before it is over: that region's last words hold what
the loop does in its first cycles (docs/machine.md, "Fill"). What those words must be follows from
the loop's.
"""

from __future__ import annotations

from vividc.dfg.regions import loop_behind
from vividc.program.dataflow import RegionFlow
from vividc.program.overlaps.sides import Side
from vividc.program.overlaps.words import Contexts, demand, part_of, times_of_moves
from vividc.program.program import Program
from vividc.program.reloads import overlap_fault
from vividc.program.tables import RegionRow
from vividc.program.words.entry import Entry, Use


def fill_fault(program: Program, region: int) -> str | None:
    """Why no loop can begin so early under a straight region, by the region table alone."""
    row, loop = program.table[region], loop_behind(program.table, region)
    if row.kind != "straight" or loop is None:
        return "it is no straight region with one loop behind it that counts alone"
    drained = max((one.drain for one in program.table if one.next == region), default=0)
    if not 0 < row.fill <= row.ii - max(0, drained):
        return "it does not take so long, or a loop ends meanwhile"
    begun = program.table[loop].begun(row.fill)
    if not begun < row.stages <= program.fabric.controller.max_stages:
        return f"it has {row.stages} stages"
    if not program.fabric.is_plain:
        return f"the fabric {program.fabric.name} does not support it"
    return overlap_fault(program, region, loop)


def ahead_of(row: RegionRow, loop: RegionRow, contexts: Contexts, flow: RegionFlow) -> Side:
    """What a loop does while the straight region of `row` ends, as that region's words have it:
    stages are counted so that the last one is that of the loop's first iteration.
    """
    begin = row.ii - row.fill
    times = times_of_moves(flow)

    def begun(now: int, pe: int, entry: Entry) -> Entry:
        """What an entry holds of iterations that there are in cycle `now` of the loop."""
        slot = now % loop.ii

        def stage_of(stage: int) -> int | None:
            iteration = now // loop.ii - stage
            return row.stages - 1 - iteration if iteration >= 0 else None

        def is_there(is_link: bool, port: int) -> bool:
            return times.get((slot, pe, is_link, port), now + 1) <= now

        return part_of(entry, stage_of, is_there)

    def never(_: int) -> None:
        return None

    idle = [part_of(entry, never, lambda *_: False) for entry in contexts[0]]
    return Side(
        [
            *([idle] * begin),
            *(
                [begun(cycle, pe, entry) for pe, entry in enumerate(contexts[cycle % loop.ii])]
                for cycle in range(row.fill)
            ),
        ],
        [(cycle, op) for op in flow.ops for cycle in range(begin + op.time, row.ii, loop.ii)],
        [(cycle, o) for o in flow.captures for cycle in range(begin + o.time, row.ii, loop.ii)],
        {
            (op.pe, cycle + op.delay)
            for op in flow.ops
            for cycle in range(begin + op.time, row.ii, loop.ii)
        },
        row.stages - 1,
    )


def demand_known(program: Program, region: int, flow: RegionFlow) -> None:
    """How often the loop runs, and whether it does, is known when it begins.

    Raises
    ------
    Contradiction
        It is not.
    """
    row, latency = program.table[region], program.fabric.controller.control_latency
    for op in flow.ops:
        if op.issue.use in (Use.TRIP, Use.BRANCH):
            is_known = op.time + op.delay + 1 + latency <= row.ii - row.fill
            demand(is_known, f"it is not known soon enough what PE {op.pe} tells the controller")
