"""What would make a kernel faster, ranked by the cycles that each change is estimated to save."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from vividc.arch import Accelerator
from vividc.arch.fabric import Fabric
from vividc.compiler.advice.changes import Change, changes_of
from vividc.compiler.advice.request import (
    Planner,
    Request,
    final,
    is_finite,
    saved_at,
    with_lengths_of,
)
from vividc.compiler.advice.search import Searched, longer_search
from vividc.compiler.driver import checked, parallel_lines
from vividc.compiler.planning.options import LoopOptions
from vividc.compiler.planning.plan import Plan
from vividc.compiler.regions.one_straight import Progress
from vividc.compiler.stage import CompileOptions
from vividc.errors import SourceLoc, TimeLimit, VividcError, warn
from vividc.frontend import KernelFunction, LLKernel
from vividc.frontend.like import Like
from vividc.host import time_limit
from vividc.mapper import EffortLevel
from vividc.program import Program
from vividc.ssa.formats.precision import FormatChoices, parse_precision

LEAST_GAIN = 0.03
"""What saves a smaller share of the cycles is no advice."""


@dataclass(frozen=True, slots=True)
class Hint:
    """A change that is estimated to make a kernel faster.

    Attributes
    ----------
    action, option
        What to do, and the option of `vividc compile` that does it; "": the source is changed.
    loc
        The line to change, or where the cycles are saved; None: nowhere in particular.
    before, after
        Estimated cycles of one run without the change and with it, loops of unknown length at
        assumed ones; on an accelerator with `prange` of one tile.
    condition
        What has to hold, or what else is different then; "": nothing.
    at_most
        More may be missing than `after` knows: it is a bound.
    """

    action: str
    option: str
    loc: SourceLoc | None
    before: float
    after: float
    condition: str = ""
    at_most: bool = False

    @property
    def saved(self) -> float:
        """Cycles."""
        return self.before - self.after


def advise(  # noqa: PLR0913 - the keywords of `compile` that a plan depends on
    kernel: KernelFunction | LLKernel,
    fabric: str | Fabric | Accelerator = "vivid-tile",
    *,
    program: Program | None = None,
    time_limit_s: float = 60.0,
    effort: EffortLevel = "normal",
    loops: LoopOptions | None = None,
    strict_fp: bool = False,
    contract: bool = True,
    reassociate: bool = False,
    precision: FormatChoices | None = None,
    like: Like | None = None,
    progress: Progress | None = None,
) -> tuple[Hint, ...]:
    """Changes that would make a kernel faster than with these arguments of `compile`, the largest
    saving first; none of less than 3 %.

    Each is planned alone as if it was made, and its plan is estimated: savings do not add up.

    Parameters
    ----------
    program
        What `compile` made of it: what a longer search could save is known from it.
    time_limit_s
        Seconds of wall time; what they leave out is a warning.
    progress
        Called with what is tried.

    Raises
    ------
    ArgumentError, KernelError, ArchError
        As `compile`.
    """
    machine = checked(kernel, fabric, time_limit_s)
    kernel = kernel if like is None else kernel.sized(like)
    options = CompileOptions(
        time_limit_s=time_limit_s,
        effort=effort,
        strict_fp=strict_fp,
        contract=contract,
        loops=LoopOptions() if loops is None else loops,
        reassociate=reassociate,
        precision=parse_precision(precision),
    )
    request = Request(kernel, machine, options, parallel_lines(kernel, options.loops))
    with time_limit.limited(time_limit_s, kernel.name, kernel.loc) as limit:
        hints = _hints(request, program, progress)
    for what in dict.fromkeys(limit.cut):
        text = f"{kernel.loc}: {what} took too long: advice may be missing"
        warn(text)
    return hints


def _hints(
    request: Request, program: Program | None, progress: Progress | None
) -> tuple[Hint, ...]:
    found: list[Hint] = []
    try:
        for hint in _found(request, program, progress):
            found.append(hint)
    except TimeLimit:
        time_limit.left_out("the search for advice")
    worthwhile = [hint for hint in found if hint.saved >= LEAST_GAIN * hint.before]
    return tuple(sorted(_best_of_each(worthwhile), key=lambda hint: -hint.saved))


def _found(request: Request, program: Program | None, progress: Progress | None) -> Iterator[Hint]:
    planner = Planner()
    plan = planner.plan(request)
    limit = time_limit.current()
    if not is_finite(plan) or (limit is not None and limit.cut):
        return  # there is nothing to compare with
    if program is not None:
        for searched in longer_search(plan, program):
            yield _of_search(searched, final(plan).cycles)
    for change in changes_of(request, plan, planner):
        time_limit.step("changes were tried")
        if progress is not None:
            progress(change.action)
        hint = _tried(change, plan, planner)
        if hint is not None:
            yield hint


def _tried(change: Change, plan: Plan, planner: Planner) -> Hint | None:
    """The hint that a change is, if it can be made."""
    try:
        changed = planner.plan(change.request)
    except TimeLimit:
        raise
    except VividcError:
        return None
    if not is_finite(changed):
        return None
    before, after = final(plan).cycles, final(changed).cycles * change.share
    if change.scaled:
        after *= before / with_lengths_of(plan, changed, planner.estimator(change.request))
    loc = change.loc or saved_at(final(plan), final(changed))
    at_most = change.share < 1.0
    return Hint(change.action, change.option, loc, before, after, change.condition, at_most)


def _of_search(searched: Searched, before: float) -> Hint:
    after = before - searched.saved
    return Hint(searched.action, searched.option, searched.loc, before, after, at_most=True)


def _best_of_each(hints: list[Hint]) -> list[Hint]:
    """Of hints for one line that differ in a number only, the best."""
    best: dict[tuple[object, ...], Hint] = {}
    for hint in hints:
        stem = hint.option.split("=")[0].rstrip("0123456789 ") or hint.action
        key = (stem, hint.loc)
        if key not in best or hint.saved > best[key].saved:
            best[key] = hint
    return list(best.values())
