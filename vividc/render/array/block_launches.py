"""Launch graphs of one program over many pieces of work, each piece on one tile."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

import vividc
from vividc.launch import At, Job
from vividc.render.array.device import Device
from vividc.render.array.frame import Ledger
from vividc.render.errors import SceneError

Array = npt.NDArray[np.generic]
_WORD = 4


@dataclass(frozen=True, slots=True, eq=False)
class Move:
    """Elements of a kernel's array, from `first` on, that are copied from or to an array."""

    array: Array
    first: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class Launch:
    """One run of a kernel.

    Attributes
    ----------
    shapes
        Of every array parameter; elements are of four bytes.
    inputs
        What is moved in before, by parameter; more than one piece if need be.
    outputs
        What is moved out after it.
    shared
        As `inputs`, for arrays that stay in the scratchpad while the next launches of the tile name
        the same ones.
    scalars
        The other arguments.
    cost
        How long it takes, in any unit: launches are dealt out by it.
    """

    shapes: Mapping[str, tuple[int, ...]]
    inputs: Mapping[str, Sequence[Move]] = field(default_factory=dict)
    outputs: Mapping[str, Sequence[Move]] = field(default_factory=dict)
    shared: Mapping[str, Array] = field(default_factory=dict)
    scalars: Mapping[str, int | float] = field(default_factory=dict)
    cost: float = 1.0


def run_launches(
    device: Device,
    ledger: Ledger,
    stage: str,
    kernel: str,
    launches: Sequence[Launch],
    **options: object,
) -> list[int]:
    """Run launches on all tiles in one job, and return what each returned (0: nothing).

    Launches with the same `shared` arrays in a row stay on one tile. While one runs, what the next
    one needs is moved in, if the scratchpad holds both. `options` are those of `vividc.compile`.

    Raises
    ------
    SceneError
        A launch does not fit the scratchpad.
    """
    if not launches:
        return []
    program = device.programs.get(kernel, **options)
    job = device.new_job()
    runs = [0] * len(launches)
    for tile, share in enumerate(dealt(launches, device.tiles)):
        chosen = [launches[number] for number in share]
        if chosen:
            places = _Places(program, chosen, device.scratchpad_bytes)
            for number, run in zip(
                share, _Tile(job, tile, program, places).add(chosen), strict=True
            ):
                runs[number] = run
    result = device.finish(ledger, stage, job)
    return [int(result.values[run] or 0) for run in runs]


def dealt(launches: Sequence[Launch], tiles: int) -> list[list[int]]:
    """Deal launches to tiles: the costliest group first, each to the tile with the least to do.

    A group is launches in a row that share arrays which others do not; one of more than a tile's
    even share is cut.
    """
    even = sum(launch.cost for launch in launches) / tiles
    keys = [tuple(map(id, launch.shared.values())) for launch in launches]
    is_grouped = len(set(keys)) > 1
    groups: list[list[int]] = []
    load, last = 0.0, None
    for number, (launch, key) in enumerate(zip(launches, keys, strict=True)):
        if not is_grouped or key != last or load + launch.cost > even:
            groups.append([])
            load = 0.0
        groups[-1].append(number)
        load, last = load + launch.cost, key
    costs = [sum(launches[number].cost for number in group) for group in groups]
    shares: list[list[int]] = [[] for _ in range(tiles)]
    loads = [0.0] * tiles
    for index in sorted(range(len(groups)), key=lambda index: -costs[index]):
        tile = loads.index(min(loads))
        shares[tile] += groups[index]
        loads[tile] += costs[index]
    return shares


