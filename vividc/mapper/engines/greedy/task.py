"""A straight region and its array as flat arrays, the form that compiled functions read."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG, EdgeKind, Node
from vividc.host.once import once_each
from vividc.machine.opcodes import Opcode
from vividc.mapper.bounds.straight import Heights, end_in
from vividc.mapper.problem import ConstantKey, MapProblem
from vividc.mapper.resources.arrays import Bytes2, Floats2, Ints, Ints2, Rows, ints
from vividc.mapper.resources.banks import Meets
from vividc.mapper.resources.distances import FAR, hop_distances

LIVE_OUT, MEMORY, CONTROL = 1, 2, 4
"""Bits of `Nodes.kind`."""


class Grid(NamedTuple):
    """The fabric. A *place* is where a word can be for a cycle: a link (first, by id) or a register
    of a PE (from `first` to that of the next PE).

    `origin`, `end`: PEs of a place; `into`, `out`: links of a PE; `distance`: hops between PEs,
    `FAR` where no links lead; `diameter`: the most of them; `room`: entries of each constant store.
    """

    pes: int
    links: int
    places: int
    diameter: int
    banks: int
    origin: Ints
    end: Ints
    first: Ints
    into_begin: Ints
    into_items: Ints
    out_begin: Ints
    out_items: Ints
    distance: Ints2
    read_ports: Ints
    write_ports: Ints
    room: Ints


class Nodes(NamedTuple):
    """What is placed, by dense number (ascending id).

    `kind`: bits `LIVE_OUT`, `MEMORY`, `CONTROL`; `busy`: cycles for which it keeps its FU; `ends`:
    cycles of the region that it needs, itself and the loop behind alone; `access`: its row in
    `Task.meets`, or -1; `waits`: for how many others; `after` (nodes, PEs): cycles from its issue
    to the region's end. `release` (nodes, PEs): the first cycle in which it may issue there.
    `pe`: its candidates; `key`: its entries of constant stores; `read`: edges that bring its words;
    `source`: where these come from, each node once, `times`: by how many edges; `fed`: edges that
    take its own word; `next`: what waits for it; `reader`: what reads the variable that it writes;
    `writer`: what writes a variable that it reads.
    """

    kind: Ints
    latency: Ints
    busy: Ints
    ends: Ints
    access: Ints
    waits: Ints
    after: Ints2
    release: Ints2
    pe_begin: Ints
    pe_items: Ints
    key_begin: Ints
    key_items: Ints
    read_begin: Ints
    read_items: Ints
    source_begin: Ints
    source_items: Ints
    times_begin: Ints
    times: Ints
    fed_begin: Ints
    fed_items: Ints
    next_begin: Ints
    next_items: Ints
    reader_begin: Ints
    reader_items: Ints
    writer_begin: Ints
    writer_items: Ints


class Edges(NamedTuple):
    """`src`, `dst`: ends of those that words take; `before`: for each node, rows (node before,
    cycles after its issue, 1 if its word is brought, too).
    """

    src: Ints
    dst: Ints
    before_begin: Ints
    before: Ints2


class Task(NamedTuple):
    """`meets` (accesses, accesses): how often those of one cycle meet in a bank; `held` (PEs,
    keys): 1 where an entry is in a constant store from the first; `stored`: all entries there.
    """

    grid: Grid
    nodes: Nodes
    edges: Edges
    meets: Floats2
    held: Bytes2
    stored: Ints


@once_each
def grid_of(fabric: Fabric) -> Grid:
    """A fabric's arrays."""
    origin = [link.src for link in fabric.links]
    end = [link.dst for link in fabric.links]
    first = [len(origin)]
    for pe in fabric.pes:
        origin += [pe.id] * pe.registers
        end += [pe.id] * pe.registers
        first.append(len(origin))
    into = Rows.of([link.id for link in links] for links in fabric.links_to)
    out = Rows.of([link.id for link in links] for links in fabric.links_from)
    distance = np.array(hop_distances(fabric), dtype=np.int64)
    return Grid(
        len(fabric.pes),
        len(fabric.links),
        len(origin),
        int(distance[distance < FAR].max(initial=0)),
        max(1, fabric.scratchpad.banks),
        ints(origin),
        ints(end),
        ints(first),
        into.begin,
        into.items,
        out.begin,
        out.items,
        distance,
        ints(pe.read_ports for pe in fabric.pes),
        ints(pe.write_ports for pe in fabric.pes),
        ints(pe.constants for pe in fabric.pes),
    )


