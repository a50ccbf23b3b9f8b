"""`map_dfg`: the mapper's front door."""

from __future__ import annotations

import inspect
import time
from collections.abc import Mapping as ReadOnly
from collections.abc import Set as AbstractSet
from dataclasses import replace
from typing import get_args

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG
from vividc.errors import (
    InternalError,
    VividcError,
    demand_callable,
    demand_type,
    printable,
    quoted,
)
from vividc.host.watch import heard, seldom, to_tell
from vividc.mapper.check.case import Violation
from vividc.mapper.check.certificate import check_certificate
from vividc.mapper.check.verify import violations
from vividc.mapper.deadline import limited
from vividc.mapper.engines import cpsat
from vividc.mapper.mapping import Status, Subject
from vividc.mapper.problem import ConstantKey, MapProblem
from vividc.mapper.registry import BUILT_IN, find_mapper, guest_fault, named, takes_constraints
from vividc.mapper.request import EFFORT_LEVELS, EffortLevel, Mapper, MapRequest, Progress
from vividc.mapper.result import MapInterrupted, MapResult
from vividc.mapper.search.tuning import SHARE_BEFORE_OBJECTIVE, SHARE_EXTENDED

_SHOWN = 5
_MOST_WORKERS = 1000


def map_dfg(  # noqa: PLR0913 - the public contract, plus keywords
    dfg: DFG,
    fabric: Fabric,
    mapper: str | Mapper = "auto",
    ii: int | None = None,
    time_limit_s: float = 60.0,
    *,
    allowed: ReadOnly[int, frozenset[int]] | None = None,
    resident: ReadOnly[int, frozenset[ConstantKey]] | None = None,
    workers: int = 2,
    progress: Progress | None = None,
    effort: EffortLevel = "prove",
    part: float = 1.0,
    extend: cpsat.Extension | None = None,
    objective: str | None = None,
) -> MapResult:
    """Map a loop's DFG onto a fabric with the least II that can be found, and say what was proved
    about it: "optimal" only if every smaller II was refuted, "infeasible" only if no II (or not the
    given one) works, both within the added constraints (`claim`). Every mapping is verified.

    Parameters
    ----------
    mapper, ii
        A name of the registry, or a function (MapProblem, MapRequest) -> MapResult, and the only II
        to try; None: the least.
    time_limit_s
        Limit in seconds: it buys an effort (`mapper/deadline.py`) that takes less on a typical
        machine, and is what the clock allows at most (`MapResult.hurried`). Unhurried, a run
        repeats exactly.
    effort
        Where to stop before that, by work that is counted and never timed: "fast" at the first good
        mapping, "normal" where more work rarely pays, "thorough" where none is expected to, "prove"
        once every smaller II is refuted.
    part
        Of the patience of "normal", from 0 to 1, that a search has which shares it with others.
    allowed, resident
        By node id the PEs that it may lie on; by PE the constants that other regions hold there.
    extend, objective
        Adds constraints to each model that is built (`ModelHandle`), for mappers that solve one;
        what to minimise at the II with the time left: "registers", "hops" or "length".

    Raises
    ------
    VividcError
        A name is unknown, a number makes no sense, or the mapper takes no constraints.
    InternalError
        A mapper of ours returned an illegal mapping. (What a guest does wrong is a VividcError.)
    MapInterrupted
        An interrupt (a KeyboardInterrupt, Ctrl-C) came when there was a mapping: `result` has it.
    """
    _check(dfg, fabric, ii, time_limit_s, workers)
    _check_part(part)
    mapper = named(mapper)
    demand_callable(progress, "progress")
    run = find_mapper(mapper)
    _check_door(mapper, extend, objective)
    check_effort(effort)
    allowed, resident = {} if allowed is None else allowed, {} if resident is None else resident
    _check_places(dfg, fabric, allowed, resident)
    problem = MapProblem(dfg, fabric, allowed, resident)
    try:
        with limited(time_limit_s) as deadline:
            tell = to_tell(progress)
            request = MapRequest(ii, deadline, workers, tell, effort, extend, part=part)
            began, spent = time.monotonic(), deadline.meter.spent_s
            result = _mapped(problem, run, request, objective)
            if mapper not in BUILT_IN:  # what a guest does is known by the clock only
                counted_s = deadline.meter.spent_s - spent
                deadline.charge(max(0.0, time.monotonic() - began - counted_s))
            hurried = deadline.meter.hurried
    except MapInterrupted as stop:
        _confirm(problem, stop.result, mapper)
        raise MapInterrupted(about(stop.result, problem)) from stop
    _confirm(problem, result, mapper)
    stats = {**result.stats, "effort_s": deadline.meter.spent_s - spent}
    return about(replace(result, hurried=hurried, stats=stats), problem)


