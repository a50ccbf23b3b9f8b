"""A graph as a picture, in layers by the longest path before a node (Sugiyama et al. 1981)."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from statistics import mean
from typing import Final

from vividc.dfg.ir import DFG, Edge, Node
from vividc.dfg.order import partial_order
from vividc.errors import demand_type
from vividc.host.files import write_whole
from vividc.host.plot import (
    INK,
    OKABE_ITO,
    Line,
    Picture,
    Rect,
    Shape,
    Text,
    encode,
    text_width,
    tint,
    to_svg,
)
from vividc.machine.opcodes import LatencyClass

_HEIGHT, _GAP, _LAYER, _MARGIN = 20.0, 12.0, 52.0, 24.0
_SIZE: Final = 9.0
_LEAST_WIDTH: Final = 44.0
_LONGEST: Final = 22
_LARGE: Final = 0xFFFF
"""Constants above are shown in hexadecimal: they are floats or masks."""
_SWEEPS: Final = 6
"""Times that nodes are put below the middle of those they depend on, and above that of others."""
_COLOURS: Final = {
    LatencyClass.LOAD: "green",
    LatencyClass.STORE: "green",
    LatencyClass.FADD: "sky",
    LatencyClass.FMUL: "sky",
    LatencyClass.FMA: "sky",
    LatencyClass.DOT: "sky",
    LatencyClass.CONVERT: "sky",
    LatencyClass.SELECT: "yellow",
    LatencyClass.COMPARE: "yellow",
}
_CARRIED: Final = OKABE_ITO["vermilion"]
_ORDER: Final = OKABE_ITO["grey"]
_STRENGTH: Final = 0.45

Place = tuple[float, float]


def draw(dfg: DFG) -> Picture:
    """Return the graph: sources on top, edges that carry words to later iterations in another
    colour with their distance, edges that only order dotted.
    """
    layers = _layers(dfg)
    widths = {node.id: _width(node) for node in dfg.nodes}
    rows = [sum(widths[node] + _GAP for node in layer) for layer in layers]
    whole = max([_LEAST_WIDTH, *rows])
    places: dict[int, Place] = {}
    for depth, (layer, row) in enumerate(zip(layers, rows, strict=True)):
        x = _MARGIN + (whole - row) / 2
        for number in layer:
            places[number] = (x + widths[number] / 2, 2 * _MARGIN + depth * _LAYER)
            x += widths[number] + _GAP
    shapes: list[Shape] = [Text(_MARGIN, _MARGIN / 2 + 2, dfg.name, size=12, bold=True)]
    for edge in sorted(dfg.edges, key=lambda edge: edge.distance):
        shapes += _edge(edge, places)
    for node in dfg.nodes:
        shapes += _node(node, places[node.id], widths[node.id])
    height = 2 * _MARGIN + len(layers) * _LAYER
    return Picture(whole + 2 * _MARGIN, height, tuple(shapes), title=dfg.name)


def _layers(dfg: DFG) -> list[list[int]]:
    """Nodes by the longest path of this iteration before them, each layer in order from the left;
    what is on a cycle without a distance, which no loop has, comes last.
    """
    order = partial_order(dfg)
    behind = {edge.src for edge in dfg.edges if not edge.distance}
    depth: dict[int, int] = {}
    for number in order:
        before = (e for e in dfg.in_edges[number] if not e.distance and e.src in depth)
        depth[number] = max((depth[edge.src] + 1 for edge in before), default=0)
    last = max(depth.values(), default=0) + 1
    for node in dfg.nodes:
        depth.setdefault(node.id, last)
    for node in dfg.nodes:  # a source stands just above the first that reads it
        if node.is_source and node.id in behind:
            after = [depth[e.dst] for e in dfg.out_edges[node.id] if not e.distance]
            depth[node.id] = max(0, min(after) - 1)
    layers: list[list[int]] = [[] for _ in range(max(depth.values(), default=-1) + 1)]
    for node in dfg.nodes:
        layers[depth[node.id]].append(node.id)
    return _untangled(dfg, layers)


def _untangled(dfg: DFG, layers: list[list[int]]) -> list[list[int]]:
    """Sort each layer by the middle of its neighbours above and below, in turn."""
    above = {n: [e.src for e in edges if not e.distance] for n, edges in dfg.in_edges.items()}
    below = {n: [e.dst for e in edges if not e.distance] for n, edges in dfg.out_edges.items()}
    for sweep in range(_SWEEPS):
        at = {node: _share(place, layer) for layer in layers for place, node in enumerate(layer)}
        neighbours = above if sweep % 2 == 0 else below
        for layer in layers if sweep % 2 == 0 else reversed(layers):
            layer.sort(key=lambda node: _middle(neighbours[node], at, at[node]))
            at |= {node: _share(place, layer) for place, node in enumerate(layer)}
    return layers


def _share(place: int, layer: Sequence[int]) -> float:
    return (place + 0.5) / len(layer)


def _middle(neighbours: Sequence[int], at: Mapping[int, float], own: float) -> float:
    return mean(at[node] for node in neighbours) if neighbours else own


def label(node: Node) -> str:
    """What stands in a node: its constant, its name, or its operation."""
    text = node.op.value
    if node.const is not None:
        text = f"{node.const:#x}" if node.const > _LARGE else str(node.const)
    elif node.name:
        text = node.name if node.is_source else f"{text} {node.name}"
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"


def _width(node: Node) -> float:
    return max(_LEAST_WIDTH, text_width(label(node), _SIZE) + 10)


def _node(node: Node, place: Place, width: float) -> Iterator[Shape]:
    x, y = place
    colour = _COLOURS.get(node.latency_class, "orange")
    fill = tint(OKABE_ITO["grey" if node.is_source else colour], _STRENGTH)
    title = f"{node.id}: {node.op.value} {node.name}".strip()
    title = title if node.loc is None else f"{title} ({node.loc})"
    yield Rect(
        x - width / 2,
        y - _HEIGHT / 2,
        width,
        _HEIGHT,
        fill=fill,
        stroke=None if node.is_source else INK,
        stroke_width=0.8,
        radius=9.0 if node.is_source else 2.0,
        title=title,
    )
    yield Text(x, y, label(node), size=_SIZE, anchor="middle")


def _edge(edge: Edge, places: Mapping[int, Place]) -> Iterator[Shape]:
    (x, y), (to_x, to_y) = places[edge.src], places[edge.dst]
    half = _HEIGHT / 2
    if not edge.distance:
        colour = INK if edge.is_data else _ORDER
        straight = ((x, y + half), (to_x, to_y - half))
        yield Line(straight, colour, 0.8, arrow=True, dashed=not edge.is_data)
        return
    if edge.init is not None:
        first_x, first_y = places[edge.init]
        first = ((first_x, first_y + half), (to_x, to_y - half))
        yield Line(first, _CARRIED, 0.6, arrow=True, dashed=True)
    side = x + (to_x - x) / 2 + (30.0 if edge.src != edge.dst else 40.0)
    points = (
        (x, y + half),
        (x + 8, y + half + 8),
        (side, (y + to_y) / 2),
        (to_x + 8, to_y - half - 8),
        (to_x, to_y - half),
    )
    yield Line(points, _CARRIED, 1.2, arrow=True, dashed=not edge.is_data)
    yield Text(side + 3, (y + to_y) / 2, str(edge.distance), size=_SIZE, fill=_CARRIED, bold=True)


def plot(self: DFG, path: str | Path | None = None) -> Picture:
    """Draw the graph in layers.

    Parameters
    ----------
    path
        Where to write the picture: `.svg` or `.png`. None: only return it.

    Raises
    ------
    VividcError
        The ending names no format, or the file cannot be written.
    """
    if path is not None:
        demand_type(path, (str, os.PathLike), "the file", "give a path that ends in .svg")
    picture = draw(self)
    if path is not None:
        write_whole(Path(path), encode(picture, Path(path)))
    return picture


def _repr_svg_(self: DFG) -> str:
    """What a notebook shows."""
    return to_svg(draw(self))


def attach() -> None:
    """Give graphs, which are data that know no pictures, the methods that users call."""
    for name, method in (("plot", plot), ("_repr_svg_", _repr_svg_)):
        setattr(DFG, name, method)
