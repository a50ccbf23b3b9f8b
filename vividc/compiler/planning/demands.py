"""The transformations that the user asks for: done whether they pay or not."""

from __future__ import annotations

from collections.abc import Iterator

from vividc.compiler.planning.candidates import Candidate, Kind, apply
from vividc.compiler.planning.plan import Draft, Stage
from vividc.compiler.planning.state import State
from vividc.errors import KernelError, SourceLoc
from vividc.ssa.analysis.frequency import expected_trips
from vividc.ssa.flow import find_loops
from vividc.ssa.loops.threads.make import MOST_THREADS
from vividc.ssa.rewrite.refusal import Refusal


def obey(draft: Draft) -> None:
    """Applies what the user asks for.

    Raises
    ------
    KernelError
        A factor is asked for a line without a loop, or of a loop that cannot be transformed so; or
        threads, and there is no loop over `prange`.
    """
    if draft.options.threads is not None:
        _thread(draft, draft.options.threads)
    asked: list[tuple[Kind, int, int]] = [
        ("unroll-and-jam", line, factor) for line, factor in draft.options.jam.items()
    ]
    asked += [("flattening", line, 0) for line, wanted in draft.options.flatten.items() if wanted]
    asked += [("unrolling", line, factor) for line, factor in draft.options.unroll.items()]
    for kind, line, factor in asked:
        for header in _at_line(draft, line):
            draft.fixed.add(header)
            if factor != 1:
                _force(draft, kind, header, factor, line)


def _thread(draft: Draft, count: int) -> None:
    """Makes threads of the loops over `prange`, as the user asks."""
    headers = draft.over_prange()
    file = draft.now.state.function.file
    if count > 1 and not headers:
        line = min(draft.parallel, default=0)
        raise KernelError(
            "the loop over prange is gone: it runs once at most",
            loc=SourceLoc(file, line) if line else None,
            hint="leave threads out",
        )
    for header in headers:
        loc = draft.now.state.loc(header)
        if count > 1:
            draft.fixed.add(header)
            _force(draft, "threads", header, count, 0 if loc is None else loc.line)


def _force(draft: Draft, kind: Kind, header: str, factor: int, line: int) -> None:
    base = draft.now
    trips = expected_trips(base.state.function, base.state.hints)
    candidate = Candidate(kind, header, factor)
    state = apply(base.state, candidate, trips)
    is_done = isinstance(state, State) or not _is_around_a_loop(draft, header)
    for other in _in_its_place(candidate, trips[header], is_possible=is_done):
        done = apply(base.state, other, trips)
        candidate, state = (other, done) if isinstance(done, State) else (candidate, state)
    if isinstance(state, Refusal):
        what = f"{kind} by {factor}" if factor else kind
        if kind == "threads":
            what = f"running {factor} iterations as threads"
        text = f"{what} is not possible here: {state.reason}"
        hint = "leave the factor out, or see what --explain says of this loop"
        raise KernelError(text, loc=SourceLoc(base.state.function.file, line), hint=hint)
    estimate = draft.estimator.estimate(state.function, state.hints)
    decision = draft.note(base, candidate, estimate, "")
    draft.fixed |= state.made - base.state.made
    draft.accept(Stage(state, estimate, decision, base))


def _is_around_a_loop(draft: Draft, header: str) -> bool:
    blocks = draft.now.state.loop(header).blocks
    loops = find_loops(draft.now.state.function)
    return any(loop.header in blocks and loop.header != header for loop in loops)


def _at_line(draft: Draft, line: int) -> list[str]:
    state = draft.now.state
    headers = [
        loop.header
        for loop in find_loops(state.function)
        if (loc := state.loc(loop.header)) is not None and loc.line == line
    ]
    if not headers:
        locs = (state.loc(loop.header) for loop in find_loops(state.function))
        lines = sorted({loc.line for loc in locs if loc is not None})
        hint = f"lines with loops: {', '.join(map(str, lines)) or 'none'}"
        file = state.function.file
        raise KernelError("no loop starts on this line", loc=SourceLoc(file, line), hint=hint)
    return headers


def _in_its_place(candidate: Candidate, trips: float, *, is_possible: bool) -> Iterator[Candidate]:
    """What does as the user asks where the transformation of this name does not, or does less."""
    header, factor = candidate.header, candidate.factor
    if candidate.kind == "unrolling" and trips <= factor:
        yield Candidate("full unrolling", header)
    if candidate.kind == "unroll-and-jam" and not is_possible and factor <= MOST_THREADS:
        yield Candidate("interleaving", header, factor)
