"""A function in the making, with what is known of its loops."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from vividc.errors import SourceLoc
from vividc.ssa.edit import block_of
from vividc.ssa.flow import Loop, find_loops
from vividc.ssa.ir import Function

MOST_INSTRUCTIONS = 1500
"""No transformation makes more: estimating it would take too long."""


@dataclass(frozen=True)
class State:
    """A function with what is known of its loops.

    Attributes
    ----------
    hints
        Iterations by header, where a transformation knows better than the code says.
    made
        Headers of loops that transformations made or rewrote.
    origin, scale
        Of loops that transformations made, by header: the loop of the source that they come from,
        and how many of its iterations one of theirs runs.
    """

    function: Function
    hints: Mapping[str, float]
    made: frozenset[str] = frozenset()
    origin: Mapping[str, str] = field(default_factory=dict)
    scale: Mapping[str, int] = field(default_factory=dict)

    def loop(self, header: str) -> Loop:
        """The loop at `header`."""
        return next(loop for loop in find_loops(self.function) if loop.header == header)

    def loc(self, header: str) -> SourceLoc | None:
        """Where the loop is written: its test is, if not at its head, then the first way out."""
        own = block_of(self.function, header).branch.loc
        loops = (loop for loop in find_loops(self.function) if loop.header == header)
        exiting = [source for loop in loops for source, _ in loop.exits]
        if header in exiting or own is None:
            return own
        left = (block_of(self.function, source).branch.loc for source in exiting)
        places = [loc for loc in left if loc is not None and loc.file == own.file]
        return min(places, key=lambda loc: loc.line, default=own)
