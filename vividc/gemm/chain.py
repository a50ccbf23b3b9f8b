"""Several layers as one program: each layer is a loop that reads the previous one's results in
place in the scratchpad.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from vividc.gemm.kept import key_of, read_program, write_program
from vividc.gemm.modes import sized
from vividc.gemm.program import CountedLoop, Shape, loops_program, region_report
from vividc.gemm.systolic import (
    BUFFER,
    GROUP_BYTES,
    OFFSETS,
    TABLE_ROW,
    BlockLayout,
    Form,
    GemmRegion,
    Stream,
    SystolicArray,
    base_name,
    gemm_region,
    lanes,
    windows,
)
from vividc.machine.params import DType, Param
from vividc.program import WORD_BYTES, Program

START_CONTEXTS = 2
"""Contexts of the start of a loop."""


@dataclass(frozen=True, slots=True)
class Link:
    """A layer of a chain: its product, and its blocks of columns."""

    form: Form
    bands: int


@dataclass(frozen=True)
class Chain:
    """Layers that run as one program on an array, and where their operands lie.

    Odd layers read what even ones write. The weights of all layers lie one behind the other in the
    stream of B, the tables of places in theirs.

    Attributes
    ----------
    parts
        Equal parts of the scratchpad, each with all operands: transfers to one hide behind a run
        on the other.
    """

    array: SystolicArray
    links: tuple[Link, ...]
    parts: int

    @property
    def words(self) -> int:
        """Words of a part."""
        return self.array.fabric.scratchpad.words // self.parts

    @cached_property
    def shapes(self) -> tuple[Shape, ...]:
        """The layers' products.

        Raises
        ------
        SystolicError
            One of them fits no array's memories.
        """
        return tuple(Shape.of(self.array, link.form, self.words) for link in self.links)

    @property
    def layouts(self) -> tuple[BlockLayout, ...]:
        """Where the layers' operands lie."""
        return tuple(shape.layout for shape in self.shapes)

    @property
    def contexts(self) -> int:
        """Contexts of the program."""
        return sum(shape.ii + START_CONTEXTS for shape in self.shapes)

    @property
    def weights(self) -> tuple[int, ...]:
        """First element of each layer's weights in the stream of B, and the end."""
        sizes = [
            link.bands * layout.band for link, layout in zip(self.links, self.layouts, strict=True)
        ]
        return tuple(int(x) for x in np.cumsum([0, *sizes]))

    @property
    def blocks(self) -> int:
        """Most blocks of rows of a launch; 0: the chain does not fit."""
        room = self.layouts[0].room
        if self.weights[-1] > room or self.contexts > self.array.fabric.controller.contexts:
            return 0
        widths = [self.width(layer) for layer in range(len(self.links) + 1)]
        table = TABLE_ROW * sum(link.bands for link in self.links)
        return min(room // (self.array.rows * max(widths)), room // table)

    def width(self, layer: int) -> int:
        """Columns of words of a layer's input as they lie there; behind the last layer: of its
        output.
        """
        if layer == 0:
            return self.links[0].form.depth
        return self.links[layer - 1].bands * self.band_width(layer - 1)

    def band_width(self, layer: int) -> int:
        """Columns of words that a block of columns of a layer's results makes."""
        return self.array.cols // lanes(self.links[layer].form.results)

    def cycles(self, blocks: int) -> int:
        """Cycles of a launch over `blocks` blocks of rows: exact, as no two accesses meet."""
        switches = (len(self.links) - 1) * self.array.fabric.controller.switch_cycles
        pairs = zip(self.shapes, self.links, strict=True)
        return switches + sum(shape.cycles(blocks * link.bands) for shape, link in pairs)

    def tables(self, blocks: int) -> tuple[NDArray[np.uint32], tuple[int, ...]]:
        """The tables of places for up to `blocks` blocks of rows, uint32 [elements], and the first
        element of each layer's.

        A launch of fewer blocks reads the beginning of each.
        """
        parts, starts, at = [], [], 0
        for layer, (link, layout) in enumerate(zip(self.links, self.layouts, strict=True)):
            block, band = np.divmod(np.arange(blocks * link.bands), link.bands)
            rows = np.zeros((block.size, TABLE_ROW), np.int64)
            rows[:, Stream.A] = block * layout.a(0, self.width(layer))
            rows[:, Stream.B] = self.weights[layer] + band * layout.band
            rows[:, Stream.C] = block * layout.c(0, self.width(layer + 1))
            rows[:, Stream.C] += band * layout.c(0, self.band_width(layer))
            parts.append((rows * GROUP_BYTES).astype(np.uint32).ravel())
            starts.append(at)
            at += parts[-1].size
        return np.concatenate(parts), tuple(starts)

    @staticmethod
    def streams(layer: int) -> tuple[Stream, Stream]:
        """Where a layer's input and output lie."""
        return (Stream.C, Stream.A) if layer % 2 else (Stream.A, Stream.C)

    @property
    def output(self) -> Stream:
        """Where the last layer's output lies."""
        return self.streams(len(self.links) - 1)[1]

    def scalars(self, part: int, blocks: int, tables: Sequence[int]) -> dict[str, int]:
        """Scalar arguments of a launch.

        Parameters
        ----------
        part
            Which part of the scratchpad it works on.
        tables
            First element of each layer's table.
        """
        first = part * self.words * WORD_BYTES
        words: dict[str, int] = {}
        for layer, (link, layout) in enumerate(zip(self.links, self.layouts, strict=True)):
            words[f"blocks{layer}"] = blocks * link.bands
            for stream, prefix in _names(layer).items():
                source = Stream[prefix.upper()] if prefix in ("a", "b", "c") else Stream.TABLE
                offset = tables[layer] * GROUP_BYTES if stream is Stream.TABLE else 0
                for window in range(windows(layout, stream)):
                    name = base_name(stream, window, prefix)
                    words[name] = first + source * WORD_BYTES + window * OFFSETS + offset
        return words


def _names(layer: int) -> dict[Stream, str]:
    """Prefixes of the live-ins of a layer's streams."""
    source, target = Chain.streams(layer)
    return {
        Stream.A: source.name.lower(),
        Stream.B: "b",
        Stream.C: target.name.lower(),
        Stream.TABLE: f"table{layer}_",
    }


def chain_program(chain: Chain) -> Program:
    """The program of a chain.

    Raises
    ------
    SystolicError
        A layer fits no array's memories.
    """
    forms = tuple(link.form for link in chain.links)
    fabric = chain.array.fabric
    return kept_program(fabric.name, fabric.scratchpad.size_bytes, forms, chain.words)


@lru_cache(maxsize=16)
def kept_program(name: str, size_bytes: int, forms: tuple[Form, ...], words: int) -> Program:
    array = SystolicArray.of(sized(name, size_bytes))
    key = key_of(array.fabric, forms, words)
    program = read_program(key)
    if program is None:
        program = built_program(array, forms, words)
        write_program(key, program)
    return program


def built_program(array: SystolicArray, forms: tuple[Form, ...], words: int) -> Program:
    loops: list[CountedLoop] = []
    names: dict[str, None] = {}
    for layer, form in enumerate(forms):
        region = gemm_region(array, form, words=words, names=_names(layer))
        number, report = str(layer), region_report(region)
        loops.append(CountedLoop(number, f"gemm{layer}", f"blocks{layer}", region.dfg, report))
        names |= dict.fromkeys(_live_ins(region, layer))
    words_given = (*(loop.trip for loop in loops), *names)
    params = [Param(BUFFER, DType.F32, 2), *(Param(name, DType.I32) for name in words_given)]
    return loops_program("gemm", array.fabric, params, loops)


def _live_ins(region: GemmRegion, layer: int) -> list[str]:
    return [
        base_name(stream, window, prefix)
        for stream, prefix in _names(layer).items()
        for window in range(windows(region.layout, stream))
    ]
