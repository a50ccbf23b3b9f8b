"""A kernel over blocks of data: cut into launches of several blocks, spread over the tiles."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from vividc.launch.turns import neighbours
from vividc.render.array.device.device import Device
from vividc.render.array.device.frame import Ledger
from vividc.render.array.device.launch import Gathered, Launch, Words
from vividc.render.array.device.launches import run_shares

_LAUNCHES = 4
"""A tile gets at least so many launches, so that there is something to hide transfers behind."""
_PLACES = 2
"""Launches that shall fit a scratchpad: one runs while the next is moved in."""


@dataclass(frozen=True, slots=True, eq=False)
class BlockMap:
    """A kernel and its arrays; all have elements of four bytes.

    Attributes
    ----------
    kernel
        As in `Programs.get`. Its parameter `blocks`, if it has one, gets the blocks of a launch.
    inputs, outputs
        By parameter, [B, ...]: a launch gets the rows of its blocks, flat if the parameter has one
        dimension. Of an input that is gathered the indices are [B, n]; its parameter is flat.
    shared
        By group, by parameter: what the launches of a group's blocks all get.
    scalars
        Other parameters.
    groups
        [B] group of each block, ascending; None: all are of group 0.
    """

    kernel: str
    inputs: Mapping[str, Words | Gathered]
    outputs: Mapping[str, Words]
    shared: Sequence[Mapping[str, Words]] = ({},)
    scalars: Mapping[str, object] = field(default_factory=dict)
    groups: npt.NDArray[np.int32] | None = None

    def run(self, device: Device, ledger: Ledger, stage: str) -> None:
        """Carry the launches out and book them; `outputs` are updated in place. A tile gets blocks
        that follow each other, so that groups change seldom.

        Raises
        ------
        SceneError
            Not even one block fits a scratchpad.
        """
        counts = any(p.name == "blocks" for p in device.programs.get(self.kernel).params)
        line = device.line_bytes
        shared = max(sum(a.nbytes + line for a in group.values()) for group in self.shared)
        room = device.scratchpad_bytes - min(_PLACES, len(self.shared)) * shared
        own = room // _PLACES - line * (len(self.inputs) + len(self.outputs))
        shares = [
            [self._launch(*span, counts) for span in self._spans(first, last, own)]
            for first, last in neighbours(len(next(iter(self.outputs.values()))), device.tiles)
        ]
        run_shares(device, ledger, stage, self.kernel, shares)

    def _spans(self, first: int, last: int, room: int) -> Iterator[tuple[int, int]]:
        """Blocks of each launch, whose arrays have `room` bytes."""
        arrays = (*self.inputs.values(), *self.outputs.values())
        block = sum(_part(array, 0, 1).nbytes for array in arrays)
        at_once = max(1, min(room // block, -(-(last - first) // _LAUNCHES)))
        cuts: list[int] = []
        if self.groups is not None and last > first:
            cuts = (np.flatnonzero(np.diff(self.groups[first:last])) + 1 + first).tolist()
        for begin, end in pairwise((first, *cuts, last)):
            for start in range(begin, end, at_once):
                yield start, min(start + at_once, end)

    def _launch(self, first: int, last: int, counts: bool) -> Launch:
        group = 0 if self.groups is None else int(self.groups[first])
        return Launch(
            inputs={name: _part(array, first, last) for name, array in self.inputs.items()},
            outputs={name: array[first:last] for name, array in self.outputs.items()},
            scalars={"blocks": last - first, **self.scalars} if counts else self.scalars,
            shared=self.shared[group],
        )


def _part(array: Words | Gathered, first: int, last: int) -> Words | Gathered:
    """Return what some blocks take of an input."""
    if isinstance(array, Gathered):
        return Gathered(array.table, array.indices[first:last].reshape(-1))
    return array[first:last]
