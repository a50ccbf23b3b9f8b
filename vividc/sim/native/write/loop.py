"""A loop region as LLVM IR: a header, in which exit decisions act, bodies, and a latch.

A body that follows another finds what it needs in phis: the last results of operations that later
bodies read, live-outs, sums. The same values go to the context when the loop is suspended.
"""

from __future__ import annotations

from typing import Final

from vividc.sim.native.plan.layout import Place, Status
from vividc.sim.native.plan.schedule import Schedule
from vividc.sim.native.write.body import Body, Key, Mode, Surroundings
from vividc.sim.native.write.ending import COUNTERS, End, finish, finish_empty
from vividc.sim.native.write.frame import Frame
from vividc.sim.native.write.text import FALSE

_ENDLESS: Final = 1 << 62
"""Iterations of a loop that only its exit node ends."""
STEADY_OPS: Final = 400
"""Loops with more operations have no steady body of their own: it would double the compile time."""


def write_loop(frame: Frame, plan: Schedule, around: Surroundings, initial: dict[Key, str]) -> None:
    """Write a loop, to its end."""
    if not frame.flow.row.counted:
        frame.trip = str(_ENDLESS)
    _Loop(frame, plan, around).write(initial)
    if frame.flow.row.counted:
        frame.code.start("empty")
        finish_empty(frame)


class _Loop:
    def __init__(self, frame: Frame, plan: Schedule, around: Surroundings) -> None:
        self._frame = frame
        self._code = frame.code
        self._flow = frame.flow
        self._plan = plan
        self._around = around
        self._end_of_trip = self._end_of(frame.trip)

    def write(self, initial: dict[Key, str]) -> None:
        """Write all of it except the path around a loop without iterations."""
        code = self._code
        carried = self._carried(initial)
        resumed = code.value(f"icmp ne i64 {self._frame.get(Place.RESUME)}, 0")
        code.do(f"br i1 {resumed}, label %resume, label %header")
        before = code.block
        kept = self._resume(carried)
        self._repeat(carried, before, kept)

    def _end_of(self, limit: str) -> str:
        """Cycles of a loop with so many iterations, more than none."""
        code = self._code
        if limit == str(_ENDLESS):
            return limit
        before = code.value(f"sub i64 {limit}, 1")
        cycles = code.value(f"mul i64 {before}, {self._flow.row.ii}")
        return code.value(f"add i64 {cycles}, {self._flow.row.span}")

    def _carried(self, initial: dict[Key, str]) -> dict[Key, tuple[str, str]]:
        """Type and initial value of what bodies hand on."""
        touched = {("stalls",), *((name,) for name in COUNTERS)} - self._untouched()
        carried: dict[Key, tuple[str, str]] = {("body",): ("i64", "0")}
        for key, value in initial.items():
            if len(key) > 1:
                carried[key] = "i32", value
            elif key in touched:
                carried[key] = "i64", value
        if self._flow.exit is not None:
            carried["limit",] = "i64", self._frame.trip
            carried["end",] = "i64", self._end_of_trip
            carried["exited",] = "i64", "-1"
            carried["resolved",] = "i64", "-1"
            carried["open", "always"] = "i64", str(_ENDLESS)
            carried["open", "unless_exit"] = "i64", str(_ENDLESS)
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
            word = self._frame.get(self._frame.machine.layout.spill + number)
            kept[key] = word if kind == "i64" else code.value(f"trunc i64 {word} to i32")
        self._frame.set(Place.RESUME, "0")
        code.do("br label %header")
        return kept

    def _suspend(
        self, carried: dict[Key, tuple[str, str]], now: str, values: dict[Key, str]
    ) -> None:
        code = self._code
        code.start("suspend")
        for number, (key, (kind, _)) in enumerate(carried.items()):
            word = values[key] if kind == "i64" else code.extended(values[key])
            self._frame.set(self._frame.machine.layout.spill + number, word)
        self._frame.set(Place.RESUME, "1")
        self._frame.set(Place.NOW, now)
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
            incoming = (
                f"[ {initial}, %{before} ], [ {kept[key]}, %resume ], [ %next{number}, %latch ]"
            )
            code.lines.append(f"  {name} = phi {kind} {incoming}")
        at_header = dict(values)
        for name in ("stalls", *COUNTERS):
            values.setdefault((name,), "0")
        fault = self._resolve(values)
        self._advance(carried, at_header, values, fault)

    def _resolve(self, values: dict[Key, str]) -> str:
        """The exit decision that acts now; whether a load that missed turns out to count."""
        code, plan = self._code, self._plan
        if plan.flow.exit is None:
            values["limit",], values["end",] = self._frame.trip, self._end_of_trip
            return FALSE
        iteration = code.value(f"sub i64 {values['body',]}, {plan.exit_stage}")
        due = code.value(f"icmp ult i64 {iteration}, {values['limit',]}")
        word = values["result", plan.flow.exit, plan.exit_lag]
        ends = code.both(due, code.value(f"icmp eq i32 {word}, 1"))
        limit = code.value(f"add i64 {iteration}, 1")
        end = code.value(f"mul i64 {iteration}, {self._flow.row.ii}")
        end = code.value(f"add i64 {end}, {self._flow.row.span}")
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
        time = code.value(f"mul i64 {values['body',]}, {self._flow.row.ii}")
        time = code.value(f"sub i64 {time}, {self._plan.offset}")
        more = code.value(f"icmp slt i64 {time}, {values['end',]}")
        code.do(f"br i1 {more}, label %go, label %finish")
        code.start("go")
        now = self._now(time, values["stalls",])
        if self._plan.offset == 0:
            self._check_limit(now, "within")
        budget = self._frame.get(Place.BUDGET)
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
        return self._code.value(f"add i64 {cycles}, {self._frame.base}")

    def _check_limit(self, now: str, then: str) -> None:
        code = self._code
        over = code.value(f"icmp sgt i64 {now}, {self._frame.get(Place.CYCLE_LIMIT)}")
        label = code.fresh(then)
        code.do(f"br i1 {over}, label %limit, label %{label}")
        code.start(label)

    def _bodies(self, values: dict[Key, str], time: str) -> list[tuple[str, dict[Key, str]]]:
        """The bodies; the last block of each, and its values at the end."""
        code = self._code
        if len(self._flow.ops) > STEADY_OPS:
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
        body = Body(code, self._frame.machine, self._plan, mode, self._around, dict(values))
        body.number, body.limit = values["body",], values["limit",]
        body.exited = values.get(("exited",), "")
        body.resolved = values.get(("resolved",), "")
        for slot in range(self._flow.row.ii):
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

    def _finish_loop(self, values: dict[Key, str]) -> None:
        code = self._code
        if self._flow.exit is not None:
            fault = self._settled(values, values["limit",])
            code.do(f"br i1 {fault}, label %fault, label %counted")
            code.start("counted")
        exited = values.get(("exited",), "")
        finish(self._frame, End(values["limit",], values["end",], exited, values, ""))
