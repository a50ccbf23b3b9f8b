"""`map_dfg`: the mapper's front door."""

from __future__ import annotations

import time
from collections.abc import Mapping as ReadOnly
from dataclasses import replace

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG
from vividc.errors import InternalError, VividcError, demand_type
from vividc.mapper.cpsat import OBJECTIVES, Extension, Search, minimise
from vividc.mapper.deadline import Deadline
from vividc.mapper.mapping import MapResult, Subject
from vividc.mapper.problem import ConstantKey, MapProblem
from vividc.mapper.registry import find_mapper, takes_constraints
from vividc.mapper.request import MapRequest, Progress
from vividc.mapper.verify import violations

_SHOWN = 5
_SHARE_BEFORE = 0.6
"""Share of the time for the II, where something is to be minimised after it."""
_SHARE_EXTENDED = 0.85
"""The same where only a caller's constraints may ask for it."""


def map_dfg(  # noqa: PLR0913 - the public contract, plus keywords
    dfg: DFG,
    fabric: Fabric,
    mapper: str = "auto",
    ii: int | None = None,
    time_limit_s: float = 60.0,
    *,
    allowed: ReadOnly[int, frozenset[int]] | None = None,
    resident: ReadOnly[int, frozenset[ConstantKey]] | None = None,
    workers: int = 2,
    progress: Progress | None = None,
    thrifty: bool = False,
    extend: Extension | None = None,
    objective: str | None = None,
) -> MapResult:
    """Map a loop's DFG onto a fabric with the least II that can be found, and say what was proved
    about it.

    Parameters
    ----------
    dfg, fabric
        What to map onto what. The DFG is taken to be well-formed (`vividc.dfg.check`).
    mapper
        "auto", "cpsat" (joint model only), "decoupled", "sat-kms", "ims", "spr", or a registered
        one.
    ii
        The only II to try. None: the least.
    time_limit_s
        Wall-clock limit in seconds.
    allowed
        PEs that a node may lie on, by node id; nodes not named are free.
    resident
        Constant-store entries that other regions hold, by PE.
    workers
        Threads the solver may use. With 1 and no limit reached a run can be repeated exactly.
    progress
        Called with one line at each step.
    thrifty
        Do not use the whole limit on a large graph when its II is within 1 of the bound and nothing
        better has been found for a while.
    extend
        Called with a `ModelHandle` for each model that is built; adds constraints, and may ask for
        something to be minimised. Only for mappers that solve the joint model.
    objective
        What to minimise at the II, with what is left of the time: "registers", "hops" or "length".

    Returns
    -------
    MapResult
        "optimal" only if every smaller II was refuted; "infeasible" only if no II (or not the
        given one) works; both within the added constraints, if there are any (`claim`). Every
        mapping in it has passed `verify`.

    Raises
    ------
    VividcError
        Unknown mapper or objective, or an II, time limit or worker count that makes no sense, or
        constraints for a mapper that takes none.
    InternalError
        The mapper returned an illegal mapping.
    """
    demand_type(dfg, DFG, "the DFG", "load one with vividc.dfg.load")
    demand_type(fabric, Fabric, "the fabric", "load one with vividc.arch.load")
    _check(ii, time_limit_s, workers)
    run = find_mapper(mapper)
    _check_door(mapper, extend, objective)
    problem = MapProblem(dfg, fabric, allowed or {}, resident or {})
    deadline = Deadline.after(time_limit_s)
    share = 1.0 if extend is None else _SHARE_EXTENDED
    first = deadline.within(time_limit_s * (share if objective is None else _SHARE_BEFORE))
    request = MapRequest(ii, first, workers, progress, thrifty, extend)
    began = time.monotonic()
    result = run(problem, request)
    if result.mapping is not None and (extend is not None or objective is not None):
        _confirm(problem, result)
        result = _minimised(problem, result, objective, replace(request, deadline=deadline))
        result = replace(result, wall_s=time.monotonic() - began)
    _confirm(problem, result)
    return _about(result, Subject(dfg, fabric))


def _minimised(
    problem: MapProblem, result: MapResult, objective: str | None, request: MapRequest
) -> MapResult:
    if result.mapping is None:
        return result
    request.tell(f"II {result.ii}: minimising {objective or 'what was added'}")
    search = Search(request.deadline, request.workers)
    mapping, found = minimise(problem, result.mapping, objective, request.extend, search)
    return replace(result, mapping=mapping, objective=found)


def _check_door(mapper: str, extend: Extension | None, objective: str | None) -> None:
    if objective is not None and objective not in OBJECTIVES:
        known = ", ".join(OBJECTIVES)
        raise VividcError(
            f"unknown objective {objective!r}", loc="objective", hint=f"choose one of: {known}"
        )
    if extend is None:
        return
    if not callable(extend):
        raise VividcError(
            "extend is not callable", loc="extend", hint="pass a function of a ModelHandle"
        )
    if not takes_constraints(mapper):
        hint = "use one that solves the joint model: auto, cpsat or decoupled"
        raise VividcError(f"mapper {mapper!r} takes no constraints", loc="extend", hint=hint)


def check_time_limit(time_limit_s: float) -> None:
    """Refuse a time limit that is not a positive number of seconds."""
    demand_type(time_limit_s, (int, float), "the time limit", "give seconds as a number")
    if not time_limit_s > 0:
        raise VividcError(
            f"the time limit must be positive, not {time_limit_s}", loc="time_limit_s"
        )


def _check(ii: int | None, time_limit_s: float, workers: int) -> None:
    if ii is not None:
        demand_type(ii, int, "the II", "give a whole number of cycles")
        if ii < 1:
            raise VividcError(f"the II must be 1 or more, not {ii}", loc="ii")
    check_time_limit(time_limit_s)
    if workers < 1:
        raise VividcError(f"at least 1 worker is needed, not {workers}", loc="workers")


def _about(result: MapResult, subject: Subject) -> MapResult:
    mapping = result.mapping
    known = None if mapping is None else replace(mapping, subject=subject)
    return replace(result, mapping=known, subject=subject)


def _confirm(problem: MapProblem, result: MapResult) -> None:
    if result.mapping is None:
        return
    found = violations(
        problem.dfg,
        problem.fabric,
        result.mapping,
        allowed=problem.allowed,
        resident=problem.resident,
    )
    if found:
        shown = "; ".join(str(violation) for violation in found[:_SHOWN])
        raise InternalError(
            f"mapper {result.mapper!r} made an illegal mapping of {problem.dfg.name!r}: {shown}"
        )
