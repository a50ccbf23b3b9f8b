"""How published mappers search: from the MII upward, the first II that maps is the answer.

Every mapper of this kind brings one function for one II. What it cannot map it has not refuted:
lower bounds come from `bounds` alone, unless the function proves more.
"""

from __future__ import annotations

from vividc.arch.fabric import Fabric
from vividc.errors import VividcError
from vividc.mapper.mapping import Mapping
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.plain_core import named_anew, plain_core
from vividc.mapper.search.climb import try_only_once
from vividc.mapper.search.state import Attempt, IISearch, TryII, ii_limit
from vividc.mapper.search.strategy import Phase, Step, Strategy
from vividc.mapper.search.tuning import UPWARD_LEAST_S, UPWARD_SHARE, UPWARD_STEP


def upward(name: str, try_ii: TryII) -> Strategy:
    """The strategy of a mapper that takes the first II that maps."""
    return Strategy(name, (Step(try_ii),), (Phase(go_upward),), (Phase(try_only_once),))


def go_upward(search: IISearch) -> None:
    """Try each II from the MII on, each with a share of the time that is left; past a few failures
    the steps grow with the II, so that some II maps.
    """
    deadline, limit = search.request.deadline, ii_limit(search.problem)
    ii = search.lower
    while ii <= limit and search.incumbent is None and not deadline.passed:
        share_s = max(UPWARD_LEAST_S, deadline.remaining_s * UPWARD_SHARE)
        search.try_ii(ii, deadline.within(share_s))
        ii += 1 + (ii - search.lower) // UPWARD_STEP


def core_for(fabric: Fabric, name: str) -> Fabric:
    """The part of a fabric that a router over the MRRG can use.

    Raises
    ------
    VividcError
        Words reach other PEs in ways that the MRRG does not have.
    """
    core = plain_core(fabric)
    if core is None:
        raise VividcError(
            f"mapper {name!r} routes words over links and registers that any word may enter, and "
            f"issues an operation a cycle on each PE; on {fabric.name} {_what_is_else(fabric)}",
            loc="mapper",
            hint="use auto, cpsat, decoupled, sat-kms or spr",
        )
    return core


def _what_is_else(fabric: Fabric) -> str:
    """Why a fabric has no plain core."""
    slow = [kind.value for kind, cycles in fabric.occupancies.items() if cycles > 1]
    if not fabric.routing.hops:
        return "no words take links"
    if slow:
        return f"units are not pipelined ({', '.join(slow)})"
    return "only its own FU writes a PE's registers"


def attempt_of(problem: MapProblem, mapping: Mapping | None) -> Attempt:
    """A mapping to the core of a fabric, in the fabric's own names, as an attempt."""
    named = None if mapping is None else named_anew(problem, mapping)
    return Attempt(mapping=named)