def build_task(
    problem: MapProblem, heights: Heights, meets: Meets
) -> tuple[Task, tuple[Node, ...]]:
    """The arrays, and the nodes in the order of their numbers; edges that words take are numbered
    as `DFG.routed_edges` has them.
    """
    placed = tuple(sorted(problem.dfg.placed, key=lambda node: node.id))
    number = {node.id: at for at, node in enumerate(placed)}
    keys = [problem.constants_of(node) for node in placed]
    candidates = [problem.candidates(node) for node in placed]
    access = {node.id: row for row, node in enumerate(n for n in placed if n.id in meets)}
    edges = _edges(problem, placed, number)
    every = {key: at for at, key in enumerate(dict.fromkeys(key for some in keys for key in some))}
    rows = [
        Rows.of(candidates),
        Rows.of([every[key] for key in some] for some in keys),
        *_words(edges, len(placed)),
        *_order(problem.dfg, placed, number),
    ]
    fabric = problem.fabric
    nodes = Nodes(
        ints(map(_kind, placed)),
        ints(map(fabric.latency, placed)),
        ints(map(fabric.occupancy, placed)),
        ints(end_in(problem, node) for node in placed),
        ints(access.get(node.id, -1) for node in placed),
        np.bincount(rows[-3].items, minlength=len(placed)),
        np.array([heights.after(node.id) for node in placed], dtype=np.int64).reshape(
            -1, len(fabric.pes)
        ),
        _releases(problem, placed),
        *(part for row in rows for part in (row.begin, row.items)),
    )
    held = _stores(problem, candidates, keys, every)
    return Task(grid_of(fabric), nodes, edges, _often(meets, access), *held), placed


def _releases(problem: MapProblem, placed: Sequence[Node]) -> Ints2:
    pes = len(problem.fabric.pes)
    if problem.drain is None:
        return np.zeros((len(placed), pes), dtype=np.int64)
    rows = [problem.releases_on(node, range(pes)) for node in placed]
    return np.array(rows, dtype=np.int64).reshape(-1, pes)


def _kind(node: Node) -> int:
    return (
        LIVE_OUT * (node.op is Opcode.LIVE_OUT)
        + MEMORY * node.is_memory
        + CONTROL * (node.control is not None)
    )


def _edges(problem: MapProblem, placed: Sequence[Node], number: dict[int, int]) -> Edges:
    dfg, fabric = problem.dfg, problem.fabric
    routed = [edge for _, edge in dfg.routed_edges()]
    begin, before = [0], []
    for node in placed:
        for edge in dfg.in_edges[node.id]:
            if edge.src in number:
                apart = 1
                if edge.kind is not EdgeKind.ORDER:
                    apart = fabric.latency(dfg.by_id[edge.src])
                if edge.kind is EdgeKind.CONTROL:
                    apart += fabric.controller.control_latency
                before.append((number[edge.src], apart, int(edge.is_data)))
        begin.append(len(before))
    return Edges(
        ints(number[edge.src] for edge in routed),
        ints(number[edge.dst] for edge in routed),
        ints(begin),
        np.array(before, dtype=np.int64).reshape(-1, 3),
    )


def _words(edges: Edges, nodes: int) -> list[Rows]:
    """By node: edges that bring its words, the nodes these come from, by how many edges each, and
    edges that take its own.
    """
    read: list[list[int]] = [[] for _ in range(nodes)]
    fed: list[list[int]] = [[] for _ in range(nodes)]
    sources: list[dict[int, int]] = [{} for _ in range(nodes)]
    for edge, (src, dst) in enumerate(zip(edges.src.tolist(), edges.dst.tolist(), strict=True)):
        read[dst].append(edge)
        fed[src].append(edge)
        sources[dst][src] = sources[dst].get(src, 0) + 1
    return [Rows.of(rows) for rows in (read, sources, (row.values() for row in sources), fed)]


def _order(dfg: DFG, placed: Sequence[Node], number: dict[int, int]) -> list[Rows]:
    """By node: what waits for it; what reads the word that the variable it writes had before the
    region; and what writes a variable that it reads so.
    """
    by_name: dict[str, dict[int, None]] = defaultdict(dict)
    for node in placed:
        for edge in dfg.in_edges[node.id]:
            source = dfg.by_id[edge.src]
            if source.op is Opcode.LIVE_IN and edge.is_data:
                by_name[source.name][number[node.id]] = None
    waiting: list[list[int]] = [[] for _ in placed]
    for edge in dfg.edges:
        if edge.src in number:
            waiting[number[edge.src]].append(number[edge.dst])
    readers: list[list[int]] = [[] for _ in placed]
    writers: list[list[int]] = [[] for _ in placed]
    for out, node in enumerate(placed):
        if node.op is not Opcode.LIVE_OUT:
            continue
        readers[out] = [*by_name.get(node.name, ())]
        for reader in readers[out]:
            writers[reader].append(out)
            if not dfg.out_edges[node.id] and reader != out:
                waiting[reader].append(out)  # nothing that reads can depend on the write
    return [Rows.of(rows) for rows in (waiting, readers, writers)]


def _stores(
    problem: MapProblem,
    candidates: Sequence[tuple[int, ...]],
    keys: Sequence[tuple[ConstantKey, ...]],
    every: dict[ConstantKey, int],
) -> tuple[Bytes2, Ints]:
    """What constant stores hold at first: other regions' entries, those of nodes with one home."""
    pes = len(problem.fabric.pes)
    there = [set(problem.resident.get(pe, ())) for pe in range(pes)]
    for home, some in zip(candidates, keys, strict=True):
        if len(home) == 1:
            there[home[0]].update(some)
    held = np.zeros((pes, max(1, len(every))), dtype=np.uint8)
    for pe, entries in enumerate(there):
        held[pe, [every[key] for key in entries if key in every]] = 1
    return held, ints(map(len, there))


def _often(meets: Meets, access: dict[int, int]) -> Floats2:
    often = np.zeros((len(access), len(access)))
    for node, row in access.items():
        for other, times in meets[node].items():
            if other in access:
                often[row, access[other]] = times
    return often
