"""A region of a program as one LLVM function: what comes first, and straight regions.

    i32 region(ptr context, ptr constants, ptr memory) -> Status

DONE: the region has run, and the context tells what is next. SUSPENDED: a loop is under way, its
carried values are in the context. After any other status nothing of the region counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from vividc.program.dataflow import RegionFlow
from vividc.program.reloads import Reloads
from vividc.sim.native.bulk.tables import BulkTables
from vividc.sim.native.bulk.write import write_bulk
from vividc.sim.native.plan.counts import CountClass
from vividc.sim.native.plan.layout import BITS, EXTENT_WORDS, Place, Status
from vividc.sim.native.plan.schedule import Schedule, constants_read, schedule
from vividc.sim.native.write.body import Body, Key, Machine, Surroundings
from vividc.sim.native.write.ending import COUNTERS, End, finish
from vividc.sim.native.write.frame import Frame, Overlap
from vividc.sim.native.write.loop import write_loop
from vividc.sim.native.write.text import FALSE, TRUE, Code

ARGUMENTS: Final = "ptr noalias %context, ptr noalias %constants, ptr noalias %memory"


def region_function(
    index: int,
    flow: RegionFlow | None,
    classes: Sequence[CountClass],
    machine: Machine,
    switch_cycles: int,
    overlap: Overlap,
    reloads: Reloads | None,
    placed: tuple[BulkTables, int] | None = None,
) -> str:
    """Text of the function `region{index}`; no flow: one that leaves the region to the reference.

    Parameters
    ----------
    overlap
        With regions before it and behind it.
    placed
        The region's tables, and their first word among all, if it runs by tables.
    """
    code = Code()
    if flow is None:
        code.do(f"ret i32 {Status.IRREGULAR:d}")
    else:
        sums = machine.layout.sums[index]
        frame = Frame(code, machine, flow, classes, switch_cycles, sums, overlap, reloads)
        _write(frame, placed)
    return "\n".join([f"define internal i32 @region{index}({ARGUMENTS}) {{", *code.lines, "}", ""])


def _write(frame: Frame, placed: tuple[BulkTables, int] | None) -> None:
    code, row = frame.code, frame.flow.row
    code.start("entry")
    frame.base = frame.get(Place.CYCLE)
    if frame.overlap.begins_early:
        frame.base = code.value(f"sub i64 {frame.base}, {frame.get(Place.OVERLAP)}")
    frame.entries = code.value(f"add i64 {frame.get(Place.ENTRIES)}, 1")
    if row.counted and row.kind == "loop":
        frame.trip = code.value(f"call i64 @llvm.smax.i64(i64 {frame.get(Place.TRIP)}, i64 0)")
        empty = code.value(f"icmp eq i64 {frame.trip}, 0")
        code.do(f"br i1 {empty}, label %empty, label %some")
        code.start("some")
    _demand_valid(frame)
    around = _surroundings(frame)
    if placed is not None:
        write_bulk(frame, around, *placed)
    elif row.kind == "straight":
        _write_straight(frame, schedule(frame.flow), around)
    else:
        write_loop(frame, schedule(frame.flow), around, _initial(frame))
    for status in (Status.FAULT, Status.LIMIT, Status.IRREGULAR):
        code.start(status.name.lower())
        code.do(f"ret i32 {status:d}")


def _demand_valid(frame: Frame) -> None:
    """Go on only if every constant-store entry that operations read has been set."""
    code, layout = frame.code, frame.machine.layout
    masks: dict[int, int] = {}
    for constant in constants_read(frame.flow):
        bit = layout.bits.get(constant)
        if bit is not None:
            word = layout.valid_word(bit)
            masks[word] = masks.get(word, 0) | 1 << bit % BITS
    ready = TRUE
    for word, mask in masks.items():
        mine = mask - (mask >> BITS - 1 << BITS)
        have = code.value(f"and i64 {frame.get(word)}, {mine}")
        ready = code.both(ready, code.value(f"icmp eq i64 {have}, {mine}"))
    code.do(f"br i1 {ready}, label %begin, label %irregular")
    code.start("begin")


def _surroundings(frame: Frame) -> Surroundings:
    code, layout = frame.code, frame.machine.layout
    constants = {
        constant: code.load("i32", "%constants", layout.cell(constant))
        for constant in constants_read(frame.flow)
        if constant not in frame.written
    }
    extents = {}
    for name in dict.fromkeys(op.array for op in frame.flow.ops):
        first = layout.extents + EXTENT_WORDS * layout.arrays[name]
        words = [frame.get(first + k) for k in range(EXTENT_WORDS)]
        extents[name] = tuple(code.value(f"trunc i64 {word} to i32") for word in words)
    return Surroundings(constants, extents)


def _initial(frame: Frame) -> dict[Key, str]:
    """Carried values at the start of the region, but for earlier results."""
    values: dict[Key, str] = {("stalls",): "0"}
    values |= {(name,): "0" for name in COUNTERS}
    for constant in frame.written:
        word = frame.code.load("i32", "%constants", frame.machine.layout.cell(constant))
        values["constant", constant.pe, constant.entry] = word
    for bit in frame.bits:
        values["valid", bit] = "0"
    return values


def _write_straight(frame: Frame, plan: Schedule, around: Surroundings) -> None:
    code, row = frame.code, frame.flow.row
    body = Body(code, frame.machine, plan, "straight", around, _initial(frame))
    for slot in range(row.ii):
        body.slot(slot)
    if body.fault != FALSE:
        code.do(f"br i1 {body.fault}, label %fault, label %finish")
        code.start("finish")
    if body.trip:
        frame.set(Place.TRIP, code.value(f"sext i32 {body.trip} to i64"))
    finish(frame, End("1", str(row.span), "", body.values, body.branch))
