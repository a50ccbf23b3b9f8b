"""The constants that steer the search over IIs, each with its reason, and with what it was measured
on where that is known.

A change shows in `benchmarks/mappers.md` (public graphs) and `benchmarks/kernels.md`, whose IIs are
those of all values together; a value without a figure was never measured alone. Shares are of the
effort that is left, `_S` are seconds of effort (`mapper/deadline.py`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from vividc.mapper.engines.negotiate import Effort

TRY_S: Final = 0.001
"""Charged for each try of an II: one that ends at once takes time, too, when it is repeated."""
WORTH_TRYING_S: Final = 0.3
"""A round of tries that takes less would only repeat itself."""

# The class of a problem.
LARGE_GRAPH: Final = 40
"""Operations from which on negotiation comes first: constraints take longer to place and route so
many.
"""
NEGOTIATED_GRAPH: Final = 28
"""Operations from which on a quick negotiation at the bound may make iterations of any length
before constraints are asked: loops of 34 operations (heat-3d) map in 0.06 s instead of 1.2.
Iterations of smaller ones (27, gemver) would come out longer.
"""
SHORT: Final = (0, 1, 2)
"""Cycles by which iterations of small graphs may be longer than their dependences take, in turn: of
98 loops of `kernels/` below 28 operations 85 map at none, 10 at one, 1 at two.
"""
LARGE_ARRAY: Final = 16
"""PEs beyond which constraints may use up the time on the way upward (of small graphs), and
rectangles of the array are searched, too.
"""

# One II.
MOST_BOOLEANS: Final = 600_000
"""A larger model is not built: it takes too much memory, and presolve would not stop in time."""
BOOLEANS_PER_S: Final = 30_000
"""Built and presolved in a second, with a margin (building alone: 100,000 on one core)."""
SCHEDULE_S, SCHEDULE_S_PER_NODE = 1.0, 0.02
ROUTE_S, ROUTE_S_PER_NODE = 2.0, 0.1
"""At most, for one schedule, and for the first tries to place and route it."""
WIDEN_AFTER: Final = 4
"""Schedules whose operations keep their times; those of as many more may be moved by a cycle."""
SCHEDULE_KINDS: Final = ((1, 0), (2, 1), (3, 2), (0, 0))
"""(cycles a word may live at no cost, stages beyond the shortest schedule), in turn: tight or loose
ones may be the first to route.
"""
MOST_DOUBLINGS: Final = 16
"""Of the time for a schedule: more overflow."""
SEEDS_IN_STEP: Final = 2
"""Annealings that run side by side: as many as threads find work (`MapRequest.workers`)."""
MOBILITY_PLACEMENTS: Final = 20
"""Placements of the kernel mobility schedule that are routed until one has routes."""
MOBILITY_EXTRA_STAGES: Final = (0, 1)
"""Stages by which the mobility schedule may be longer than the longest path, in turn."""

# The steps of a strategy at one II.
PROOF_SHARE: Final = 0.15
NEGOTIATION_SHARE: Final = 0.4
DECOUPLED_SHARE: Final = 0.7
FOLDING_SHARE: Final = 0.4
"""Of the time for an II; the last step has what is left."""

# The climb from the bound, and the descent, with constraints.
CLIMB_SHARE: Final = 0.08
"""For the first turn of each II: small, since an II that takes longer is tried again from above."""
LONG_CLIMB_FIRST_SHARE, LONG_CLIMB_SHARE = 0.5, 0.2
"""The same at the bound and above it where constraints alone are to find a mapping."""
CLIMB_LEAST_S: Final = 2.0
BOUND_SHARE: Final = 0.5
"""At most, for the turn at the bound before a warm start."""
FAILURES_PER_STEP: Final = 3
"""Failures after which the climb takes steps that are longer by one."""

# A warm start of a small graph.
WARM_START_SHARE: Final = 0.3
WARM_START_LEAST_S: Final = 2.0
MOBILITY_STEPS: Final = (1.0, 1.3, 1.7, 2.2, 3.0)
"""IIs for the kernel mobility schedule, in bounds."""
MOBILITY_SHARE: Final = 0.2
"""For each of them."""
SECOND_SEED: Final = 2
"""Of the first negotiation after a warm start, which has seed 1."""

# Negotiation.
QUICK: Final = Effort(moves=2000, rounds=30, repairs=60, trials=1, shown=1)
"""To find a first mapping."""
DESCENTS: Final = (Effort(trials=1), Effort())
DESCENTS_WITH_MOVES: Final = (
    Effort(moves=4000, repairs=60, shown=1),
    Effort(moves=4000, repairs=60),
    Effort(moves=8000),
    Effort(moves=16000),
)
"""Of each round downward. Where FUs move words, tries that fail take longest; rounds of growing
effort, together with an annealer that refuses moves earlier, took conv2D on openedge-4x4 in 20 s
from II 38 to 27, idctrows from 14 to 11, matrix_multiply from 18 to 15.
"""
STEP, STEP_WITH_MOVES, LARGE_STEP_WITH_MOVES = 1 / 24, 1 / 4, 1.0
"""The first step above the bound, in bounds (the last one: on arrays of `STEPPED_ARRAY` PEs or
more). Where FUs move words the best II is farther above the bound, and tries that fail take
longest.
"""
LONGER, LONGER_IF_FAR, LONG = 2, 4, 12
"""By what a step above the bound is longer than the one before, and after an II that is far from a
mapping, of bounds that are long: a loop of 278 operations with a bound of 18 (splat_footprints)
maps at 34 after 3 tries instead of 5, and at 25 from there either way. Short ones are not found
again from so far above: softmax of NPBench takes 1.12 times its cycles, mandelbrot1 1.07 times.
"""
STEPPED_ARRAY: Final = 64
ROOMY: Final = 0.3
"""Part of the array's slots that operations take at the bound: up to it the bound is tried even
where steps are large.
"""
FIRST_SHARE, BOUND_SHARE_WITH_MOVES = 0.4, 0.1
"""For an II until something is mapped (the latter: at the bound where FUs move words)."""
DESCENT, DESCENT_WITH_MOVES = 2, 3
"""Parts into which the open IIs are cut on the way downward: where FUs move words most of what is
far below fails.
"""
FIRST_PROOF_S, PROOF_S = 1.0, 2.0
"""For refuting the bound by a schedule without places, before and after the way downward."""
SEEDS: Final = 3
"""At most, of a round of restarts."""
SEEDED_NODES: Final = 150
"""Where FUs move words: nodes that the seeds of the first round anneal together, since each seed is
as likely to map as the one before, and the solver is rarely faster.
"""
SOLVER_S: Final = 400.0
"""For constraints in the first round of restarts, of a graph of one node: a graph of n nodes gets
an nth of it, since the solver does better on smaller graphs.
"""
SOLVED_GRAPH: Final = 80
"""Operations from which on constraints are not asked for less than a proof: of 104 operations they
took 13 of 24 s and brought nothing.
"""
SOLVED_LATER: Final = 60
"""Operations from which on they are asked after the second round of seeds and not the first: of 65
(march_rays) they took 2.7 of 5.5 s of the search, and a seed of the second round mapped.
"""


# Where a search with an incumbent stops.
NEAR: Final = 1
"""A gap between bound and II that takes a proof to close, which rarely ends."""


@dataclass(frozen=True, slots=True)
class Patience:
    """How long a search goes on without a better mapping.

    Attributes
    ----------
    least_s, factor
        At least so long, and as many times as long as it took to come to the incumbent.
    good, near, large
        Part of the bound by which a good II, as one within `NEAR`, is above it; how much of its
        patience the search has then, and with another II of a large graph, whose descent is not cut
        into shares.
    turn_s
        Of constraints at an II that is tried first on the way upward.
    first_proof_s, proof_s
        For refuting the bound of a large graph by a schedule without places, before and after the
        way downward, the latter whether patience is left or not.
    quits
        Annealing ends where what is broken is frozen.
    shared
        Loops of a kernel have parts of it, by the cycles that are expected in them.
    """

    least_s: float
    factor: float
    good: float
    near: float
    large: float
    turn_s: float
    first_proof_s: float
    proof_s: float
    quits: bool = False
    shared: bool = False


PATIENCES: Final = {
    "fast": Patience(
        0.5, 1 / 4, good=1 / 8, near=0.0, large=1.0, turn_s=0.5, first_proof_s=0.0, proof_s=0.0
    ),
    "normal": Patience(
        least_s=2.5,
        factor=1 / 2,
        good=1 / 8,
        near=1 / 5,
        large=0.6,
        turn_s=0.5,
        first_proof_s=0.2,
        proof_s=0.5,
        quits=True,
        shared=True,
    ),
    "thorough": Patience(
        least_s=6.0,
        factor=1.0,
        good=1 / 8,
        near=1 / 6,
        large=5 / 8,
        turn_s=2.0,
        first_proof_s=0.3,
        proof_s=1.25,
    ),
}
"""Of requests that are not to prove. "thorough": of 138 searches of PolyBench's loops and the
slowest of `kernels/` 12 got a better mapping near the bound, after 0.8 s of effort without one at
most (heat-3d), and none in the 0.9 s after that; 7 farther above it, after 1.7 s at most, where
half of them took 3.0 when moves of the annealer took longer. "fast": a loop of 278 operations
(bound 18) that maps at 26 in 16 s took 61 s with a factor of 1, and mapped at 24. Proofs: 1 of 14
came to one, in 0.9 s, none in half a second.
"""
PROVED_GRAPH: Final = 150
"""Operations from which on, unless it is to prove, the bound is not refuted by a schedule without
places: in eight loops of so many 17 s came to nothing.
"""
SCHEDULED_SHARE, SCHEDULED_SHARE_TO_PROVE = 1 / 4, 1 / 2
"""Of the time for refuting an II: for a schedule, which is mostly found in a tenth of it."""

# Windows.
LEAST_WINDOW: Final = 16
"""PEs of the smallest one."""
WINDOW_TARGET: Final = 2
"""The II, in bounds, for which windows have room while nothing is mapped."""
ROOM, ROOM_WITH_MOVES = 1.2, 2.0
"""Slots for each operation; where FUs move words, moves take slots, too."""
NARROWEST: Final = 4
"""The shortest side of a window, in PEs."""
GROWTH: Final = 1.5
"""Least ratio of the sizes of two windows in turn."""
AMPLE_WINDOWS: Final = 3
"""Windows that may reach the bound, after which larger ones are not tried."""
FIRST_WINDOW_SHARE, WINDOW_SHARE = 0.3, 0.2
"""For a window until something is mapped, and after that."""
SPARSE, FILLED = 0.06, 0.2
"""Parts of the slots: a graph that takes less of the array's begins in a window where it takes no
more than this of them, since on the whole array annealing leaves it far apart.
"""
WINDOW_SEEDS: Final = (1, 2)
WINDOW_SEED_SHARE: Final = 0.1

# What follows the search.
SHARE_BEFORE_OBJECTIVE: Final = 0.6
"""Of the time, for the II, if an objective is minimised after it."""
SHARE_EXTENDED: Final = 0.85
"""The same if only a caller's constraints may ask for an objective."""

# Mappers that only go upward.
UPWARD_SHARE: Final = 0.35
UPWARD_LEAST_S: Final = 1.0
UPWARD_STEP: Final = 8
"""Past so many IIs above the bound steps are longer by one, past twice as many by two."""
