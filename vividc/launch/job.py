"""`Job`: a launch graph that the host builds step by step."""

from __future__ import annotations

import os
from collections.abc import Mapping as ReadOnly
from collections.abc import Sequence
from dataclasses import replace
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from vividc import arch
from vividc.arch import Accelerator
from vividc.errors import ArgumentError, demand_type
from vividc.launch.images import Images
from vividc.launch.memory import Buffers
from vividc.launch.own_arrays import OwnArrays
from vividc.launch.simulate import JobResult, simulate_steps
from vividc.launch.steps import Configure, Execute, Listed, Step, Transfer
from vividc.program import WORD_BYTES, Program
from vividc.sim.placed import Signature
from vividc.sim.run import CYCLE_LIMIT, check_run
from vividc.sim.tile import AUTO, check_engine

_WHOLE = (int, np.integer)


class Job:
    """A launch graph under construction. Every method that adds a step returns its number, for the
    `after` of others.

    Steps of one tile run in the order in which they were added; all else is ordered by `after`
    only. A graph whose result would depend on timing is refused when it is simulated.

    Parameters
    ----------
    fabric
        An accelerator, a preset's name, or a YAML file.
    """

    def __init__(self, fabric: str | os.PathLike[str] | Accelerator = "vivid") -> None:
        self.accelerator: Accelerator = (
            fabric if isinstance(fabric, Accelerator) else arch.load_accelerator(fabric)
        )
        self._steps: list[Step] = []
        self._buffers = Buffers()
        self._own = OwnArrays()
        self._held: dict[int, tuple[Program, int]] = {}
        self._images = Images(self.accelerator)
        self._signatures: dict[int, Signature] = {}

    def __repr__(self) -> str:
        return f"<Job on {self.accelerator.name}: {len(self._steps)} steps>"

    @property
    def steps(self) -> tuple[Step, ...]:
        """The steps so far."""
        return tuple(self._steps)

    @property
    def count(self) -> int:
        """How many steps there are so far."""
        return len(self._steps)

    def move_in(
        self,
        tiles: int | Sequence[int],
        source: NDArray[np.generic],
        address: int,
        *,
        after: Sequence[int] = (),
        pitch: int = WORD_BYTES,
    ) -> int:
        """Copy an array, contiguous or strided, from DRAM to byte `address` of the scratchpads,
        each word `pitch` bytes behind the one before.

        Raises
        ------
        ArgumentError
            Tiles, address or array are not such as the accelerator has.
        """
        where = self._tiles(tiles)
        array = _array(source)
        pieces = self._buffers.pieces(array)
        step = Transfer(
            "move in", where, address, pieces, array, after=self._after(after), pitch=pitch
        )
        return self._transfer(step)

    def gather(
        self,
        tiles: int | Sequence[int],
        source: NDArray[np.generic],
        indices: NDArray[np.generic] | Listed,
        address: int,
        *,
        after: Sequence[int] = (),
    ) -> int:
        """Copy `source[indices]`, whole rows of a C-contiguous array, to the scratchpads. The
        engine reads the indices when the step runs: from DRAM, or from the one tile's scratchpad.

        Raises
        ------
        ArgumentError
            As for `move_in`, or the indices are not one-dimensional 32-bit integers.
        """
        where, known = self._tiles(tiles), self._after(after)
        array = _array(source)
        base = self._buffers.pieces(array)
        step = Transfer("gather", where, address, base, array, after=known)
        return self._transfer(self._by_list(step, indices))

    def scatter(
        self,
        tile: int,
        address: int,
        target: NDArray[np.generic],
        indices: NDArray[np.generic] | Listed,
        *,
        after: Sequence[int] = (),
    ) -> int:
        """Copy rows from byte `address` of a tile's scratchpad, where they lie one after the other,
        to `target[indices]`, whole rows of a C-contiguous array.

        Parameters
        ----------
        indices
            [n] int32 or uint32 in DRAM, or where a run lists them in the tile's scratchpad: the
            engine reads them when the step runs. Rows are written in this order: of one that is
            there twice, the last stays.

        Raises
        ------
        ArgumentError
            As for `gather`, or the array is read-only.
        """
        where, known = self._one_tile(tile), self._after(after)
        array = _target(target, "a scatter")
        base = self._buffers.pieces(array)
        step = Transfer("scatter", where, address, base, array, after=known)
        return self._transfer(self._by_list(step, indices))

    def _by_list(self, step: Transfer, indices: object) -> Transfer:
        """A gather or scatter of the rows that a list says."""
        what = f"a {step.kind}"
        if not step.view.flags.c_contiguous or step.view.ndim == 0:
            hint = (
                "give an array of whole rows that lie one after the other, or a slice of its rows"
            )
            raise ArgumentError(f"the array of {what} is not C-contiguous", hint=hint)
        if isinstance(indices, Listed):
            if len(step.tiles) != 1:
                raise ArgumentError(f"{what} by a list in a scratchpad is for one tile")
            hint = "give Listed two whole numbers, from 0 on"
            demand_type(indices.address, (int, np.integer), "the address of a list", hint)
            demand_type(indices.most, (int, np.integer), "the length of a list", hint)
            if indices.most < 0:
                raise ArgumentError(f"a list is of at most {indices.most} indices", hint=hint)
            self._check_told(*indices.extent, step.tiles[0], "the list of indices", what)
            return replace(step, listed=indices)
        chosen = _array(indices)
        if chosen.dtype not in (np.int32, np.uint32) or chosen.ndim != 1:
            text = f"{what}'s indices must be one-dimensional, of int32 or uint32"
            raise ArgumentError(text, hint="convert them: indices.ravel().astype(np.int32)")
        return replace(step, index_pieces=self._buffers.pieces(chosen), indices=chosen)

    def _check_told(self, start: int, end: int, tile: int, what: str, reader: str) -> None:
        """Check where something lies that the engine reads in a scratchpad to know what to move."""
        self._fits(start, end - start, (tile,), what)
        if start % WORD_BYTES:
            raise ArgumentError(f"{what} starts at {start}, not at a multiple of 4")
        self._own.demand_kept(tile, start, end, reader)

    def move_out(
        self,
        tile: int,
        address: int,
        target: NDArray[np.generic],
        *,
        after: Sequence[int] = (),
        pitch: int = WORD_BYTES,
        count_at: int | None = None,
    ) -> int:
        """Copy from byte `address` of a tile's scratchpad, word by word `pitch` bytes apart, to an
        array, contiguous or strided.

        Parameters
        ----------
        count_at
            First byte of a word of the scratchpad that says how many rows of the array move, the
            first ones: the engine reads it when the step runs. None: all of them.

        Raises
        ------
        ArgumentError
            As for `move_in`, or the array is read-only.
        """
        where, array = self._one_tile(tile), _target(target, "a move out")
        pieces, known = self._buffers.pieces(array), self._after(after)
        step = Transfer("move out", where, address, pieces, array, None, None, known, pitch)
        if count_at is not None:
            demand_type(count_at, (int, np.integer), "count_at", "give a byte of the scratchpad")
            if array.ndim == 0:
                raise ArgumentError("an array of no dimension has no rows to count")
            self._check_told(count_at, count_at + WORD_BYTES, where[0], "the count", "a move out")
            step = replace(step, count_at=count_at)
        return self._transfer(step)

    def configure(
        self, tiles: int | Sequence[int], program: Program, *, after: Sequence[int] = ()
    ) -> int:
        """Load a program into tiles; they switch to it together, at their next run.

        Raises
        ------
        ArgumentError
            The program was not compiled for the accelerator's north-west tile, or has more contexts
            than a tile holds.
        """
        where = self._tiles(tiles)
        images = tuple(self._images.of(program, tile) for tile in where)
        number = self._add(Configure(where, images, self._after(after)))
        for other in chain.from_iterable(self.accelerator.sharing[tile] for tile in where):
            self._held.pop(other, None)
        self._held.update({tile: (program, number) for tile in where})
        return number

    @property
    def moved(self) -> int:
        """Bytes that all transfers move, at most."""
        return sum(step.size for step in self._steps if isinstance(step, Transfer))

    def holds(self, tiles: Sequence[int], program: Program) -> bool:
        """Whether these tiles hold a program after the steps so far."""
        return all(tile in self._held and self._held[tile][0] is program for tile in tiles)

    def run(
        self,
        tile: int,
        program: Program,
        *,
        after: Sequence[int] = (),
        own_at: object = None,
        **arguments: object,
    ) -> int:
        """Run a program on a tile; it is loaded first if the tile does not hold it.

        Parameters
        ----------
        own_at
            The byte from which arrays lie that the kernel makes. None: behind the last argument,
            or, if earlier steps put something there, behind all of that. Where there is no room
            but theirs, a later step that reads what they overwrote is refused.
        arguments
            The kernel's arguments by name: scalars, and `At` for arrays.

        Raises
        ------
        ArgumentError
            Arguments are missing, of the wrong kind, or outside the scratchpad, or an array that
            the kernel writes overlaps another.
        """
        demand_type(program, Program, "the program", "compile a kernel with vividc.compile")
        where = self._one_tile(tile)
        demand_type(own_at, (int, type(None)), "own_at", "give a byte of the scratchpad, or None")
        inputs, extents = self._signature(program).bound(arguments)
        arguments_at = dict(extents)
        own = self._place_own(tile, program, inputs, extents, own_at)
        _refuse_overlap(program, extents)
        room = self.accelerator.units[tile].scratchpad.size_bytes
        for name, (start, end) in extents.items():
            if start % WORD_BYTES:
                raise ArgumentError(f"array {name} starts at {start}, not at a multiple of 4")
            if end > room:
                self._fits(start, end - start, where, f"array {name}")
        for name, (start, end) in arguments_at.items():
            if name in program.loaded_arrays:
                self._own.demand_kept(tile, start, end, f"{name} of {program.name}")
        self._own.take(tile, own, program.name)
        for name in program.stored_arrays & arguments_at.keys():
            self._own.refill(where, *arguments_at[name])
        return self.execute(tile, program, inputs, extents, after=after)

    def _signature(self, program: Program) -> Signature:
        if id(program) not in self._signatures:
            self._signatures[id(program)] = Signature(program)  # it keeps the id in use
        return self._signatures[id(program)]

    def _place_own(
        self,
        tile: int,
        program: Program,
        inputs: dict[str, int],
        extents: dict[str, tuple[int, int]],
        own_at: object,
    ) -> tuple[int, int]:
        """Add the places of the arrays that a kernel makes; first byte and end of all of them."""
        sizes = {local.name: WORD_BYTES * local.at_launch(inputs).words for local in program.locals}
        total = sum(sizes.values())
        if isinstance(own_at, int):
            start = own_at
        else:
            ends = (-(-end // WORD_BYTES) * WORD_BYTES for _, end in extents.values())
            room = self.accelerator.units[tile].scratchpad.size_bytes
            start = self._own.place(tile, total, max(ends, default=0), room)
        place = start
        for name, size in sizes.items():
            extents[name] = (place, place + size)
            inputs[f"&{name}"] = place
            place += size
        return start, start + total

    def execute(
        self,
        tile: int,
        program: Program,
        inputs: ReadOnly[str, int],
        extents: ReadOnly[str, tuple[int, int]],
        stores: ReadOnly[str, tuple[int, int]] | None = None,
        *,
        after: Sequence[int] = (),
    ) -> int:
        """As `run`, with the launch words, the places of all arrays, and of what is written (None:
        all of each array that the kernel writes) given by the caller.
        """
        if stores is None:
            stores = {name: extents[name] for name in program.stored_arrays & extents.keys()}
        if tile not in self._held or self._held[tile][0] is not program:
            self.configure(tile, program)
        configured = self._held[tile][1]
        image = self._images.of(program, tile)
        return self._add(
            Execute(tile, image, program, inputs, extents, stores, configured, self._after(after))
        )

    def simulate(
        self, *, engine: str = AUTO, cycle_limit: int = CYCLE_LIMIT, threads: int | None = None
    ) -> JobResult:
        """Carry the job out; arrays are written only if all of it succeeds.

        Parameters
        ----------
        cycle_limit
            Cycles after which a run of a tile is given up.
        threads
            Tiles simulated at the same time; None: one for each core.

        Raises
        ------
        ArgumentError
            The graph's result would depend on timing: two steps use the same bytes, at least one
            of them writes, and nothing orders them. Or a list names a row that its array does not
            have, or a count says more rows than there are.
        SimulationError
            A program broke a rule of the machine, or ran past `cycle_limit`.
        """
        check_run(cycle_limit)
        check_engine(engine)
        if threads is not None:
            hint = "give a whole number from 1 on, or None"
            demand_type(threads, int, "threads", hint)
            if threads < 1:
                raise ArgumentError(f"threads cannot be {threads}", hint=hint)
        return simulate_steps(
            self.accelerator, self.steps, self._buffers, engine, cycle_limit, threads
        )

    def _transfer(self, step: Transfer) -> int:
        """Check where a step moves bytes in the scratchpads, and add it."""
        demand_type(step.pitch, (int, np.integer), "the pitch", "give a whole number of bytes")
        demand_type(step.address, (int, np.integer), "the address", "give a whole number of bytes")
        apart = step.pitch != WORD_BYTES
        if step.pitch < WORD_BYTES or step.pitch % WORD_BYTES:
            raise ArgumentError(f"the pitch is {step.pitch} bytes, not a multiple of {WORD_BYTES}")
        if apart and (step.view.itemsize != WORD_BYTES or step.address % WORD_BYTES):
            raise ArgumentError("a transfer with a pitch moves whole words, at a multiple of 4")
        start, end = step.extent(step.size)
        self._fits(start, end - start, step.tiles)
        if step.to_dram:
            self._own.demand_kept(step.tiles[0], start, end, f"a {step.kind}")
        else:
            self._own.refill(step.tiles, start, end)
        return self._add(step)

    def _add(self, step: Step) -> int:
        self._steps.append(step)
        self._own.note(step)
        return len(self._steps) - 1

    def _after(self, after: Sequence[int]) -> tuple[int, ...]:
        hint = "give a sequence of the numbers of steps"
        demand_type(after, (tuple, list, range, set, frozenset, np.ndarray), "after", hint)
        for number in after:
            demand_type(number, (int, np.integer), "a step in after", hint)
            if not 0 <= number < len(self._steps):
                raise ArgumentError(f"there is no step {number} to come after")
        return tuple(sorted(set(after)))

    def _one_tile(self, tile: int) -> tuple[int, ...]:
        demand_type(tile, (int, np.integer), "a tile", "give a tile's number, as 0")
        return self._tiles(tile)

    def _tiles(self, tiles: int | Sequence[int]) -> tuple[int, ...]:
        hint = "give a tile's number, or a sequence of them"
        demand_type(tiles, (int, np.integer, tuple, list, range, np.ndarray), "tiles", hint)
        chosen = (tiles,) if isinstance(tiles, _WHOLE) else tuple(tiles)
        for tile in chosen:
            demand_type(tile, (int, np.integer), "a tile", hint)
        count = len(self.accelerator.units)
        if not chosen or len(set(chosen)) < len(chosen):
            raise ArgumentError("a step must name its tiles, once each")
        for tile in chosen:
            if not 0 <= tile < count:
                raise ArgumentError(f"there is no tile {tile}: they are 0 to {count - 1}")
            if not self.accelerator.sharing[tile].isdisjoint(chosen):
                raise ArgumentError(f"a step names tile {tile} and another form of it")
        return chosen

    def _fits(
        self, address: int, size: int, tiles: tuple[int, ...], what: str = "the array"
    ) -> None:
        demand_type(address, (int, np.integer), "the address", "give a whole number of bytes")
        room = min([self.accelerator.units[tile].scratchpad.size_bytes for tile in tiles])
        if address < 0 or address + size > room:
            raise ArgumentError(
                f"{what} would lie at bytes {address} to {address + size}, and the scratchpad has "
                f"{room}"
            )


def _array(value: object) -> NDArray[np.generic]:
    if not isinstance(value, np.ndarray):
        raise ArgumentError(f"expected a numpy array, got {type(value).__name__}")
    if value.dtype.kind not in "biuf" or value.itemsize > WORD_BYTES:
        raise ArgumentError(f"the accelerator does not support elements of {value.dtype}")
    return value


def _target(value: object, what: str) -> NDArray[np.generic]:
    array = _array(value)
    if not array.flags.writeable:
        raise ArgumentError(f"the target of {what} is read-only", hint="pass a copy")
    return array


def _refuse_overlap(program: Program, extents: ReadOnly[str, tuple[int, int]]) -> None:
    """Refuse arrays that overlap: the compiler orders accesses within each array only."""
    places = sorted((start, end, name) for name, (start, end) in extents.items() if end > start)
    for number, (_, end, name) in enumerate(places):
        for start, _, other in places[number + 1 :]:
            if start < end and program.stored_arrays & {name, other}:
                raise ArgumentError(
                    f"arrays {name} and {other} of {program.name} overlap in the scratchpad, and "
                    "it writes one of them",
                    hint="give them places of their own",
                )
