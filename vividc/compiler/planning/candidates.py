"""The transformations that can be tried on a function, and the result of each."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Final, Literal

from vividc.compiler.planning.nests.parts import jammed
from vividc.compiler.planning.state import MOST_INSTRUCTIONS, State
from vividc.ssa.analysis.constant_trips import constant_trips
from vividc.ssa.flow import Loop, find_loops
from vividc.ssa.ir import Function
from vividc.ssa.loops.flatten.flatten import flatten, flattened_iterations, nest_at
from vividc.ssa.loops.grouped import unroll_masked, with_partial_results
from vividc.ssa.loops.threads.make import thread
from vividc.ssa.loops.unroll import unroll
from vividc.ssa.loops.versions import versions
from vividc.ssa.parallel.independent import meeting_array
from vividc.ssa.rewrite.normalize import canonical_loops
from vividc.ssa.rewrite.number_values import merge_recurrences
from vividc.ssa.rewrite.peel import peel
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy

Kind = Literal[
    "full unrolling",
    "unrolling",
    "masked unrolling",
    "unroll-and-jam",
    "flattening",
    "threads",
    "interleaving",
    "restructuring",
    "versioning",
    "partial results",
]
"""`threads` are of a loop over `prange`; `interleaving` makes them of any other one."""

MOST_ITERATIONS = 64
"""Loops of more iterations are not unrolled fully."""

_MOST_KNOWN = 4096
"""Of so many iterations it is asked whether they are a loop's each time."""

_APART = 0.9
"""How often accesses that a test before their loop tells apart are so."""

