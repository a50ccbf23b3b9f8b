"""The modulo reservation table: which operation each PE issues in each slot (Rau 1994)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Final

from vividc.arch.fabric import PE
from vividc.host.plot import Rect, Shape, Text, readable_on, text_width
from vividc.mapper.report.draw.array import FAINT, FRAME
from vividc.mapper.report.draw.label import fitted_id, name_and_id
from vividc.mapper.report.draw.scene import (
    IDLE,
    MOVE,
    Scene,
    colour_of,
    describe,
    operation_name,
    pale,
)

_HEADER: Final = 36.0
_ROW: Final = 15.0
_LABEL: Final = 46.0
_WIDE: Final = 78.0
_NARROW: Final = 27.0
_WIDE_UP_TO: Final = 12
_ROWS_A_BLOCK: Final = 32
_GAP: Final = 18.0
_FONT: Final = 8.5
_TITLE_FONT: Final = 11.0


@dataclass(frozen=True)
class ReservationTable:
    """Rows are PEs, columns slots; long tables continue in blocks side by side."""

    scene: Scene
    room: float

    @property
    def cell(self) -> float:
        """Width of a column: wide ones name the operation, narrow ones its id only."""
        return _WIDE if self.scene.mapping.ii <= _WIDE_UP_TO else _NARROW

    @property
    def block_width(self) -> float:
        """Width of one block, its gap included."""
        return _LABEL + self.scene.mapping.ii * self.cell + _GAP

    @property
    def blocks_a_row(self) -> int:
        """Blocks side by side."""
        return max(1, int((self.room + _GAP) // self.block_width))

    @property
    def blocks(self) -> int:
        """Blocks in all."""
        return max(1, -(-len(self.pes) // _ROWS_A_BLOCK))

    @cached_property
    def pes(self) -> tuple[PE, ...]:
        """The rows; of a large array only PEs that issue something."""
        pes = self.scene.fabric.pes
        if len(pes) <= _ROWS_A_BLOCK:
            return pes
        busy = {pe for pe, _ in [*self.scene.issues, *self.scene.moved, *self.scene.kept]}
        return tuple(pe for pe in pes if pe.id in busy)

    @property
    def width(self) -> float:
        """Width of all blocks."""
        title = 1.05 * text_width(self.title, _TITLE_FONT)
        return max(title, min(self.blocks, self.blocks_a_row) * self.block_width)

    @property
    def title(self) -> str:
        """What the table is, and what it leaves out."""
        shown = "operation, its id and stage" if self.cell == _WIDE else "ids of operations"
        left_out = len(self.scene.fabric.pes) - len(self.pes)
        rest = f"; {left_out} idle PEs are left out" if left_out else ""
        return f"Modulo reservation table ({shown}){rest}"

    @property
    def height(self) -> float:
        """Height of all blocks, the heading included."""
        rows = -(-self.blocks // self.blocks_a_row)
        return _HEADER + rows * self._block_height() - (rows > 0) * _GAP + 4

    def shapes(self) -> Iterator[Shape]:
        """All shapes; the origin is the top left corner."""
        yield Text(0, 9, self.title, _TITLE_FONT, bold=True)
        for block in range(self.blocks):
            x = block % self.blocks_a_row * self.block_width
            y = _HEADER + block // self.blocks_a_row * self._block_height()
            yield from self._block(block * _ROWS_A_BLOCK, x, y)

    def _block_height(self) -> float:
        rows = min(len(self.pes), _ROWS_A_BLOCK)
        return rows * _ROW + _ROW + _GAP

    def _block(self, first: int, x: float, y: float) -> Iterator[Shape]:
        ii = self.scene.mapping.ii
        for slot in range(ii):
            middle = x + _LABEL + (slot + 0.5) * self.cell
            yield Text(middle, y - _ROW / 2, str(slot), _FONT, "middle", bold=True)
        for row, pe in enumerate(self.pes[first : first + _ROWS_A_BLOCK]):
            top = y + row * _ROW
            label = f"PE {pe.id}" + (" M" if self.scene.marked(pe) else "")
            yield Text(x + _LABEL - 5, top + _ROW / 2, label, _FONT, "end")
            for slot in range(ii):
                yield from self._cell((pe.id, slot), x + _LABEL + slot * self.cell, top)

    def _cell(self, at: tuple[int, int], x: float, y: float) -> Iterator[Shape]:
        here = self.scene.issues.get(at, ())
        moved, kept = self.scene.moved.get(at, ()), self.scene.kept.get(at)
        if not here:
            text = self._label("mov", moved[0], self.cell) if moved else ""
            fill = MOVE if moved else IDLE if kept is None else pale(kept)
            yield Rect(x, y, self.cell, _ROW, fill, FRAME if moved or kept else FAINT, 0.5)
            yield Text(x + self.cell / 2, y + _ROW / 2, text, _FONT, "middle")
            return
        tip = "; ".join(describe(node, place, self.scene.fabric) for node, place in here)
        share = self.cell / len(here)
        for number, (node, place) in enumerate(here):
            fill, left = colour_of(node), x + number * share
            yield Rect(left, y, share, _ROW, fill, FRAME, 0.5, title=tip)
            tail = f" s{place.time // self.scene.mapping.ii}"
            text = self._label(operation_name(node), node.id, share, tail)
            yield Text(left + share / 2, y + _ROW / 2, text, _FONT, "middle", readable_on(fill))

    def _label(self, name: str, number: int, width: float, tail: str = "") -> str:
        """What happens in a cell `width` wide; narrow ones have room for the id only."""
        if width < _WIDE:
            return fitted_id(number, _FONT, width - 2)
        return name_and_id(name, number, _FONT, width - 4 - text_width(tail, _FONT)) + tail
