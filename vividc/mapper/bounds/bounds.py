"""Lower bounds on the II that hold for every mapping, each with what binds it.

RecMII is the exact maximum cycle ratio (Rau 1994, section 2.2); the resource bounds are Hall's
condition (Hall 1935) on the PEs that can run each operation. One operation completes per PE and
slot as well as one issues, so completion binds no more than issue does. Scratchpad banks give no
bound: two accesses of a cycle that meet in a bank stall the tile, but are legal.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import networkx as nx

from vividc.dfg.ir import EdgeKind, Node
from vividc.dfg.order import partial_order
from vividc.errors import printable
from vividc.host.once import once_each
from vividc.machine.opcodes import Opcode
from vividc.mapper.bounds.pressure import pressure_bounds
from vividc.mapper.bounds.reach import island_bounds, operand_bounds, unreachable_bounds
from vividc.mapper.bounds.refutations import ASSUMED, KNOWN
from vividc.mapper.mapping import Bound
from vividc.mapper.problem import ConstantKey, MapProblem, constant_key
from vividc.mapper.resources.dependences import (
    Dependence,
    dependences,
    earliest_starts,
    least_ii,
    positive_cycle,
)

_MAX_HALL_SETS = 256
_SHOWN = 6


def mii(bounds: Iterable[Bound]) -> int:
    """The largest of the bounds, at least 1."""
    return max((bound.ii for bound in bounds), default=1)


def all_bounds(problem: MapProblem) -> tuple[Bound, ...]:
    """All bounds on the II, sharpest first.

    A bound above `controller.contexts` says that no II can work; so does a cycle of distance 0.
    """
    never = placement_bounds(problem) + lifetime_bounds(problem)
    if never:
        return never
    candidates = {node.id: frozenset(usable_pes(problem, node)) for node in problem.dfg.placed}
    never = operand_bounds(problem, candidates, no_ii(problem))
    never = never or unreachable_bounds(problem, candidates, no_ii(problem))
    if never:
        return never
    if len(problem.dfg.operations) >= no_ii(problem):
        crowded = tuple(bound for bound in issue_bounds(problem) if bound.ii >= no_ii(problem))
        if crowded:  # no need to look at the paths of a graph that is far too large
            return crowded
    bounds = [
        *island_bounds(problem, candidates),
        *recurrence_bounds(problem),
        *issue_bounds(problem),
        *occupancy_bounds(problem),
        *live_out_bounds(problem),
        *control_bounds(problem),
        *bank_bounds(problem),
    ]
    bounds += stage_bounds(problem, mii(bounds))
    bounds += pressure_bounds(problem, mii(bounds), no_ii(problem))
    return tuple(sorted(bounds, key=lambda bound: -bound.ii))


def no_ii(problem: MapProblem) -> int:
    """The II that stands for "no II works": one more than the configuration memory holds."""
    return problem.fabric.controller.contexts + 1


def usable_pes(problem: MapProblem, node: Node) -> tuple[int, ...]:
    """Candidate PEs of `node` whose constant store has room for the node's own constants."""
    return _usable_pes(problem)[node.id]


@once_each
def _usable_pes(problem: MapProblem) -> dict[int, tuple[int, ...]]:
    """The same for every placed node."""
    usable = {}
    for node in problem.dfg.placed:
        keys = frozenset(problem.constants_of(node))
        usable[node.id] = tuple(
            pe
            for pe in problem.candidates(node)
            if not keys
            or len(keys | _resident(problem, pe)) <= problem.fabric.pes[pe].constants
            or keys <= _resident(problem, pe)
        )
    return usable