MAY_MEET = "iterations may meet in"
"""Before an array's name: why threads were not tried."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """A transformation of the loop at `header`; full unrolling, flattening and versioning have
    factor 0.
    """

    kind: Kind
    header: str
    factor: int = 0


def apply(state: State, candidate: Candidate, trips: Mapping[str, float]) -> State | Refusal:
    """The state after the transformation.

    Parameters
    ----------
    trips
        Expected iterations of every loop of the state.
    """
    if not candidate.factor:
        return _without_factor(state, candidate, trips)
    expected = trips[candidate.header]
    factor = candidate.factor
    size = _size(state.function, state.loop(candidate.header)) * factor
    if size > MOST_INSTRUCTIONS:
        return Refusal(f"it would make {size} instructions")
    if candidate.kind in _MADE:
        return _MADE[candidate.kind](state, candidate, trips)
    if candidate.kind == "unroll-and-jam":
        return jammed(state, candidate.header, factor, trips)
    rest = expected % factor if has_known_length(state, candidate.header) else (factor - 1) / 2
    return _unrolled(state, candidate, trips, rest)


def _without_factor(
    state: State, candidate: Candidate, trips: Mapping[str, float]
) -> State | Refusal:
    if candidate.kind == "flattening":
        return _flattened(state, candidate.header, trips)
    if candidate.kind == "versioning":
        return _versioned(state, candidate.header, trips)
    return _fully(state, candidate.header)


def _unrolled(
    state: State, candidate: Candidate, trips: Mapping[str, float], rest: float
) -> State | Refusal:
    """Runs iterations of an innermost loop as one; `rest` of them are left over."""
    factor = candidate.factor
    done = unroll(state.function, state.loop(candidate.header), factor)
    if isinstance(done, Refusal):
        return done
    hints = {done.main: (trips[candidate.header] - rest) / factor, done.rest: rest}
    derived = {done.main: done.rest}
    return _next(state, tidy(done.function), hints, derived, factor)


def _in_groups(state: State, candidate: Candidate, trips: Mapping[str, float]) -> State | Refusal:
    """Runs iterations of an innermost loop as one, the last ones masked, perhaps each with partial
    results of its own.
    """
    factor, expected = candidate.factor, trips[candidate.header]
    if candidate.kind == "masked unrolling":
        done = unroll_masked(state.function, state.loop(candidate.header), factor)
    else:
        function = merge_recurrences(state.function)  # a sum may be there twice
        done = with_partial_results(function, state.loop(candidate.header), factor)
    if isinstance(done, Refusal):
        return done
    is_constant = has_known_length(state, candidate.header)
    groups = math.ceil(expected / factor) if is_constant else (expected + (factor - 1) / 2) / factor
    derived = {done.main: candidate.header}
    return _next(state, tidy(done.function), {done.main: groups}, derived, factor)


def _interleaved(state: State, candidate: Candidate, trips: Mapping[str, float]) -> State | Refusal:
    """Runs iterations as threads that prove to be independent."""
    array = meeting_array(state.function, candidate.header)
    if array is not None:
        return Refusal(f"{MAY_MEET} {array}")
    return _threaded(state, candidate, trips)


def _threaded(state: State, candidate: Candidate, trips: Mapping[str, float]) -> State | Refusal:
    """Runs iterations of a parallel loop as threads. A loop inside it lasts as long as the longest
    of theirs: as lengths are assumed to be evenly spread from 0, the mean of the longest of n is
    2n / (n + 1) times the mean.
    """
    done = thread(state.function, candidate.header, candidate.factor)
    if isinstance(done, Refusal):
        return done
    derived = {done.main: candidate.header, **dict(done.loops)}
    count = candidate.factor
    hints = {new: trips[old] for new, old in derived.items()}
    for new, old in done.loops:
        if new in done.free and not has_known_length(state, old):
            hints[new] *= 2 * count / (count + 1)
    hints[done.main] = math.ceil(trips[candidate.header] / count)
    return _next(state, tidy(done.function), hints, derived, count)


def _flattened(state: State, header: str, trips: Mapping[str, float]) -> State | Refusal:
    """Makes one loop of the nest at `header`; it runs iterations of the inner loop."""
    function = flatten(state.function, header)
    if function is None:
        return Refusal("it does not hold exactly one loop that it goes on after")
    nest = nest_at(canonical_loops(state.function), header)
    assert nest is not None
    inner = nest.inner.header
    hints = {header: flattened_iterations(state.function, header, trips)}
    origin = {**state.origin, header: state.origin.get(inner, inner)}
    scale = {**state.scale, header: state.scale.get(inner, 1)}
    made = state.made | {header}
    return State(function, {**state.hints, **hints}, made, origin, scale)


def _versioned(state: State, header: str, trips: Mapping[str, float]) -> State | Refusal:
    """Runs the loop in a version for when its accesses prove to be apart, else as it was."""
    done = versions(state.function, state.loop(header))
    if isinstance(done, Refusal):
        return done
    hints = dict.fromkeys((done.apart, done.meeting), trips[header])
    made = _next(state, tidy(done.function), hints, {done.meeting: header}, 1)
    return replace(made, hints={**made.hints, done.entered: _APART})


_MADE: Final[Mapping[Kind, Callable[[State, Candidate, Mapping[str, float]], State | Refusal]]] = {
    "interleaving": _interleaved,
    "threads": _threaded,
    "partial results": _in_groups,
    "masked unrolling": _in_groups,
}


def _next(
    state: State,
    function: Function,
    hints: Mapping[str, float],
    derived: Mapping[str, str],
    factor: int,
) -> State:
    """The state with new loops; `derived` are their headers and those of the loops they copy."""
    origin = {new: state.origin.get(old, old) for new, old in derived.items()}
    scale = {new: state.scale.get(old, 1) * factor for new, old in derived.items()}
    return State(
        function,
        {**state.hints, **hints},
        state.made | hints.keys(),
        {**state.origin, **origin},
        {**state.scale, **scale},
    )


def _fully(state: State, header: str) -> State | Refusal:
    """Unrolls the loop and those in it, inner ones first, or as soon as their trips are known."""
    function = state.function
    inside = {header} | {
        loop.header for loop in find_loops(function) if loop.header in state.loop(header).blocks
    }
    while True:
        loops = [loop for loop in find_loops(function) if loop.header in inside]
        if not loops:
            return replace(state, function=function, made=state.made | {_around(state, header)})
        counted = ((loop, constant_trips(function, loop, MOST_ITERATIONS)) for loop in loops)
        loop, trips = next((known for known in counted if known[1] is not None), (loops[0], None))
        if trips is None:
            return Refusal(f"its trip count is not a constant up to {MOST_ITERATIONS}")
        size = _size(function, loop) * trips.entries
        if size > MOST_INSTRUCTIONS:
            return Refusal(f"it would make {size} instructions")
        peeled = peel(function, loop, trips.entries)
        inside |= {new for new, old in peeled.origin.items() if old in inside}
        function = tidy(peeled.function)


def changed_by(state: State, candidate: Candidate) -> str:
    """The header of the loop that a candidate makes another one of."""
    is_inside = candidate.kind == "full unrolling"
    return _around(state, candidate.header) if is_inside else candidate.header


def _around(state: State, header: str) -> str:
    """The loop around, which becomes another one by full unrolling; itself if there is none."""
    loops = [loop for loop in find_loops(state.function) if header in loop.blocks]
    return next((loop.header for loop in loops if loop.header != header), header)


def has_known_length(state: State, header: str) -> bool:
    """Whether a loop has as many iterations each time, and that is known."""
    return constant_trips(state.function, state.loop(header), _MOST_KNOWN) is not None


def _size(function: Function, loop: Loop) -> int:
    return sum(len(block.instrs) for block in function.blocks if block.name in loop.blocks)
