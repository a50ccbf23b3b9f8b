"""Launches of one kernel on the tiles: what each needs is moved in while the one before runs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

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
_WORD = 4
_PLACES = (2, 1)
"""Launches that lie in a scratchpad at once, at best: one runs while the next is moved in."""


@dataclass(frozen=True, slots=True, eq=False)
class Gathered:
    """Rows of a table, by indices [n] int32 or uint32 that DRAM holds when the job runs."""

    table: Words
    indices: Words

    @property
    def nbytes(self) -> int:
        """Of the chosen rows."""
        return len(self.indices) * int(self.table[:1].nbytes)


@dataclass(frozen=True, slots=True, eq=False)
class Launch:
    """One run of a kernel; arrays have elements of four bytes.

    Attributes
    ----------
    inputs, outputs
        Arrays of DRAM, contiguous or strided, by parameter.
    scalars
        The other arguments.
    resident
        Arrays that stay in the scratchpad for the tile's next launch if that names the same mapping
        object.
    room
        Words of arrays of one dimension that the kernel works in, by parameter.
    """

    inputs: Mapping[str, Words | Gathered]
    outputs: Mapping[str, Words]
    scalars: Mapping[str, object] = field(default_factory=dict)
    resident: Mapping[str, Words] = field(default_factory=dict)
    room: Mapping[str, int] = field(default_factory=dict)

    @property
    def nbytes(self) -> int:
        """In the scratchpad, without what is resident."""
        room = sum(padded(_WORD * words) for words in self.room.values())
        return _size([*self.inputs.values(), *self.outputs.values()]) + room


def run_launches(
    device: Device, ledger: Ledger, stage: str, kernel: str, shares: Sequence[Sequence[Launch]]
) -> None:
    """Run each tile's share of launches as one job, and book it; outputs are updated in place.

    Raises
    ------
    SceneError
        A launch does not fit a scratchpad.
    """
    shares = [share for share in shares if share]
    if not shares:
        return
    program = device.programs.get(kernel)
    job = device.new_job()
    size_bytes = job.accelerator.fabric.scratchpad.size_bytes
    with ledger.timed(stage):
        for tile, share in enumerate(shares):
            _TileSteps(job, tile, program, share, size_bytes).add()
    device.finish(ledger, stage, job)


def padded(size: int) -> int:
    """Return the room that `size` bytes take in a scratchpad."""
    return -(-size // _ALIGNMENT) * _ALIGNMENT


class _TileSteps:
    """The steps of one tile: in, run, out of each launch, alternating between the places."""

    def __init__(
        self, job: Job, tile: int, program: vividc.Program, share: Sequence[Launch], size: int
    ) -> None:
        self._job, self._tile, self._program, self._share = job, tile, program, share
        self._flat = {p.name for p in program.params if p.ndim == 1}
        residents = {id(launch.resident): _size(launch.resident.values()) for launch in share}
        room = max(residents.values())
        self._slots = [room * slot for slot in range(min(2, len(residents)))]
        start = room * len(self._slots)
        self._places = _places(start, max(launch.nbytes for launch in share), size, program.name)
        self._freed: list[list[int]] = [[] for _ in self._places]
        self._users: list[list[int]] = [[] for _ in self._slots]
        self._slot = -1
        self._held: Mapping[str, Words] | None = None
        self._residing: dict[str, object] = {}
        self._ready: list[int] = []

    def add(self) -> None:
        """Add them all."""
        for number, launch in enumerate(self._share):
            self._hold(launch.resident)
            self._launch(number % len(self._places), launch)

    def _hold(self, resident: Mapping[str, Words]) -> None:
        """Move resident arrays in, unless they are there."""
        if resident is self._held:
            return
        self._held = resident
        self._slot = (self._slot + 1) % len(self._slots)
        address, after = self._slots[self._slot], self._users[self._slot]
        self._users[self._slot], self._residing, self._ready = [], {}, []
        for name, array in resident.items():
            self._residing[name] = self._at(name, address, array)
            self._ready.append(self._job.move_in(self._tile, array, address, after=after))
            address += padded(array.nbytes)

    def _launch(self, place: int, launch: Launch) -> None:
        job, tile, address = self._job, self._tile, self._places[place]
        freed = self._freed[place]
        arguments = dict(self._residing)
        waits = [*self._ready, *freed]
        for name, array in launch.inputs.items():
            if isinstance(array, Gathered):
                rows, chosen = array.table, array.indices
                waits.append(job.gather(tile, rows, chosen, address, after=freed))
                arguments[name] = At(address, (array.nbytes // array.table.itemsize,))
            else:
                waits.append(job.move_in(tile, array, address, after=freed))
                arguments[name] = self._at(name, address, array)
            address += padded(array.nbytes)
        leaving = []
        for name, array in launch.outputs.items():
            arguments[name] = self._at(name, address, array)
            leaving.append((address, array))
            address += padded(array.nbytes)
        for name, words in launch.room.items():
            arguments[name] = At(address, (words,))
            address += padded(_WORD * words)
        run = job.run(tile, self._program, after=waits, **arguments, **launch.scalars)
        self._users[self._slot].append(run)
        self._freed[place] = [
            job.move_out(tile, start, array, after=[run]) for start, array in leaving
        ]

    def _at(self, name: str, address: int, array: Words) -> At:
        return At(address, (array.size,) if name in self._flat else array.shape)


def _places(start: int, launch: int, size: int, kernel: str) -> list[int]:
    for places in _PLACES:
        if start + places * launch <= size:
            return [start + launch * place for place in range(places)]
    raise SceneError(
        f"a launch of `{kernel}` needs {launch} bytes beside {start} that stay, and a scratchpad "
        f"has {size}",
        hint="use a model with narrower layers, or a fabric with larger scratchpads",
    )


def _size(arrays: Iterable[Words | Gathered]) -> int:
    return sum(padded(array.nbytes) for array in arrays)