@seldom()
@heard()
def _mapped(
    problem: MapProblem, run: Mapper, request: MapRequest, objective: str | None
) -> MapResult:
    """The mapper's result, improved at its II in the time that is left."""
    share = _share_of_the_ii(request.extend, objective)
    deadline = request.deadline.within(request.deadline.remaining_s * share)
    began = time.monotonic()
    result = run(problem, replace(request, deadline=deadline))
    if share < 1 and not _violations(problem, result):
        result = _minimised(problem, result, objective, request)
        result = replace(result, wall_s=time.monotonic() - began)
    return result


def _share_of_the_ii(extend: cpsat.Extension | None, objective: str | None) -> float:
    """The search's share of the time; the rest is for what is minimised at the II."""
    if objective is not None:
        return SHARE_BEFORE_OBJECTIVE
    return 1.0 if extend is None else SHARE_EXTENDED


def _minimised(
    problem: MapProblem, result: MapResult, objective: str | None, request: MapRequest
) -> MapResult:
    if result.mapping is None:
        return result
    search = cpsat.Search(request.deadline, request.workers)
    try:
        request.tell(f"II {result.ii}: minimising {objective or 'the added objective'}")
        mapping, minimum = cpsat.minimise(
            problem, result.mapping, objective, request.extend, search
        )
    except KeyboardInterrupt as stop:
        raise MapInterrupted(result) from stop
    return replace(result, mapping=mapping, objective=minimum)


def _check_door(mapper: str, extend: cpsat.Extension | None, objective: str | None) -> None:
    if objective is not None:
        demand_type(
            objective, str, "the objective", f"choose one of: {', '.join(cpsat.OBJECTIVES)}"
        )
    if objective is not None and objective not in cpsat.OBJECTIVES:
        known = ", ".join(cpsat.OBJECTIVES)
        raise VividcError(
            f"unknown objective {objective!r}", loc="objective", hint=f"choose one of: {known}"
        )
    if extend is None:
        return
    if not callable(extend):
        raise VividcError(
            "extend is not callable", loc="extend", hint="pass a function of a ModelHandle"
        )
    try:
        inspect.signature(extend).bind(None)
    except TypeError as error:
        reason = f"extend cannot be called with one argument: {error}"
        raise VividcError(reason, loc="extend", hint="pass a function of a ModelHandle") from error
    except ValueError:  # a function of C that does not say what it takes
        pass
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


def _check_part(part: float) -> None:
    demand_type(part, (int, float), "the part of the patience", "give a number from 0 to 1")
    if not 0 <= part <= 1:
        raise VividcError(f"the part of the patience is from 0 to 1, not {part}", loc="part")


def check_effort(effort: str) -> None:
    """Refuse what is no effort."""
    known = ", ".join(EFFORT_LEVELS)
    demand_type(effort, str, "the effort", f"choose one of: {known}")
    if effort not in EFFORT_LEVELS:
        raise VividcError(
            f"unknown effort {quoted(effort)}", loc="effort", hint=f"choose one of: {known}"
        )


