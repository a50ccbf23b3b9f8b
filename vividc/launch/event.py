"""What a unit of the accelerator did when: the record from which traces and pictures are made."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vividc.launch.steps import Kind

Unit = Literal["tile", "dma", "configuration"]


@dataclass(frozen=True, slots=True)
class Event:
    """A unit was busy with a step.

    Attributes
    ----------
    unit, index
        "tile" and its number, "dma" and its engine, or "configuration".
    kind
        What the step does.
    step
        Its number in the graph.
    start, end
        First cycle, and the cycle after the last.
    size_bytes
        Bytes moved; 0 for runs and configuration.
    program
        Name of the program run or configured.
    tiles
        The tiles concerned.
    """

    unit: Unit
    index: int
    kind: Kind
    step: int
    start: int
    end: int
    size_bytes: int = 0
    program: str = ""
    tiles: tuple[int, ...] = ()
