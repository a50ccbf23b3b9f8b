"""A kernel over blocks of data: cut into launches, spread over the tiles, transfers behind runs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import numpy.typing as npt

import vividc
from vividc.launch import At, Job
from vividc.render.array.device import Device
from vividc.render.array.frame import Ledger
from vividc.render.errors import SceneError

Words = npt.NDArray[np.generic]
_ALIGNMENT = 32
"""Arrays start at a multiple of a line of the scratchpad's eight banks."""
_PLACES = (2, 1)
"""Launches that lie in a scratchpad at once, at best: one runs while the next is moved in."""
_SHARE = 2
"""A tile gets at least so many launches, so that there is something to hide transfers behind."""


@dataclass(frozen=True, slots=True, eq=False)
class BlockMap:
    """A kernel and its arrays; all are C-contiguous with elements of four bytes.

    Attributes
    ----------
    kernel
        As in `Programs.get`. Its scalar parameter `blocks` gets the number of blocks of a launch.
    inputs, outputs
        By parameter, [B, ...]: a launch gets the rows of its blocks, flat if the parameter has one
        dimension.
    shared
        By parameter, [...]: every launch gets all of it; with `groups`, [G, ...], and a launch
        gets the row of its blocks' group.
    scalars
        Other parameters.
    groups
        [B] group of each block, ascending; None: there are none.
    skew
        Words that `shared` arrays are shifted by, against conflicts of banks.
    """

    kernel: str
    inputs: Mapping[str, Words]
    outputs: Mapping[str, Words]
    shared: Mapping[str, Words] = field(default_factory=dict)
    scalars: Mapping[str, object] = field(default_factory=dict)
    groups: npt.NDArray[np.int32] | None = None
    skew: int = 0

    @property
    def blocks(self) -> int:
        """How many there are."""
        return len(next(iter(self.outputs.values())))

    def run(self, device: Device, ledger: Ledger, stage: str) -> None:
        """Carry the launches out and book them; `outputs` are updated in place.

        Raises
        ------
        SceneError
            Not even one block fits a scratchpad.
        """
        if self.blocks == 0:
            return
        program = device.programs.get(self.kernel)
        job = device.new_job()
        plan = _Plan.of(self, job.accelerator.fabric.scratchpad.size_bytes, len(job.accelerator.tiles))
        for tile, share in enumerate(self._shares(plan.at_once, len(job.accelerator.tiles))):
            _add_tile(job, tile, program, self, plan, share)
        device.finish(ledger, stage, job)

    def _shares(self, at_once: int, tiles: int) -> Iterator[list[tuple[int, int]]]:
        """For each tile the first and last block (excluded) of its launches: neighbours, so that
        groups change seldom."""
        ends = [self.blocks * tile // tiles for tile in range(tiles + 1)]
        cuts = np.flatnonzero(np.diff(self.groups)) + 1 if self.groups is not None else ()
        for first, last in pairwise(ends):
            bounds = [first, *(int(cut) for cut in cuts if first < cut < last), last]
            yield [
                (start, min(start + at_once, end))
                for begin, end in pairwise(bounds)
                for start in range(begin, end, at_once)
            ]


@dataclass(frozen=True, slots=True)
class _Plan:
    """Where things lie in a scratchpad, in bytes."""

    at_once: int
    shared: tuple[int, ...]
    places: tuple[int, ...]

    @classmethod
    def of(cls, work: BlockMap, size_bytes: int, tiles: int) -> _Plan:
        """Two places where two fit; launches as long as fit and as there is work for."""
        grouped = work.groups is not None
        one_shared = sum(_row_bytes(a, grouped) for a in work.shared.values()) + 4 * work.skew
        copies = 2 if grouped else 1
        block = sum(_row_bytes(a, True) for a in (*work.inputs.values(), *work.outputs.values()))
        most = max(1, -(-work.blocks // (tiles * _SHARE)))
        for places in _PLACES:
            room = (size_bytes - copies * one_shared) // places
            at_once = min(most, room // block)
            if at_once > 0:
                start = copies * one_shared
                return cls(
                    at_once,
                    tuple(one_shared * i for i in range(copies)),
                    tuple(start + at_once * block * i for i in range(places)),
                )
        raise SceneError(
            f"a block of `{work.kernel}` needs {block} bytes beside {copies * one_shared} of shared "
            f"data, and a scratchpad has {size_bytes}",
            hint="render a model with narrower layers, or on a fabric with larger scratchpads",
        )


def _add_tile(
    job: Job,
    tile: int,
    program: vividc.Program,
    work: BlockMap,
    plan: _Plan,
    share: Sequence[tuple[int, int]],
) -> None:
    """Add the steps of one tile: in, run, out of each launch, alternating between the places."""
    freed: list[list[int]] = [[] for _ in plan.places]
    shared = _Shared(job, tile, work, plan)
    for number, (first, last) in enumerate(share):
        place = number % len(plan.places)
        address = plan.places[place]
        arguments, ready = shared.of_block(first)
        waits = [*ready, *freed[place]]
        for name, array in work.inputs.items():
            part = array[first:last]
            waits.append(job.move_in(tile, part, address, after=freed[place]))
            arguments[name] = _at(program, name, address, part)
            address += _padded(part.nbytes)
        leaving = []
        for name, array in work.outputs.items():
            part = array[first:last]
            arguments[name] = _at(program, name, address, part)
            leaving.append((address, part))
            address += _padded(part.nbytes)
        arguments |= {"blocks": last - first, **work.scalars}
        run = job.run(tile, program, after=waits, **arguments)
        shared.used(run)
        freed[place] = [job.move_out(tile, start, part, after=[run]) for start, part in leaving]


class _Shared:
    """The shared arrays in a tile's scratchpad: moved in once, or when the group changes."""

    def __init__(self, job: Job, tile: int, work: BlockMap, plan: _Plan) -> None:
        self._job, self._tile, self._work, self._plan = job, tile, work, plan
        self._group: int | None = None
        self._slot = -1
        self._users: list[list[int]] = [[] for _ in plan.shared]
        self._ready: list[int] = []

    def of_block(self, block: int) -> tuple[dict[str, object], list[int]]:
        """Arguments of the launch that starts with `block`, and the steps it waits for."""
        group = -1 if self._work.groups is None else int(self._work.groups[block])
        fresh = group != self._group
        if fresh:
            self._slot = (self._slot + 1) % len(self._plan.shared)
            self._group, self._ready = group, []
        address = self._plan.shared[self._slot] + 4 * self._work.skew
        arguments: dict[str, object] = {}
        for name, array in self._work.shared.items():
            row = array if self._work.groups is None else array[group]
            arguments[name] = At(address, row.shape)
            if fresh:
                after = self._users[self._slot]
                self._ready.append(self._job.move_in(self._tile, row, address, after=after))
            address += _padded(row.nbytes)
        if fresh:
            self._users[self._slot] = []
        return arguments, self._ready

    def used(self, run: int) -> None:
        """Note that a run reads the arrays as they lie now."""
        self._users[self._slot].append(run)


def _at(program: vividc.Program, name: str, address: int, part: Words) -> At:
    flat = next(p.ndim for p in program.params if p.name == name) == 1
    return At(address, (part.size,) if flat else part.shape)


def _row_bytes(array: Words, by_row: bool) -> int:
    return _padded(array[:1].nbytes if by_row else array.nbytes)


def _padded(size: int) -> int:
    return -(-size // _ALIGNMENT) * _ALIGNMENT
