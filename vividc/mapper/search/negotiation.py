"""Ever smaller IIs by negotiation, then proofs for what is left.

Each step has a fixed effort and a fixed seed, and a deadline only cuts the sequence off: a longer
time limit goes the same way farther. The limit does not count the one compilation of the annealer.
"""

from __future__ import annotations

import math

from vividc.arch.fabric import Fabric
from vividc.mapper.deadline import Deadline
from vividc.mapper.engines.negotiate import Effort, annealing_s
from vividc.mapper.search.attempt import map_negotiated, refute_cheaply
from vividc.mapper.search.climb import first_turn
from vividc.mapper.search.state import Attempt, IISearch, ii_limit
from vividc.mapper.search.tuning import (
    BOUND_SHARE_WITH_MOVES,
    DESCENT,
    DESCENT_WITH_MOVES,
    DESCENTS,
    DESCENTS_WITH_MOVES,
    FIRST_PROOF_S,
    FIRST_SHARE,
    LARGE_STEP_WITH_MOVES,
    LONG,
    LONGER,
    LONGER_IF_FAR,
    PATIENCES,
    PROOF_S,
    PROVED_GRAPH,
    QUICK,
    ROOMY,
    SEEDED_NODES,
    SEEDS,
    SOLVED_GRAPH,
    SOLVED_LATER,
    SOLVER_S,
    STEP,
    STEP_WITH_MOVES,
    STEPPED_ARRAY,
)
from vividc.mapper.search.windows import windows, work_of


def negotiate_upward(search: IISearch) -> None:
    """Where nothing is mapped: an incumbent, from the bound upward; from above it on large arrays
    whose FUs move words, unless there is room enough at the bound.
    """
    if search.incumbent is not None:
        return
    fabric = search.problem.fabric
    share = BOUND_SHARE_WITH_MOVES if fabric.routing.moves else FIRST_SHARE
    if not _needs_large_steps(fabric) or _is_roomy(search):
        negotiate(search, search.lower, 1, QUICK, share)
    if search.incumbent is None:
        climb(search, ii_limit(search.problem))


def _needs_large_steps(fabric: Fabric) -> bool:
    return fabric.routing.moves and len(fabric.pes) >= STEPPED_ARRAY


def _is_roomy(search: IISearch) -> bool:
    """Whether operations take a small part of the array's slots at the bound."""
    return work_of(search.problem) <= ROOMY * len(search.problem.fabric.pes) * search.lower


def negotiate_downward(search: IISearch) -> None:
    """Smaller IIs in rounds of growing effort, and the bound as far as it is raised easily."""
    _raise_bound(search, first=True)
    moves = search.problem.fabric.routing.moves
    for turn, effort in enumerate(DESCENTS_WITH_MOVES if moves else DESCENTS):
        descend(search, effort, 1 + turn)
    _raise_bound(search, first=False)


def restart_below(search: IISearch) -> None:
    """The II just below the incumbent's, with other seeds and more effort in each round, then a
    window of the array, then the strategy's own steps at the bound (of large graphs only to
    prove); at last the windows that are left.
    """
    rectangles, turn = windows(search), 0
    while search.open_iis() and not search.deadline.passed:
        turn += 1
        if search.open_iis()[-1] <= search.far or _is_cut_short(search, turn):
            search.over = True
            break
        if _negotiate_seeds(search, search.open_iis()[-1], turn):
            turn = 0
            continue
        next(rectangles, None)
        if not search.unfinished:
            break
        nodes = len(search.problem.dfg.placed)
        solved = SOLVED_LATER if turn == 1 else SOLVED_GRAPH
        if search.request.effort != "prove" and nodes >= solved:
            continue
        budget_s = turn * SOLVER_S / nodes
        search.try_ii(search.open_iis()[0], search.deadline.within(budget_s))
    for _ in rectangles:
        pass


def negotiate_only(search: IISearch) -> None:
    """The II that is asked for, with some seeds."""
    for turn in range(1, SEEDS):
        if search.incumbent is None and search.only_ii not in search.refuted:
            _negotiate_seeds(search, search.only_ii, turn)


def solve_only_for_a_turn(search: IISearch) -> None:
    """The II that is asked for by the strategy's own steps, before negotiation: where it is far
    above the bound, many slots make constraints slow.
    """
    search.try_ii(search.only_ii, first_turn(search.request))


