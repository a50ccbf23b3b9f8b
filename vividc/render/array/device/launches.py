"""Launches of kernels on the tiles: the data of each is moved in while the previous one runs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby

import numpy as np
from numpy.lib.array_utils import byte_bounds

import vividc
from vividc.launch import At, Job, Listed
from vividc.launch.turns import Turns, deal
from vividc.machine.words import WORD_BYTES
from vividc.render.array.device.kernels import Options
from vividc.render.array.device.launch import (
    Gathered,
    Launch,
    Moved,
    Words,
    bytes_of,
    pieces,
)
from vividc.render.array.device.places import Places

Shares = Sequence[Sequence[Launch]]
"""What each tile runs, one after the other."""


@dataclass(frozen=True, slots=True, eq=False)
class Phase:
    """Launches of one kernel, as in `Programs.get`; None: what they move in is moved out again."""

    kernel: str | None
    shares: Shares
    options: Options = field(default_factory=dict)


def add_phases(
    job: Job, programs: Sequence[vividc.Program | None], phases: Sequence[Phase]
) -> list[list[list[int]]]:
    """Add phases with their programs to a job: launches of a phase may read what the phases before
    have written, and a tile goes on to the next phase when its own part is done. Return the last
    step of each launch.
    """
    graph = _Graph(job)
    return [graph.add(*pair) for pair in zip(programs, phases, strict=True)]


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


def by_cost(launches: Sequence[Launch], tiles: int) -> list[list[Launch]]:
    """Deal launches to tiles by cost, as `dealt` says."""
    return [[launches[number] for number in share] for share in dealt(launches, tiles)]


def in_turn(launches: Sequence[Launch], tiles: int) -> list[Sequence[Launch]]:
    """Deal launches to tiles one after the other."""
    return [launches[tile::tiles] for tile in range(tiles)]


class _Graph:
    """Adds phases to a job; the launches of all tiles in turn, so that none waits for transfers of
    another tile's second launch before its first.
    """

    def __init__(self, job: Job) -> None:
        self._job = job
        self._ends: dict[int, list[int]] = {}
        self._left: list[tuple[Words, int]] = []

    def add(self, program: vividc.Program | None, phase: Phase) -> list[list[int]]:
        """Add a phase; return the last run of each launch."""
        scratchpad = self._job.accelerator.fabric.scratchpad
        name, room = "copies", scratchpad.size_bytes
        wishes: Mapping[str, int] = {}
        if program is not None:
            name, wishes = program.name, program.banks
            room -= WORD_BYTES * sum(local.words for local in program.locals)
        common = _common([launch for share in phase.shares for launch in share])
        written = _Written(self._left)
        tiles = {}
        for number, share in enumerate(phase.shares):
            if share:
                places = Places(name, wishes, scratchpad.banks, share, room, first=common)
                before = self._ends.get(number, [])
                tiles[number] = _Tile(self._job, number, program, places, before, written)
        self._hold_together(tiles, common, written)
        runs: list[list[int]] = [[] for _ in phase.shares]
        adding = {number: tile.add(phase.shares[number]) for number, tile in tiles.items()}
        while adding:
            for number in list(adding):
                run = next(adding[number], None)
                if run is None:
                    del adding[number]
                else:
                    runs[number].append(run)
        for number, tile in tiles.items():
            self._ends[number] = tile.end()
            self._left += tile.leaving
        return runs

    def _hold_together(
        self, tiles: Mapping[int, _Tile], common: Mapping[str, Words], written: _Written
    ) -> None:
        """Move in what all launches hold once, to all tiles."""
        before = sorted({step for tile in tiles.values() for step in tile.before})
        for name, array in common.items():
            (at,) = {tile.held_at(name) for tile in tiles.values()}
            after = [*before, *written.by(array)]
            ready = self._job.move_in(sorted(tiles), array, at, after=after)
            for tile in tiles.values():
                tile.hold(name, array, [ready])


class _Tile:
    """Adds the steps of one tile: in, run, out of each launch, alternating between the places.

    Attributes
    ----------
    before
        Steps that the scratchpad is in use until.
    """

    def __init__(
        self,
        job: Job,
        tile: int,
        program: vividc.Program | None,
        places: Places,
        before: Sequence[int],
        written: _Written,
    ) -> None:
        self._job, self._tile, self._program, self._places = job, tile, program, places
        params = () if program is None else program.params
        self._flat = {parameter.name for parameter in params if parameter.ndim == 1}
        self._own_copies = len(places.own)
        self._turns = Turns([tile], self._own_copies)
        self.before = tuple(before)
        for copy in range(self._own_copies):
            self._turns.free(tile, copy, *self.before)
        self._held: dict[str, _Held] = {}
        self._freed: dict[tuple[str, int], tuple[int, ...]] = {}
        self._written = written
        self._last: tuple[int, ...] = self.before
        self.leaving: list[tuple[Words, int]] = []

    def add(self, share: Sequence[Launch]) -> Iterator[int]:
        """Add launches one after the other, and yield the last step of each that the next one on
        this tile waits for.

        Of launches that fetch rows and share arrays, as many begin as there are places before the
        first of them goes on: so the rows of one come while another runs.
        """
        at_once = self._own_copies if share[0].fetched else 1
        for _, alike in groupby(share, lambda launch: launch.group):
            launches = list(alike)
            for first in range(0, len(launches), at_once):
                some = launches[first : first + at_once]
                begun = [(launch, *self._begin(launch)) for launch in some]
                for one in begun:
                    yield self._finish(*one)
        for name in list(self._held):
            self._let_go(name)

    def end(self) -> list[int]:
        """Return the steps after which all of the scratchpad is free again."""
        own = (self._turns.take()[2] for _ in range(self._own_copies))
        ends = (*own, *self._freed.values(), self._last)
        return sorted({step for steps in ends for step in steps})

    def held_at(self, name: str) -> int:
        """Return where the first copy of a held array lies."""
        return self._places.held[name][0]

    def hold(self, name: str, array: Moved, ready: Sequence[int]) -> None:
        """Take the first copy of a held array, which steps move in, as given."""
        self._held[name] = _Held(array, 0, tuple(ready))

    def _begin(self, launch: Launch) -> tuple[int, dict[str, int], list[int]]:
        """Add what comes before a launch's last run; return its place, where its arrays lie there,
        and what that run waits for.
        """
        at, ready = self._hold(launch)
        _, copy, freed = self._turns.take()
        at |= self._places.addresses(launch.sizes, self._places.own[copy])
        at |= self._places.addresses(bytes_of(launch.work), self._places.work)
        moved = (
            step
            for name, array in launch.inputs.items()
            for step in self._moves_in(array, at[name], freed)
        )
        after = [*moved, *ready, *freed]
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
        done, step = after, -1
        if self._program is not None:
            step = self._run(launch, at, after, **({"phase": 1} if launch.fetched else {}))
            done = (step,)
        counts = {name: at[count] for name, count in launch.counted.items()}
        leaving = [
            self._move_out(at[name] + move.first_byte, move.array, done, counts.get(name))
            for name, array in launch.outputs.items()
            for move in pieces(array)
            if isinstance(move.array, np.ndarray)
        ]
        self._turns.free(self._tile, copy, *(leaving or done))
        return step

    def _run(
        self, launch: Launch, at: Mapping[str, int], after: Sequence[int], **more: object
    ) -> int:
        assert self._program is not None
        arguments = {
            name: At(at[name], (math.prod(shape),) if name in self._flat else shape)
            for name, shape in launch.all_shapes.items()
        }
        scalars = {**launch.scalars, **more}
        run = self._job.run(
            self._tile,
            self._program,
            after=after,
            own_at=self._places.end,
            **arguments,
            **scalars,
        )
        self._last = (run,)
        return run

    def _hold(self, launch: Launch) -> tuple[dict[str, int], list[int]]:
        """Move in what a launch holds and the tile does not; return where it lies, and what the
        launch waits for.
        """
        at: dict[str, int] = {}
        ready: list[int] = []
        starts: dict[str, Moved] = {**launch.starts, **launch.shared}
        for name, array in launch.held.items():
            places, held = self._places.held[name], self._held.get(name)
            if held is None or held.array is not array:
                copy = 0
                if held is not None:
                    copy = (held.copy + 1) % len(places)
                    self._let_go(name)
                free = self._freed.get((name, copy), self.before)
                moved = self._moves_in(starts.get(name, ()), places[copy], free)
                out = launch.carried.get(name)
                held = self._held[name] = _Held(array, copy, tuple(moved or free), out)
            at[name] = places[held.copy]
            ready += held.ready
            held.ready = ()  # runs of a tile follow each other
        return at, ready

    def _let_go(self, name: str) -> None:
        """Move out what the last launches carried on, and do not hold it any more."""
        held = self._held.pop(name)
        free = self._last
        if held.out is not None:
            at = self._places.held[name][held.copy]
            free = (self._move_out(at, held.out, self._last),)
        self._freed[name, held.copy] = free

    def _moves_in(self, moved: Moved, address: int, after: Sequence[int]) -> list[int]:
        job, tile = self._job, self._tile
        steps: list[int] = []
        for move in pieces(moved):
            array, at = move.array, address + move.first_byte
            if isinstance(array, Gathered):
                known = [*after, *self._written.by(array.table, array.indices)]
                steps.append(job.gather(tile, array.table, array.indices, at, after=known))
            else:
                known = [*after, *self._written.by(array)]
                steps.append(job.move_in(tile, array, at, after=known))
        return steps

    def _move_out(
        self, address: int, array: Words, after: Sequence[int], count_at: int | None = None
    ) -> int:
        step = self._job.move_out(self._tile, address, array, after=after, count_at=count_at)
        self.leaving.append((array, step))
        return step


@dataclass(slots=True, eq=False)
class _Held:
    """What a tile holds: its copy, the steps that the first run waits for, where it leaves to."""

    array: Moved
    copy: int
    ready: tuple[int, ...]
    out: Words | None = None


class _Written:
    """Which bytes of the host's arrays the moves of some steps write."""

    def __init__(self, moves: Sequence[tuple[Words, int]] = ()) -> None:
        bounds = [(*byte_bounds(array), step) for array, step in moves if array.size]
        self._rows = np.array(bounds, dtype=np.int64).reshape(-1, 3)

    def by(self, *arrays: Words) -> list[int]:
        """Return the steps that write bytes between the first and the last of arrays."""
        found: list[int] = []
        for array in arrays if len(self._rows) else ():
            low, high = byte_bounds(array)
            overlaps = (self._rows[:, 0] < high) & (self._rows[:, 1] > low)
            found += self._rows[overlaps, 2].tolist()
        return found


def _common(launches: Sequence[Launch]) -> dict[str, Words]:
    """Return the shared arrays that are the same in all launches."""
    if not launches:
        return {}
    first, *others = launches
    return {
        name: array
        for name, array in first.shared.items()
        if isinstance(array, np.ndarray) and all(one.shared.get(name) is array for one in others)
    }
