"""A region of a program as one LLVM function: entry, bodies, what is summed at the end.

    i32 region(ptr context, ptr constants, ptr memory) -> Status

DONE: the region has run, and the context tells what is next. SUSPENDED: a loop is under way, its
carried values are in the context. After any other status nothing of the region counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from vividc.program import RegionRow
from vividc.sim.native.body import Body, Key, Machine, Mode, Surroundings
from vividc.sim.native.counts import CountClass, Speculation
from vividc.sim.native.layout import BITS, EXTENT_WORDS, Place, Status, Sum
from vividc.sim.native.schedule import Schedule, constants_read, schedule
from vividc.sim.native.text import FALSE, Code
from vividc.sim.native.trace import Constant, RegionFlow

ENDLESS: Final = 1 << 62
"""Iterations of a loop that only its exit node ends."""
_ARGUMENTS: Final = "ptr noalias %context, ptr noalias %constants, ptr noalias %memory"
_COUNTERS: Final = {
    "constant_writes": Sum.CONSTANT_WRITES,
    "capture_reads": Sum.CAPTURE_READS,
    "reads": Sum.READS,
    "writes": Sum.WRITES,
}
_SMALL_LOOP_OPS: Final = 400
"""Loops with more operations have no steady body of their own: it would double the compile time."""


def region_function(
    index: int,
    flow: RegionFlow | None,
    classes: Sequence[CountClass],
    machine: Machine,
    switch_cycles: int,
) -> str:
    """Text of the function `region{index}`; None: one that leaves the region to the reference."""
    if flow is None:
        body = [f"  ret i32 {Status.IRREGULAR:d}"]
    else:
        body = _RegionWriter(index, flow, classes, machine, switch_cycles).lines()
    return "\n".join([f"define internal i32 @region{index}({_ARGUMENTS}) {{", *body, "}", ""])


@dataclass
class _End:
    """Values at the end of a region. `end`: its cycles without stalls; `empty`: no iteration."""

    limit: str
    end: str
    exited: str
    values: dict[Key, str]
    branch: str


class _RegionWriter:
    def __init__(
        self,
        index: int,
        flow: RegionFlow,
        classes: Sequence[CountClass],
        machine: Machine,
        switch_cycles: int,
    ) -> None:
        self._sums = machine.layout.sums[index]
        self._flow = flow
        self._row: RegionRow = flow.row
        self._classes = classes
        self._machine = machine
        self._switch_cycles = switch_cycles
        self._plan: Schedule = schedule(flow)
        self._code = Code()
        self._written = list(dict.fromkeys(capture.target for capture in flow.captures))
        self._bits = [machine.layout.bits[c] for c in self._written if c in machine.layout.bits]

    def lines(self) -> list[str]:
        """The function's blocks."""
        code = self._code
        code.start("entry")
        self._base = self._context(Place.CYCLE)
        self._entries = code.value(f"add i64 {self._context(Place.ENTRIES)}, 1")
        if self._row.kind == "straight":
            self._demand_valid("begin")
            self._around = self._surroundings()
            self._straight()
        else:
            self._loop()
        for status in (Status.FAULT, Status.LIMIT, Status.IRREGULAR):
            code.start(status.name.lower())
            code.do(f"ret i32 {status:d}")
        return code.lines

    # Entry

    def _context(self, place: int) -> str:
        return self._code.load("i64", "%context", place)

    def _set_context(self, place: int, value: str) -> None:
        self._code.store("i64", value, "%context", place)

    def _demand_valid(self, then: str) -> None:
        """Go on only if every constant-store entry that operations read has been set."""
        code, layout = self._code, self._machine.layout
        masks: dict[int, int] = {}
        for constant in constants_read(self._flow):
            bit = layout.bits.get(constant)
            if bit is not None:
                word = layout.valid_word(bit)
                masks[word] = masks.get(word, 0) | 1 << bit % BITS
        ready = "true"
        for word, mask in masks.items():
            mine = mask - (mask >> BITS - 1 << BITS)
            have = code.value(f"and i64 {self._context(word)}, {mine}")
            ready = code.both(ready, code.value(f"icmp eq i64 {have}, {mine}"))
        code.do(f"br i1 {ready}, label %{then}, label %irregular")
        code.start(then)

    def _surroundings(self) -> Surroundings:
        code, layout = self._code, self._machine.layout
        constants = {
            constant: code.load("i32", "%constants", layout.cell(constant))
            for constant in constants_read(self._flow)
            if constant not in self._written
        }
        arrays = dict.fromkeys(op.array for op in self._flow.ops)
        extents = {}
        for name in arrays:
            first = layout.extents + EXTENT_WORDS * layout.arrays[name]
            words = [self._context(first + k) for k in range(EXTENT_WORDS)]
            extents[name] = tuple(code.value(f"trunc i64 {word} to i32") for word in words)
        return Surroundings(constants, extents)

    def _initial(self) -> dict[Key, str]:
        """Carried values at the start of the region, but for earlier results."""
        code, layout = self._code, self._machine.layout
        values: dict[Key, str] = {("stalls",): "0"}
        values |= {(name,): "0" for name in _COUNTERS}
        for constant in self._written:
            word = code.load("i32", "%constants", layout.cell(constant))
            values["constant", constant.pe, constant.entry] = word
        for bit in self._bits:
            values["valid", bit] = "0"
        return values

    def _body(self, mode: Mode, values: dict[Key, str]) -> Body:
        return Body(self._code, self._machine, self._plan, mode, self._around, values)

    # Straight regions

    def _straight(self) -> None:
        body = self._body("straight", self._initial())
        for slot in range(self._row.ii):
            body.slot(slot)
        if body.fault != FALSE:
            self._code.do(f"br i1 {body.fault}, label %fault, label %finish")
            self._code.start("finish")
        if body.trip:
            self._set_context(Place.TRIP, self._code.value(f"sext i32 {body.trip} to i64"))
        self._finish(_End("1", str(self._row.span), "", body.values, body.branch))

    # Loops

    def _loop(self) -> None:
        code, row = self._code, self._row
        if row.counted:
            trip = self._context(Place.TRIP)
            self._trip = code.value(f"call i64 @llvm.smax.i64(i64 {trip}, i64 0)")
            empty = code.value(f"icmp eq i64 {self._trip}, 0")
            code.do(f"br i1 {empty}, label %empty, label %some")
            code.start("some")
        else:
            self._trip = str(ENDLESS)
        self._demand_valid("begin")
        self._around = self._surroundings()
        self._end_of_trip = self._end_of(self._trip)
        carried = self._carried()
        resumed = code.value(f"icmp ne i64 {self._context(Place.RESUME)}, 0")
        code.do(f"br i1 {resumed}, label %resume, label %header")
        before = code.block
        kept = self._resume(carried)
        self._repeat(carried, before, kept)
        if row.counted:
            code.start("empty")
            self._finish_empty()

    def _end_of(self, limit: str) -> str:
        """Cycles of a loop with so many iterations, more than none."""
        code = self._code
        if limit == str(ENDLESS):
            return limit
        before = code.value(f"sub i64 {limit}, 1")
        cycles = code.value(f"mul i64 {before}, {self._row.ii}")
        return code.value(f"add i64 {cycles}, {self._row.span}")

    def _carried(self) -> dict[Key, tuple[str, str]]:
        """Type and initial value of what bodies hand on."""
        touched = {("stalls",), *((name,) for name in _COUNTERS)} - self._untouched()
        carried: dict[Key, tuple[str, str]] = {("body",): ("i64", "0")}
        for key, value in self._initial().items():
            if len(key) > 1:
                carried[key] = "i32", value
            elif key in touched:
                carried[key] = "i64", value
        if self._flow.exit is not None:
            carried["limit",] = "i64", self._trip
            carried["end",] = "i64", self._end_of_trip
            carried["exited",] = "i64", "-1"
            carried["resolved",] = "i64", "-1"
            carried["open", "always"] = "i64", str(ENDLESS)
            carried["open", "unless_exit"] = "i64", str(ENDLESS)
        for index, depth in enumerate(self._plan.depth):
            for age in range(1, depth + 1):
                carried["result", index, age] = "i32", "0"
        return carried

    def _untouched(self) -> set[Key]:
        """Counters that no body changes."""
        names = {op.issue.op.value for op in self._flow.ops}
        untouched: set[Key] = set()
        if "load" not in names:
            untouched.add(("reads",))
        if "store" not in names:
            untouched.add(("writes",))
        if not self._flow.captures:
            untouched |= {("constant_writes",), ("capture_reads",)}
        if not names & {"load", "store"}:
            untouched.add(("stalls",))
        return untouched

    def _resume(self, carried: dict[Key, tuple[str, str]]) -> dict[Key, str]:
        code = self._code
        code.start("resume")
        kept = {}
        for number, (key, (kind, _)) in enumerate(carried.items()):
            word = self._context(self._machine.layout.spill + number)
            kept[key] = word if kind == "i64" else code.value(f"trunc i64 {word} to i32")
        self._set_context(Place.RESUME, "0")
        code.do("br label %header")
        return kept

    def _suspend(self, carried: dict[Key, tuple[str, str]], now: str, values: dict[Key, str]) -> None:
        code = self._code
        code.start("suspend")
        for number, (key, (kind, _)) in enumerate(carried.items()):
            word = values[key] if kind == "i64" else code.extended(values[key])
            self._set_context(self._machine.layout.spill + number, word)
        self._set_context(Place.RESUME, "1")
        self._set_context(Place.NOW, now)
        code.do(f"ret i32 {Status.SUSPENDED:d}")

    def _repeat(
        self, carried: dict[Key, tuple[str, str]], before: str, kept: dict[Key, str]
    ) -> None:
        """Header, bodies, latch."""
        code = self._code
        code.start("header")
        values: dict[Key, str] = {}
        for number, (key, (kind, initial)) in enumerate(carried.items()):
            name = f"%carried{number}"
            values[key] = name
            incoming = f"[ {initial}, %{before} ], [ {kept[key]}, %resume ], [ %next{number}, %latch ]"
            code.lines.append(f"  {name} = phi {kind} {incoming}")
        at_header = dict(values)
        for name in ("stalls", *_COUNTERS):
            values.setdefault((name,), "0")
        fault = self._resolve(values)
        self._advance(carried, at_header, values, fault)

    def _resolve(self, values: dict[Key, str]) -> str:
        """The exit decision that acts now; whether a load that missed turns out to count."""
        code, plan = self._code, self._plan
        if plan.flow.exit is None:
            values["limit",], values["end",] = self._trip, self._end_of_trip
            return FALSE
        iteration = code.value(f"sub i64 {values['body',]}, {plan.exit_stage}")
        due = code.value(f"icmp ult i64 {iteration}, {values['limit',]}")
        word = values["result", plan.flow.exit, plan.exit_lag]
        ends = code.both(due, code.value(f"icmp eq i32 {word}, 1"))
        limit = code.value(f"add i64 {iteration}, 1")
        end = code.value(f"mul i64 {iteration}, {self._row.ii}")
        end = code.value(f"add i64 {end}, {self._row.span}")
        values["limit",] = code.choose(ends, "i64", limit, values["limit",])
        values["end",] = code.choose(ends, "i64", end, values["end",])
        values["exited",] = code.choose(ends, "i64", iteration, values["exited",])
        values["resolved",] = code.choose(due, "i64", iteration, values["resolved",])
        return self._settled(values, values["resolved",])

    def _settled(self, values: dict[Key, str], resolved: str) -> str:
        """Whether an open miss counts: its iteration is live and known to happen."""
        code = self._code
        always, unless = values["open", "always"], values["open", "unless_exit"]
        before = code.value(f"sub i64 {always}, 1")
        known = code.value(f"icmp sle i64 {before}, {resolved}")
        is_live = code.value(f"icmp slt i64 {always}, {values['limit',]}")
        counts = code.both(known, is_live)
        known = code.value(f"icmp sle i64 {unless}, {resolved}")
        is_live = code.value(f"icmp slt i64 {unless}, {values['limit',]}")
        goes_on = code.value(f"icmp ne i64 {unless}, {values['exited',]}")
        return code.either(counts, code.both(known, code.both(is_live, goes_on)))

    def _advance(
        self,
        carried: dict[Key, tuple[str, str]],
        at_header: dict[Key, str],
        values: dict[Key, str],
        fault: str,
    ) -> None:
        code = self._code
        if fault != FALSE:
            code.do(f"br i1 {fault}, label %fault, label %settled")
            code.start("settled")
        time = code.value(f"mul i64 {values['body',]}, {self._row.ii}")
        time = code.value(f"sub i64 {time}, {self._plan.offset}")
        more = code.value(f"icmp slt i64 {time}, {values['end',]}")
        code.do(f"br i1 {more}, label %go, label %finish")
        code.start("go")
        now = self._now(time, values["stalls",])
        if self._plan.offset == 0:
            self._check_limit(now, "within")
        budget = self._context(Place.BUDGET)
        late = code.value(f"icmp sgt i64 {now}, {budget}")
        code.do(f"br i1 {late}, label %suspend, label %work")
        self._suspend(carried, now, at_header)
        code.start("work")
        ends = self._bodies(values, time)
        self._latch(carried, at_header, ends)
        code.start("finish")
        self._finish_loop(values)

    def _now(self, time: str, stalls: str) -> str:
        cycles = self._code.value(f"add i64 {time}, {stalls}")
        return self._code.value(f"add i64 {cycles}, {self._base}")

    def _check_limit(self, now: str, then: str) -> None:
        code = self._code
        over = code.value(f"icmp sgt i64 {now}, {self._context(Place.CYCLE_LIMIT)}")
        label = code.fresh(then)
        code.do(f"br i1 {over}, label %limit, label %{label}")
        code.start(label)

    def _bodies(self, values: dict[Key, str], time: str) -> list[tuple[str, dict[Key, str]]]:
        """The bodies; the last block of each, and its values at the end."""
        code = self._code
        if len(self._flow.ops) > _SMALL_LOOP_OPS:
            return [self._one_body("general", values, time)]
        began = code.value(f"icmp sgt i64 {values['body',]}, {self._plan.stages}")
        goes_on = code.value(f"icmp slt i64 {values['body',]}, {values['limit',]}")
        steady = code.both(began, goes_on)
        code.do(f"br i1 {steady}, label %steady, label %general")
        ends = []
        modes: tuple[Mode, ...] = ("steady", "general")
        for mode in modes:
            code.start(mode)
            ends.append(self._one_body(mode, values, time))
        return ends

    def _one_body(
        self, mode: Mode, values: dict[Key, str], time: str
    ) -> tuple[str, dict[Key, str]]:
        code = self._code
        body = self._body(mode, dict(values))
        body.number, body.limit = values["body",], values["limit",]
        body.exited = values.get(("exited",), "")
        body.resolved = values.get(("resolved",), "")
        for slot in range(self._row.ii):
            if slot == self._plan.offset and slot > 0:
                self._check_within(body, time, mode)
            body.slot(slot)
        after = body.finish()
        after["body",] = code.value(f"add i64 {values['body',]}, 1")
        if body.fault != FALSE:
            label = code.fresh("good")
            code.do(f"br i1 {body.fault}, label %fault, label %{label}")
            code.start(label)
        last = code.block
        code.do("br label %latch")
        return last, after

    def _check_within(self, body: Body, time: str, mode: Mode) -> None:
        """The limit is looked at where the contexts begin anew, after what went wrong before."""
        code = self._code
        if body.fault != FALSE:
            label = code.fresh("sound")
            code.do(f"br i1 {body.fault}, label %fault, label %{label}")
            code.start(label)
            body.fault = FALSE
        here = code.value(f"add i64 {time}, {self._plan.offset}")
        end = body.values["end",]
        here = code.value(f"call i64 @llvm.smin.i64(i64 {here}, i64 {end})")
        self._check_limit(self._now(here, body.values["stalls",]), mode)

    def _latch(
        self,
        carried: dict[Key, tuple[str, str]],
        at_header: dict[Key, str],
        ends: list[tuple[str, dict[Key, str]]],
    ) -> None:
        code = self._code
        code.start("latch")
        for number, (key, (kind, _)) in enumerate(carried.items()):
            incoming = ", ".join(f"[ {after[key]}, %{last} ]" for last, after in ends)
            code.lines.append(f"  %next{number} = phi {kind} {incoming}")
        code.do("br label %header")

    # The end

    def _finish_loop(self, values: dict[Key, str]) -> None:
        code = self._code
        if self._flow.exit is not None:
            fault = self._settled(values, values["limit",])
            code.do(f"br i1 {fault}, label %fault, label %counted")
            code.start("counted")
        exited = values.get(("exited",), "")
        self._finish(_End(values["limit",], values["end",], exited, values, ""))

    def _finish(self, end: _End) -> None:
        code = self._code
        cycles = code.value(f"add i64 {end.end}, {end.values[('stalls',)]}")
        now = code.value(f"add i64 {self._base}, {cycles}")
        limit = self._context(Place.CYCLE_LIMIT)
        over = code.either(
            code.value(f"icmp sgt i64 {now}, {limit}"),
            code.value(f"icmp sgt i64 {self._entries}, {limit}"),
        )
        code.do(f"br i1 {over}, label %limit, label %over")
        code.start("over")
        self._continue(now, end.branch)
        self._write_back(end.values)
        sums = {
            Sum.ENTRIES: "1",
            Sum.NONEMPTY: "1",
            Sum.ITERATIONS: end.limit,
            Sum.CYCLES: cycles,
            Sum.STALLS: end.values["stalls",],
        }
        sums |= {place: end.values[name,] for name, place in _COUNTERS.items()}
        for place, value in sums.items():
            self._sum(place, value)
        if self._row.kind == "loop":
            for number, count in enumerate(self._classes):
                self._sum(len(Sum) + number, self._class_value(count, end))
        code.do(f"ret i32 {Status.DONE:d}")

    def _finish_empty(self) -> None:
        self._sum(Sum.ENTRIES, "1")
        self._continue(self._base, "")
        self._code.do(f"ret i32 {Status.DONE:d}")

    def _sum(self, place: int, value: str) -> None:
        if value == "0":
            return
        word = self._context(self._sums + place)
        self._set_context(self._sums + place, self._code.value(f"add i64 {word}, {value}"))

    def _class_value(self, count: CountClass, end: _End) -> str:
        """What one run adds to a class of counts (see `counts`)."""
        code = self._code
        extra = "0"
        if count.most and end.exited:
            beyond = code.value(f"sub i64 {self._trip}, {end.limit}")
            extra = code.value(f"call i64 @llvm.smin.i64(i64 {beyond}, i64 {count.most})")
            has_exited = code.value(f"icmp sge i64 {end.exited}, 0")
            extra = code.choose(has_exited, "i64", extra, "0")
        if isinstance(count, Speculation):
            return extra
        extra = code.value(f"call i64 @llvm.smin.i64(i64 {extra}, i64 {count.last})")
        moved = code.value(f"add i64 {end.limit}, {extra}")
        return code.value(f"call i64 @llvm.smax.i64(i64 {moved}, i64 0)")

    def _write_back(self, values: dict[Key, str]) -> None:
        code, layout = self._code, self._machine.layout
        for constant in self._written:
            word = values["constant", constant.pe, constant.entry]
            code.store("i32", word, "%constants", layout.cell(constant))
        for bit in self._bits:
            place = layout.valid_word(bit)
            valid = code.extended(values["valid", bit])
            shifted = code.value(f"shl i64 {valid}, {bit % BITS}")
            self._set_context(place, code.value(f"or i64 {self._context(place)}, {shifted}"))

    def _continue(self, now: str, branch: str) -> None:
        """Time, and the region that runs next."""
        code, targets = self._code, (self._row.next, self._row.branch)
        onward, branched = (-1 if target is None else target for target in targets)
        following = str(onward)
        if branch:
            taken = code.value(f"icmp eq i32 {branch}, 1")
            following = code.choose(taken, "i64", str(branched), str(onward))
        switch = "0"
        if onward >= 0 or (branch and branched >= 0):
            goes_on = code.value(f"icmp sge i64 {following}, 0")
            switch = code.choose(goes_on, "i64", str(self._switch_cycles), "0")
            now = code.value(f"add i64 {now}, {switch}")
            self._check_switch(now, goes_on)
        self._set_context(Place.NEXT, following)
        self._set_context(Place.CYCLE, now)
        self._set_context(Place.ENTRIES, self._entries)
        passed = self._context(Place.SWITCH_CYCLES)
        self._set_context(Place.SWITCH_CYCLES, code.value(f"add i64 {passed}, {switch}"))

    def _check_switch(self, now: str, goes_on: str) -> None:
        code = self._code
        limit = self._context(Place.CYCLE_LIMIT)
        over = code.either(
            code.value(f"icmp sgt i64 {now}, {limit}"),
            code.value(f"icmp sgt i64 {self._entries}, {limit}"),
        )
        label = code.fresh("switched")
        over = code.both(goes_on, over)
        code.do(f"br i1 {over}, label %limit, label %{label}")
        code.start(label)
