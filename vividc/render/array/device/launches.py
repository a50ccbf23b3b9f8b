"""Launches of one kernel on the tiles: the data of each is moved in while the previous one runs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import Final, TypeAlias

import numpy as np
import numpy.typing as npt

import vividc
from vividc.launch import At, Job, Listed
from vividc.launch.turns import Turns, deal
from vividc.machine.words import WORD_BYTES
from vividc.render.array.device.device import Device
from vividc.render.array.device.frame import Ledger
from vividc.render.errors import SceneError

Words = npt.NDArray[np.generic]
_COPIES: Final = ((2, 2), (1, 2), (1, 1))
"""Of shared and of own arrays, the best first: one is used while the next is moved in."""


@dataclass(frozen=True, slots=True, eq=False)
class Gathered:
    """Rows of a table, by indices [n] int32 or uint32 that DRAM holds when the job runs."""

    table: Words
    indices: Words

    @property
    def nbytes(self) -> int:
        """Of the chosen rows."""
        return len(self.indices) * int(self.table[:1].nbytes)

    @property
    def shape(self) -> tuple[int, ...]:
        """Of the chosen rows, one below the other."""
        return (len(self.indices), *self.table.shape[1:])


@dataclass(frozen=True, slots=True, eq=False)
class Move:
    """Elements of a kernel's array, from `first` on, that are copied from or to an array, or are
    rows of one.
    """

    array: Words | Gathered
    first: int = 0

    @property
    def first_byte(self) -> int:
        """Of the kernel's array."""
        return WORD_BYTES * self.first


@dataclass(frozen=True, slots=True, eq=False)
class Fetched:
    """Rows of a table that the kernel itself asks for, in an array of words.

    A launch runs twice. With the scalar `phase` 0 the kernel writes there how many rows it wants,
    and behind that word their numbers. They come to the same place, from word `first` on, and the
    kernel runs with `phase` 1. Of more than `most` rows none is to be asked for.
    """

    table: Words
    most: int
    first: int

    @property
    def shape(self) -> tuple[int, ...]:
        """Words of the array."""
        row = self.table[:1].nbytes // WORD_BYTES
        return (max(1 + self.most, self.first + row * self.most),)


Moved: TypeAlias = Words | Gathered | Sequence[Move]
"""A whole array, contiguous or strided, rows of one, or pieces."""


@dataclass(frozen=True, slots=True, eq=False)
class Launch:
    """One run of a kernel; arrays have elements of four bytes.

    Attributes
    ----------
    shapes
        Of array parameters that are moved in pieces, and of those that the kernel works in.
    inputs
        What is moved in before, by parameter.
    outputs
        What is moved out after it: arrays or pieces, not rows.
    shared
        Arrays that stay in the scratchpad while the next launches of the tile name the same ones.
    fetched
        Rows that the kernel asks for, by parameter.
    carried
        Arrays that launches in a row, which name the same ones, hand on to each other. They stay in
        a scratchpad, hold nothing before the first of these launches, and leave after the last.
    work
        Arrays that hold nothing when the kernel starts or ends, by parameter.
    scalars
        The other arguments.
    cost
        How long it takes, in any unit: `run_launches` deals out by it.
    """

    shapes: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    inputs: Mapping[str, Moved] = field(default_factory=dict)
    outputs: Mapping[str, Words | Sequence[Move]] = field(default_factory=dict)
    shared: Mapping[str, Words] = field(default_factory=dict)
    fetched: Mapping[str, Fetched] = field(default_factory=dict)
    carried: Mapping[str, Words] = field(default_factory=dict)
    work: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    scalars: Mapping[str, object] = field(default_factory=dict)
    cost: float = 1.0

    @property
    def sizes(self) -> dict[str, int]:
        """Bytes of each array that is neither held nor work."""
        rows = {name: some.shape for name, some in self.fetched.items()}
        sizes = {name: WORD_BYTES * math.prod(s) for name, s in (rows | {**self.shapes}).items()}
        sizes |= {name: array.nbytes for name, array in self._whole()}
        return {name: size for name, size in sizes.items() if name not in self.shared}

    @property
    def all_shapes(self) -> dict[str, tuple[int, ...]]:
        """Of each array."""
        whole = (*self._whole(), *self.held.items())
        shapes = {name: array.shape for name, array in (*whole, *self.fetched.items())}
        return {**shapes, **self.shapes, **self.work}

    @property
    def group(self) -> tuple[int, ...]:
        """A key that is equal for launches with the same held arrays."""
        return tuple(map(id, self.held.values()))

    @property
    def held(self) -> dict[str, Words]:
        """Arrays that stay in a scratchpad from launch to launch."""
        return {**self.shared, **self.carried}

    def _whole(self) -> Iterator[tuple[str, Words | Gathered]]:
        for name, array in (*self.inputs.items(), *self.outputs.items()):
            if isinstance(array, np.ndarray | Gathered) and name not in self.shapes:
                yield name, array


