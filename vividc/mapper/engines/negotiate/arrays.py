"""A mapping problem at one II as flat arrays, the form that compiled functions read."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vividc.dfg.ir import Node
from vividc.machine.opcodes import Opcode
from vividc.mapper.engines.negotiate.frame import Frame
from vividc.mapper.problem import ConstantKey, MapProblem
from vividc.mapper.resources.arrays import Bytes, Bytes2, Floats3, Ints, Ints2, Rows, ints
from vividc.mapper.resources.banks import Meetings
from vividc.mapper.resources.dependences import Dependence, dependences
from vividc.mapper.resources.distances import hop_distances
from vividc.mapper.resources.mrrg import MRRG


class Nodes(NamedTuple):
    """What is placed, by dense number (ascending id).

    `can`: uint8 (nodes, PEs); `latency`: cycles from issue to result; `busy`: cycles for which it
    keeps its FU; `done`: its last cycle after the one of its issue, modulo II; `last`: its latest
    start; `kind`: bits `FU`, `MEMORY`, `CONTROL`; `keys`: constant-store entries; `key_uses`:
    `READ` or `WRITTEN` for each.
    """

    can: Bytes2
    pe_begin: Ints
    pe_items: Ints
    latency: Ints
    busy: Ints
    done: Ints
    last: Ints
    kind: Ints
    key_begin: Ints
    key_items: Ints
    key_uses: Ints


class Edges(NamedTuple):
    """Dependences: start[dst] - start[src] >= `shift`; a routed word lives start[dst] - start[src]
    - `ready` cycles beyond its result.

    `of`: edges at each node but self loops, and beside each its other end, its `shift`, its `lag`,
    which is what it needs between two times beside the array's `reach`, and its kind, bits `LEAVES`
    and `ROUTED`; `sink`: routed edges out of a node; `fed`: producers of what a node reads, itself
    not counted. `ahead` = II * distance.
    """

    src: Ints
    dst: Ints
    shift: Ints
    ready: Ints
    ahead: Ints
    routed: Bytes
    of_begin: Ints
    of_items: Ints
    sink_begin: Ints
    sink_items: Ints
    fed_begin: Ints
    fed_items: Ints
    of_other: Ints
    of_shift: Ints
    of_lag: Ints
    of_kind: Ints


class Array(NamedTuple):
    """The fabric. `reach`: cycles after its result that a word needs between PEs; `hop`: links on
    the way; `near`: PEs one link away and the PE itself; `room`: entries of each constant store;
    `stored`, `held` (PEs, keys): those that other regions hold there, `RESIDENT` each. `outputs`: 1
    where words go from PE to PE through output registers only, else 0; `moves`: 1 where FUs move
    them on there, too; `rivals`: 1 where a live-out writes an entry that another node reads, else
    0. `slots`, `stages`: of each time, modulo II and over II.
    """

    ii: int
    outputs: int
    moves: int
    pes: int
    banks: int
    keys: int
    rivals: int
    reach: Ints2
    hop: Ints2
    near_begin: Ints
    near_items: Ints
    room: Ints
    stored: Ints
    held: Ints2
    slots: Ints
    stages: Ints


class Meets(NamedTuple):
    """Accesses that meet in banks, by number: `access` of a node, or -1; `node` of each; `stalls`
    (accesses, accesses, 1 + 2 `far`): those expected of a pair in one slot, by the stages by which
    the first is later, up to `far` either way.
    """

    access: Ints
    node: Ints
    stalls: Floats3
    far: int


class Task(NamedTuple):
    """Nodes, edges and array of one attempt, and what meets in banks."""

    nodes: Nodes
    edges: Edges
    array: Array
    meets: Meets


FU, MEMORY, CONTROL = 1, 2, 4
LEAVES, ROUTED = 1, 2
READ, WRITTEN, RESIDENT = 1, 1 << 20, 1 << 40
"""Uses of an entry of a constant store, which are summed up."""


def build_task(
    problem: MapProblem, ii: int, frame: Frame, graph: MRRG
) -> tuple[Task, tuple[int, ...]]:
    """The arrays, and the ids of the nodes in the order of their numbers."""
    ids = tuple(sorted(node.id for node in problem.dfg.placed))
    number = {node: index for index, node in enumerate(ids)}
    nodes, keys = _nodes(problem, ids, frame, ii)
    edges = dependences(problem.dfg, problem.fabric)
    latest = max((*frame.begin.values(), *frame.last.values()), default=0)
    array = _array(problem, ii, graph, keys, np.arange(latest + 1))
    return Task(nodes, _edges(edges, number, ii), array, _meets(frame.meetings, number)), ids


def _meets(meetings: Meetings, number: dict[int, int]) -> Meets:
    node = ints(number[access] for access in meetings.accesses)
    access = np.full(len(number), -1, dtype=np.int64)
    access[node] = np.arange(len(node))
    return Meets(access, node, meetings.stalls, meetings.stalls.shape[2] // 2)


def _nodes(
    problem: MapProblem, ids: Sequence[int], frame: Frame, ii: int
) -> tuple[Nodes, dict[ConstantKey, int]]:
    placed = [problem.dfg.by_id[node] for node in ids]
    candidates = [problem.candidates(node) for node in placed]
    can = np.zeros((len(ids), len(problem.fabric.pes)), dtype=np.uint8)
    for index, pes in enumerate(candidates):
        can[index, list(pes)] = 1
    number: dict[ConstantKey, int] = {}
    keys = Rows.of(
        [number.setdefault(key, len(number)) for key in problem.constants_of(node)]
        for node in placed
    )
    uses = [
        WRITTEN if key == _written(node) else READ
        for node in placed
        for key in problem.constants_of(node)
    ]
    packed = Rows.of(candidates)
    kinds = [
        FU * node.uses_fu + MEMORY * node.is_memory + CONTROL * (node.control is not None)
        for node in placed
    ]
    latency = [problem.fabric.latency(node) for node in placed]
    made = Nodes(
        can,
        packed.begin,
        packed.items,
        ints(latency),
        ints(problem.fabric.occupancy(node) for node in placed),
        ints((cycles - 1) % ii for cycles in latency),
        ints(frame.last[node.id] for node in placed),
        ints(kinds),
        keys.begin,
        keys.items,
        ints(uses),
    )
    return made, number


def _edges(deps: Sequence[Dependence], number: dict[int, int], ii: int) -> Edges:
    ends = [(number[e.src], number[e.dst]) for e in deps]
    of: list[list[int]] = [[] for _ in number]
    sinks: list[list[int]] = [[] for _ in number]
    fed: list[dict[int, None]] = [{} for _ in number]
    for index, (edge, (src, dst)) in enumerate(zip(deps, ends, strict=True)):
        if src != dst:
            of[src].append(index)
            of[dst].append(index)
        if edge.routed:
            sinks[src].append(index)
            if src != dst:
                fed[dst][src] = None
    packed = [Rows.of(rows) for rows in (of, sinks, fed)]
    srcs, dsts = ints(src for src, _ in ends), ints(dst for _, dst in ends)
    shift = ints(e.separation - ii * e.distance for e in deps)
    ready = ints(e.latency - ii * e.distance for e in deps)
    routed = np.array([e.routed for e in deps], dtype=np.uint8)
    parts = [part for rows in packed for part in (rows.begin, rows.items)]
    parts += _beside(packed[0], srcs, dsts, shift, np.where(routed, ready, shift), routed)
    return Edges(srcs, dsts, shift, ready, ints(ii * e.distance for e in deps), routed, *parts)


def _beside(
    of: Rows, src: Ints, dst: Ints, shift: Ints, lag: Ints, routed: Bytes
) -> tuple[Ints, Ints, Ints, Ints]:
    """What `of` has beside each edge."""
    node, edge = np.repeat(np.arange(len(of.begin) - 1), np.diff(of.begin)), of.items
    kind = LEAVES * (src[edge] == node) + ROUTED * routed[edge].astype(np.int64)
    return src[edge] + dst[edge] - node, shift[edge], lag[edge], kind


def _has_rivals(problem: MapProblem) -> bool:
    """Whether a live-out writes an entry that another node reads."""
    placed = problem.dfg.placed
    written = {_written(node) for node in placed}
    return any(written & (set(problem.constants_of(node)) - {_written(node)}) for node in placed)


def _written(node: Node) -> ConstantKey | None:
    """The entry of a constant store that a live-out writes."""
    return ("live_in", node.name) if node.op is Opcode.LIVE_OUT else None


def _array(
    problem: MapProblem, ii: int, graph: MRRG, keys: dict[ConstantKey, int], times: Ints
) -> Array:
    fabric = problem.fabric
    pes = len(fabric.pes)
    near = Rows.of([pe, *(k.dst for k in fabric.links_from[pe])] for pe in range(pes))
    resident = [problem.resident.get(pe, frozenset()) for pe in range(pes)]
    held = np.zeros((pes, max(len(keys), 1)), dtype=np.int64)
    for pe, entries in enumerate(resident):
        for key in entries & keys.keys():
            held[pe, keys[key]] = RESIDENT
    return Array(
        ii=ii,
        outputs=int(not fabric.routing.hops),
        moves=int(not fabric.routing.hops and fabric.routing.shared and fabric.routing.moves),
        pes=pes,
        banks=fabric.scratchpad.banks,
        keys=held.shape[1],
        rivals=int(_has_rivals(problem)),
        reach=graph.reach,
        hop=np.array(hop_distances(fabric), dtype=np.int64),
        near_begin=near.begin,
        near_items=near.items,
        room=ints(
            max(pe.constants, len(there)) for pe, there in zip(fabric.pes, resident, strict=True)
        ),
        stored=ints(len(there) for there in resident),
        held=held,
        slots=times % ii,
        stages=times // ii,
    )
