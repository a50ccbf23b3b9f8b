"""The native engine: runs a program's machine code in pieces, and leaves to the reference engine
what the code cannot do.

Regions of an irregular form, and every region in which something went wrong, run on the reference
engine, from their first cycle: errors are the same because they come from there.
"""

from __future__ import annotations

import sys
from functools import partial
from typing import Final

from vividc.program import Program
from vividc.sim.engine import ByRegion, Launch, Run
from vividc.sim.native.code import Compiled, compiled
from vividc.sim.native.fallback import Fallback
from vividc.sim.native.plan.counts import Sums, Totals
from vividc.sim.native.plan.layout import Place, Status
from vividc.sim.native.spans import Spans
from vividc.sim.native.state import NEVER, MachineState
from vividc.sim.reference.engine import ReferenceEngine, returned

CYCLES_A_CALL: Final = 4_000_000
"""Cycles between two looks at interrupts and progress: at most some tenths of a second."""
ENTRIES_A_CALL: Final = 1_000_000


class NativeEngine:
    """Runs the machine code of one program."""

    def __init__(self, program: Program) -> None:
        self._program = program
        self._compiled = compiled(program)
        self._fallback = Fallback(program, self._compiled.plan.layout)

    @property
    def irregular_regions(self) -> tuple[int, ...]:
        """Regions whose words have no form to compile: the reference engine runs them."""
        flows = self._compiled.plan.flows
        return tuple(index for index, flow in enumerate(flows) if flow is None)

    def run(self, launch: Launch) -> Run:
        """Run the program once (see `Engine.run`)."""
        if sys.byteorder != "little" or not self._compiled.blank.takes(launch):
            return ReferenceEngine(self._program).run(launch)
        return _Running(self._program, self._compiled, self._fallback, launch).run()


class _Running:
    """One launch."""

    def __init__(
        self, program: Program, code: Compiled, fallback: Fallback, launch: Launch
    ) -> None:
        self._program = program
        self._code = code
        self._fallback = fallback
        self._launch = launch
        self._elsewhere: dict[int, Totals] = {}  # of regions that ran on the reference engine
        self._state = self._initial()

    def _initial(self) -> MachineState:
        state = self._code.blank.state(self._launch)
        state.context[Place.TABLES] = self._code.plan.table_words.ctypes.data
        return state

    def run(self) -> Run:
        """Run to the end."""
        snapshot: MachineState | None = None  # the start
        spans = Spans(self._code.plan, self._elsewhere, self._launch.observer)
        entries = ENTRIES_A_CALL if self._launch.observer is None else 1
        while True:
            spans.before(self._state)
            status = self._call(self._state, CYCLES_A_CALL, entries)
            if self._launch.progress is not None and status is not Status.FAULT:
                self._launch.progress(self._state.now)
            if status is Status.DONE:
                spans.after(self._state)
                return self._result()
            if status is Status.LIMIT:
                self._fallback.demand_time(self._launch, self._state)
            if status is Status.FAULT:
                self._state = self._before_fault(snapshot or self._initial())
            if status in (Status.FAULT, Status.IRREGULAR):
                self._run_elsewhere()
            spans.after(self._state)
            if not self._state.context[Place.RESUME]:
                snapshot = self._state.copy()

    def _run_elsewhere(self) -> None:
        region = int(self._state.context[Place.NEXT])
        done = self._fallback.run_region(self._launch, self._state)
        self._elsewhere[region] = self._elsewhere.get(region, Totals()) + done

    def _call(self, state: MachineState, cycles: int, entries: int) -> Status:
        context = state.context
        context[Place.BUDGET] = state.now + cycles
        context[Place.ENTRY_STOP] = min(int(context[Place.ENTRIES]) + entries, NEVER)
        return Status(self._code.native(*state.pointers))

    def _before_fault(self, state: MachineState) -> MachineState:
        """The snapshot `state`, run up to the region in which something went wrong."""
        target = int(self._state.context[Place.ENTRIES])
        while int(state.context[Place.ENTRIES]) < target:
            self._call(state, CYCLES_A_CALL, target - int(state.context[Place.ENTRIES]))
        return state

    def _result(self) -> Run:
        state, plan = self._state, self._code.plan
        words = state.context[: plan.layout.spill].copy()
        sums = Sums(plan.counts, plan.layout.sums, words)
        return Run(
            cycles=int(state.context[Place.CYCLE]),
            switch_cycles=int(state.context[Place.SWITCH_CYCLES]),
            reload_cycles=int(state.context[Place.RELOAD_CYCLES]),
            memory=state.scratchpad,
            value=returned(self._program, partial(state.word_at, plan.layout)),
            counts=ByRegion(sums.regions(self._elsewhere)) if self._elsewhere else sums,
            engine="native",
        )