def placement_bounds(problem: MapProblem) -> tuple[Bound, ...]:
    """A bound for each node that no PE can take, a live-out among them that would overwrite the
    word it reads itself.
    """
    bounds = []
    for node in problem.dfg.placed:
        if node.op is Opcode.LIVE_OUT and _reads_its_own_entry(problem, node):
            reason = f"{_name(node)} reads the entry of the constant store that it writes"
            bounds.append(Bound("live-out entry", no_ii(problem), reason, (node.id,)))
            continue
        if usable_pes(problem, node):
            continue
        slices = ", which needs slices for 16 or 8 bits" if node.info.sliced else ""
        fault = (
            f"no PE allowed for it has that operation{slices}"
            if not problem.candidates(node)
            else f"its {len(problem.constants_of(node))} constants fit no PE's constant store"
        )
        reason = f"{_name(node)} cannot be placed: {fault}"
        bounds.append(Bound("placement", no_ii(problem), reason, (node.id,)))
    return tuple(bounds)


def _reads_its_own_entry(problem: MapProblem, live_out: Node) -> bool:
    nodes = problem.dfg.by_id
    sources = (
        nodes[source]
        for edge in problem.dfg.in_edges[live_out.id]
        for source in (edge.src, edge.init)
        if source is not None and edge.is_data
    )
    return any(constant_key(source) == ("live_in", live_out.name) for source in sources)


def lifetime_bounds(problem: MapProblem) -> tuple[Bound, ...]:
    """A word read d iterations later lives (d - max_stages) * II - latency cycles or more, so about
    d - max_stages of its instances are on their way at once, each in a place of its own.
    """
    fabric = problem.fabric
    links = len(fabric.links) if fabric.routing.hops else 0
    places = links + sum(pe.registers + 1 for pe in fabric.pes)
    bounds = []
    for _, edge in problem.dfg.routed_edges():
        latency = fabric.latency(problem.dfg.by_id[edge.src])
        alive = edge.distance - fabric.controller.max_stages - latency
        if alive > places:
            node = problem.dfg.by_id[edge.src]
            reason = f"{_name(node)} is read {edge.distance} iterations later: {alive} of its words"
            reason += f" do not fit the {places} links, registers and outputs"
            bounds.append(Bound("lifetime", no_ii(problem), reason, (edge.src, edge.dst)))
    return tuple(bounds)


def recurrence_bounds(problem: MapProblem) -> tuple[Bound, ...]:
    """RecMII: max over cycles of ceil(sum of separations / sum of distances), with a cycle that
    reaches it.

    A cycle with a positive weight at II - 1 is one of ratio above II - 1.
    """
    edges = _on_cycles(dependences(problem.dfg, problem.fabric))
    any_bound = _recurrence(problem, edges)
    if any_bound is None:
        return ()
    proved = [edge for edge in edges if not problem.dfg.edges[edge.index].assumed]
    sure = _recurrence(problem, proved) if len(proved) < len(edges) else None
    return (sure if sure is not None and sure.ii == any_bound.ii else any_bound,)


def _recurrence(problem: MapProblem, edges: Sequence[Dependence]) -> Bound | None:
    nodes = tuple(dict.fromkeys(end for edge in edges for end in (edge.src, edge.dst)))
    least = least_ii(nodes, edges)
    if least == 0:
        return None
    impossible = sum(max(edge.separation, 0) for edge in edges)
    cycle = positive_cycle(nodes, edges, impossible if least is None else least - 1)
    memory = _memory_text(problem, cycle)
    if least is None:
        reason = f"cycle of distance 0: {_cycle_text(problem, cycle)}{memory}"
        return _recurrence_bound(no_ii(problem), reason, cycle)
    latency = sum(edge.separation for edge in cycle)
    distance = sum(edge.distance for edge in cycle)
    reason = f"{latency} cycles over distance {distance}: {_cycle_text(problem, cycle)}{memory}"
    return _recurrence_bound(least, reason, cycle)


