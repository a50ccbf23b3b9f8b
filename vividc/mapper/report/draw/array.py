"""The array in one slot: PEs with what they issue and hold, links with what they carry."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Final

from vividc.arch.draw.grid import FULL, HEADER, Detail, Grid
from vividc.arch.draw.wires import Wire, wires, wrap_arounds
from vividc.arch.fabric import PE
from vividc.dfg.ir import Node
from vividc.host.plot import (
    OKABE_ITO,
    PAPER,
    Line,
    Rect,
    Shape,
    Text,
    readable_on,
    text_width,
    tint,
)
from vividc.mapper.report.draw.label import fitted, fitted_id, name_and_id
from vividc.mapper.report.draw.scene import (
    IDLE,
    MOVE,
    Scene,
    colour_of,
    describe,
    operation_name,
    pale,
)

WIRE: Final = OKABE_ITO["blue"]
CHIP: Final = tint(OKABE_ITO["vermilion"], 0.35)
FRAME: Final = "#555555"
FAINT: Final = "#c8c8c8"


_CHIP_HEIGHT: Final = 12.0
_CHIPS_A_ROW: Final = 3
_CHIP_FONT: Final = 7.5
_LEAST_FONT: Final = 5.0
_SMALL_FONT: Final = 5.5
_SHORTENED: Final = 0.6  # of a gap: a label that is cut, beside one of the other direction


@dataclass(frozen=True)
class ArrayPanel:
    """Draws one slot; its origin is the top left corner of the panel."""

    scene: Scene

    @cached_property
    def grid(self) -> Grid:
        """Where the PEs lie."""
        return Grid(self.scene.fabric)

    @cached_property
    def wrapped(self) -> frozenset[int]:
        """Ids of the links that wrap around."""
        return wrap_arounds(self.scene.fabric)

    def shapes(self, slot: int) -> Iterator[Shape]:
        """The shapes of one slot: wires lowest, then PEs, then labels on wires."""
        ii = self.scene.mapping.ii
        yield Rect(4, 0, self.grid.width - 8, self.grid.height, None, FAINT, 0.8, 4)
        title = f"slot {slot}" if ii > 1 else "every cycle"
        yield Text(12, HEADER / 2 + 3, title, 11, bold=True)
        carried = self._carried(slot)
        labels: list[Shape] = []
        for wire in wires(self.grid, self.wrapped, (self.scene.fabric.links[k] for k in carried)):
            for run in wire.runs:
                yield Line(run, WIRE, self.grid.detail.wire, arrow=True)
            labels += self._wire_label(wire, carried[wire.link.id])
        for pe in self.scene.fabric.pes:
            yield from self._pe(pe, slot)
        yield from labels

    def _carried(self, slot: int) -> dict[int, list[int]]:
        """The words on each link that is driven, by link id."""
        words: dict[int, list[int]] = {}
        for link, value in self.scene.driven.get(slot, ()):
            words.setdefault(link, []).append(value)
        return words

    def _pe(self, pe: PE, slot: int) -> Iterator[Shape]:
        d = self.grid.detail
        x, y = self.grid.corner(pe)
        here = self.scene.issues.get((pe.id, slot), ())
        issued = next(((node, place) for node, place in here if node.uses_fu), None)
        kept = self.scene.kept.get((pe.id, slot))
        fill = IDLE if kept is None else pale(kept)
        fill = fill if issued is None else colour_of(issued[0])
        tip = "; ".join(describe(each, place, self.scene.fabric) for each, place in here)
        tip = tip or ("idle" if kept is None else f"kept by #{kept.id}")
        stroke = FRAME if here else FAINT
        pen = 1.8 if self.scene.marked(pe) else 0.9
        yield Rect(x, y, d.width, d.height, fill, stroke, pen, 3, f"PE {pe.id}: {tip}")
        if d.names:
            yield Text(x + 4, y + 0.65 * d.font, str(pe.id), _pe_font(d), fill=readable_on(fill))
        if issued is not None:
            stage = issued[1].time // self.scene.mapping.ii
            yield from self._operation(pe, issued[0], stage)
        yield from self._chips(pe, slot)

    def _operation(self, pe: PE, node: Node, stage: int) -> Iterator[Shape]:
        d = self.grid.detail
        x, y = self.grid.corner(pe)
        ink = readable_on(colour_of(node))
        middle, room = x + d.width / 2, d.width - 6
        corner = (x + d.width - 4, y + 0.65 * d.font)
        if not d.names:
            text, size = _shrunk("", node.id, d.font, d.width - 4)
            yield Text(middle, y + 0.38 * d.height, text, size, "middle", ink)
        elif d.chips > _CHIPS_A_ROW:
            text = name_and_id(operation_name(node), node.id, d.font, room)
            yield Text(middle, y + 0.36 * d.height, text, d.font, "middle", ink, True)
            yield Text(*corner, f"s{stage}", 0.7 * d.font, "end", ink)
        else:
            text = fitted(operation_name(node), d.font, room)
            yield Text(middle, y + 0.46 * d.height, text, d.font, "middle", ink)
            beside = room - text_width(str(pe.id), _pe_font(d)) - 5
            number = fitted_id(node.id, 0.8 * d.font, beside)
            yield Text(*corner, number, 0.8 * d.font, "end", ink)

    def _words(self, pe: PE, slot: int) -> list[tuple[str, int, str]]:
        """(what, id, fill) of each word that the PE holds, or delivers to its constant store."""
        held = self.scene.held.get((pe.id, slot), ())
        words = [
            ("o:" if kind == "out" else f"{kind[0]}{index}:", value, CHIP)
            for kind, index, value in held
        ]
        words += [("mov ", value, MOVE) for value in self.scene.moved.get((pe.id, slot), ())]
        for node, _ in self.scene.issues.get((pe.id, slot), ()):
            if not node.uses_fu:
                words.append(("out ", node.id, colour_of(node)))
        return words

    def _chips(self, pe: PE, slot: int) -> Iterator[Shape]:
        d = self.grid.detail
        x, y = self.grid.corner(pe)
        words = self._words(pe, slot)
        if not words:
            return
        if len(words) > d.chips:
            yield from self._summary(len(words), x, y)
            return
        width = (d.width - 6) / min(_CHIPS_A_ROW, d.chips)
        rows = -(-d.chips // _CHIPS_A_ROW)
        for number, (what, value, fill) in enumerate(words):
            left = x + 3 + number % _CHIPS_A_ROW * width
            top = y + d.height - 3 - (rows - number // _CHIPS_A_ROW) * _CHIP_HEIGHT
            yield Rect(left, top, width - 1, _CHIP_HEIGHT - 1, fill, FRAME, 0.5, 2)
            text, size = _shrunk(what, value, _CHIP_FONT, width - 3)
            yield Text(left + width / 2 - 0.5, top + _CHIP_HEIGHT / 2 - 0.5, text, size, "middle")

    def _summary(self, count: int, x: float, y: float) -> Iterator[Shape]:
        d = self.grid.detail
        text = f"{count} words held" if d.width >= FULL.width else f"+{count}"
        size = 7.5 if d.names else _SMALL_FONT
        width, height = text_width(text, size) + 3, size + 2
        left, top = x + d.width - width - 2, y + d.height - height - 1.5
        yield Rect(left, top, width, height, CHIP, FRAME, 0.4, 1.5)
        yield Text(left + width / 2, top + height / 2, text, size, "middle")

    def _wire_label(self, wire: Wire, values: list[int]) -> Iterator[Shape]:
        d = self.grid.detail
        size = 0.72 * d.font if d.names else _SMALL_FONT
        text = ",".join(map(str, values))
        if text_width(text, size) > d.gap - 5:
            room = _SHORTENED * d.gap / len(values)
            text = ",".join(fitted_id(value, size, room) for value in values)
        width = text_width(text, size) + 1.6
        for x, y in wire.labels:
            yield Rect(x - width / 2, y - size / 2, width, size, PAPER, None)
            yield Text(x, y, text, size, "middle", WIRE)


def _pe_font(detail: Detail) -> float:
    return 0.76 * detail.font


def _shrunk(what: str, number: int, size: float, width: float) -> tuple[str, float]:
    """A word's label and its font: as small as can be read, then with less of the id."""
    text = f"{what}{number}"
    shrunk = size * min(1.0, width / text_width(text, size))
    if shrunk >= _LEAST_FONT:
        return text, shrunk
    return what + fitted_id(number, _LEAST_FONT, width - text_width(what, _LEAST_FONT)), _LEAST_FONT
