"""The array in one slot: PEs with what they issue and hold, links with what they carry."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Final

from vividc.arch.fabric import PE, Link
from vividc.dfg.ir import Node
from vividc.mapper.draw_scene import (
    IDLE,
    MOVE,
    Scene,
    colour_of,
    describe,
    operation_name,
    pale,
)
from vividc.plot import OKABE_ITO, PAPER, Line, Rect, Shape, Text, readable_on, text_width, tint

WIRE: Final = OKABE_ITO["blue"]
CHIP: Final = tint(OKABE_ITO["vermilion"], 0.35)
FRAME: Final = "#555555"
FAINT: Final = "#c8c8c8"


@dataclass(frozen=True, slots=True)
class Detail:
    """Sizes in points. `chips`: held words that are named one by one; `names`: operations are."""

    width: float
    height: float
    gap: float
    font: float
    chips: int
    names: bool
    wire: float


_FULL: Final = Detail(82, 60, 34, 10.5, 6, True, 1.3)
_MEDIUM: Final = Detail(50, 38, 24, 9, 2, True, 1.1)
_SMALL: Final = Detail(25, 20, 15, 8, 0, False, 0.9)
_FULL_UP_TO: Final = 36
_MEDIUM_UP_TO: Final = 100
_HEADER: Final = 18.0
_CHIP_HEIGHT: Final = 12.0
_CHIPS_A_ROW: Final = 3
_SIDE: Final = 0.16  # the two directions of a link pair lie this far beside the middle


def detail_of(scene: Scene) -> Detail:
    """How much of a PE can be shown in an array of this size."""
    pes = len(scene.fabric.pes)
    if pes <= _FULL_UP_TO:
        return _FULL
    return _MEDIUM if pes <= _MEDIUM_UP_TO else _SMALL


@dataclass(frozen=True)
class ArrayPanel:
    """Draws one slot; its origin is the top left corner of the panel."""

    scene: Scene
    detail: Detail

    @property
    def width(self) -> float:
        """Width of a panel, margins included."""
        d = self.detail
        return self.scene.fabric.cols * (d.width + d.gap) - d.gap + 2 * self.margin

    @property
    def height(self) -> float:
        """Height of a panel, its header and margins included."""
        d = self.detail
        return _HEADER + self.scene.fabric.rows * (d.height + d.gap) - d.gap + 2 * self.margin

    @cached_property
    def margin(self) -> float:
        """Room around the PEs: for the stubs of long links where there are any."""
        pes = self.scene.fabric.pes
        spans = (_span(pes[link.src], pes[link.dst]) for link in self.scene.fabric.links)
        return (
            self.detail.gap + 6 if max(spans, default=0) > 1 else max(12.0, 0.4 * self.detail.gap)
        )

    def shapes(self, slot: int) -> Iterator[Shape]:
        """The shapes of one slot: wires lowest, then PEs, then labels on wires."""
        ii = self.scene.mapping.ii
        yield Rect(4, 0, self.width - 8, self.height, None, FAINT, 0.8, 4)
        title = f"slot {slot}" if ii > 1 else "every cycle"
        yield Text(12, _HEADER / 2 + 3, title, 11, bold=True)
        carried = self._carried(slot)
        labels: list[Shape] = []
        for link, values in carried:
            yield from self._wire(link)
            labels += self._wire_label(link, values)
        for pe in self.scene.fabric.pes:
            yield from self._pe(pe, slot)
        yield from labels

    def _carried(self, slot: int) -> list[tuple[Link, list[int]]]:
        words: dict[int, list[int]] = {}
        for link, value in self.scene.driven.get(slot, ()):
            words.setdefault(link, []).append(value)
        return [(self.scene.fabric.links[link], values) for link, values in words.items()]

    def _corner(self, pe: PE) -> tuple[float, float]:
        d, margin = self.detail, self.margin
        return (
            margin + pe.col * (d.width + d.gap),
            _HEADER + margin + pe.row * (d.height + d.gap),
        )

    def _pe(self, pe: PE, slot: int) -> Iterator[Shape]:
        d = self.detail
        x, y = self._corner(pe)
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
            yield Text(x + 4, y + 0.65 * d.font, str(pe.id), 0.7 * d.font, fill="#666666")
        if issued is not None:
            stage = issued[1].time // self.scene.mapping.ii
            yield from self._operation(x, y, issued[0], stage)
        yield from self._chips(pe, slot, x, y)

    def _operation(self, x: float, y: float, node: Node, stage: int) -> Iterator[Shape]:
        d = self.detail
        ink = readable_on(colour_of(node))
        middle, room = x + d.width / 2, d.width - 6
        name, number = operation_name(node), str(node.id)
        corner = (x + d.width - 4, y + 0.65 * d.font)
        if not d.names:
            size = min(d.font, d.font * (d.width - 4) / text_width(number, d.font))
            yield Text(middle, y + 0.38 * d.height, number, size, "middle", ink)
        elif d.chips > _CHIPS_A_ROW:
            text = fitted(name, d.font, room - text_width(f" {number}", d.font))
            yield Text(middle, y + 0.36 * d.height, f"{text} {number}", d.font, "middle", ink, True)
            yield Text(*corner, f"s{stage}", 0.7 * d.font, "end", ink)
        else:
            text = fitted(name, d.font, room)
            yield Text(middle, y + 0.46 * d.height, text, d.font, "middle", ink)
            yield Text(*corner, number, 0.8 * d.font, "end", ink)

    def _words(self, pe: PE, slot: int) -> list[tuple[str, str]]:
        """(text, fill) of each word that the PE holds, or delivers to its constant store."""
        held = self.scene.held.get((pe.id, slot), ())
        words = [
            (f"{'o' if kind == 'out' else f'{kind[0]}{index}'}:{value}", CHIP)
            for kind, index, value in held
        ]
        words += [(f"mov {value}", MOVE) for value in self.scene.moved.get((pe.id, slot), ())]
        for node, _ in self.scene.issues.get((pe.id, slot), ()):
            if not node.uses_fu:
                words.append((f"out {node.id}", colour_of(node)))
        return words

    def _chips(self, pe: PE, slot: int, x: float, y: float) -> Iterator[Shape]:
        d = self.detail
        words = self._words(pe, slot)
        if not words:
            return
        if len(words) > d.chips:
            yield from self._summary(len(words), x, y)
            return
        width = (d.width - 6) / min(_CHIPS_A_ROW, d.chips)
        rows = -(-d.chips // _CHIPS_A_ROW)
        for number, (text, fill) in enumerate(words):
            left = x + 3 + number % _CHIPS_A_ROW * width
            top = y + d.height - 3 - (rows - number // _CHIPS_A_ROW) * _CHIP_HEIGHT
            yield Rect(left, top, width - 1, _CHIP_HEIGHT - 1, fill, FRAME, 0.5, 2)
            size = min(7.5, 7.5 * (width - 2) / text_width(text, 7.5))
            yield Text(left + width / 2 - 0.5, top + _CHIP_HEIGHT / 2 - 0.5, text, size, "middle")

    def _summary(self, count: int, x: float, y: float) -> Iterator[Shape]:
        d = self.detail
        text = f"{count} words held" if d.width >= _FULL.width else f"+{count}"
        size = 7.5 if d.names else 5.5
        width, height = text_width(text, size) + 3, size + 2
        left, top = x + d.width - width - 2, y + d.height - height - 1.5
        yield Rect(left, top, width, height, CHIP, FRAME, 0.4, 1.5)
        yield Text(left + width / 2, top + height / 2, text, size, "middle")

    def _wire(self, link: Link) -> Iterator[Shape]:
        for start, end in self._runs(link):
            yield Line((start, end), WIRE, self.detail.wire, arrow=True)

    def _wire_label(self, link: Link, values: list[int]) -> Iterator[Shape]:
        text = ",".join(map(str, values))
        size = 0.72 * self.detail.font if self.detail.names else 5.5
        width = text_width(text, size) + 1.6
        if width > self.detail.gap - 5:
            return
        for (x0, y0), (x1, y1) in self._runs(link):
            x, y = x0 + 0.42 * (x1 - x0), y0 + 0.42 * (y1 - y0)
            yield Rect(x - width / 2, y - size / 2, width, size, PAPER, None)
            yield Text(x, y, text, size, "middle", WIRE)

    def _runs(self, link: Link) -> list[tuple[tuple[float, float], tuple[float, float]]]:
        """Where a link is drawn: between its PEs, or as two stubs where it wraps around."""
        src, dst = self.scene.fabric.pes[link.src], self.scene.fabric.pes[link.dst]
        rows, cols = dst.row - src.row, dst.col - src.col
        if max(abs(rows), abs(cols)) <= 1:
            return [self._between(src, dst, rows, cols)]
        # Longer ones are those of a torus and irregular ones: a stub at either end.
        out_row, out_col = (-_sign(rows) * (abs(rows) > 1), -_sign(cols) * (abs(cols) > 1))
        return [
            self._stub(src, out_row, out_col, out=True),
            self._stub(dst, -out_row, -out_col, out=False),
        ]

    def _between(
        self, src: PE, dst: PE, rows: int, cols: int
    ) -> tuple[tuple[float, float], tuple[float, float]]:
        return (self._port(src, rows, cols, 1), self._port(dst, -rows, -cols, -1))

    def _stub(
        self, pe: PE, row: int, col: int, *, out: bool
    ) -> tuple[tuple[float, float], tuple[float, float]]:
        x, y = self._port(pe, row, col, 1 if out else -1)
        length = 0.86 * self.detail.gap
        far = (x + col * length, y + row * length)
        return ((x, y), far) if out else (far, (x, y))

    def _port(self, pe: PE, row: int, col: int, side: int) -> tuple[float, float]:
        """A point on the PE's border towards (row, col), beside the middle by `side`."""
        d = self.detail
        left, top = self._corner(pe)
        x = left + d.width * (0.5 + 0.5 * col) + side * _SIDE * d.height * -row
        y = top + d.height * (0.5 + 0.5 * row) + side * _SIDE * d.height * col
        return (x, y)


def fitted(text: str, size: float, width: float) -> str:
    """The text, shortened until it fits."""
    if text_width(text, size) <= width:
        return text
    while len(text) > 1 and text_width(f"{text}.", size) > width:
        text = text[:-1]
    return f"{text}."


def _span(src: PE, dst: PE) -> int:
    return max(abs(dst.row - src.row), abs(dst.col - src.col))


def _sign(number: int) -> int:
    return (number > 0) - (number < 0)
