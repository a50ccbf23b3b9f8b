"""A fabric as a picture: PEs with their ids, load/store units marked, and links."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from vividc.arch.draw.grid import Grid
from vividc.arch.draw.wires import wires, wrap_arounds
from vividc.arch.fabric import PE, Fabric
from vividc.host.plot import INK, OKABE_ITO, Line, Picture, Rect, Shape, Text, tint, to_svg

_WIRE: Final = tint(OKABE_ITO["blue"], 0.7)
_PE: Final = tint(OKABE_ITO["grey"], 0.25)
_MEMORY: Final = tint(OKABE_ITO["green"], 0.45)
_SMALL: Final = 0.72
_MARGIN: Final = 14.0
_NOTE: Final = 20.0


def draw(fabric: Fabric) -> Picture:
    """Return the array; PEs with a load/store unit are green, and marked with an M."""
    grid = Grid(fabric)
    shapes: list[Shape] = [Text(_MARGIN, 11, fabric.name, 11, bold=True)]
    for wire in wires(grid, wrap_arounds(fabric), fabric.links):
        shapes += (Line(run, _WIRE, grid.detail.wire, arrow=True) for run in wire.runs)
    for pe in fabric.pes:
        shapes += _pe(pe, grid)
    bottom = grid.height + _NOTE
    note = f"{repr(fabric)[1:-1]}, {len(fabric.links)} links"
    shapes.append(Text(_MARGIN, bottom - _NOTE / 2, note, 9))
    return Picture(max(grid.width, 260.0), bottom, tuple(shapes), fabric.name)


def _pe(pe: PE, grid: Grid) -> Iterator[Shape]:
    d = grid.detail
    x, y = grid.corner(pe)
    fill = _MEMORY if pe.has_memory else _PE
    what = ", ".join(sorted(lat.value for lat in pe.classes))
    tip = f"PE {pe.id}, row {pe.row}, column {pe.col}: {pe.registers} registers; {what}"
    yield Rect(x, y, d.width, d.height, fill, INK, 0.8, 3, tip)
    name = f"{pe.id} M" if pe.has_memory and d.names else str(pe.id)
    yield Text(x + d.width / 2, y + d.height / 2, name, d.font, "middle")
    if d.chips > 1:
        words = f"{pe.registers} registers"
        yield Text(x + d.width / 2, y + 0.8 * d.height, words, _SMALL * d.font, "middle")


def _repr_svg_(self: Fabric) -> str:
    """What a notebook shows."""
    return to_svg(draw(self))


def attach() -> None:
    """Give fabrics, which are data that know no pictures, the picture that notebooks show."""
    setattr(Fabric, "_repr_svg_", _repr_svg_)  # noqa: B010 - mypy knows no such attribute
