"""What a plan follows from, and the plans of several requests."""

from __future__ import annotations

import math
import warnings
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from vividc.arch import Accelerator
from vividc.arch.fabric import Fabric
from vividc.compiler.advice.apart import reading_apart
from vividc.compiler.driver import estimator_for, planned
from vividc.compiler.planning.estimate import Estimate, Estimator
from vividc.compiler.planning.plan import Plan
from vividc.compiler.planning.state import State
from vividc.compiler.stage import CompileOptions
from vividc.dfg.pipeline import PassOptions
from vividc.errors import KernelError, SourceLoc, VividcWarning
from vividc.frontend import KernelFunction, LLKernel
from vividc.host import watch
from vividc.ssa.analysis.frequency import expected_trips
from vividc.ssa.flow import find_loops
from vividc.ssa.ir import Function
from vividc.ssa.parallel.cut import cut_parallel_loop


@dataclass(frozen=True)
class Request:
    """A kernel to plan.

    Attributes
    ----------
    lines
        Lines in which a loop over `prange` begins.
    words_at
        Lines whose 64-bit integers are cast to int32.
    apart
        An array whose loads go to one of their own; "": none.
    """

    kernel: KernelFunction | LLKernel
    machine: Fabric | Accelerator
    options: CompileOptions
    lines: frozenset[int]
    words_at: frozenset[int] = frozenset()
    apart: str = ""

    @property
    def fabric(self) -> Fabric:
        """The tile's."""
        return self.machine.fabric if isinstance(self.machine, Accelerator) else self.machine

    def lowered(self) -> tuple[Function, frozenset[int]]:
        """The kernel in words, whose warnings were given when it was compiled, and the lines whose
        loops may become threads: on an accelerator only of what is cut, if nobody asks for them.
        """
        strict = self.options.strict_fp
        with warnings.catch_warnings(), watch.aside():
            warnings.simplefilter("ignore", VividcWarning)
            if not isinstance(self.kernel, KernelFunction):
                return self.kernel.lower(strict_fp=strict), frozenset()
            spread = isinstance(self.machine, Accelerator) and bool(self.lines)
            function = self.kernel.lower(strict, spread, self.words_at)
        function = reading_apart(function, self.apart) if self.apart else function
        if not spread:
            return function, self.lines
        try:
            return cut_parallel_loop(function, self.lines)[0], self.lines
        except KernelError:  # it runs on one tile
            asked = self.options.loops.threads is not None
            return function, self.lines if asked else frozenset()


@dataclass
class Planner:
    """Plans requests; what was estimated for one is known for the others."""

    _estimators: dict[tuple[str, PassOptions], Estimator] = field(default_factory=dict)

    def plan(self, request: Request) -> Plan:
        """The plan of a request.

        Raises
        ------
        VividcError
            It cannot be compiled so.
        """
        function, lines = request.lowered()
        return planned(function, self.estimator(request), request.options, lines)

    def estimator(self, request: Request) -> Estimator:
        """What estimates functions of a request."""
        made = estimator_for(request.fabric, request.options)
        return self._estimators.setdefault((request.fabric.name, made.options), made)


def final(plan: Plan) -> Estimate:
    """What is estimated of the stage that is mapped first."""
    return plan.stages[-1].estimate


def is_finite(plan: Plan) -> bool:
    """Whether the kernel as written and what is mapped first fit the fabric."""
    return math.isfinite(plan.stages[0].estimate.cycles) and math.isfinite(final(plan).cycles)


def with_lengths_of(plan: Plan, other: Plan, estimator: Estimator) -> float:
    """Cycles of a plan's last stage if its loops had the lengths that those of another plan have,
    line by line.
    """
    assumed, wanted = _lengths(plan.stages[0].state), _lengths(other.stages[0].state)
    state = plan.stages[-1].state
    first = plan.stages[0].state
    places = {loop.header: first.loc(loop.header) for loop in find_loops(first.function)}
    hints = dict(state.hints)
    for header, trips in expected_trips(state.function, state.hints).items():
        loc = places.get(state.origin.get(header, header))
        if loc in assumed and loc in wanted:
            hints[header] = trips * wanted[loc] / assumed[loc]
    return estimator.estimate(replace(state.function), hints).cycles


def _lengths(state: State) -> dict[SourceLoc, float]:
    """Iterations of the loop on each line that has one."""
    trips = expected_trips(state.function, state.hints)
    return {loc: trips[header] for header in trips if (loc := state.loc(header)) is not None}


def saved_at(before: Estimate, after: Estimate) -> SourceLoc | None:
    """The line that takes fewer cycles after than before by most."""
    earlier, later = _by_line(before), _by_line(after)
    saved = {loc: cycles - later.get(loc, 0.0) for loc, cycles in earlier.items()}
    return max(saved, key=lambda loc: saved[loc], default=None)


def _by_line(estimate: Estimate) -> Mapping[SourceLoc, float]:
    cycles: dict[SourceLoc, float] = defaultdict(float)
    for cost in estimate.regions:
        if cost.loc is not None and cost.kind == "loop":
            cycles[cost.loc] += cost.cycles
    return cycles