def negotiate(
    search: IISearch,
    ii: int,
    seed: int,
    effort: Effort,
    share: float = 1.0,
    longer: int | None = None,
) -> Attempt:
    """Negotiate an II, with a share of the time that is left at most; `longer`: see
    `map_negotiated`.
    """
    deadline = search.deadline.within(share * search.deadline.remaining_s)
    attempt = map_negotiated(search.problem, ii, search.request, deadline, seed, effort, longer)
    search.record(ii, attempt)
    return attempt


def climb(search: IISearch, limit: int) -> None:
    """Negotiate above the bound, each time twice as far above it, and farther after a long II that
    is far from a mapping, until one maps.
    """
    fabric = search.problem.fabric
    step = STEP_WITH_MOVES if fabric.routing.moves else STEP
    step = LARGE_STEP_WITH_MOVES if _needs_large_steps(fabric) else step
    above = math.ceil(step * search.lower)
    if_far = LONGER_IF_FAR if search.lower >= LONG else LONGER
    if search.far >= search.lower:
        above *= if_far // LONGER
    while not search.request.deadline.passed:
        ii = min(search.lower + above, limit)
        share = 1.0 if ii == limit else FIRST_SHARE
        attempt = negotiate(search, ii, 1, QUICK, share)
        if attempt.mapping is not None or ii == limit:
            return
        above *= if_far if attempt.is_far else LONGER


def descend(search: IISearch, effort: Effort, seed: int = 1) -> None:
    """Halve what is open below the incumbent's II (take a third where FUs move words and most of it
    will fail), as if all IIs above one that fails would map.
    """
    parts = DESCENT_WITH_MOVES if search.problem.fabric.routing.moves else DESCENT
    low = max(search.lower, search.far + 1)
    while search.incumbent is not None and low < search.incumbent.ii:
        if search.deadline.passed:
            return
        ii = search.incumbent.ii - math.ceil((search.incumbent.ii - low) / parts)
        if negotiate(search, ii, seed, effort).mapping is None:
            low = ii + 1


def _raise_bound(search: IISearch, *, first: bool) -> None:
    """Refute from below while that is easy; `first`: before the way downward."""
    while search.open_iis():
        before, budget = search.lower, _for_a_proof(search, first)
        if budget.passed:
            return
        search.record(before, refute_cheaply(search.problem, before, search.request, budget))
        if search.lower == before:
            return


def _for_a_proof(search: IISearch, first: bool) -> Deadline:
    """Of one, which is worth its effort or not, whatever patience is left."""
    request = search.request
    if request.effort == "prove":
        return search.deadline.within(FIRST_PROOF_S if first else PROOF_S)
    patience = PATIENCES[request.effort]
    seconds = patience.first_proof_s if first else patience.proof_s
    large = len(search.problem.dfg.placed) >= PROVED_GRAPH
    return request.deadline.within(0.0 if large else seconds)


def _is_cut_short(search: IISearch, turn: int) -> bool:
    """Whether patience would end before the annealing of this turn is cold: its places crowd."""
    if search.request.effort == "prove" or search.incumbent is None:
        return False
    return search.deadline.remaining_s < annealing_s(search.problem, _effort(turn))


def _negotiate_seeds(search: IISearch, ii: int, turn: int) -> bool:
    """Some seeds, with effort that grows from turn to turn; whether one maps."""
    effort = _effort(turn)
    for seed in _seeds(search, turn):
        if search.deadline.passed or _is_cut_short(search, turn):
            return False
        if negotiate(search, ii, seed, effort).mapping is not None:
            return True
    return False


def _effort(turn: int) -> Effort:
    return Effort(moves=Effort().moves * (1 + turn // 2), repairs=Effort().repairs * turn)


def _seeds(search: IISearch, turn: int) -> range:
    """As many as turns, up to `SEEDS`; where FUs move words, more for smaller graphs."""
    if not search.problem.fabric.routing.moves:
        return range(SEEDS * turn, SEEDS * turn + min(turn, SEEDS))
    each = math.ceil(SEEDED_NODES / len(search.problem.dfg.placed))
    first = 1 + len(DESCENTS_WITH_MOVES) + each * turn * (turn - 1) // 2
    return range(first, first + each * turn)
