"""What was done to each source loop, for `vividc compile --explain`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from vividc.compiler.planning.fallback import Settled
from vividc.compiler.planning.plan import Decision, Plan
from vividc.dfg.ir import Control
from vividc.dfg.regions import Region, is_variable
from vividc.machine.opcodes import Opcode
from vividc.program.tables import LoopReport, RegionReport, TransformReport
from vividc.ssa.edit import block_of
from vividc.ssa.flow import Loop, find_loops
from vividc.ssa.ir import Function

_OTHER = "another form was chosen"


def loop_reports(plan: Plan, settled: Settled) -> tuple[LoopReport, ...]:
    """A report for each loop of the kernel as written, innermost first."""
    teller = _Teller(plan, settled)
    source = plan.stages[0].state.function
    loops = find_loops(source)
    return tuple(teller.report(loop, _innermost(loop, loops)) for loop in loops)


def _innermost(loop: Loop, loops: tuple[Loop, ...]) -> bool:
    return not any(o.header in loop.blocks and o.header != loop.header for o in loops)


@dataclass(frozen=True)
class _Hot:
    """The region that runs most iterations of a source loop: `scale` of them in one of its own."""

    region: Region
    report: RegionReport
    header: str
    scale: int


@dataclass(frozen=True)
class _Teller:
    plan: Plan
    settled: Settled

    def report(self, loop: Loop, innermost: bool) -> LoopReport:
        header = loop.header
        before = self.plan.stages[0].estimate.loop(header)
        source = self.plan.stages[0].state
        hot = self._hot(header)
        return LoopReport(
            loc=source.loc(header),
            outcome=self._outcome(header, hot),
            cycles_before=float(before.shape.ii) if before is not None and innermost else None,
            cycles_after=None if hot is None else hot.report.ii / hot.scale,
            binds="" if hot is None else _binding(hot.report),
            notes=tuple(self._notes(header, hot)),
            transforms=tuple(self._transforms(header)),
        )

    @property
    def _function(self) -> Function:
        return self.settled.outcome.stage.state.function

    def _hot(self, header: str) -> _Hot | None:
        outcome = self.settled.outcome
        state = outcome.stage.state
        loops = [
            _Hot(region, report, region.header, state.scale.get(region.header, 1))
            for region, report in zip(outcome.kernel.regions, outcome.program.regions, strict=True)
            if region.kind == "loop" and state.origin.get(region.header, region.header) == header
        ]
        return max(loops, key=lambda hot: hot.scale, default=None)

    def _outcome(self, header: str, hot: _Hot | None) -> str:
        state = self.settled.outcome.stage.state
        if hot is not None:
            each = "" if hot.scale == 1 else f" for {hot.scale} iterations"
            return f"modulo-scheduled, II {hot.report.ii}{each}"
        remaining = [
            loop.header
            for loop in find_loops(self._function)
            if state.origin.get(loop.header, loop.header) == header
        ]
        if not remaining and self._is_flattened(header):
            return "flattened: one loop with the loop inside it"
        if not remaining:
            return "unrolled fully: its iterations are part of the code around"
        why = [w for h, w in self.settled.outcome.sequential.items() if h in remaining]
        if why:
            return f"runs block by block: it {why[0]}"
        return "runs block by block around the loops inside it"

    def _is_flattened(self, header: str) -> bool:
        decisions = (d for d in self.plan.decisions if d.kind == "flattening")
        return any(d.origin == header and not self._reason(d) for d in decisions)

    def _notes(self, header: str, hot: _Hot | None) -> Iterator[str]:
        if hot is None:
            return
        loop = next(lp for lp in find_loops(self._function) if lp.header == hot.header)
        inside = [
            name
            for name in loop.blocks
            if sum(t in loop.blocks for t in block_of(self._function, name).branch.successors) > 1
        ]
        if inside:
            yield f"{len(inside)} branches became predicates and selects (if-conversion)"
        exits = [node for node in hot.region.dfg.nodes if node.control is Control.EXIT]
        if exits and not hot.region.counted:
            yield "its length is not known when it starts: it is left by a predicate"
        elif exits:
            yield "counted by the tile controller, and left early by a predicate"
        invariants = [
            node
            for node in hot.region.dfg.nodes
            if node.op is Opcode.LIVE_IN and is_variable(node.name)
        ]
        if invariants:
            yield f"{len(invariants)} values that do not change in it are computed before it"

    def _transforms(self, header: str) -> Iterator[TransformReport]:
        """What was done to a loop, and what was not; nothing twice, though it is tried in each way
        to the kernel that is kept.
        """
        own = [(one, self._reason(one)) for one in self.plan.decisions if one.origin == header]
        told = {(one.kind, one.factor) for one, reason in own if not reason}
        for one, reason in own:
            if not reason or (one.kind, one.factor) not in told:
                told.add((one.kind, one.factor))
                yield TransformReport(
                    one.kind, one.factor, not reason, one.before, one.after, reason
                )

    def _reason(self, decision: Decision) -> str:
        if decision.reason:
            return decision.reason
        kept = self.settled.outcome.stage
        if any(stage.decision is decision for stage in kept.lineage()):
            return ""
        for index, stage in enumerate(self.plan.stages):
            if stage.decision is decision:
                return self._dropped(index) if index > self.settled.index else _OTHER
        return "another factor was chosen"

    def _dropped(self, index: int) -> str:
        later = [i for i in sorted(self.settled.dropped) if i >= index]
        own = self.settled.dropped.get(index)
        return own or (self.settled.dropped[later[0]] if later else "taken back")


def _binding(report: RegionReport) -> str:
    """What proves the II, or what is known below it."""
    for item in report.refuted:
        if item.ii == report.ii - 1:
            return f"II {item.ii} is refuted by {item.by}"
    bounds = [f"{bound.name}: {bound.reason}" for bound in report.bounds if bound.ii == report.ii]
    if bounds:
        return bounds[0]
    return "" if report.ii == 1 else f"no smaller II than {report.ii} was found in time"
