"""A mapping as a picture: the array slot by slot, then the modulo reservation table."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG
from vividc.mapper.draw_array import CHIP, FRAME, WIRE, ArrayPanel, detail_of
from vividc.mapper.draw_scene import MOVE, Scene, groups_of, scene_of
from vividc.mapper.draw_table import ReservationTable
from vividc.mapper.mapping import Mapping
from vividc.plot import Line, Picture, Rect, Shape, Text, text_width, translated

_MARGIN: Final = 14.0
_TITLE: Final = 46.0
_LEGEND: Final = 24.0
_WIDTH: Final = 1500.0
_SPACE: Final = 10.0


def draw(dfg: DFG, fabric: Fabric, mapping: Mapping) -> Picture:
    """The picture of a mapping.

    One panel a slot shows the array in steady state: what each PE issues (with the operation's id
    and stage), the links that are driven in the slot and the registers that hold a word, both
    with the id of the word's producer. Links that wrap around are drawn as stubs. Larger arrays
    are drawn with less text. Below stands the modulo reservation table.

    Raises
    ------
    VividcError
        The mapping is not one of this graph on this fabric.
    """
    scene = scene_of(dfg, fabric, mapping)
    panel = ArrayPanel(scene, detail_of(scene))
    rows = -(-mapping.ii // max(1, int(_WIDTH // panel.width)))
    a_row = -(-mapping.ii // rows)
    room = max(a_row * panel.width, _WIDTH / 2)
    table = ReservationTable(scene, room)
    top = _TITLE + _LEGEND
    shapes: list[Shape] = [*_title(scene), *_moved(_legend(scene), _MARGIN, _TITLE)]
    for slot in range(mapping.ii):
        x = _MARGIN + slot % a_row * panel.width
        y = top + slot // a_row * (panel.height + _SPACE)
        shapes += _moved(panel.shapes(slot), x, y)
    bottom = top + rows * (panel.height + _SPACE) + _SPACE
    shapes += _moved(table.shapes(), _MARGIN, bottom)
    width = max(a_row * panel.width, table.width, _title_width(scene)) + 2 * _MARGIN
    title = f"{dfg.name} on {fabric.name}"
    return Picture(width, bottom + table.height + _MARGIN, tuple(shapes), title)


def _moved(shapes: Iterable[Shape], x: float, y: float) -> Iterator[Shape]:
    return (translated(shape, x, y) for shape in shapes)


def _headline(scene: Scene) -> str:
    stages = f"{scene.stages} stage" + ("s" if scene.stages > 1 else "")
    return f"{scene.dfg.name} on {scene.fabric.name}: II {scene.mapping.ii}, {stages}"


def _title(scene: Scene) -> Iterator[Shape]:
    yield Text(_MARGIN, _MARGIN, _headline(scene), 15, bold=True)
    yield Text(_MARGIN, _MARGIN + 19, scene.usage(), 10)


def _title_width(scene: Scene) -> float:
    legend = max((x for x, _ in _entries(scene)), default=0.0) + 120
    return max(text_width(_headline(scene), 15) * 1.08, text_width(scene.usage(), 10), legend)


def _entries(scene: Scene) -> list[tuple[float, str]]:
    x, entries = 0.0, []
    for name in [*(name for name, _ in groups_of(scene.dfg)), *_signs(scene)]:
        entries.append((x, name))
        x += 22 + text_width(name, 9) + 14
    return entries


_LINK: Final = "word on a link, by producer"
_HELD: Final = "word in a register (r) or output (o)"
_MOVED: Final = "word moved by an FU"
_MEMORY: Final = "PE with load/store unit"


def _signs(scene: Scene) -> list[str]:
    """What the picture shows besides operations."""
    signs = (
        (_LINK, scene.driven),
        (_HELD, scene.held),
        (_MOVED, scene.moved),
        (_MEMORY, scene.fabric_has_plain_pes),
    )
    return [name for name, shown in signs if shown]


def _legend(scene: Scene) -> Iterator[Shape]:
    colours = dict(groups_of(scene.dfg)) | {_HELD: CHIP, _MOVED: MOVE}
    for x, name in _entries(scene):
        if name == _LINK:
            yield Line(((x, 6), (x + 16, 6)), WIRE, 1.3, arrow=True)
        elif name == _MEMORY:
            yield Rect(x, 1, 16, 10, None, FRAME, 1.8, 2)
        else:
            yield Rect(x, 1, 16, 10, colours[name], FRAME, 0.5, 2)
        yield Text(x + 21, 6, name, 9)
