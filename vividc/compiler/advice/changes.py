"""Changes that may make a program faster: other options, and other words in the source."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TypeVar

from vividc.arch import Accelerator
from vividc.compiler.advice.apart import separable
from vividc.compiler.advice.request import Planner, Request
from vividc.compiler.advice.sizes import sizes_option, stand_in_sizes
from vividc.compiler.planning.candidates import MAY_MEET
from vividc.compiler.planning.options import LoopOptions
from vividc.compiler.planning.plan import Plan
from vividc.errors import SourceLoc
from vividc.frontend import KernelFunction
from vividc.ssa.flow import Loop, find_loops
from vividc.ssa.ir import Function
from vividc.ssa.parallel.independent import meeting_array
from vividc.ssa.rewrite.tidy import tidy

_Wanted = TypeVar("_Wanted", int, bool)
_THREADS = (2, 4, 8)
_MOST_LINES = 4
"""So many lines are tried with casts of their own, those with most instructions to save."""

_ROUNDING = "results may differ in their last bits"
_LEAVE, _AUTO = "leave out {}", "--transform"
_CAST = "what is computed there fits in 32 bits"


@dataclass(frozen=True)
class Change:
    """A request that differs from another one, and how the user makes it.

    Attributes
    ----------
    action, option
        What to do, and the option of the command line that does it; "": the source is changed.
    condition
        What has to hold, or what else is different then; "": nothing.
    loc
        The line to change; None: of the options, or where the change saves most.
    share
        The part of the kernel that a tile runs then.
    scaled
        Loops may have other lengths: what it saves is compared at those.
    """

    request: Request
    action: str
    option: str = ""
    condition: str = ""
    loc: SourceLoc | None = None
    share: float = 1.0
    scaled: bool = False


def changes_of(base: Request, plan: Plan, planner: Planner) -> Iterator[Change]:
    """All that is worth trying; `plan` is that of `base`."""
    yield from _switches(base)
    yield from _loops(base, plan)
    yield from _sizes(base)
    if isinstance(base.kernel, KernelFunction):
        yield from _casts(base)
        yield from _parallel(base, plan)
        yield from _arrays(base, plan, planner)


def _switches(base: Request) -> Iterator[Change]:
    options = base.options
    if not options.reassociate:
        request = replace(base, options=replace(options, reassociate=True))
        yield Change(request, "sum floats in another order", "--reassociate", _ROUNDING)
    request = replace(base, options=replace(options, contract=not options.contract))
    if options.contract:
        action = "round products before they are added"
        yield Change(request, action, "--no-contract", _ROUNDING)
    else:
        yield Change(request, "fuse products and sums", "--contract", _ROUNDING)


def _loops(base: Request, plan: Plan) -> Iterator[Change]:
    wanted = base.options.loops
    for loops, action, option in (*_automatic(wanted), *_without_factors(wanted)):
        yield Change(_with_loops(base, loops), action, option)
    yield from _other_factors(base, plan)
    if any(d.kind == "threads" and d.reason.startswith(MAY_MEET) for d in plan.decisions):
        for count in _THREADS:
            yield Change(
                _with_loops(base, replace(wanted, threads=count)),
                f"run {count} iterations of the loop over prange side by side",
                f"--threads {count}",
                "no iteration reads or writes what another one writes",
            )


def _with_loops(base: Request, loops: LoopOptions) -> Request:
    return replace(base, options=replace(base.options, loops=loops))


def _automatic(wanted: LoopOptions) -> Iterator[tuple[LoopOptions, str, str]]:
    if not wanted.auto:
        yield replace(wanted, auto=True), "let the compiler transform loops", "--transform"
    if wanted.auto and not wanted.restructure:
        action = "let the compiler restructure nests of loops"
        yield replace(wanted, restructure=True), action, "--restructure"


def _without_factors(wanted: LoopOptions) -> Iterator[tuple[LoopOptions, str, str]]:
    """Without what the user asks for of a line, and without threads."""
    free = replace(wanted, auto=True)
    for line, factor in wanted.unroll.items():
        option = f"--unroll {line}={factor}"
        yield replace(free, unroll=_but(line, wanted.unroll)), _LEAVE.format(option), _AUTO
    for line, factor in wanted.jam.items():
        yield (
            replace(free, jam=_but(line, wanted.jam)),
            _LEAVE.format(f"--jam {line}={factor}"),
            _AUTO,
        )
    for line, flat in wanted.flatten.items():
        option = f"--{'' if flat else 'no-'}flatten {line}"
        yield replace(free, flatten=_but(line, wanted.flatten)), _LEAVE.format(option), _AUTO
    if wanted.threads is not None:
        yield replace(free, threads=None), _LEAVE.format(f"--threads {wanted.threads}"), _AUTO


def _but(line: int, given: Mapping[int, _Wanted]) -> dict[int, _Wanted]:
    return {other: wanted for other, wanted in given.items() if other != line}


def _other_factors(base: Request, plan: Plan) -> Iterator[Change]:
    """Factors that would have saved a little, less than is sure to be worth it."""
    wanted = base.options.loops
    taken = [stage.decision for stage in plan.stages]
    for decision in plan.decisions:
        pays = decision.after is not None and decision.after < decision.before
        loc, factor = decision.loc, decision.factor
        if not pays or decision in taken or loc is None or loc.file != base.kernel.file:
            continue
        line = loc.line
        if decision.kind == "unrolling":
            loops = replace(wanted, unroll={**wanted.unroll, line: factor})
            option = f"--unroll {line}={factor}"
            yield Change(_with_loops(base, loops), f"unroll by {factor}", option, loc=loc)


def _sizes(base: Request) -> Iterator[Change]:
    function, _ = base.lowered()
    like = stand_in_sizes(function)
    if like:
        request = replace(base, kernel=base.kernel.sized(like))
        condition = "every launch has the same: yours in place of these"
        action = "say the sizes of the launches"
        yield Change(request, action, sizes_option(like), condition, scaled=True)


def _casts(base: Request) -> Iterator[Change]:
    """Casts to int32 on all lines that compute in 64 bits, and on each of them alone."""
    function, _ = base.lowered()
    before = _instructions(function)
    everywhere = replace(base, words_at=frozenset(before))
    after = _instructions(everywhere.lowered()[0])
    saved = {line: count - after[line] for line, count in before.items() if count > after[line]}
    costly = sorted(saved, key=lambda line: (-saved[line], line))
    for line in costly[:_MOST_LINES]:
        action = "compute in 32 bits, with np.int32(...) around the 64-bit operands:"
        action += f" {before[line]} instructions become {after[line]}"
        loc = SourceLoc(function.file, line)
        yield Change(replace(base, words_at=frozenset({line})), action, "", _CAST, loc)
    if len(costly) > 1:
        lines = ", ".join(map(str, sorted(costly)))
        action = f"compute in 32 bits, with np.int32(...), on lines {lines}"
        loc = SourceLoc(function.file, costly[0])
        yield Change(replace(base, words_at=frozenset(costly)), action, "", _CAST, loc)


def _instructions(function: Function) -> Counter[int]:
    """Instructions of each line of the function's file."""
    locs = (instr.loc for block in function.blocks for instr in block.instrs)
    return Counter(loc.line for loc in locs if loc is not None and loc.file == function.file)


