"""The Boolean formulation of SAT-MapIt over the kernel mobility schedule (Tirelli et al. 2023).

x[v,p,t]: node v issues on PE p at time t, t within its mobility (ASAP .. ALAP), which folded by
the II is the kernel mobility schedule. C1: each node exactly once. C2: one node per PE and slot.
C3: a consumer is where its producer's word is in time: on the same PE, from a register, or next to
it; no word travels further, and none lives longer than II cycles. What the rest of this machine
demands of slots (completion, live-outs, control results) is added as C2 is.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from typing import Final

from ortools.sat.python.cp_model import CpModel, IntVar, LinearExpr

from vividc.mapper.deadline import Deadline
from vividc.mapper.engines.cpsat.constraints import (
    accesses_fit_banks,
    completions_differ,
    constants_fit_store,
    each_node_starts_once,
    edges_without_a_word_are_ordered,
    live_outs_spare_words_still_read,
    one_control_result_per_slot,
    one_issue_per_fu_and_slot,
    one_live_out_per_pe_and_slot,
)
from vividc.mapper.engines.cpsat.problem import Prepared, windowed
from vividc.mapper.engines.cpsat.run import Search, run
from vividc.mapper.engines.cpsat.variables import Variables, new_variables
from vividc.mapper.engines.cpsat.ways import at_most
from vividc.mapper.mapping import Place
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.dependences import Dependence
from vividc.mapper.resources.distances import cycles_for, hop_distances

_MOST_LITERALS: Final = 3_000_000
_LITERALS_PER_S: Final = 300_000

_FAMILIES: Final = (
    each_node_starts_once,
    one_issue_per_fu_and_slot,
    constants_fit_store,
    one_live_out_per_pe_and_slot,
    live_outs_spare_words_still_read,
    one_control_result_per_slot,
    accesses_fit_banks,
    edges_without_a_word_are_ordered,
)


@dataclass(frozen=True, slots=True)
class MobilityModel:
    """The model of one II; `exclude` makes it ask for another placement."""

    model: CpModel
    start: dict[tuple[int, int, int], IntVar]

    @staticmethod
    def of(task: MapProblem, ii: int, slack: int, deadline: Deadline) -> MobilityModel | None:
        """Build it for schedules up to `slack` cycles longer than the longest path; None where it
        is too large for the time there is.
        """
        problem = windowed(task, ii, slack)
        near = _near(problem)
        at_once = max(len(row) for row in near)
        widest = max((len(w.times) for w in problem.windows.values()), default=1)
        literals = len(problem.starts) * at_once * min(widest, ii)
        if literals > min(_MOST_LITERALS, _LITERALS_PER_S * deadline.remaining_s):
            return None
        model = CpModel()
        variables = new_variables(model, problem, routes=False)
        for family in _FAMILIES:
            family(model, problem, variables)
        completions_differ(model, problem, variables)
        _lives_last_one_ii(model, problem, variables)
        output = _outputs(model, problem, variables) if problem.fabric.routing.shared else {}
        for edge in problem.dependences:
            if edge.routed:
                _consumer_near_producer(model, problem, variables, edge, near, output)
        return MobilityModel(model, dict(variables.start))

    def solve(self, search: Search) -> dict[int, Place] | None:
        """Time and place of each node; None if no placement is left or time is up."""
        return run(
            self.model,
            search,
            lambda value: {
                node: Place(pe, time)
                for (node, pe, time), literal in self.start.items()
                if value(literal)
            },
        ).value

    def exclude(self, places: dict[int, Place]) -> None:
        """Exclude this placement."""
        chosen = [self.start[node, place.pe, place.time] for node, place in places.items()]
        self.model.add_bool_or([~literal for literal in chosen])


def _near(problem: Prepared) -> tuple[dict[int, bool], ...]:
    """By consumer PE: producer PEs whose results it can read in the cycle in which they are ready,
    itself first, and whether the word can wait, in a register of either, or only while it is the
    last result of its producer's PE.
    """
    fabric = problem.fabric
    hops, a_cycle = hop_distances(fabric), max(fabric.routing.hops, 0)
    by_edge = []
    for pe in fabric.pes:
        near = {pe.id: True} | dict.fromkeys(fabric.outputs_seen_by[pe.id][1:], False)
        for other in fabric.pes:
            if cycles_for(hops[other.id][pe.id], a_cycle) == 1:
                near[other.id] = True
        by_edge.append(near)
    return tuple(by_edge)


def _lives_last_one_ii(model: CpModel, problem: Prepared, v: Variables) -> None:
    """0 <= start[dst] + II * distance - start[src] - latency <= II: redundant beside C3, but over
    integers, along which bounds travel.
    """
    starts: dict[int, IntVar] = {}
    for node in problem.nodes:
        window = problem.windows[node.id]
        start = model.new_int_var(window.first, window.last, f"time[{node.id}]")
        keys = [key for key in v.start if key[0] == node.id]
        literals = [v.start[key] for key in keys]
        model.add(start == LinearExpr.weighted_sum(literals, [time for _, _, time in keys]))
        starts[node.id] = start
    for edge in problem.dependences:
        if edge.routed:
            life = starts[edge.dst] + problem.ii * edge.distance - starts[edge.src] - edge.latency
            model.add_linear_constraint(life, 0, problem.ii)


def _outputs(model: CpModel, problem: Prepared, v: Variables) -> dict[tuple[int, int, int], IntVar]:
    """O[v,p,t]: the word of v is still in the output register of p, where it was made; any other
    completion there ends that.
    """
    made: dict[tuple[int, int, int], IntVar] = {}
    for (node, pe, time), literal in v.start.items():
        if node in problem.reads:
            made[node, pe, time + problem.latency[node]] = literal
    last = problem.ii if problem.fabric.routing.holds else 1
    output: dict[tuple[int, int, int], IntVar] = {}
    for word, pe, time in sorted({(w, p, t + age) for w, p, t in made for age in range(last)}):
        literal = output[word, pe, time] = model.new_bool_var(f"output[{word},{pe},{time}]")
        ways = [made[word, pe, time]] if (word, pe, time) in made else []
        if (word, pe, time - 1) in output and last > 1:
            ways.append(output[word, pe, time - 1])
        model.add_bool_or([*ways, ~literal])
        if (word, pe, time) in made:
            model.add_implication(made[word, pe, time], literal)
    held: dict[tuple[int, int], list[IntVar]] = defaultdict(list)
    for (_, pe, time), literal in output.items():
        held[pe, time % problem.ii].append(literal)
    silent = {node.id for node in problem.nodes if node.uses_fu and node.id not in problem.reads}
    for (node, pe, time), literal in v.start.items():
        if node in silent:
            held[pe, (time + problem.latency[node]) % problem.ii].append(literal)
    at_most(model, held, 1)
    return output


def _consumer_near_producer(
    model: CpModel,
    problem: Prepared,
    v: Variables,
    edge: Dependence,
    near: tuple[dict[int, bool], ...],
    output: dict[tuple[int, int, int], IntVar],
) -> None:
    """C3: x[dst,p,t] => x[src,q,t'] for a PE q near p and a time t' in time for it, at most II
    cycles before.
    """
    for (node, pe, time), literal in v.start.items():
        if node != edge.dst:
            continue
        read = time + problem.ii * edge.distance
        ways = []
        for origin, waits in near[pe].items():
            if not waits:
                ways += [output[key] for key in [(edge.src, origin, read)] if key in output]
                continue
            for life in range(problem.ii + 1):
                key = (edge.src, origin, read - edge.latency - life)
                if key in v.start:
                    ways.append(v.start[key])
        model.add_bool_or([*ways, ~literal])