def _check(dfg: DFG, fabric: Fabric, ii: int | None, time_limit_s: float, workers: int) -> None:
    demand_type(dfg, DFG, "the DFG", "load one with vividc.dfg.load")
    demand_type(fabric, Fabric, "the fabric", "load one with vividc.arch.load")
    if ii is not None:
        demand_type(ii, int, "the II", "give a whole number of cycles")
        if ii < 1:
            raise VividcError(f"the II must be 1 or more, not {ii}", loc="ii")
    check_time_limit(time_limit_s)
    demand_type(workers, int, "the number of workers", "give a whole number of threads")
    if not 1 <= workers <= _MOST_WORKERS:
        hint = f"give 1 to {_MOST_WORKERS}; there is no use for more than one per core"
        raise VividcError(f"{workers} workers are not possible", loc="workers", hint=hint)


def _check_places(
    dfg: DFG,
    fabric: Fabric,
    allowed: ReadOnly[int, frozenset[int]],
    resident: ReadOnly[int, frozenset[ConstantKey]],
) -> None:
    """Refuse nodes that are not in the graph and PEs that are not in the fabric."""
    _check_sets(allowed, "allowed", "give the set of PEs of each node: {3: frozenset({0, 1})}")
    _check_sets(resident, "resident", "give the set of constants of each PE")
    nodes = sorted(allowed.keys() - {node.id for node in dfg.nodes}, key=str)
    if nodes:
        hint = "name nodes by their ids in the DFG"
        raise VividcError(
            f"{printable(dfg.name)} has no node {quoted(nodes[0])}", loc="allowed", hint=hint
        )
    named = {"allowed": frozenset().union(*allowed.values()), "resident": resident.keys()}
    for loc, pes in named.items():
        absent = sorted(pes - {pe.id for pe in fabric.pes}, key=str)
        if absent:
            hint = f"PEs are 0 to {len(fabric.pes) - 1}"
            raise VividcError(f"{fabric.name} has no PE {quoted(absent[0])}", loc=loc, hint=hint)


def _check_sets(given: object, loc: str, hint: str) -> None:
    if not isinstance(given, ReadOnly):
        raise VividcError(f"{loc} cannot be {quoted(given)}", loc=loc, hint=hint)
    for key, members in given.items():
        if not isinstance(members, AbstractSet):
            reason = f"{loc} cannot have {quoted(members)} for {quoted(key)}: it is not a set"
            raise VividcError(reason, loc=loc, hint=hint)


def about(result: MapResult, problem: MapProblem) -> MapResult:
    """The result, said to be of this problem."""
    subject, mapping = _subject(problem), result.mapping
    known = None if mapping is None else replace(mapping, subject=subject)
    return replace(result, mapping=known, subject=subject)


def _subject(problem: MapProblem) -> Subject:
    """What a result is about, copied so that a caller cannot change it afterwards."""
    return Subject(
        problem.dfg,
        problem.fabric,
        {node: frozenset(pes) for node, pes in problem.allowed.items()},
        {pe: frozenset(held) for pe, held in problem.resident.items()},
    )


def _confirm(problem: MapProblem, result: MapResult, mapper: str) -> None:
    """Refuse an illegal mapping: our bug, or one of the package that `mapper` comes from. A guest's
    claims must hold as well, as far as that can be checked without a solver.
    """
    faults = [str(violation) for violation in _violations(problem, result)]
    what = f"made an illegal mapping of {printable(problem.dfg.name)!r}"
    if mapper not in BUILT_IN and not faults:
        faults, what = _false_claims(problem, result), "makes false claims"
    if not faults:
        return
    what = f"{what}: {'; '.join(faults[:_SHOWN])}"
    if mapper in BUILT_IN:
        raise InternalError(f"mapper {mapper!r} {what}")
    raise guest_fault(mapper, what)


def _false_claims(problem: MapProblem, result: MapResult) -> list[str]:
    if result.status not in get_args(Status):
        return [f"there is no status {quoted(result.status)}"]
    findings = check_certificate(result, _subject(problem))
    return [finding.what for finding in findings if finding.verdict == "wrong"]


def _violations(problem: MapProblem, result: MapResult) -> list[Violation]:
    if result.mapping is None:
        return []
    return violations(
        problem.dfg,
        problem.fabric,
        result.mapping,
        allowed=problem.allowed,
        resident=problem.resident,
    )