def run_launches(
    device: Device,
    ledger: Ledger,
    stage: str,
    kernel: str,
    launches: Sequence[Launch],
    **options: object,
) -> list[int]:
    """Run launches on all tiles in one job, dealt out by cost, and return what each returned.

    Parameters
    ----------
    options
        Of `vividc.compile`.

    Returns
    -------
    By launch; 0 of a kernel that returns nothing.

    Raises
    ------
    SceneError
        A launch does not fit the scratchpad.
    """
    numbers = dealt(launches, device.tiles)
    shares = [[launches[number] for number in share] for share in numbers]
    returned = [0] * len(launches)
    by_share = run_shares(device, ledger, stage, kernel, shares, **options)
    for share, values in zip(numbers, by_share, strict=True):
        for number, value in zip(share, values, strict=True):
            returned[number] = value
    return returned


def run_shares(
    device: Device,
    ledger: Ledger,
    stage: str,
    kernel: str,
    shares: Sequence[Sequence[Launch]],
    **options: object,
) -> list[list[int]]:
    """Run each tile's share of launches as one job, book it, and return what each returned.

    Outputs are updated in place. Parameters and errors as of `run_launches`.
    """
    if not any(shares):
        return [[] for _ in shares]
    program = device.programs.get(kernel, **options)
    job = device.new_job()
    with ledger.timed(stage):
        tiles = {
            tile: _Tile(job, tile, program, Places(program, share, device.scratchpad_bytes))
            for tile, share in enumerate(shares)
            if share
        }
        _hold_together(job, tiles, [launch for share in shares for launch in share])
        runs = [tiles[tile].add(share) if share else [] for tile, share in enumerate(shares)]
    values = device.finish(ledger, stage, job).values
    return [[int(values[run] or 0) for run in share] for share in runs]


def dealt(launches: Sequence[Launch], tiles: int) -> list[list[int]]:
    """Deal launches to tiles: the costliest group first, each to the tile with the least to do.

    A group is launches in a row that hold arrays which others do not; one of more than a tile's
    even share is cut, if nothing is carried on.
    """
    even = sum(launch.cost for launch in launches) / tiles
    keys = [launch.group for launch in launches]
    is_grouped = len(set(keys)) > 1 or any(launch.carried for launch in launches)
    groups: list[list[int]] = []
    load, last = 0.0, None
    for number, (launch, key) in enumerate(zip(launches, keys, strict=True)):
        is_full = load + launch.cost > even and not launch.carried
        if not is_grouped or key != last or is_full:
            groups.append([])
            load = 0.0
        groups[-1].append(number)
        load, last = load + launch.cost, key
    costs = [sum(launches[number].cost for number in group) for group in groups]
    return [[n for index in share for n in groups[index]] for share in deal(costs, tiles)]


