"""The constraint families of the joint model of time, place and route; one function each.

Notation: x[v,p,t] = start, L[v,k,t] = link, H, W, R[v,p,t] = held, written, read, O, M[v,p,t] =
output, move (`output_constraints`: fabrics whose output registers take part); `lat` = latency of v.
All sums are over the times t of one slot, several t of the same word included: they are words of
different iterations. The time-expanded form follows the MRRG (Mei et al. 2002; Chin and Anderson
2018) with time kept absolute.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection, Mapping
from typing import Final

from ortools.sat.python.cp_model import CpModel, IntVar, LinearExpr, LinearExprT

from vividc.mapper.engines.cpsat.output_constraints import (
    moves_find_the_word,
    one_word_per_output_and_slot,
    outputs_keep_words,
    results_enter_outputs,
    words_pass_links,
)
from vividc.mapper.engines.cpsat.problem import Prepared, is_live_out
from vividc.mapper.engines.cpsat.variables import Variables
from vividc.mapper.engines.cpsat.ways import at_most, grouped, readable, results, supply
from vividc.mapper.problem import ConstantKey, constant_key

Family = Callable[[CpModel, Prepared, Variables], None]


def each_node_starts_once(model: CpModel, problem: Prepared, v: Variables) -> None:
    """sum over p, t of x[v,p,t] = 1."""
    choices: dict[int, list[IntVar]] = {node.id: [] for node in problem.nodes}
    for (node, _, _), literal in v.start.items():
        choices[node].append(literal)
    for literals in choices.values():
        model.add_exactly_one(literals)


def one_issue_per_fu_and_slot(model: CpModel, problem: Prepared, v: Variables) -> None:
    """sum over operations v and t .. t + occupancy - 1 = slot of x[v,p,t], and over words of
    M[v,p,t], <= 1.
    """
    busy = {n.id: problem.fabric.occupancy(n) for n in problem.nodes if n.uses_fu}
    users = [
        ((pe, (time + cycle) % problem.ii), literal)
        for (node, pe, time), literal in v.start.items()
        for cycle in range(busy.get(node, 0))
    ]
    users += [((pe, time % problem.ii), literal) for (_, pe, time), literal in v.move.items()]
    at_most(model, grouped(users), 1)


def one_completion_per_fu_and_slot(model: CpModel, problem: Prepared, v: Variables) -> None:
    """sum over operations v and t + lat = slot of x[v,p,t] <= 1; `one_word_per_output_and_slot`
    says it where output registers take part.
    """
    if not problem.fabric.routing.open_outputs:
        completions_differ(model, problem, v)


def completions_differ(model: CpModel, problem: Prepared, v: Variables) -> None:
    """At most one operation of a PE completes in a slot, whatever the output registers are."""
    operations = {node.id for node in problem.nodes if node.uses_fu}
    users = (
        ((pe, (time + problem.latency[node]) % problem.ii), literal)
        for (node, pe, time), literal in v.start.items()
        if node in operations
    )
    at_most(model, grouped(users), 1)


def links_are_driven(model: CpModel, problem: Prepared, v: Variables) -> None:
    """L[v,k,t] => x[v,p,t-lat] or L[v,k',t-1] of a link k' into p or R[v,p,t-1] or O[v,q,t-1] that
    p reads, with p the PE that k leaves. Where a word passes several links in a cycle,
    `words_pass_links` says it.
    """
    if problem.fabric.routing.hops > 1:
        return
    sources = {link.id: link.src for link in problem.fabric.links}
    for (word, link, time), literal in v.link.items():
        ways = supply(problem, v, word, sources[link], time)
        model.add_bool_or([*ways, ~literal])


def registers_are_written(model: CpModel, problem: Prepared, v: Variables) -> None:
    """W[v,p,t] => x[v,p,t-lat] or L[v,k,t-1] of a link k into p or R[v,p,t-1] (a copy from another
    register) or O[v,q,t-1] that p reads. Registers that only the FU writes: x[v,p,t-lat] or
    M[v,p,t-1].
    """
    for (word, pe, time), literal in v.written.items():
        ways = results if problem.fabric.pes[pe].written_by_fu else supply
        model.add_bool_or([*ways(problem, v, word, pe, time), ~literal])


def registers_keep_words(model: CpModel, problem: Prepared, v: Variables) -> None:
    """H[v,p,t] => W[v,p,t] or H[v,p,t-1]; W => H."""
    for (word, pe, time), literal in v.held.items():
        written = v.written[word, pe, time]
        before = v.held.get((word, pe, problem.wrap(time - 1)))
        kept = [written] if before is None else [written, before]
        model.add_bool_or([*kept, ~literal])
        model.add_implication(written, literal)


def registers_last_one_ii(model: CpModel, problem: Prepared, v: Variables) -> None:
    """H[v,p,t] => W[v,p,t] or ... or W[v,p,t-II+1]: then the next iteration's word overwrites the
    register.

    Left out where H cannot reach back II cycles: there `registers_keep_words` says it already. In
    a rotating file the next word goes elsewhere.
    """
    for (word, pe, time), literal in v.held.items():
        if problem.fabric.pes[pe].rotating and not problem.cyclic:
            continue
        if (word, pe, problem.wrap(time - problem.ii)) not in v.held:
            continue
        times = (problem.wrap(time - age) for age in range(problem.ii))
        writes = [v.written[word, pe, t] for t in times if (word, pe, t) in v.written]
        model.add_bool_or([*writes, ~literal])


def reads_find_the_word(model: CpModel, problem: Prepared, v: Variables) -> None:
    """R[v,p,t] => H[v,p,t]."""
    del problem
    for key, literal in v.read.items():
        model.add_implication(literal, v.held[key])


def operands_arrive(model: CpModel, problem: Prepared, v: Variables) -> None:
    """x[u,p,t] => x[v,p,t'-lat] or L[v,k,t'] of a link k into p or R[v,p,t'] or O[v,q,t'] that p
    reads, t' = t + II * distance, per edge (v, u).
    """
    incoming: dict[int, list[tuple[int, int]]] = defaultdict(list)
    for edge in problem.dependences:
        pair = (edge.src, edge.distance)
        if edge.routed and pair not in incoming[edge.dst]:
            incoming[edge.dst].append(pair)
    for (node, pe, time), literal in v.start.items():
        for word, distance in incoming[node]:
            at = problem.wrap(time + problem.ii * distance)
            model.add_bool_or([*readable(problem, v, word, pe, at), ~literal])


def one_word_per_link_and_slot(model: CpModel, problem: Prepared, v: Variables) -> None:
    """sum over words v and t = slot of L[v,k,t] <= 1."""
    users = (((k, time % problem.ii), literal) for (_, k, time), literal in v.link.items())
    at_most(model, grouped(users), 1)


def words_fit_registers(model: CpModel, problem: Prepared, v: Variables) -> None:
    """sum over words v and t = slot of H[v,p,t] <= registers of p."""
    capacity = {pe.id: pe.registers for pe in problem.fabric.pes}
    _port_capacity(model, problem, v.held, capacity)


def reads_fit_ports(model: CpModel, problem: Prepared, v: Variables) -> None:
    """sum over words v and t = slot of R[v,p,t] <= read ports of p."""
    capacity = {pe.id: pe.read_ports for pe in problem.fabric.pes}
    _port_capacity(model, problem, v.read, capacity)


def writes_fit_ports(model: CpModel, problem: Prepared, v: Variables) -> None:
    """sum over words v and t = slot of W[v,p,t] <= write ports of p."""
    capacity = {pe.id: pe.write_ports for pe in problem.fabric.pes}
    _port_capacity(model, problem, v.written, capacity)


def constants_fit_store(model: CpModel, problem: Prepared, v: Variables) -> None:
    """x[v,p,t] => C[p,key] for each constant of v; sum of C[p,.] + resident entries <= capacity of
    p.
    """
    for (node, pe, _), literal in v.start.items():
        for key in problem.task.constants_of(problem.task.dfg.by_id[node]):
            if (pe, key) in v.constant:
                model.add_implication(literal, v.constant[pe, key])
    for pe, literals in grouped((pe, c) for (pe, _), c in v.constant.items()).items():
        resident = len(problem.task.resident.get(pe, ()))
        model.add(LinearExpr.sum(literals) <= max(problem.fabric.pes[pe].constants - resident, 0))


def one_live_out_per_pe_and_slot(model: CpModel, problem: Prepared, v: Variables) -> None:
    """sum over live-outs v and t = slot of x[v,p,t] <= 1."""
    live_outs = {node.id for node in problem.nodes if is_live_out(node)}
    users = (
        ((pe, time % problem.ii), literal)
        for (node, pe, time), literal in v.start.items()
        if node in live_outs
    )
    at_most(model, grouped(users), 1)


def live_outs_spare_words_still_read(model: CpModel, problem: Prepared, v: Variables) -> None:
    """No live-out shares a PE with a node that reads the entry it writes: iterations overlap, the
    old word is lost.
    """
    readers, writers = _entry_users(problem)
    for key, nodes in writers.items():
        if key not in readers:
            continue
        for pe in problem.fabric.pes:
            writes_here = model.new_bool_var(f"writes[{pe.id},{key[1]}]")
            for (node, at, _), literal in v.start.items():
                if at == pe.id and node in nodes:
                    model.add_implication(literal, writes_here)
                if at == pe.id and node in readers[key]:
                    model.add_implication(literal, ~writes_here)


def one_control_result_per_slot(model: CpModel, problem: Prepared, v: Variables) -> None:
    """sum over control nodes v, PEs p and t + lat = slot of x[v,p,t] <= 1."""
    control = {node.id for node in problem.nodes if node.control is not None}
    users = (
        ((time + problem.latency[node]) % problem.ii, literal)
        for (node, _, time), literal in v.start.items()
        if node in control
    )
    at_most(model, grouped(users), 1)


def accesses_fit_banks(model: CpModel, problem: Prepared, v: Variables) -> None:
    """sum over loads and stores v, PEs p and t = slot of x[v,p,t] <= banks."""
    memory = {node.id for node in problem.nodes if node.is_memory}
    users = (
        (time % problem.ii, literal)
        for (node, _, time), literal in v.start.items()
        if node in memory
    )
    at_most(model, grouped(users), problem.fabric.scratchpad.banks)


def edges_without_a_word_are_ordered(model: CpModel, problem: Prepared, v: Variables) -> None:
    """start[dst] + II * distance >= start[src] + separation for ORDER and CONTROL edges."""
    _precedences(model, problem, v, routed=False)


def routed_edges_are_ordered(model: CpModel, problem: Prepared, v: Variables) -> None:
    """The same for DATA edges. Redundant on the open timeline (routes take time); needed on the
    cyclic one.
    """
    _precedences(model, problem, v, routed=True)


CONSTRAINT_FAMILIES: Final[tuple[Family, ...]] = (
    each_node_starts_once,
    one_issue_per_fu_and_slot,
    one_completion_per_fu_and_slot,
    links_are_driven,
    registers_are_written,
    registers_keep_words,
    registers_last_one_ii,
    reads_find_the_word,
    operands_arrive,
    one_word_per_link_and_slot,
    words_fit_registers,
    reads_fit_ports,
    writes_fit_ports,
    constants_fit_store,
    one_live_out_per_pe_and_slot,
    live_outs_spare_words_still_read,
    one_control_result_per_slot,
    accesses_fit_banks,
    edges_without_a_word_are_ordered,
    routed_edges_are_ordered,
    outputs_keep_words,
    results_enter_outputs,
    moves_find_the_word,
    one_word_per_output_and_slot,
    words_pass_links,
)


def add_constraints(
    model: CpModel, problem: Prepared, variables: Variables, dropped: Collection[str] = ()
) -> None:
    """Add every family but those named in `dropped` (for ablation and for the drop-one test)."""
    for family in CONSTRAINT_FAMILIES:
        if family.__name__ not in dropped:
            family(model, problem, variables)


def _entry_users(
    problem: Prepared,
) -> tuple[dict[ConstantKey, set[int]], dict[ConstantKey, set[int]]]:
    """Nodes that read each constant-store entry, and live-outs that write it."""
    readers: dict[ConstantKey, set[int]] = defaultdict(set)
    writers: dict[ConstantKey, set[int]] = defaultdict(set)
    nodes = problem.task.dfg.by_id
    for node in problem.nodes:
        if is_live_out(node):
            writers["live_in", node.name].add(node.id)
        for edge in problem.task.dfg.in_edges[node.id]:
            for source in (edge.src, edge.init):
                key = None if source is None or not edge.is_data else constant_key(nodes[source])
                if key is not None:
                    readers[key].add(node.id)
    return readers, writers


def _port_capacity(
    model: CpModel,
    problem: Prepared,
    literals: Mapping[tuple[int, int, int], IntVar],
    capacity: Mapping[int, int],
) -> None:
    pairs = (((pe, time % problem.ii), literal) for (_, pe, time), literal in literals.items())
    for (pe, slot), group in grouped(pairs).items():
        at_most(model, {slot: group}, capacity[pe])


def _precedences(model: CpModel, problem: Prepared, v: Variables, *, routed: bool) -> None:
    edges = [edge for edge in problem.dependences if edge.routed is routed]
    times = _start_times(problem, v, {end for e in edges for end in (e.src, e.dst)})
    for edge in edges:
        first, last = problem.windows[edge.dst].first, problem.windows[edge.src].last
        if not problem.cyclic and first >= last + edge.weight(problem.ii):
            continue
        model.add(times[edge.dst] >= times[edge.src] + edge.weight(problem.ii))


def _start_times(problem: Prepared, v: Variables, nodes: Collection[int]) -> dict[int, LinearExprT]:
    terms: dict[int, tuple[list[IntVar], list[int]]] = {node: ([], []) for node in nodes}
    for (node, _, time), literal in v.start.items():
        if node in terms:
            terms[node][0].append(literal)
            terms[node][1].append(time)
    for node, stage in v.stage.items():
        if node in terms:
            terms[node][0].append(stage)
            terms[node][1].append(problem.ii)
    return {node: LinearExpr.weighted_sum(*pair) for node, pair in terms.items()}