def _memory_text(problem: MapProblem, cycle: Sequence[Dependence]) -> str:
    """The pairs of accesses on the cycle: those that nothing proves apart, else those that meet."""
    by_id = problem.dfg.by_id
    assumed: dict[str, None] = {}
    known: dict[str, None] = {}
    for edge in cycle:
        order = problem.dfg.edges[edge.index]
        if order.kind is not EdgeKind.ORDER:
            continue
        pair = " and ".join(sorted(_place(by_id[end]) for end in (edge.src, edge.dst)))
        if order.assumed:
            assumed[pair] = None
        else:
            known[f"{pair} meet {_after(edge.distance)}"] = None
    if assumed:
        return f"; {ASSUMED}accesses at {', '.join(assumed)} may meet"
    return f"; {KNOWN}accesses at {', '.join(known)}" if known else ""


def _after(iterations: int) -> str:
    if iterations == 0:
        return "in one iteration"
    return "1 iteration later" if iterations == 1 else f"{iterations} iterations later"


def _place(node: Node) -> str:
    return printable(str(node.loc)) if node.loc is not None else _name(node)


def issue_bounds(problem: MapProblem) -> tuple[Bound, ...]:
    """ResMII of each set of PEs that is all some operations can use; memory PEs form one."""
    return _hall_bounds(problem, "ResMII", problem.dfg.operations)


def occupancy_bounds(problem: MapProblem) -> tuple[Bound, ...]:
    """An operation that occupies its FU for n cycles cannot issue again within n cycles."""
    longest = max(problem.dfg.operations, key=problem.fabric.occupancy, default=None)
    if longest is None or problem.fabric.occupancy(longest) == 1:
        return ()
    cycles = problem.fabric.occupancy(longest)
    reason = f"{_name(longest)} keeps its FU for {cycles} cycles"
    return (Bound("FU occupancy", cycles, reason, (longest.id,)),)


def live_out_bounds(problem: MapProblem) -> tuple[Bound, ...]:
    """A constant store takes one live-out a cycle."""
    live_outs = tuple(node for node in problem.dfg.nodes if node.op is Opcode.LIVE_OUT)
    return _hall_bounds(problem, "live-out writes", live_outs)


def control_bounds(problem: MapProblem) -> tuple[Bound, ...]:
    """The tile controller takes one control result a cycle."""
    users = tuple(node for node in problem.dfg.nodes if node.control is not None)
    if not users:
        return ()
    reason = f"one control result a cycle: {_names(users)}"
    return (Bound("control port", len(users), reason, tuple(node.id for node in users)),)


