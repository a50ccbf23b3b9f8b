"""Regions as data for the page: graph, schedule by context, bounds and what binds."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from vividc.arch.draw.grid import Grid
from vividc.arch.draw.wires import wires, wrap_arounds
from vividc.arch.fabric import Fabric
from vividc.dfg import DFG
from vividc.dfg.draw import label
from vividc.dfg.ir import Edge, Node
from vividc.mapper.mapping import Bound, Place
from vividc.mapper.report.draw.scene import (
    Scene,
    colour_of,
    describe,
    groups_of,
    operation_name,
    scene_of,
)
from vividc.mapper.report.explain import binding, explain
from vividc.mapper.result import MapResult
from vividc.page.source import Data, OwnLines
from vividc.program import Program

_LENGTH: Final = "critical path"
"""The bound of straight code: on its length, not on an II."""


def fabric_data(fabric: Fabric) -> Data:
    """Return the array as a drawing: PEs with their corners, links with their lines, in points."""
    grid = Grid(fabric)
    drawn = {wire.link.id: wire for wire in wires(grid, wrap_arounds(fabric), fabric.links)}
    return {
        "name": fabric.name,
        "width": grid.width,
        "height": grid.height,
        "pe_width": grid.detail.width,
        "pe_height": grid.detail.height,
        "banks": fabric.scratchpad.banks,
        "pes": [
            {"at": grid.corner(pe), "memory": pe.has_memory, "registers": pe.registers}
            for pe in fabric.pes
        ],
        "links": [
            {
                "src": link.src,
                "dst": link.dst,
                "runs": drawn[link.id].runs,
                "labels": drawn[link.id].labels,
            }
            for link in fabric.links
        ],
    }


def region_data(program: Program, index: int, own: OwnLines) -> Data:
    """Return one region.

    Raises
    ------
    BundleError
        The program keeps no graphs and mappings, or they are damaged.
    """
    report = program.regions[index]
    graph, result = report.dfg, report.result
    scene = None
    if result is not None and result.mapping is not None:
        scene = scene_of(graph, program.fabric, result.mapping)
    return {
        "name": report.name,
        "kind": report.kind,
        "line": own.line(report.loc),
        "ii": report.ii,
        "lower_bound": report.lower_bound,
        "status": report.status,
        "utilization": report.utilization,
        "operations": report.operations,
        "span": report.span,
        "stages": report.stages,
        "drain": program.table[index].drain,
        "fill": program.table[index].fill,
        "mapper": report.mapper,
        "nodes": [_node(node, own, program.fabric, scene) for node in graph.nodes],
        "edges": [_edge(edge) for edge in graph.edges],
        "groups": groups_of(graph),
        "slots": [] if scene is None else [_slot(scene, slot) for slot in range(report.ii)],
        "usage": "" if scene is None else scene.usage(),
        **_proof(graph, result, own),
    }


def _node(node: Node, own: OwnLines, fabric: Fabric, scene: Scene | None) -> Data:
    place = None if scene is None else scene.mapping.places.get(node.id)
    return {
        "id": node.id,
        "name": operation_name(node),
        "label": label(node),
        "title": _title(node, place, fabric),
        "source": node.is_source,
        "colour": None if node.is_source else colour_of(node),
        "line": own.line(node.loc),
        "pe": None if place is None else place.pe,
        "time": None if place is None else place.time,
    }


def _title(node: Node, place: Place | None, fabric: Fabric) -> str:
    """All about a node in one line."""
    short = node
    if node.loc is not None:  # the page names one file, above its source
        short = replace(node, loc=None)
    where = "" if node.loc is None else f", line {node.loc.line}"
    if place is not None:
        return describe(short, place, fabric) + where
    return f"#{node.id} {operation_name(node)} {label(node)}{where}"


def _edge(edge: Edge) -> Data:
    return {
        "src": edge.src,
        "dst": edge.dst,
        "distance": edge.distance,
        "init": edge.init,
        "kind": edge.kind.value,
        "assumed": edge.assumed,
    }


def _slot(scene: Scene, slot: int) -> Data:
    """What happens in one context: by PE, and by link."""
    ii = scene.mapping.ii
    pes = range(len(scene.fabric.pes))
    return {
        "issues": [
            [pe, node.id, place.time // ii]
            for pe in pes
            for node, place in scene.issues.get((pe, slot), ())
        ],
        "links": [list(driven) for driven in scene.driven.get(slot, ())],
        "held": [[pe, *word] for pe in pes for word in scene.held.get((pe, slot), ())],
        "moved": [[pe, word] for pe in pes for word in scene.moved.get((pe, slot), ())],
        "kept": [[pe, scene.kept[pe, slot].id] for pe in pes if (pe, slot) in scene.kept],
    }


def _proof(graph: DFG, result: MapResult | None, own: OwnLines) -> Data:
    if result is None:
        return {"bounds": [], "refuted": [], "binds": None, "explained": "nothing to place"}
    cause = binding(result)
    names = [bound.name for bound in result.bounds]
    binds = None
    if cause is not None and cause.bound is not None:
        binds = names.index(cause.bound)
    elif result.bounds and result.bounds[0].name == _LENGTH:
        binds = 0
    return {
        "bounds": [_bound(bound, graph, own) for bound in result.bounds],
        "refuted": [{"ii": item.ii, "by": own.of(item.by)} for item in result.refuted],
        "binds": binds,
        "explained": own.of(explain(result)),
    }


def _bound(bound: Bound, graph: DFG, own: OwnLines) -> Data:
    """A bound; of a recurrence that names no edges, all between its nodes."""
    nodes = set(bound.nodes)
    edges = list(bound.edges)
    if not edges and bound.name in ("RecMII", _LENGTH):
        edges = [
            index
            for index, edge in enumerate(graph.edges)
            if edge.src in nodes and edge.dst in nodes
        ]
    for edge in edges:
        nodes |= {graph.edges[edge].src, graph.edges[edge].dst}
    return {
        "name": bound.name,
        "ii": bound.ii,
        "reason": own.of(bound.reason),
        "nodes": sorted(nodes),
        "edges": edges,
    }
