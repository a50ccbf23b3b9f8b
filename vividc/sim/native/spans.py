"""Reports each run of a region to an observer: native code pauses after every one."""

from __future__ import annotations

from collections.abc import Mapping

from vividc.sim.engine import Observer, RegionSpan
from vividc.sim.native.module import Plan
from vividc.sim.native.plan.counts import Totals
from vividc.sim.native.plan.layout import Place, Sum
from vividc.sim.native.state import MachineState


class Spans:
    """What a run of a region took: the difference between the sums before and after it."""

    def __init__(
        self, plan: Plan, elsewhere: Mapping[int, Totals], observer: Observer | None
    ) -> None:
        self._plan = plan
        self._elsewhere = elsewhere
        self._observer = observer
        self._region = self._start = self._switches = self._entries = 0
        self._sums = (0, 0)

    def before(self, state: MachineState) -> None:
        """Remember the state, unless a loop is suspended in it."""
        context = state.context
        if self._observer is None or context[Place.RESUME]:
            return
        self._region = int(context[Place.NEXT])
        self._start = int(context[Place.CYCLE])
        self._switches = int(context[Place.SWITCH_CYCLES])
        self._entries = int(context[Place.ENTRIES])
        self._sums = self._counted(state)

    def after(self, state: MachineState) -> None:
        """Report the region that has ended since, if any."""
        context = state.context
        if self._observer is None or context[Place.RESUME]:
            return
        if int(context[Place.ENTRIES]) == self._entries:
            return
        switched = int(context[Place.SWITCH_CYCLES]) - self._switches
        end = int(context[Place.CYCLE]) - switched
        now = self._counted(state)
        spent = (a - b for a, b in zip(now, self._sums, strict=True))
        self._observer(RegionSpan(self._region, self._start, end, *spent))

    def _counted(self, state: MachineState) -> tuple[int, int]:
        """Iterations and stalls of the region, in native code and on the reference engine."""
        done = self._elsewhere.get(self._region, Totals()).region_run()
        iterations, stalls = done.iterations, done.bank_stalls
        if self._plan.counts[self._region] is not None:
            first = self._plan.layout.sums[self._region]
            iterations += int(state.context[first + Sum.ITERATIONS])
            stalls += int(state.context[first + Sum.STALLS])
        return iterations, stalls