def bank_bounds(problem: MapProblem) -> tuple[Bound, ...]:
    """The scratchpad takes one access a bank and cycle."""
    users = tuple(node for node in problem.dfg.nodes if node.is_memory)
    if not users:
        return ()
    banks = problem.fabric.scratchpad.banks
    reason = f"{len(users)} accesses to {banks} banks: {_names(users)}"
    return (Bound("banks", -(-len(users) // banks), reason, tuple(node.id for node in users)),)


def stage_bounds(problem: MapProblem, least: int) -> tuple[Bound, ...]:
    """The longest dependence path must fit `max_stages` stages of II cycles; monotone in the II."""
    nodes = tuple(node.id for node in problem.dfg.placed)
    edges = _forward(problem)
    stages = problem.fabric.controller.max_stages
    for ii in range(max(least, 1), no_ii(problem)):
        starts = earliest_starts(nodes, edges, ii)
        if starts is not None and max(starts.values(), default=0) < stages * ii:
            break
    else:
        ii = no_ii(problem)
    if ii <= least or not nodes:
        return ()
    reason = f"the longest path does not fit {stages} stages at a smaller II"
    return (Bound("stages", ii, reason),)


def hall_sets(candidates: Iterable[Iterable[int]]) -> tuple[frozenset[int], ...]:
    """Unions of the candidate sets (at most `_MAX_HALL_SETS`; fewer only weaken the bound), small
    ones first.
    """
    basic = sorted({frozenset(pes) for pes in candidates}, key=_order)
    everything: frozenset[int] = frozenset().union(*basic)
    sets = dict.fromkeys([*basic[: _MAX_HALL_SETS - 1], everything])
    frontier = list(sets)
    while frontier and len(sets) < _MAX_HALL_SETS:
        grown = [a | b for a in frontier for b in basic if (a | b) not in sets]
        frontier = sorted(dict.fromkeys(grown), key=_order)[: _MAX_HALL_SETS - len(sets)]
        sets.update(dict.fromkeys(frontier))
    return tuple(sorted((pes for pes in sets if pes), key=_order))


def _order(pes: frozenset[int]) -> tuple[int, tuple[int, ...]]:
    return (len(pes), tuple(sorted(pes)))


def _resident(problem: MapProblem, pe: int) -> frozenset[ConstantKey]:
    return problem.resident.get(pe, frozenset())


def _hall_bounds(problem: MapProblem, name: str, nodes: Sequence[Node]) -> tuple[Bound, ...]:
    candidates = {node.id: frozenset(usable_pes(problem, node)) for node in nodes}
    bounds = []
    for pes in hall_sets(candidates.values()) if nodes else ():
        users = [node for node in nodes if candidates[node.id] <= pes]
        cycles = sum(problem.fabric.occupancy(node) for node in users)
        ii = -(-cycles // len(pes))
        kept = "" if cycles == len(users) else f", {cycles} cycles of an FU,"
        reason = f"{len(users)}{kept} on {_pes_text(problem, pes)}: {_names(users)}"
        bounds.append(Bound(name, ii, reason, tuple(node.id for node in users)))
    best = max((bound.ii for bound in bounds), default=0)
    return tuple(bound for bound in bounds if bound.ii == best)[:1]


def _on_cycles(edges: Sequence[Dependence]) -> tuple[Dependence, ...]:
    """The dependences inside strongly connected components: no other lies on a cycle."""
    graph = nx.DiGraph((edge.src, edge.dst) for edge in edges)
    parts = enumerate(nx.strongly_connected_components(graph))
    part_of = {node: number for number, part in parts for node in part}
    return tuple(edge for edge in edges if part_of[edge.src] == part_of[edge.dst])


def _forward(problem: MapProblem) -> tuple[Dependence, ...]:
    """The dependences such that one pass over them finds most of a longest path."""
    position = {node: number for number, node in enumerate(partial_order(problem.dfg))}
    edges = dependences(problem.dfg, problem.fabric)
    return tuple(sorted(edges, key=lambda edge: position.get(edge.src, len(position))))


def _recurrence_bound(ii: int, reason: str, cycle: Sequence[Dependence]) -> Bound:
    nodes, edges = tuple(edge.src for edge in cycle), tuple(edge.index for edge in cycle)
    return Bound("RecMII", ii, reason, nodes, edges, sum(edge.distance for edge in cycle))


def _cycle_text(problem: MapProblem, cycle: Sequence[Dependence]) -> str:
    nodes = [problem.dfg.by_id[edge.src] for edge in cycle]
    return " -> ".join(_name(node) for node in [*nodes, nodes[0]])


def _pes_text(problem: MapProblem, pes: frozenset[int]) -> str:
    if len(pes) == len(problem.fabric.pes):
        return f"all {len(pes)} PEs"
    return f"the {len(pes)} PEs {', '.join(str(pe) for pe in sorted(pes))}"


def _names(nodes: Sequence[Node]) -> str:
    shown = ", ".join(_name(node) for node in nodes[:_SHOWN])
    return shown if len(nodes) <= _SHOWN else f"{shown}, and {len(nodes) - _SHOWN} more"


def _name(node: Node) -> str:
    kind = "" if node.op is Opcode.GENERIC else node.op.value
    label = " ".join(
        filter(None, (kind, node.name, f"#{node.id}", node.label and f"({node.label})"))
    )
    label = printable(label)
    return label if node.loc is None else f"{label} ({node.loc})"
