"""Our own mappers as rows: how they try one II, and how they walk over IIs."""

from __future__ import annotations

from typing import Final

from vividc.mapper.problem import MapProblem
from vividc.mapper.request import MapRequest
from vividc.mapper.result import MapResult
from vividc.mapper.search.attempt import (
    map_decoupled,
    map_jointly,
    map_negotiated_if_slow,
    refute_by_folding,
    refute_now_and_then,
)
from vividc.mapper.search.climb import (
    climb_in_long_turns,
    climb_in_short_turns,
    descend,
    refute_below,
    try_only,
)
from vividc.mapper.search.negotiation import (
    negotiate_downward,
    negotiate_only,
    negotiate_upward,
    restart_below,
    solve_only_for_a_turn,
)
from vividc.mapper.search.strategy import Phase, Step, Strategy, run
from vividc.mapper.search.tuning import (
    DECOUPLED_SHARE,
    FOLDING_SHARE,
    NEGOTIATION_SHARE,
    PROOF_SHARE,
)
from vividc.mapper.search.warm_start import negotiate_at_bound, solve_at_bound, warm_start
from vividc.mapper.search.windows import search_windows, start_in_window

AUTO: Final = Strategy(
    "auto",
    steps=(
        Step(refute_now_and_then, PROOF_SHARE),
        Step(map_negotiated_if_slow, NEGOTIATION_SHARE, extended=False),
        Step(map_decoupled, DECOUPLED_SHARE),
        Step(refute_by_folding, FOLDING_SHARE),
        Step(map_jointly),
    ),
    phases=(
        Phase(start_in_window, "large", extended=False),
        Phase(negotiate_upward, "large", extended=False),
        Phase(negotiate_downward, "large", extended=False),
        Phase(restart_below, "large", extended=False),  # with windows
        Phase(climb_in_short_turns, "large", unless_mapped=True),
        Phase(negotiate_at_bound, "small", extended=False),
        Phase(solve_at_bound, "small", extended=False),
        Phase(warm_start, "small", extended=False),
        Phase(search_windows, "small"),
        Phase(climb_in_short_turns, "small"),
        Phase(descend),
    ),
    only=(
        Phase(solve_only_for_a_turn, "small", extended=False),
        Phase(negotiate_only, extended=False),
        Phase(try_only),
        Phase(refute_below),
    ),
)

CPSAT: Final = Strategy(
    "cpsat",
    steps=(Step(refute_now_and_then, PROOF_SHARE), Step(map_jointly)),
    phases=(
        Phase(negotiate_upward, "large", extended=False),
        Phase(climb_in_long_turns),
        Phase(descend),
    ),
    only=(Phase(try_only), Phase(refute_below)),
)

DECOUPLED: Final = Strategy(
    "decoupled",
    steps=(Step(refute_now_and_then, PROOF_SHARE), Step(map_decoupled)),
    phases=(Phase(search_windows), Phase(climb_in_long_turns), Phase(descend)),
    only=(Phase(try_only), Phase(refute_below)),
)


def auto(problem: MapProblem, request: MapRequest) -> MapResult:
    """Everything we have: negotiation where constraints take long, schedules before places,
    relaxations, the joint model, and windows of large arrays.
    """
    return run(AUTO, problem, request)


def cpsat(problem: MapProblem, request: MapRequest) -> MapResult:
    """The joint model, after the bounds and the scheduling relaxation; for large graphs negotiation
    gives a first mapping, which the model improves.
    """
    return run(CPSAT, problem, request)


def decoupled(problem: MapProblem, request: MapRequest) -> MapResult:
    """Schedule first, then place and route, for graphs of any size, in windows of large arrays
    first; "optimal" only where bounds and the relaxation prove it.
    """
    return run(DECOUPLED, problem, request)
