"""Modulo scheduling without placement: a relaxation that refutes an II, and the first half of the
decoupled way.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations, product

from ortools.sat.python.cp_model import CpModel, IntVar, LinearExpr, LinearExprT

from vividc.dfg.ir import Node
from vividc.machine.opcodes import BASE, Opcode
from vividc.mapper.bounds.bounds import hall_sets, usable_pes
from vividc.mapper.engines.cpsat.objective import carrying_cost
from vividc.mapper.engines.cpsat.output_cells import cells_suffice
from vividc.mapper.engines.cpsat.problem import Prepared, is_live_out, last_useful_stage, windowed
from vividc.mapper.engines.cpsat.run import Outcome, Search, run
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.dependences import dependences
from vividc.mapper.resources.distances import hop_distances, hops_a_cycle


@dataclass(frozen=True, slots=True)
class ScheduleOptions:
    """How the schedules of the decoupled mapper differ.

    Attributes
    ----------
    easy_life
        Cycles between result and read that cost nothing.
    slack
        Cycles that the schedule may be longer than the longest path.
    seed
        Seeds the weights of the edges; 0 weighs all alike.
    carry
        Minimise the cost of carrying words; else take any schedule.
    spread
        Keep accesses that step through one array out of each other's banks, where stalls would
        follow; a preference, so a schedule that is not found this way may exist.
    """

    easy_life: int = 1
    slack: int = 4
    seed: int = 0
    carry: bool = True
    spread: bool = False


@dataclass(frozen=True, slots=True)
class _Times:
    """Start of each node as an expression, and for each slot the literals of which one says "starts
    there".
    """

    start: Mapping[int, IntVar]
    in_slot: Mapping[int, Sequence[Sequence[IntVar]]]
    at: Mapping[int, Mapping[int, IntVar]] = field(default_factory=dict)

    def read(self, value: Callable[[LinearExprT], int]) -> dict[int, int]:
        """The schedule of a solution."""
        return {node: value(start) for node, start in self.start.items()}


def refute_schedule(task: MapProblem, ii: int, search: Search) -> Outcome[dict[int, int]]:
    """Look for any schedule at all: issue, completion, control and live-out slots, and dependences.

    It drops places and routes but for Hall's condition and the fan-out of a word in its first
    cycle; with stages up to `last_useful_stage` it loses no mapping, so "refuted" means that the II
    is impossible.
    """
    model = CpModel()
    times = _slots_and_stages(model, task, ii)
    _constrain(model, task, ii, times)
    return run(model, search, times.read)


def schedule(
    task: MapProblem, ii: int, options: ScheduleOptions, search: Search
) -> Outcome[dict[int, int]]:
    """A schedule with words that are easy to carry. "refuted" only says that it may take longer
    than `slack` allows.
    """
    problem = windowed(task, ii, options.slack)
    model = CpModel()
    times = _times_in_windows(model, problem)
    _constrain(model, task, ii, times)
    if options.spread:
        _streams_spare_banks(model, task, ii, times)
    if options.carry:
        _minimise_carrying(model, problem, times, options)
    return run(model, search, times.read)


def _minimise_carrying(
    model: CpModel, problem: Prepared, times: _Times, options: ScheduleOptions
) -> None:
    draw = random.Random(options.seed)
    lives = {}
    for index, edge in enumerate(problem.dependences):
        if edge.routed:
            way = times.start[edge.dst] - times.start[edge.src]
            lives[index] = (edge, way + problem.ii * edge.distance - edge.latency)
    weights = {index: 4 + (draw.randint(0, 8) if options.seed else 0) for index in lives}
    longest = max((window.last for window in problem.windows.values()), default=0)
    longest += problem.ii * max((edge.distance for edge, _ in lives.values()), default=0)
    carrying_cost(model, lives, weights, options.easy_life, longest)


def _slots_and_stages(model: CpModel, task: MapProblem, ii: int) -> _Times:
    """Start = slot + II * stage: few literals even for very long schedules."""
    last_stage = last_useful_stage(task, ii)
    starts: dict[int, IntVar] = {}
    in_slot: dict[int, list[list[IntVar]]] = {}
    for node in task.dfg.placed:
        literals = [model.new_bool_var(f"in_slot[{node.id},{slot}]") for slot in range(ii)]
        model.add_exactly_one(literals)
        start = model.new_int_var(0, ii * (last_stage + 1) - 1, f"start[{node.id}]")
        stage = model.new_int_var(0, last_stage, f"stage[{node.id}]")
        model.add(start == LinearExpr.weighted_sum([*literals, stage], [*range(ii), ii]))
        starts[node.id] = start
        in_slot[node.id] = [[literal] for literal in literals]
    return _Times(starts, in_slot)


def _times_in_windows(model: CpModel, problem: Prepared) -> _Times:
    """One literal per start time: propagates best while windows are short."""
    starts: dict[int, IntVar] = {}
    in_slot: dict[int, list[list[IntVar]]] = {}
    at: dict[int, dict[int, IntVar]] = {}
    for node, window in problem.windows.items():
        start = model.new_int_var(window.first, window.last, f"start[{node}]")
        literals = [model.new_bool_var(f"start_is[{node},{t}]") for t in window.times]
        model.add_exactly_one(literals)
        model.add(start == LinearExpr.weighted_sum(literals, list(window.times)))
        starts[node] = start
        in_slot[node] = [[] for _ in range(problem.ii)]
        at[node] = dict(zip(window.times, literals, strict=True))
        for time, literal in zip(window.times, literals, strict=True):
            in_slot[node][time % problem.ii].append(literal)
    return _Times(starts, in_slot, at)


def _constrain(model: CpModel, task: MapProblem, ii: int, times: _Times) -> None:
    _slots_fit_pes(model, task, times, ii)
    _control_results_differ(model, task, times, ii)
    _accesses_fit_banks(model, task, times, ii)
    for edge in dependences(task.dfg, task.fabric):
        model.add(times.start[edge.dst] >= times.start[edge.src] + edge.weight(ii))
    _first_reads_fit_neighbours(model, task, times.start, ii)
    cells_suffice(model, task, ii, times.start, times.in_slot)


def _slots_fit_pes(model: CpModel, task: MapProblem, times: _Times, ii: int) -> None:
    """For each set S of PEs: operations that only S can take issue, and complete, at most |S| a
    slot.
    """
    for nodes in (task.dfg.operations, tuple(n for n in task.dfg.placed if is_live_out(n))):
        candidates = {node.id: frozenset(usable_pes(task, node)) for node in nodes}
        for pes in hall_sets(candidates.values()) if nodes else ():
            users = [node for node in nodes if candidates[node.id] <= pes]
            if sum(task.fabric.occupancy(node) for node in users) <= len(pes):
                continue
            same = len({task.fabric.latency(node) for node in users}) == 1
            for slot in range(ii):
                issued = _keeping_fus(task, users, times, slot, ii)
                model.add(LinearExpr.sum(issued) <= len(pes))
                if not same:  # else they complete as evenly as they issue
                    model.add(LinearExpr.sum(_completing(task, users, times, slot, ii)) <= len(pes))


def _keeping_fus(
    task: MapProblem, nodes: Iterable[Node], times: _Times, slot: int, ii: int
) -> list[IntVar]:
    """Literals of the nodes whose FU can issue nothing else in `slot`."""
    return [
        literal
        for node in nodes
        for cycle in range(task.fabric.occupancy(node))
        for literal in times.in_slot[node.id][(slot - cycle) % ii]
    ]


def _completing(
    task: MapProblem, nodes: Iterable[Node], times: _Times, slot: int, ii: int
) -> list[IntVar]:
    """Literals of the nodes whose results are ready in `slot`."""
    return [
        literal
        for node in nodes
        for literal in times.in_slot[node.id][(slot - task.fabric.latency(node)) % ii]
    ]


def _control_results_differ(model: CpModel, task: MapProblem, times: _Times, ii: int) -> None:
    users: list[Node] = [node for node in task.dfg.nodes if node.control is not None]
    if len(users) <= 1:
        return
    for slot in range(ii):
        model.add_at_most_one(_completing(task, users, times, slot, ii))


def _accesses_fit_banks(model: CpModel, task: MapProblem, times: _Times, ii: int) -> None:
    users = [node.id for node in task.dfg.nodes if node.is_memory]
    banks = task.fabric.scratchpad.banks
    if len(users) <= banks:
        return
    for slot in range(ii):
        model.add(LinearExpr.sum([x for n in users for x in times.in_slot[n][slot]]) <= banks)


def _streams_spare_banks(model: CpModel, task: MapProblem, ii: int, times: _Times) -> None:
    """Two accesses that step through one array are never in the same slot and bank.

    In one cycle, an access that starts n * II cycles later than another sees the bytes n steps
    behind.
    """
    scratchpad = task.fabric.scratchpad
    streams: dict[tuple[str, int, int], list[Node]] = {}
    for node in task.dfg.nodes:
        word, base = task.dfg.operand(node.id, 0), task.dfg.operand(node.id, BASE)
        if not node.is_memory or word is None or base is None:
            continue
        if task.dfg.by_id[word.src].op is Opcode.IV:
            streams.setdefault((node.name, base.src, node.shift), []).append(node)
    for (_, _, shift), nodes in streams.items():
        step = 1 << shift
        for one, other in combinations(nodes, 2):
            ahead = one.offset - other.offset
            for (t, first), (u, second) in product(
                times.at[one.id].items(), times.at[other.id].items()
            ):
                if (t - u) % ii == 0 and scratchpad.may_meet(ahead - step * (t - u) // ii):
                    model.add_at_most_one(first, second)


def _first_reads_fit_neighbours(
    model: CpModel, task: MapProblem, starts: Mapping[int, IntVar], ii: int
) -> None:
    """A word is read in its first cycle on its own PE and at the ends of that PE's links only (of
    the links that it passes in one cycle), once on each.

    For operations only: a live-out may be read beside an operation of the same PE.
    """
    near = max(hops_a_cycle(task.fabric), 1)
    room = max(sum(hops <= near for hops in row) for row in hop_distances(task.fabric))
    pairs = dict.fromkeys(
        (edge.src, edge.dst, edge.distance, edge.latency)
        for edge in dependences(task.dfg, task.fabric)
        if edge.routed and task.dfg.by_id[edge.dst].uses_fu
    )
    fan_out = Counter(src for src, *_ in pairs)
    early: dict[int, list[IntVar]] = {}
    for src, dst, distance, latency in pairs:
        if fan_out[src] <= room:
            continue
        first = model.new_bool_var(f"first[{src},{dst},{distance}]")
        later = starts[dst] + ii * distance >= starts[src] + latency + 1
        model.add(later).only_enforce_if(~first)
        early.setdefault(src, []).append(first)
    for literals in early.values():
        model.add(LinearExpr.sum(literals) <= room)