class _Places:
    """Where a tile's arrays lie: shared ones first, once or twice, then the others, likewise."""

    def __init__(self, program: vividc.Program, launches: Sequence[Launch], room: int) -> None:
        self._program = program
        shared = {name for launch in launches for name in launch.shared}
        sizes: dict[str, int] = {}
        for launch in launches:
            for name, shape in launch.shapes.items():
                sizes[name] = max(sizes.get(name, 0), _WORD * math.prod(shape))
        self.shared = [name for name in sizes if name in shared]
        self.own = [name for name in sizes if name not in shared]
        slack = _WORD * program.fabric.scratchpad.banks
        self._sizes = {name: size + slack for name, size in sizes.items()}
        fits = [copies for copies in _COPIES if self._need(copies) <= room]
        if not fits:
            raise SceneError(
                f"a launch of {program.name} needs {self._need((1, 1))} bytes of a scratchpad of "
                f"{room}: {', '.join(f'{name} {size}' for name, size in sizes.items())}",
                hint="use a fabric whose tiles have larger scratchpads",
            )
        self.shared_copies, self.own_copies = fits[0]

    def _need(self, copies: tuple[int, int]) -> int:
        return sum(self._total(names) * n for names, n in zip(self._groups, copies, strict=True))

    @property
    def _groups(self) -> tuple[list[str], list[str]]:
        return self.shared, self.own

    def _total(self, names: Sequence[str]) -> int:
        return sum(self._sizes[name] for name in names)

    def addresses(self, names: Sequence[str], copy: int) -> dict[str, int]:
        """Return the address of each array, in the bank that the compiler wished for."""
        start = copy * self._total(names)
        if names is self.own:
            start += self.shared_copies * self._total(self.shared)
        banks = self._program.fabric.scratchpad.banks
        found = {}
        for name in names:
            wish = self._program.banks.get(name, 0)
            found[name] = _WORD * (start // _WORD + (wish - start // _WORD) % banks)
            start += self._sizes[name]
        return found


_COPIES = ((2, 2), (1, 2), (1, 1))
"""Of shared and of own arrays, the best first."""


class _Tile:
    """Adds the steps of one tile."""

    def __init__(self, job: Job, tile: int, program: vividc.Program, places: _Places) -> None:
        self._job = job
        self._tile = tile
        self._program = program
        self._places = places
        self._shared_now: tuple[int, ...] = ()
        self._shared_count = 0
        self._shared_moves: list[int] = []
        self._shared_users: list[list[int]] = [[] for _ in range(places.shared_copies)]
        self._shared_at: dict[str, int] = {}

    def add(self, launches: Sequence[Launch]) -> list[int]:
        """Add launches one after the other, and return their runs."""
        places = self._places
        freed: list[list[int]] = [[] for _ in range(places.own_copies)]
        runs = []
        for number, launch in enumerate(launches):
            self._share(launch)
            copy = number % places.own_copies
            at = places.addresses(places.own, copy)
            moves = self._moves_in(launch.inputs, at, freed[copy])
            arguments: dict[str, object] = {
                name: At((at | self._shared_at)[name], shape)
                for name, shape in launch.shapes.items()
            }
            run = self._job.run(
                self._tile,
                self._program,
                after=[*moves, *self._shared_moves, *freed[copy]],
                **arguments,
                **launch.scalars,
            )
            self._shared_users[self._shared_count % places.shared_copies].append(run)
            freed[copy] = [
                run,
                *(
                    self._job.move_out(
                        self._tile, at[name] + _WORD * move.first, move.array, after=[run]
                    )
                    for name, moves_out in launch.outputs.items()
                    for move in moves_out
                ),
            ]
            runs.append(run)
        return runs

    def _share(self, launch: Launch) -> None:
        """Move in the shared arrays of a launch, if the tile does not hold them."""
        key = tuple(map(id, launch.shared.values()))
        if key == self._shared_now:
            return
        self._shared_now = key
        self._shared_count += 1
        copy = self._shared_count % self._places.shared_copies
        self._shared_at = self._places.addresses(self._places.shared, copy)
        moves = {name: (Move(array),) for name, array in launch.shared.items()}
        self._shared_moves = self._moves_in(moves, self._shared_at, self._shared_users[copy])
        self._shared_users[copy] = []

    def _moves_in(
        self, moves: Mapping[str, Sequence[Move]], at: Mapping[str, int], after: Sequence[int]
    ) -> list[int]:
        return [
            self._job.move_in(self._tile, move.array, at[name] + _WORD * move.first, after=after)
            for name, pieces in moves.items()
            for move in pieces
        ]
