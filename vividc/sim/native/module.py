"""A whole program as one LLVM module.

    i32 run(ptr context, ptr constants, ptr memory) -> Status

runs regions from the context's NEXT on, until the program ends or there is something for the caller
to do.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vividc.program import Program
from vividc.program.dataflow import RegionFlow, trace
from vividc.program.overlaps.parts import sound_parts
from vividc.program.reloads import reloads_of
from vividc.sim.native.bulk import write as bulk
from vividc.sim.native.bulk.tables import BulkTables, bulk_tables
from vividc.sim.native.plan.counts import RegionCounts, region_counts
from vividc.sim.native.plan.layout import Layout, Place, Status, layout
from vividc.sim.native.plan.schedule import schedule
from vividc.sim.native.region import ARGUMENTS, region_function
from vividc.sim.native.write.body import Machine
from vividc.sim.native.write.frame import Overlap
from vividc.sim.native.write.operations import DECLARATIONS
from vividc.sim.native.write.text import Code

ENTRY: Final = "run"
_DECLARED: Final = (
    "declare i64 @llvm.smin.i64(i64, i64)\ndeclare i64 @llvm.smax.i64(i64, i64)\n"
    + DECLARATIONS
    + bulk.DECLARATIONS
)
_DECLARATIONS: Final = "".join(dict.fromkeys(_DECLARED.splitlines(keepends=True)))
"""Once each, whatever files name them."""


@dataclass(frozen=True, slots=True)
class Plan:
    """What the analysis of a program finds before it is compiled.

    Attributes
    ----------
    flows
        Of each region; None: the reference engine runs it.
    counts
        What the sums of each region tell.
    tables
        Of each region that runs by tables.
    table_words
        int32: their words, one region's behind the other's.
    """

    flows: tuple[RegionFlow | None, ...]
    counts: tuple[RegionCounts | None, ...]
    layout: Layout
    tables: tuple[BulkTables | None, ...]
    table_words: NDArray[np.int32]


def plan(program: Program) -> Plan:
    """Analyse the words of a program."""
    parts = sound_parts(program)
    flows = tuple(
        parts.flows.get(index) or trace(program, index, contexts)
        for index, contexts in enumerate(parts.own)
    )
    counts = tuple(None if flow is None else region_counts(flow) for flow in flows)
    sizes = [0 if one is None else len(one.classes) for one in counts]
    pes = len(program.fabric.pes)
    tables = tuple(None if flow is None else bulk_tables(flow, pes) for flow in flows)
    words = [table.words for table in tables if table is not None]
    joined = np.concatenate([np.zeros(0, np.int32), *words])
    return Plan(flows, counts, layout(program, sizes), tables, joined)


def module_text(program: Program, planned: Plan) -> str:
    """LLVM IR of the program."""
    scratchpad = program.fabric.scratchpad
    machine = Machine(planned.layout, scratchpad.size_bytes, scratchpad.banks)
    switch_cycles, reloads = program.fabric.controller.switch_cycles, reloads_of(program)
    regions, first = [], 0
    for index, (flow, counts, tables) in enumerate(
        zip(planned.flows, planned.counts, planned.tables, strict=True)
    ):
        classes = () if counts is None else counts.classes
        placed = None if tables is None else (tables, first)
        overlap = Overlap.of(program.table, index)
        text = region_function(
            index, flow, classes, machine, switch_cycles, overlap, reloads, placed
        )
        regions.append(text)
        first += 0 if tables is None else tables.words.size
    return "\n".join([_DECLARATIONS, *regions, _dispatch(len(regions))])


def spill_words(planned: Plan, banks: int) -> int:
    """Words that the largest suspended loop takes in the context: an upper bound."""
    sizes = [0]
    for flow, tables in zip(planned.flows, planned.tables, strict=True):
        if tables is not None:
            sizes.append(bulk.bulk_words(tables, banks))
        elif flow is not None:
            sizes.append(_carried(flow))
    return max(sizes)


def _dispatch(regions: int) -> str:
    code = Code()
    code.start("entry")
    code.do("br label %next")
    code.start("next")
    region = code.load("i64", "%context", Place.NEXT)
    targets = " ".join(f"i64 {index}, label %check{index}" for index in range(regions))
    code.do(f"switch i64 {region}, label %done [ {targets} ]")
    for index in range(regions):
        _call(code, index)
    for status in (Status.DONE, Status.STOPPED):
        code.start(status.name.lower())
        code.do(f"ret i32 {status:d}")
    code.start("suspended")
    cycle = code.load("i64", "%context", Place.CYCLE)
    code.store("i64", cycle, "%context", Place.NOW)
    code.do(f"ret i32 {Status.SUSPENDED:d}")
    return "\n".join([f"define i32 @{ENTRY}({ARGUMENTS}) {{", *code.lines, "}", ""])


def _call(code: Code, index: int) -> None:
    code.start(f"check{index}")
    entries = code.load("i64", "%context", Place.ENTRIES)
    stop = code.load("i64", "%context", Place.ENTRY_STOP)
    stopped = code.value(f"icmp sge i64 {entries}, {stop}")
    code.do(f"br i1 {stopped}, label %stopped, label %time{index}")
    code.start(f"time{index}")
    cycle = code.load("i64", "%context", Place.CYCLE)
    budget = code.load("i64", "%context", Place.BUDGET)
    late = code.value(f"icmp sgt i64 {cycle}, {budget}")
    code.do(f"br i1 {late}, label %suspended, label %call{index}")
    code.start(f"call{index}")
    call = f"call i32 @region{index}(ptr %context, ptr %constants, ptr %memory)"
    status = code.value(call)
    done = code.value(f"icmp eq i32 {status}, 0")
    code.do(f"br i1 {done}, label %next, label %leave{index}")
    code.start(f"leave{index}")
    code.do(f"ret i32 {status}")


def _carried(flow: RegionFlow) -> int:
    return sum(schedule(flow).depth) + 2 * len(flow.captures) + 16
