"""The reference engine: the rules of docs/machine.md, cycle by cycle, in plain Python.

It is what other engines and the hardware are compared with, so it favours clarity; it is fast only
in that idle parts of the machine cost nothing.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import numpy as np

from vividc.errors import SimulationError
from vividc.program import Home, Program, joined
from vividc.program.reloads import reloads_of
from vividc.sim.engine import Activity, ByRegion, Launch, Observer, RegionRun, RegionSpan, Run
from vividc.sim.reference.predecode import RegionCode, State, StateMap, predecode
from vividc.sim.reference.region import RegionState, iterations
from vividc.sim.reference.tile import Tile, Watch


class ReferenceEngine:
    """Runs the decoded words of one program; `watch` sees every cycle."""

    def __init__(self, program: Program, watch: Watch | None = None) -> None:
        self._program = program
        self._watch = watch
        self._cells = StateMap(program.fabric)
        self._regions = predecode(program, self._cells)
        self._reloads = reloads_of(program)

    def run(self, launch: Launch) -> Run:
        """Run the program once (see `Engine.run`)."""
        tile = Tile(
            program=self._program,
            cells=self._cells,
            state=self._initial_state(launch),
            memory=launch.memory.tolist(),
            cycle_limit=launch.cycle_limit,
            progress=launch.progress,
            extents=launch.extents,
            watch=self._watch,
        )
        totals = [_Totals() for _ in self._regions]
        index: int | None = 0
        switches = brought = 0
        held = 0 if self._reloads is None else self._reloads.held
        left: RegionState | None = None  # a loop of which something is left
        begun: RegionState | None = None  # one that has begun

        def ended(one: RegionState) -> None:
            totals[one.region.index].add(one)
            _tell(launch.observer, one)

        while index is not None:
            done = self._run_region(tile, self._regions[index], begun, left, ended)
            left, begun = done if done.is_left else None, done.behind
            row = done.region.row
            index = row.branch if done.branch else row.next
            if index is not None and left is None and begun is None:
                reload = 0
                if self._reloads is not None:
                    reload, held = self._reloads.entered(index, held)
                passed = self._program.fabric.controller.switch_cycles + reload
                switches, brought = switches + passed, brought + reload
                tile.cycle += passed
                tile.check_limit(done.region.index, tile.cycle)
            if left is None:
                ended(done)
        return Run(
            cycles=tile.cycle,
            switch_cycles=switches,
            reload_cycles=brought,
            memory=np.array(tile.memory, np.uint32),
            value=returned(
                self._program, lambda home: tile.state[self._cells.constant(home.pe, home.entry)]
            ),
            counts=ByRegion(tuple(total.region_run() for total in totals)),
        )

    def _run_region(
        self,
        tile: Tile,
        region: RegionCode,
        begun: RegionState | None,
        left: RegionState | None,
        ended: Callable[[RegionState], None],
    ) -> RegionState:
        if left is None and begun is None:
            tile.state[: self._cells.volatile] = [None] * self._cells.volatile
        tile.entries += 1
        limit = iterations(region.row, tile.trip)
        state = begun or RegionState(tile, region, limit, left, ended, self._regions)
        state.run()
        return state

    def _initial_state(self, launch: Launch) -> State:
        program, cells = self._program, self._cells
        state: State = [None] * cells.size
        state[cells.true] = 1
        images = program.images.tolist()
        for pe, entry in np.argwhere(program.images_set).tolist():
            state[cells.constant(pe, entry)] = images[pe][entry]
        for row in program.launch:
            state[cells.constant(row.pe, row.entry)] = launch.inputs[row.key]
        return state


def _tell(observer: Observer | None, done: RegionState) -> None:
    if observer is not None:
        end = done.now
        times = (end - done.cycles, end, done.iterations, done.stalls)
        observer(RegionSpan(done.region.index, *times))


def returned(program: Program, word_at: Callable[[Home], int | None]) -> int | None:
    """The word of the returned scalar, of two words joined; None if nothing is returned.

    Parameters
    ----------
    word_at
        The word of a constant-store entry at the end; None: nothing was written there.

    Raises
    ------
    SimulationError
        The program ended without writing it.
    """
    if program.return_home is None:
        return None
    low = _written(program, word_at(program.return_home))
    high = program.return_high
    return joined(program.returns, low, None if high is None else _written(program, word_at(high)))


def _written(program: Program, word: int | None) -> int:
    if word is None:
        raise SimulationError(
            f"{program.name} ended without writing its return value",
            loc=program.provenance.kernel_file or None,
        )
    return word


class _Totals:
    """Sums over the runs of one region."""

    def __init__(self) -> None:
        self.entries = 0
        self.iterations = 0
        self.cycles = 0
        self.stalls = 0
        self.issued: Counter[str] = Counter()
        self.activity = Activity()
        self.register_reads = 0
        self.constant_reads = 0

    def add(self, done: RegionState) -> None:
        """Count one run of the region."""
        self.entries += 1
        self.iterations += done.iterations
        self.cycles += done.cycles
        self.stalls += done.stalls
        self.activity = Activity.total((self.activity, done.activity()))
        for count in done.region.counts:
            issues = done.issues_of(count.time)
            if issues == 0:
                continue
            self.issued[count.op] += issues
            later = issues - 1
            self.register_reads += count.first_register_reads + later * count.register_reads
            self.constant_reads += count.first_constant_reads + later * count.constant_reads

    def region_run(self) -> RegionRun:
        """The sums as a result."""
        issued = dict(sorted(self.issued.items()))
        operands = Activity(register_reads=self.register_reads, constant_reads=self.constant_reads)
        activity = Activity.total((self.activity, operands))
        return RegionRun(self.entries, self.iterations, self.cycles, self.stalls, issued, activity)
