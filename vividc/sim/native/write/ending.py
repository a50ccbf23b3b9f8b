"""The end of a region's run: time, the region that follows, live-outs and sums."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from vividc.program.reloads import Reloads
from vividc.sim.native.plan.counts import CountClass, Speculation
from vividc.sim.native.plan.layout import BITS, Place, Status, Sum
from vividc.sim.native.write.body import Key
from vividc.sim.native.write.frame import Frame

COUNTERS: Final = {
    "constant_writes": Sum.CONSTANT_WRITES,
    "capture_reads": Sum.CAPTURE_READS,
    "reads": Sum.READS,
    "writes": Sum.WRITES,
}
"""Counters that bodies hand on, and the sums they go to."""


@dataclass(frozen=True)
class End:
    """Values at the end of a region.

    Attributes
    ----------
    limit
        Iterations run.
    end
        Cycles, without stalls.
    exited
        The iteration that ended the loop, or -1; empty: there is no exit node.
    branch
        The word that chooses the next region; empty: there is none.
    """

    limit: str
    end: str
    exited: str
    values: dict[Key, str]
    branch: str


def finish(frame: Frame, end: End) -> None:
    """The end of a run that had an iteration."""
    code = frame.code
    cycles = code.value(f"add i64 {end.end}, {end.values[('stalls',)]}")
    now = code.value(f"add i64 {frame.base}, {cycles}")
    if frame.overlap.begins_early:
        cycles = code.value(f"sub i64 {cycles}, {frame.get(Place.OVERLAP)}")
    limit = frame.get(Place.CYCLE_LIMIT)
    over = code.either(
        code.value(f"icmp sgt i64 {now}, {limit}"),
        code.value(f"icmp sgt i64 {frame.entries}, {limit}"),
    )
    code.do(f"br i1 {over}, label %limit, label %over")
    code.start("over")
    row = frame.flow.row
    if row.drain:
        _go_on(frame, now, str(row.next), "0")
        overlap = str(row.drain)
    else:
        overlap = _continue(frame, now, end.branch)
    if row.drain or frame.overlap.fill or frame.overlap.begins_early:
        frame.set(Place.OVERLAP, overlap)
    _write_back(frame, end.values)
    sums = {
        Sum.ENTRIES: "1",
        Sum.NONEMPTY: "1",
        Sum.ITERATIONS: end.limit,
        Sum.CYCLES: cycles,
        Sum.STALLS: end.values["stalls",],
    }
    sums |= {place: end.values[name,] for name, place in COUNTERS.items()}
    for place, value in sums.items():
        _sum(frame, place, value)
    if frame.flow.row.kind == "loop":
        for number, count in enumerate(frame.classes):
            _sum(frame, len(Sum) + number, _class_value(frame, count, end))
    code.do(f"ret i32 {Status.DONE:d}")


def finish_empty(frame: Frame) -> None:
    """The end of a run without any."""
    _sum(frame, Sum.ENTRIES, "1")
    _continue(frame, frame.base, "")  # a loop that has none does not begin early
    frame.code.do(f"ret i32 {Status.DONE:d}")


def _sum(frame: Frame, place: int, value: str) -> None:
    if value == "0":
        return
    word = frame.get(frame.sums + place)
    frame.set(frame.sums + place, frame.code.value(f"add i64 {word}, {value}"))


def _class_value(frame: Frame, count: CountClass, end: End) -> str:
    """What one run adds to a class of counts (see `counts`)."""
    code = frame.code
    extra = "0"
    if count.most and end.exited:
        beyond = code.value(f"sub i64 {frame.trip}, {end.limit}")
        extra = code.value(f"call i64 @llvm.smin.i64(i64 {beyond}, i64 {count.most})")
        has_exited = code.value(f"icmp sge i64 {end.exited}, 0")
        extra = code.choose(has_exited, "i64", extra, "0")
    if isinstance(count, Speculation):
        return extra
    extra = code.value(f"call i64 @llvm.smin.i64(i64 {extra}, i64 {count.last})")
    moved = code.value(f"add i64 {end.limit}, {extra}")
    return code.value(f"call i64 @llvm.smax.i64(i64 {moved}, i64 0)")


def _write_back(frame: Frame, values: dict[Key, str]) -> None:
    code, layout = frame.code, frame.machine.layout
    for constant in frame.written:
        word = values["constant", constant.pe, constant.entry]
        code.store("i32", word, "%constants", layout.cell(constant))
    for bit in frame.bits:
        place = layout.valid_word(bit)
        valid = code.extended(values["valid", bit])
        shifted = code.value(f"shl i64 {valid}, {bit % BITS}")
        frame.set(place, code.value(f"or i64 {frame.get(place)}, {shifted}"))


def _continue(frame: Frame, now: str, branch: str) -> str:
    """Time, and the region that runs next; in how many cycles that was under way."""
    code, targets = frame.code, (frame.flow.row.next, frame.flow.row.branch)
    onward, branched = (-1 if target is None else target for target in targets)
    following = str(onward)
    if branch:
        taken = code.value(f"icmp eq i32 {branch}, 1")
        following = code.choose(taken, "i64", str(branched), str(onward))
    switch = overlap = "0"
    if onward >= 0 or (branch and branched >= 0):
        goes_on = code.value(f"icmp sge i64 {following}, 0")
        switch = code.choose(goes_on, "i64", str(frame.switch_cycles), "0")
        if frame.overlap.fill:
            has_begun = _has_begun(frame, following)
            overlap = code.choose(has_begun, "i64", str(frame.overlap.fill), "0")
            switch = code.choose(has_begun, "i64", "0", switch)
        if frame.reloads is not None:
            cycles = _brought(frame, frame.reloads, targets, following)
            switch = code.value(f"add i64 {switch}, {cycles}")
        now = code.value(f"add i64 {now}, {switch}")
        _check_switch(frame, now, goes_on)
    _go_on(frame, now, following, switch)
    return overlap


def _brought(frame: Frame, reloads: Reloads, targets: Sequence[int | None], following: str) -> str:
    """Bring the contexts of the region that follows if they are not held; cycles that takes."""
    code, words, cycles = frame.code, frame.machine.layout.held, "0"
    for target in dict.fromkeys(target for target in targets if target is not None):
        reload, bit = reloads.rows[target], 1 << target
        held = code.value(
            f"and i64 {frame.get(words[target // BITS])}, {_signed(bit, target // BITS)}"
        )
        enters = code.both(
            code.value(f"icmp eq i64 {following}, {target}"),
            code.value(f"icmp eq i64 {held}, 0"),
        )
        for number, word in enumerate(words):
            now = frame.get(word)
            kept = code.value(f"and i64 {now}, {_signed(~reload.evicted, number)}")
            kept = code.value(f"or i64 {kept}, {_signed(bit, number)}")
            frame.set(word, code.choose(enters, "i64", kept, now))
        cycles = code.choose(enters, "i64", str(reload.cycles), cycles)
    passed = code.value(f"add i64 {frame.get(Place.RELOAD_CYCLES)}, {cycles}")
    frame.set(Place.RELOAD_CYCLES, passed)
    return cycles


def _signed(bits: int, number: int) -> int:
    """A word of a mask."""
    word = bits >> number * BITS & (1 << BITS) - 1
    return word - (word >> BITS - 1 << BITS)


def _has_begun(frame: Frame, following: str) -> str:
    """Whether the loop that follows has begun while the region ended."""
    code = frame.code
    trips = frame.get(Place.TRIP)
    return code.both(
        code.value(f"icmp eq i64 {following}, {frame.overlap.loop}"),
        code.value(f"icmp sge i64 {trips}, {frame.overlap.least}"),
    )


def _go_on(frame: Frame, now: str, following: str, switch: str) -> None:
    code = frame.code
    frame.set(Place.NEXT, following)
    frame.set(Place.CYCLE, now)
    frame.set(Place.ENTRIES, frame.entries)
    passed = frame.get(Place.SWITCH_CYCLES)
    frame.set(Place.SWITCH_CYCLES, code.value(f"add i64 {passed}, {switch}"))


def _check_switch(frame: Frame, now: str, goes_on: str) -> None:
    code = frame.code
    limit = frame.get(Place.CYCLE_LIMIT)
    over = code.either(
        code.value(f"icmp sgt i64 {now}, {limit}"),
        code.value(f"icmp sgt i64 {frame.entries}, {limit}"),
    )
    label = code.fresh("switched")
    over = code.both(goes_on, over)
    code.do(f"br i1 {over}, label %limit, label %{label}")
    code.start(label)
