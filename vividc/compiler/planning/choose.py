"""Chooses the loop transformations that pay off, from the inside out, by estimates from bounds."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace

from vividc.compiler.planning.candidates import (
    MAY_MEET,
    Candidate,
    Kind,
    changed_by,
    has_known_length,
)
from vividc.compiler.planning.demands import obey
from vividc.compiler.planning.estimate import Estimate, Estimator
from vividc.compiler.planning.fit import fitted, is_far_too_long, version_for_sizes
from vividc.compiler.planning.gains import (
    GAIN,
    GAIN_OF_LARGE,
    GAIN_WITHOUT_LOOP,
    LARGE,
    LITTLE,
    OPERATIONS_PER_PE,
    in_vain,
    pays_inside,
    too_large,
)
from vividc.compiler.planning.interleave import loops_around_waiting
from vividc.compiler.planning.nests.parts import Restructured, joined_parts, static_part
from vividc.compiler.planning.nests.restructure import restructured, restructured_together
from vividc.compiler.planning.options import LoopOptions
from vividc.compiler.planning.plan import (
    Decision,
    Draft,
    Plan,
    Stage,
    better_last,
    clearly_better,
)
from vividc.compiler.planning.state import State
from vividc.errors import TimeLimit
from vividc.host import time_limit
from vividc.host.processes.beside import Beside
from vividc.host.watch import seldom
from vividc.mapper.bounds.refutations import ASSUMED
from vividc.ssa.analysis.constant_trips import constant_trips
from vividc.ssa.analysis.frequency import NO_TRIPS, expected_trips
from vividc.ssa.flow import Loop, find_loops
from vividc.ssa.ir import Function
from vividc.ssa.loops.begun_sums import begun_sums
from vividc.ssa.loops.taken_in import taken_in
from vividc.ssa.parallel.independent import meeting_array
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy

_BESIDE = 0.0025
"""Of the cycles: a candidate saves no more than its nest takes, and this at most beside it (of 475
candidates of eight kernels none saved more than its nest took).
"""

_NO_GAIN, _TOO_RARE = "does not pay", "takes less than it would have to save"

_BEST = 1 << 10
"""The place of the last of all forms: nests beside those that are joined have what was found."""

_FEW = 2
"""Nests of a kernel, at most, of which other forms are mapped, too."""

_STEP = 0.955
"""A factor must do so much better than half of it."""

_FACTORS = (2, 4, 8)

_SHARE = 0.4
"""Of the time, for the choice."""


@seldom()
def choose(
    function: Function,
    estimator: Estimator,
    options: LoopOptions,
    parallel: Collection[int] = (),
    trips: Mapping[str, float] = NO_TRIPS,
) -> Plan:
    """The transformations of `function` that pay, or that the user asks for.

    Parameters
    ----------
    parallel
        Lines of the function's file in which a loop over `prange` begins.
    trips
        Iterations expected of loops, by header, of which more is known than the function says.

    Raises
    ------
    TimeLimit
        Time was up before the kernel as written, and what the user asks for, was estimated.
    KernelError
        A factor is asked for a line without a loop, or of a loop that cannot be transformed so; or
        threads, and there is no loop over `prange`.
    """
    tidied = tidy(function)
    hints = expected_trips(tidied, trips)  # of the loops as written: transformations keep to it
    first = Stage(State(function, hints), estimator.estimate(function, hints))
    if options.idle:
        return Plan((first,))
    chooser = _Chooser(estimator, options, [first], frozenset(parallel))
    if estimator.options.reassociate and options.auto:
        tidied = begun_sums(tidied)
    if options.auto:
        tidied = taken_in(tidied)
    chooser.start(State(tidied, hints))
    obey(chooser)
    asked = len(chooser.stages) - 1
    if options.auto:
        version_for_sizes(chooser)
    if options.auto and not is_far_too_long(chooser):
        for fitting in fitted(chooser, chooser.now):
            chooser.accept(fitting)
        chooser.improve_in_time()
    return Plan(tuple(chooser.stages), tuple(chooser.decisions), asked)


@dataclass
class _Chooser(Draft):
    """`forms`: what headers of nests can be given instead, the best last, before it those that are
    likelier to be mapped. `plain`: the stages and decisions of the way without that, made beside.
    """

    forms: dict[str, tuple[Restructured, ...]] = field(default_factory=dict)
    plain: Beside[tuple[list[Stage], list[Decision]]] | None = None

    def improve_in_time(self) -> None:
        """As `improve`; what it has found by the end of its time is kept."""
        try:
            with time_limit.limited(_SHARE * time_limit.remaining_s()):
                self.improve()
        except TimeLimit:
            time_limit.step("loop transformations were chosen")
            time_limit.left_out("the choice of loop transformations")

    def improve(self) -> None:
        """Applies what pays. Where nests are restructured, what pays with forms of them that a
        mapper is likelier to have room for is kept in reserve, and what pays without that is tried,
        so that no kernel is slower for it: the better stages come last.
        """
        start, first = self.now, len(self.stages)
        ways: list[list[Stage]] = []
        try:
            self._way(start, ways, restructure=self.options.restructure)
            if self.options.restructure and any(joined_parts(start.state)):
                self._way(start, ways, restructure=True, form=_BEST, joins=True)
            for form in range(max(map(len, self.forms.values()), default=1) - 1):
                self._way(start, ways, restructure=True, form=form)
                ways[-1] = [replace(stage, reserve=True) for stage in ways[-1]]
            if any(forms[-1].other for forms in self.forms.values()) and len(self.forms) <= _FEW:
                best = {header: forms[-1] for header, forms in self.forms.items()}
                self.forms = {header: (one.other or one,) for header, one in best.items()}
                self._way(start, ways, restructure=True, form=0)
            if self.forms:
                self._go_plain_way(start, ways)
                ways[-1] = clearly_better(ways[-1], ways[0][-1])
            if self.spare is not None:
                self._way(self.spare, ways, restructure=self.options.restructure)
        finally:
            self.stages[first:] = better_last(ways)
            if self.plain is not None:
                self.plain.stop()

    def _go_plain_way(self, start: Stage, ways: list[list[Stage]]) -> None:
        """Adds what pays where no nest is restructured."""
        made = None if self.plain is None else self.plain.result()
        if made is None:
            self._way(start, ways, restructure=False)
            return
        [(stages, decisions)] = made
        ways.append(stages)
        self.decisions += decisions

    def _plain_way(self, start: Stage) -> tuple[list[Stage], list[Decision]]:
        """The same in a copy of this process."""
        ways: list[list[Stage]] = []
        noted = len(self.decisions)
        self._way(start, ways, restructure=False)
        return ways[0], self.decisions[noted:]

    def _way(
        self,
        start: Stage,
        ways: list[list[Stage]],
        *,
        restructure: bool,
        form: int | None = None,
        joins: bool = False,
    ) -> None:
        """Adds to `ways` the stages that `_improve` accepts from `start`."""
        first = len(self.stages)
        self.now = start
        try:
            self._improve(restructure=restructure, form=form, joins=joins)
        finally:
            ways.append(self.stages[first:])
            del self.stages[first:]

    def _improve(self, *, restructure: bool, form: int | None, joins: bool = False) -> None:
        """Applies what pays: full unrolling, then threads, then other loops for affine nests, then
        interleaving, then flattening of what is still a nest, then unrolling of innermost loops.

        Parameters
        ----------
        form
            Of restructured nests: its place among `forms`, or in them if they are fewer. None: the
            best one is looked for.
        joins
            Whether two nests that go through one matrix become one.
        """
        start, awaited = self.now, self._awaited() if restructure else frozenset[str]()
        if awaited and self.plain is None:
            self.plain = Beside(lambda: self._plain_way(start))
        self._unroll_fully(awaited)
        unrolled = self.now.state.made
        if self.options.threads is None:
            for header in self.over_prange():
                self._climb_threads(header)
        if joins:
            self._join()
        if restructure and form is None:
            self._restructure_all()
        elif restructure and form is not None:
            for header in (one for one in self.nests() if one in self.forms):
                self._take(header, self.forms[header][: form + 1][-1])
        if restructure:
            self._unroll_fully(self.now.state.made)
        self._shorten(self.now.state.made - unrolled)

    def _shorten(self, taken: Collection[str]) -> None:
        """Flattens and unrolls, with and without interleaving before.

        Parameters
        ----------
        taken
            Headers of loops whose nests are not to be interleaved.
        """
        start, first = self.now, len(self.stages)
        self._interleave(taken)
        is_interleaved = self.now is not start
        self._flatten_and_unroll()
        if not is_interleaved:
            return
        ways = [self.stages[first:]]
        self.now = start
        del self.stages[first:]
        try:
            self._flatten_and_unroll()
        finally:
            self.stages[first:] = better_last([self.stages[first:], *ways])

    def _flatten_and_unroll(self) -> None:
        """Flattens nests where it pays, unrolls innermost loops."""
        self._flatten()
        for header in [loop.header for loop in self.innermost()]:
            if self._may_wait_in_vain(header):
                self._try(Candidate("versioning", header))
            before = self.now
            if self.estimator.options.reassociate:
                self._climb("partial results", header)
            if self.now is before:
                self._climb(self._unrolling(header), header)

    def _may_wait_in_vain(self, header: str) -> bool:
        """Whether a recurrence binds a loop that nothing has proved."""
        cost = self.now.estimate.loop(header)
        bound = None if cost is None else cost.shape.bound
        return bound is not None and bound.name == "RecMII" and ASSUMED in bound.reason

    def _unroll_fully(self, left: Collection[str]) -> None:
        """Unrolls what it pays to unroll fully, of the loops `left` only those that are short."""
        tried: set[str] = set()
        while (loop := self.open_loop(tried)) is not None:
            tried.add(loop.header)
            if loop.header not in left or self._is_short(loop):
                self._try(Candidate("full unrolling", loop.header))

    def _is_short(self, loop: Loop) -> bool:
        trips = constant_trips(self.now.state.function, loop, _FACTORS[-1])
        return trips is not None and trips.iterations <= _FACTORS[-1]

    def _awaited(self) -> frozenset[str]:
        """Headers of the loops in nests that may be restructured, which loops unrolled inside could
        prevent.
        """
        awaited: set[str] = set()
        for header in self.nests():
            if not isinstance(static_part(self.now.state, header), Refusal):
                inside = self.now.state.loop(header).blocks
                loops = find_loops(self.now.state.function)
                awaited |= {loop.header for loop in loops if loop.header in inside}
        return frozenset(awaited)

    def _climb_threads(self, header: str) -> None:
        """Threads where iterations prove to be independent: on one tile a loop over `prange` whose
        iterations are not has run one after the other so far.
        """
        array = meeting_array(self.now.state.function, header)
        if array is None:
            self._climb("threads", header)
            return
        reason = f"{MAY_MEET} {array}: ask for threads if they do not"
        self.note(self.now, Candidate("threads", header, _FACTORS[0]), None, reason)

    def _interleave(self, taken: Collection[str]) -> None:
        """Runs iterations of loops side by side where loops inside them wait, from the outside in;
        nests with loops in `taken` have what they need.
        """
        tried = set(self.over_prange())  # they have threads if any
        pes = len(self.estimator.fabric.pes)
        while True:
            base = self.now
            near = {*taken, *self.fixed}
            header = next(loops_around_waiting(base.state, base.estimate, pes, near, tried), None)
            if header is None:
                return
            tried.add(header)
            self._interleave_at(header)
            taken = {*taken, *(self.now.state.made - base.state.made)}

    def _interleave_at(self, header: str) -> None:
        found, _ = self._ascent("interleaving", header)
        for stage in found[-2:-1]:
            self.accept(replace(stage, reserve=True))
        for stage in found[-1:]:
            self.accept(stage)

    def _restructure_all(self) -> None:
        """Restructures nests; those that take little beside the others when these take less."""
        headers, before = self.nests(), math.inf
        while headers and self.now.estimate.cycles < before:
            before, tried, headers = self.now.estimate.cycles, headers, []
            for header in tried:
                if self._is_rare(self.now, header, LITTLE):
                    headers.append(header)
                else:
                    self._restructure(header)
        for header in headers:
            self.note(self.now, Candidate("restructuring", header), None, _NO_GAIN)

    def _restructure(self, header: str) -> None:
        """Gives the loops of a static-control part another order, and tiles for registers."""
        base = self.now
        trips = expected_trips(base.state.function, base.state.hints)
        most = self._most_operations(base, "restructuring")
        found = restructured(base.state, header, self.estimator, trips, most)
        if isinstance(found, Refusal):
            self.note(base, Candidate("restructuring", header), None, found.reason)
            return
        kept: list[tuple[Restructured, Stage]] = []
        for done in found:
            candidate = Candidate("restructuring", header, done.factor)
            reason = self._objection(base, candidate, done.estimate)
            if reason == _NO_GAIN and pays_inside(base, header, done.estimate):
                reason = ""
            decision = self.note(base, candidate, done.estimate, reason)
            if not reason:
                kept.append((done, Stage(done.state, done.estimate, decision, base)))
        if kept:
            self.forms[header] = tuple(form for form, _ in kept)
            self.accept(kept[-1][1])

    def _is_rare(self, base: Stage, header: str, share: float) -> bool:
        """Whether a nest takes less than this share of the cycles, which it would have to save."""
        own = base.cycles_in(header, self.estimator.fabric.controller.switch_cycles)
        return own < share * base.estimate.cycles < math.inf

    def _join(self) -> None:
        """Gives pairs of nests that go through one matrix one nest of loops."""
        tried: set[str] = set()
        while True:
            base = self.now
            parts = (one for one in joined_parts(base.state) if one[0] not in tried)
            header, state, part = next(parts, ("", base.state, None))
            if part is None:
                return
            tried.add(header)
            trips = expected_trips(state.function, state.hints)
            most = self._most_operations(base, "restructuring")
            found = restructured_together(state, part, self.estimator, trips, most)
            if not isinstance(found, Refusal):
                done = found[-1]
                candidate = Candidate("restructuring", header, done.factor)
                decision = self.note(base, candidate, done.estimate, "")
                self.accept(Stage(done.state, done.estimate, decision, base))

    def _take(self, header: str, form: Restructured) -> None:
        """Gives a static-control part loops that were found before."""
        base = self.now
        state = self.with_nest(base.state, header, form.order, form.tree)
        if isinstance(state, State):
            estimate = self.estimator.estimate(state.function, state.hints)
            candidate = Candidate("restructuring", header, form.factor)
            self.accept(Stage(state, estimate, self.note(base, candidate, estimate, ""), base))

    def _flatten(self) -> None:
        """Flattens nests of two loops, then what has become one by that."""
        tried: set[str] = set()
        while headers := self.around_one_loop(self.now, tried):
            tried.add(headers[0])
            self._try(Candidate("flattening", headers[0]))

    def _climb(self, kind: Kind, header: str) -> None:
        """Applies the factor up to which the estimate falls; the next one, if it is a little
        better, is for when that has no mapping.
        """
        found, spare = self._ascent(kind, header)
        for stage in found[-1:]:
            if spare is not None:
                self.accept(replace(spare, reserve=True))
            self.accept(stage)

    def _ascent(self, kind: Kind, header: str) -> tuple[list[Stage], Stage | None]:
        """The factors up to the one up to which the estimate falls, and the one after it if it is
        better, but not by enough.
        """
        base = self.now
        found: list[Stage] = []
        few = header in base.state.made and base.state.hints[header] < _FACTORS[-1]
        if few and kind != "partial results":
            return [], None  # what an earlier transformation left over
        for factor in _FACTORS:
            stage = self._evaluate(base, Candidate(kind, header, factor))
            if stage is None:
                if kind == "interleaving" and self.decisions[-1].reason == _NO_GAIN and not found:
                    continue  # four may fill what two do not
                break
            if found and stage.estimate.cycles > _STEP * found[-1].estimate.cycles:
                return found, stage if stage.estimate.cycles < found[-1].estimate.cycles else None
            found.append(stage)
        return found, None

    def _unrolling(self, header: str) -> Kind:
        """Masked for a loop of unknown length inside another: entered often, it would pay for a
        rest often.
        """
        loops = find_loops(self.now.state.function)
        nested = any(header in loop.blocks and header != loop.header for loop in loops)
        is_known = has_known_length(self.now.state, header)
        return "masked unrolling" if nested and not is_known else "unrolling"

    def _try(self, candidate: Candidate) -> None:
        stage = self._evaluate(self.now, candidate)
        if stage is not None:
            self.accept(stage)

    def _evaluate(self, base: Stage, candidate: Candidate) -> Stage | None:
        """The stage after the candidate if it pays; the decision is noted."""
        time_limit.step("loop transformations were chosen")
        share, limit = GAIN[candidate.kind], self._most_operations(base, candidate.kind)
        is_rare = self._is_rare(base, changed_by(base.state, candidate), 1.0 - share - _BESIDE)
        reason = _TOO_RARE if is_rare else in_vain(self.estimator, base, candidate, limit)
        foreseen = None if reason else self.foreseen(base, candidate, share, limit)
        if reason or foreseen is not None:
            self.note(base, candidate, foreseen, reason or _NO_GAIN)
            return None
        state = self.applied(base.state, candidate)
        if isinstance(state, Refusal):
            self.note(base, candidate, None, state.reason)
            return None
        estimate = self.estimator.estimate(state.function, state.hints)
        reason = self._objection(base, candidate, estimate)
        decision = self.note(base, candidate, estimate, reason)
        return None if reason else Stage(state, estimate, decision, base)

    def _objection(self, base: Stage, candidate: Candidate, estimate: Estimate) -> str:
        limit = self._most_operations(base, candidate.kind)
        largest = self.estimator.largest_loop(estimate)
        if largest > limit:
            return too_large(largest, limit)
        if math.isinf(estimate.cycles):
            return f"it needs more than the {self.estimator.fabric.controller.contexts} contexts"
        share = GAIN[candidate.kind]
        if largest > LARGE:
            share = min(share, GAIN_OF_LARGE)
        if not any(region.kind == "loop" for region in estimate.regions):
            share = GAIN_WITHOUT_LOOP
        if estimate.cycles > base.estimate.cycles * share:
            return _NO_GAIN
        return ""

    def _most_operations(self, base: Stage, kind: Kind) -> int:
        """Of a loop: more take too long to map, unless one has more already."""
        loops = (region for region in base.estimate.regions if region.kind == "loop")
        known = max((loop.shape.operations for loop in loops), default=0)
        return max(OPERATIONS_PER_PE[kind] * len(self.estimator.fabric.pes), known)
