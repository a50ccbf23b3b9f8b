"""A mapping as a picture: the array slot by slot, then the modulo reservation table."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG
from vividc.host.plot import Line, Picture, Rect, Shape, Text, text_width, translated
from vividc.mapper.mapping import Mapping
from vividc.mapper.report.draw.array import CHIP, FRAME, WIRE, ArrayPanel
from vividc.mapper.report.draw.label import fitted
from vividc.mapper.report.draw.scene import MOVE, Scene, groups_of, scene_of
from vividc.mapper.report.draw.table import ReservationTable

_MARGIN: Final = 14.0
_TITLE: Final = 46.0
_LEGEND: Final = 24.0
_WIDTH: Final = 1500.0
_SPACE: Final = 10.0
_FONT: Final = 15.0
_BOLD: Final = 1.08  # how much wider bold text is
_LEAST_HEADLINE: Final = 300.0


def draw(dfg: DFG, fabric: Fabric, mapping: Mapping) -> Picture:
    """The picture of a mapping.

    One panel a slot shows the array in steady state: what each PE issues (with the operation's id
    and stage), the links that are driven in the slot and the registers that hold a word, both
    with the id of the word's producer. Links between PEs that are no neighbours lead round those
    between, and links that wrap around are drawn as stubs. Larger arrays are drawn with less text.
    Below stands the modulo reservation table.

    Raises
    ------
    VividcError
        The mapping is not one of this graph on this fabric.
    """
    scene = scene_of(dfg, fabric, mapping)
    panel = ArrayPanel(scene)
    grid = panel.grid
    rows = -(-mapping.ii // max(1, int(_WIDTH // grid.width)))
    a_row = -(-mapping.ii // rows)
    room = max(a_row * grid.width, _WIDTH / 2)
    table = ReservationTable(scene, room)
    top = _TITLE + _LEGEND
    shapes = list(_moved(_legend(scene), _MARGIN, _TITLE))
    for slot in range(mapping.ii):
        x = _MARGIN + slot % a_row * grid.width
        y = top + slot // a_row * (grid.height + _SPACE)
        shapes += _moved(panel.shapes(slot), x, y)
    bottom = top + rows * (grid.height + _SPACE) + _SPACE
    shapes += _moved(table.shapes(), _MARGIN, bottom)
    width = max(a_row * grid.width, table.width, _least_width(scene))
    shapes += _title(scene, width)
    title = f"{dfg.name} on {fabric.name}"
    height = bottom + table.height + _MARGIN
    return Picture(width + 2 * _MARGIN, height, tuple(shapes), title)


def _moved(shapes: Iterable[Shape], x: float, y: float) -> Iterator[Shape]:
    return (translated(shape, x, y) for shape in shapes)


def _title(scene: Scene, width: float) -> Iterator[Shape]:
    yield Text(_MARGIN, _MARGIN, _headline(scene, width), _FONT, bold=True)
    yield Text(_MARGIN, _MARGIN + 19, scene.usage(), 10)


def _headline(scene: Scene, width: float) -> str:
    """Names that are too long are shortened; the picture is not stretched for them."""
    stages = f"{scene.stages} stage" + ("s" if scene.stages > 1 else "")
    tail = f": II {scene.mapping.ii}, {stages}"
    room = width / _BOLD - text_width(f" on {tail}", _FONT)
    fabric = fitted(scene.fabric.name, _FONT, room / 2)
    graph = fitted(scene.dfg.name, _FONT, room - text_width(fabric, _FONT))
    return f"{graph} on {fabric}{tail}"


def _least_width(scene: Scene) -> float:
    """Least width that has room for what stands above the panels."""
    legend = max((x + _entry_width(name) for x, name in _entries(scene)), default=0.0)
    return max(text_width(scene.usage(), 10), legend, _LEAST_HEADLINE)


def _entries(scene: Scene) -> list[tuple[float, str]]:
    x, entries = 0.0, []
    for name in [*(name for name, _ in groups_of(scene.dfg)), *_signs(scene)]:
        entries.append((x, name))
        x += _entry_width(name) + 14
    return entries


def _entry_width(name: str) -> float:
    return 22 + text_width(name, 9)


_LINK: Final = "word on a link, by producer"
_HELD: Final = "word in a register (r) or output (o)"
_HELD_ROTATING: Final = f"{_HELD}; r is its name when the word's iteration began (rotating files)"
_MOVED: Final = "word moved by an FU"
_MEMORY: Final = "PE with load/store unit"


def _signs(scene: Scene) -> list[str]:
    """What the picture shows besides operations."""
    rotates = any(pe.rotating for pe in scene.fabric.pes)
    signs = (
        (_LINK, scene.driven),
        (_HELD_ROTATING if rotates else _HELD, scene.held),
        (_MOVED, scene.moved),
        (_MEMORY, scene.fabric_has_plain_pes),
    )
    return [name for name, shown in signs if shown]


def _legend(scene: Scene) -> Iterator[Shape]:
    colours = dict(groups_of(scene.dfg)) | {_HELD: CHIP, _HELD_ROTATING: CHIP, _MOVED: MOVE}
    for x, name in _entries(scene):
        if name == _LINK:
            yield Line(((x, 6), (x + 16, 6)), WIRE, 1.3, arrow=True)
        elif name == _MEMORY:
            yield Rect(x, 1, 16, 10, None, FRAME, 1.8, 2)
        else:
            yield Rect(x, 1, 16, 10, colours[name], FRAME, 0.5, 2)
        yield Text(x + 21, 6, name, 9)
