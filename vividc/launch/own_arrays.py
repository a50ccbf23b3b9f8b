"""Where arrays that programs make are placed in a job written by hand, and what they overwrite.

They lie behind a run's arguments, where something else may lie, which nobody who writes the job can
see: then behind all that earlier steps put into the tile. Where that has no room, what they
overwrite is lost, and a later step that reads it is refused.

A step comes `after` earlier ones only, so the order in which steps were added is one in which they
may run, and a job's result does not depend on which.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

from vividc.errors import ArgumentError
from vividc.launch.steps import Execute, Step, Transfer
from vividc.program import WORD_BYTES


@dataclass(frozen=True, slots=True)
class _Lost:
    """Bytes of a tile that held data until `program` ran."""

    start: int
    end: int
    program: str


class OwnArrays:
    """What own arrays of runs took from each tile, as steps are added."""

    def __init__(self) -> None:
        self._lost: dict[int, list[_Lost]] = {}
        self._held: dict[int, dict[tuple[int, int], None]] = defaultdict(dict)

    def note(self, step: Step) -> None:
        """A step was added: keep first bytes and ends of what it puts into its tiles."""
        if isinstance(step, Transfer):
            if not step.to_dram:
                for tile in step.tiles:
                    self._held[tile][step.extent(step.size)] = None
        elif isinstance(step, Execute):
            own = {local.name for local in step.program.locals}
            for name, extent in step.stores.items():
                if name not in own:
                    self._held[step.tile][extent] = None

    def place(self, tile: int, size: int, end: int, room: int) -> int:
        """First byte for own arrays of `size` bytes, of a run whose arguments end at `end`."""
        held = self._held[tile]
        if size == 0 or not any(start < end + size and end < stop for start, stop in held):
            return end
        beyond = max(end, *(-(-stop // WORD_BYTES) * WORD_BYTES for _, stop in held))
        return beyond if beyond + size <= room else end

    def take(self, tile: int, own: tuple[int, int], program: str) -> None:
        """A run's own arrays lie here: what earlier steps left is lost."""
        start, end = own
        if start == end:
            return
        for first, stop in self._held[tile]:
            if first < end and start < stop:
                lost = _Lost(max(first, start), min(stop, end), program)
                self._lost.setdefault(tile, []).append(lost)

    def refill(self, tiles: Sequence[int], start: int, end: int) -> None:
        """Note that bytes are written again."""
        for tile in tiles:
            if tile in self._lost:
                self._lost[tile] = [
                    _Lost(first, stop, lost.program)
                    for lost in self._lost[tile]
                    for first, stop in ((lost.start, min(lost.end, start)),
                                        (max(lost.start, end), lost.end))
                    if first < stop
                ]  # fmt: skip

    def demand_kept(self, tile: int, start: int, end: int, what: str) -> None:
        """Refuse a step that reads what is lost.

        Raises
        ------
        ArgumentError
            Some of the bytes held data that a run overwrote with arrays of its own.
        """
        for lost in self._lost.get(tile, ()):
            if lost.start < end and start < lost.end:
                raise ArgumentError(
                    f"{what} reads bytes {max(start, lost.start)} to {min(end, lost.end)} of tile "
                    f"{tile}, where arrays that {lost.program} makes have overwritten them",
                    hint="the scratchpad has no other room for these: put less into the tile "
                    "before that run, or move it in again behind it",
                )
