"""Improves a mapping at its II: the same model of time, place and route, now with an objective."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable
from dataclasses import replace
from typing import Final

from ortools.sat.python.cp_model import IntVar, LinearExpr, LinearExprT

from vividc.mapper.engines.cpsat.handle import Extension, ModelHandle
from vividc.mapper.engines.cpsat.problem import Prepared, windowed
from vividc.mapper.engines.cpsat.run import Search, run
from vividc.mapper.engines.cpsat.solve import JointModel, build, solved
from vividc.mapper.mapping import Mapping, Objective
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.dependences import dependences, earliest_starts, longest_tails
from vividc.mapper.resources.fu_slots import moved

_MOST_BOOLEANS: Final = 300_000
_ROUNDING: Final = 1e-6


def minimise(
    task: MapProblem,
    mapping: Mapping,
    objective: str | None,
    extend: Extension | None,
    search: Search,
) -> tuple[Mapping, Objective | None]:
    """Minimise the named objective, and what `extend` asks to minimise, at the mapping's II.

    Schedules are considered up to the length of the mapping's own. The mapping is the solver's
    first hint, and is kept where nothing better is found. No objective: nothing was to minimise.
    """
    problem, last_issue = _around(task, mapping)
    name = objective or "added objective"
    before = None if objective is None else measure(task, mapping, objective)
    nothing = Objective(name, before, before, None, last_issue)
    if problem.size > _MOST_BOOLEANS or search.deadline.passed:
        return mapping, nothing
    joint = build(problem)
    handle = ModelHandle(joint.model, problem, joint.variables, [])
    if extend is not None:
        extend(handle)
    added = bool(handle.objectives)
    if objective is not None:
        handle.minimize(OBJECTIVES[objective](handle))
    if not handle.objectives:
        return mapping, None
    handle.model.minimize(LinearExpr.sum(handle.objectives))
    _hint(joint, problem, mapping)
    _complete_hint(joint, search)
    outcome = solved(problem, joint, search)
    if outcome.value is None:
        return mapping, nothing
    bound = math.ceil(outcome.bound - _ROUNDING)
    if added or objective is None:
        name = " + ".join(part for part in ("added objective", objective) if part)
        return outcome.value, Objective(name, round(outcome.objective), None, bound, last_issue)
    value = measure(task, outcome.value, objective)
    return outcome.value, Objective(name, value, before, bound, last_issue)


def measure(task: MapProblem, mapping: Mapping, objective: str) -> int:
    """The value of a named objective, read from a mapping."""
    if objective == "length":
        nodes = task.dfg.by_id
        ends = (p.time + task.fabric.latency(nodes[n]) for n, p in mapping.places.items())
        return max(ends, default=0)
    words = {
        (task.dfg.edges[edge].src, step) for edge, route in mapping.routes.items() for step in route
    }
    if objective == "hops":
        moves = moved(task.dfg, task.fabric, mapping).values()
        return sum(step.kind == "link" for _, step in words) + sum(map(len, moves))
    held: dict[tuple[int, int], int] = defaultdict(int)
    for _, step in words:
        held[step.pe, step.time % mapping.ii] += step.kind == "reg"
    most: dict[int, int] = defaultdict(int)
    for (pe, _), count in held.items():
        most[pe] = max(most[pe], count)
    return sum(most.values())


def _around(task: MapProblem, mapping: Mapping) -> tuple[Prepared, int]:
    """Windows that hold every schedule no longer than the mapping's, and that length: the last
    issue.
    """
    nodes = tuple(node.id for node in task.dfg.placed)
    edges = dependences(task.dfg, task.fabric)
    first = earliest_starts(nodes, edges, mapping.ii) or {}
    tails = longest_tails(nodes, edges, mapping.ii)
    least = max((first[node] + tails[node] for node in nodes), default=0)
    wanted = max((mapping.places[node].time + tails[node] for node in nodes), default=0)
    return windowed(task, mapping.ii, wanted - least), wanted


def _hint(joint: JointModel, problem: Prepared, mapping: Mapping) -> None:
    """Start the solver at the mapping: all starts, and where its words are."""
    v = joint.variables
    for (node, pe, time), literal in v.start.items():
        joint.model.add_hint(
            literal, (pe, time) == (mapping.places[node].pe, mapping.places[node].time)
        )
    edges = problem.task.dfg.edges
    steps = [(edges[i].src, step) for i, route in mapping.routes.items() for step in route]
    links = {(word, step.index, step.time) for word, step in steps if step.kind == "link"}
    held = {(word, step.pe, step.time) for word, step in steps if step.kind == "reg"}
    for key, literal in v.link.items():
        joint.model.add_hint(literal, key in links)
    for key, literal in v.held.items():
        joint.model.add_hint(literal, key in held)


def _complete_hint(joint: JointModel, search: Search) -> None:
    """Hint every variable: what the mapping leaves open follows from a solve with its own fixed."""
    model = joint.model
    variables = [model.get_int_var_from_proto_index(i) for i in range(len(model.proto.variables))]
    search = replace(search, light=True, as_hinted=True)
    known = run(model, search, lambda value: [value(variable) for variable in variables])
    if known.value is None:
        return
    model.clear_hints()  # type: ignore[no-untyped-call]
    for variable, value in zip(variables, known.value, strict=True):
        model.add_hint(variable, value)


def registers(handle: ModelHandle) -> LinearExprT:
    """Registers used: the sum over PEs of the most words that the file holds in a slot (MaxLive,
    Rau et al. 1992).
    """
    slots: dict[int, dict[int, list[IntVar]]] = defaultdict(lambda: defaultdict(list))
    for (_, pe, time), literal in handle.variables.held.items():
        slots[pe][time % handle.ii].append(literal)
    used = []
    for pe, groups in slots.items():
        most = handle.model.new_int_var(0, handle.problem.fabric.pes[pe].registers, f"used[{pe}]")
        for literals in groups.values():
            handle.model.add(LinearExpr.sum(literals) <= most)
        used.append(most)
    return LinearExpr.sum(used)


def hops(handle: ModelHandle) -> LinearExprT:
    """Links driven and moves made for one iteration: what carrying words costs in energy."""
    return handle.hops()


def length(handle: ModelHandle) -> LinearExprT:
    """Cycles from the start of an iteration to its last result."""
    problem = handle.problem
    latest = max(
        (problem.windows[n.id].last + problem.latency[n.id] for n in problem.nodes), default=0
    )
    end = handle.model.new_int_var(0, latest, "length")
    for node in problem.nodes:
        handle.model.add(end >= handle.start(node.id) + problem.latency[node.id])
    return end


OBJECTIVES: Final[dict[str, Callable[[ModelHandle], LinearExprT]]] = {
    "registers": registers,
    "hops": hops,
    "length": length,
}