def _parallel(base: Request, plan: Plan) -> Iterator[Change]:
    """Loops over `prange` whose iterations are proved to be independent."""
    if base.lines or base.options.loops.threads is not None:
        return
    function = tidy(base.lowered()[0])
    first = plan.stages[0]
    for loop in _independent(function):
        loc = first.state.loc(loop.header)
        if loc is None or loc.file != function.file:
            continue
        request = replace(base, lines=frozenset({loc.line}))
        action = "write prange instead of range: its iterations are independent"
        share = 1.0
        if isinstance(base.machine, Accelerator):
            if request.lowered()[1] == frozenset():
                continue
            trips = first.state.hints.get(loop.header, 1.0)
            share = 1.0 / max(min(trips, len(base.machine.tiles)), 1.0)
            action += ", and tiles share them"
        yield Change(request, action, "", "", loc, share)


def _independent(function: Function) -> Iterator[Loop]:
    """The outermost loops that are so."""
    found: list[Loop] = []
    for loop in sorted(find_loops(function), key=lambda loop: -len(loop.blocks)):
        if any(loop.header in outer.blocks for outer in found):
            continue
        if meeting_array(function, loop.header) is None:
            found.append(loop)
            yield loop


def _arrays(base: Request, plan: Plan, planner: Planner) -> Iterator[Change]:
    written = plan.stages[0].state
    estimator = planner.estimator(base)
    kernel = estimator.built(estimator.prepared(written.function, written.hints))
    for array, load in separable(written.function, estimator.optimized_kernel(kernel)):
        action = f"read {array} from an array of its own, and write to another one"
        condition = f"no iteration reads what another one has written to {array}"
        yield Change(replace(base, apart=array), action, "", condition, load.loc)