class Places:
    """Where a tile's arrays lie: those that are held first, once or twice, then the others,
    likewise, and work arrays, once.
    """

    def __init__(self, program: vividc.Program, share: Sequence[Launch], room: int) -> None:
        self._banks = program.banks
        self._count = program.fabric.scratchpad.banks
        self._line = WORD_BYTES * self._count
        own = [launch.sizes for launch in share]
        shared = {launch.group: _sizes(launch.held) for launch in share}
        needs = [max(self._end(sizes) for sizes in some) for some in (shared.values(), own)]
        room -= max(self._end(_bytes(launch.work)) for launch in share)
        copies = dict.fromkeys((min(few, len(shared)), many) for few, many in _COPIES)
        fits = [some for some in copies if some[0] * needs[0] + some[1] * needs[1] <= room]
        if not fits:
            most = [max(some, key=self._end) for some in (list(shared.values()), own)]
            raise SceneError(
                f"a launch of {program.name} needs {sum(needs)} bytes of a scratchpad of {room}: "
                + ", ".join(f"{name} {size}" for sizes in most for name, size in sizes.items()),
                hint="use a smaller model, or a fabric whose tiles have larger scratchpads",
            )
        few, many = fits[0]
        self.shared = [needs[0] * copy for copy in range(few)]
        self.own = [needs[0] * few + needs[1] * copy for copy in range(many)]
        self.work = needs[0] * few + needs[1] * many

    def addresses(self, sizes: Mapping[str, int], start: int) -> dict[str, int]:
        """Return the address of each array from `start` on, in the bank the compiler wished for."""
        addresses = {}
        word = start // WORD_BYTES
        for name, size in sizes.items():
            word += (self._banks.get(name, 0) - word) % self._count
            addresses[name] = WORD_BYTES * word
            word += size // WORD_BYTES
        return addresses

    def _end(self, sizes: Mapping[str, int]) -> int:
        """Return the bytes that arrays take, in whole lines of banks: so many bytes further on they
        lie in the same banks.
        """
        if not sizes:
            return 0
        name, address = list(self.addresses(sizes, 0).items())[-1]
        return -(-(address + sizes[name]) // self._line) * self._line


class _Tile:
    """Adds the steps of one tile: in, run, out of each launch, alternating between the places."""

    def __init__(self, job: Job, tile: int, program: vividc.Program, places: Places) -> None:
        self._job, self._tile, self._program, self._places = job, tile, program, places
        self._flat = {parameter.name for parameter in program.params if parameter.ndim == 1}
        self._turns = Turns([tile], len(places.own))
        self._held: tuple[int, ...] | None = None
        self._carried: Mapping[str, Words] = {}
        self._last: list[int] = []
        self._copy = 0
        self._users: list[list[int]] = [[] for _ in places.shared]
        self._shared_at: dict[str, int] = {}
        self._ready: list[int] = []

    def add(self, share: Sequence[Launch]) -> list[int]:
        """Add launches one after the other, and return their last runs.

        Of launches that fetch rows and share arrays, as many begin as there are places before the
        first of them goes on: so the rows of one come while another runs.
        """
        runs: list[int] = []
        at_once = len(self._places.own) if share[0].fetched else 1
        for _, alike in groupby(share, lambda launch: launch.group):
            launches = list(alike)
            for first in range(0, len(launches), at_once):
                some = launches[first : first + at_once]
                begun = [(launch, *self._begin(launch)) for launch in some]
                runs += [self._finish(*one) for one in begun]
        self._let_go()
        return runs

    def _begin(self, launch: Launch) -> tuple[int, dict[str, int], list[int]]:
        """Add what comes before a launch's last run; return its place, where its arrays lie there,
        and what that run waits for.
        """
        self._hold(launch)
        _, copy, freed = self._turns.take()
        at = self._places.addresses(launch.sizes, self._places.own[copy])
        after = [*self._moves_in(launch.inputs, at, freed), *self._ready, *freed]
        if launch.carried:
            after += self._last
        at |= self._shared_at
        at |= self._places.addresses(_bytes(launch.work), self._places.work)
        if not launch.fetched:
            return copy, at, after
        listed = self._run(launch, at, after, phase=0)
        rows = [
            self._job.gather(
                self._tile,
                some.table,
                Listed(at[name], some.most),
                at[name] + WORD_BYTES * some.first,
                after=[listed],
            )
            for name, some in launch.fetched.items()
        ]
        return copy, at, [listed, *rows]

    def _finish(self, launch: Launch, copy: int, at: dict[str, int], after: Sequence[int]) -> int:
        """Add the last run, and what leaves after it."""
        run = self._run(launch, at, after, **({"phase": 1} if launch.fetched else {}))
        leaving = [
            self._job.move_out(self._tile, at[name] + move.first_byte, move.array, after=[run])
            for name, array in launch.outputs.items()
            for move in _pieces(array)
            if isinstance(move.array, np.ndarray)
        ]
        self._turns.free(self._tile, copy, *(leaving or [run]))
        return run

    def _run(
        self, launch: Launch, at: Mapping[str, int], after: Sequence[int], **more: object
    ) -> int:
        arguments = {
            name: At(at[name], (math.prod(shape),) if name in self._flat else shape)
            for name, shape in launch.all_shapes.items()
        }
        scalars = {**launch.scalars, **more}
        run = self._job.run(self._tile, self._program, after=after, **arguments, **scalars)
        self._users[self._copy].append(run)
        self._last = [run]
        return run

    def shared_addresses(self, launch: Launch) -> dict[str, int]:
        """Return where the first shared arrays lie."""
        return self._places.addresses(_sizes(launch.held), self._places.shared[0])

    def hold(self, launch: Launch, at: Mapping[str, int], ready: Sequence[int]) -> None:
        """Take the first shared arrays, which steps move in, as given."""
        self._held, self._shared_at, self._ready = launch.group, dict(at), list(ready)

    def _hold(self, launch: Launch) -> None:
        """Move in the shared arrays of a launch, if the tile does not hold them."""
        if launch.group == self._held:
            return
        self._let_go()
        self._held, self._carried = launch.group, launch.carried
        self._copy = (self._copy + 1) % len(self._places.shared)
        start = self._places.shared[self._copy]
        self._shared_at = self._places.addresses(_sizes(launch.held), start)
        free = self._users[self._copy]
        moved = self._moves_in(launch.shared, self._shared_at, free)
        self._ready = [*moved, *free] if launch.carried else moved
        self._users[self._copy] = []

    def _let_go(self) -> None:
        """Move out what the held launches carried on."""
        self._users[self._copy] += [
            self._job.move_out(self._tile, self._shared_at[name], array, after=self._last)
            for name, array in self._carried.items()
        ]
        self._carried = {}

    def _moves_in(
        self, inputs: Mapping[str, Moved], at: Mapping[str, int], after: Sequence[int]
    ) -> list[int]:
        job, tile = self._job, self._tile
        steps = []
        for name, moved in inputs.items():
            for move in _pieces(moved):
                array, address = move.array, at[name] + move.first_byte
                if isinstance(array, Gathered):
                    rows = (array.table, array.indices, address)
                    steps.append(job.gather(tile, *rows, after=after))
                else:
                    steps.append(job.move_in(tile, array, address, after=after))
        return steps


def _hold_together(job: Job, tiles: Mapping[int, _Tile], launches: Sequence[Launch]) -> None:
    """Move in shared arrays once, to all tiles, if all launches have the same."""
    first = launches[0]
    if first.carried or not first.shared or len({launch.group for launch in launches}) > 1:
        return
    (at,) = {tuple(tile.shared_addresses(first).items()) for tile in tiles.values()}
    ready = [job.move_in(sorted(tiles), first.shared[name], address) for name, address in at]
    for tile in tiles.values():
        tile.hold(first, dict(at), ready)


def _pieces(array: Moved) -> Sequence[Move]:
    return (Move(array),) if isinstance(array, np.ndarray | Gathered) else array


def _sizes(arrays: Mapping[str, Words]) -> dict[str, int]:
    return {name: array.nbytes for name, array in arrays.items()}


def _bytes(shapes: Mapping[str, tuple[int, ...]]) -> dict[str, int]:
    return {name: WORD_BYTES * math.prod(shape) for name, shape in shapes.items()}
