"""Windows of a block in a scratchpad, and constant tables at its end: where each lies, and the
launch words that say so.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from vividc.launch.tiles.blocks import NestLaunch, Window
from vividc.machine.words import WORD_BYTES, WORD_MASK
from vividc.program import Program, pitch_words
from vividc.sim.footprint.boxes import Block, Box


def table_extents(program: Program, inputs: Mapping[str, int]) -> dict[str, tuple[int, int]]:
    """First byte and end of each constant table of a program's nests, and of each array of their
    own, one before the other from the end of a scratchpad: no block of any nest lies where a table
    of another does. Arrays of the same name share a place, the size of the largest.
    """
    words: dict[str, int] = {}
    for local in (local.at_launch(inputs) for nest in program.nests for local in nest.locals):
        words[local.name] = max(local.words, words.get(local.name, 0))
    end = program.fabric.scratchpad.size_bytes
    found: dict[str, tuple[int, int]] = {}
    for name, count in words.items():
        found[name] = (end - WORD_BYTES * count, end)
        end -= WORD_BYTES * count
    return found


@dataclass
class Placed:
    """Windows in a scratchpad, one behind the other from a byte on, and what moves them in."""

    launch: NestLaunch
    end: int
    windows: dict[str, Window] = field(default_factory=dict)
    starts: dict[str, int] = field(default_factory=dict)
    moves: list[int] = field(default_factory=list)

    def copy(self) -> Placed:
        """The same, to add to."""
        return Placed(
            self.launch, self.end, dict(self.windows), dict(self.starts), list(self.moves)
        )

    def add(self, name: str, window: Window) -> None:
        """Place a window so that elements are in the banks that the program wished for."""
        banks = self.launch.program.fabric.scratchpad.banks
        wish = self.launch.program.banks.get(name, 0) + self._first(name, window)
        place = self.end // WORD_BYTES
        self.starts[name] = WORD_BYTES * (place + (wish - place) % banks)
        self.windows[name] = window
        self.end = self.starts[name] + WORD_BYTES * window.words

    def _first(self, name: str, window: Window) -> int:
        """Words from an array's first element, were it there, to a window's."""
        if len(window.box) == 1:
            return window.box[0][0]
        (row, _), (column, _) = window.box
        return row * window.row + column

    def within(self, name: str, box: Box) -> tuple[int, int]:
        """First byte and end of a box in its window."""
        first, end = self.windows[name].offset(box)
        return self.starts[name] + first, self.starts[name] + end

    def extents(self) -> dict[str, tuple[int, int]]:
        """First byte and end of each array; of those that are not touched, nothing."""
        found = dict.fromkeys(self.launch.arrays, (0, 0)) | dict(self.launch.tables)
        for name, window in self.windows.items():
            start = self.starts[name]
            found[name] = (start, start + WORD_BYTES * window.words)
        return found

    def words(self) -> dict[str, int]:
        """Launch words: addresses and pitches."""
        found = {f"&{name}": 0 for name in self.launch.arrays}
        found |= {f"&{name}": start for name, (start, _) in self.launch.tables.items()}
        pitches = dict.fromkeys(self.launch.program.pitches, 0)
        for name, window in self.windows.items():
            first = WORD_BYTES * self._first(name, window)
            found[f"&{name}"] = (self.starts[name] - first) & WORD_MASK
            if name in pitches:
                flat = name in self.launch.flat
                pitches[name] = self.launch.arrays[name].shape[-1] if flat else window.row
        return found | pitch_words(pitches)

    def inputs(self, block: Block) -> dict[str, int]:
        """All launch words of a block's run."""
        return {**self.launch.inputs, **block.words(self.launch.parallel), **self.words()}
