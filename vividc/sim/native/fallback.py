"""One region on the reference engine, in the middle of a native run."""

from __future__ import annotations

from collections import Counter
from dataclasses import astuple, replace

import numpy as np

from vividc.program import Program
from vividc.program.reloads import reloads_of
from vividc.sim.engine import Launch
from vividc.sim.native.plan.counts import Totals
from vividc.sim.native.plan.layout import BITS, Layout, Place
from vividc.sim.native.state import MachineState
from vividc.sim.reference.predecode import RegionCode, State, StateMap, predecode
from vividc.sim.reference.region import RegionState, iterations
from vividc.sim.reference.tile import Tile


class Fallback:
    """Runs what native code leaves to the reference engine."""

    def __init__(self, program: Program, layout: Layout) -> None:
        self._program = program
        self._layout = layout
        self._cells = StateMap(program.fabric)
        self._regions: tuple[RegionCode, ...] | None = None

    def run_region(self, launch: Launch, machine: MachineState) -> Totals:
        """Run the region that is next; what it counts.

        Raises
        ------
        SimulationError
            The program did something the machine forbids, or the cycle limit was reached.
        """
        if self._regions is None:
            self._regions = predecode(self._program, self._cells)
        region = self._regions[int(machine.context[Place.NEXT])]
        tile = self._tile(launch, machine)
        tile.entries += 1
        overlap = int(machine.context[Place.OVERLAP])
        tile.cycle -= overlap
        run = RegionState(tile, region, iterations(region.row, tile.trip))
        run.run()
        if run.is_left:
            run.finish()
        has_begun = run.begins_next
        machine.context[Place.OVERLAP] = (
            region.row.drain if run.is_left else region.row.fill if has_begun else 0
        )
        following = region.row.branch if run.branch else region.row.next
        switches = 0
        if following is not None and not run.is_left and not has_begun:
            switches = self._program.fabric.controller.switch_cycles
            switches += self._reload(machine, following)
            tile.cycle += switches
            tile.check_limit(region.index, tile.cycle)
        machine.context[Place.NEXT] = -1 if following is None else following
        machine.context[Place.SWITCH_CYCLES] += switches
        self._write_back(tile, machine)
        return _totals(run, overlap)

    def _reload(self, machine: MachineState, region: int) -> int:
        """Bring a region's contexts if they are not held; cycles that takes."""
        reloads = reloads_of(self._program)
        if reloads is None:
            return 0
        cycles, held = reloads.entered(region, machine.held(self._layout))
        machine.hold(self._layout, held)
        machine.context[Place.RELOAD_CYCLES] += cycles
        return cycles

    def demand_time(self, launch: Launch, machine: MachineState) -> None:
        """Raise the error of a run that went past its limit in the region that is next."""
        tile = self._tile(launch, machine)
        tile.check_limit(int(machine.context[Place.NEXT]), launch.cycle_limit + 1)

    def _tile(self, launch: Launch, machine: MachineState) -> Tile:
        return Tile(
            program=self._program,
            cells=self._cells,
            state=self._words(machine),
            memory=machine.scratchpad.tolist(),
            cycle_limit=launch.cycle_limit,
            progress=launch.progress,
            extents=launch.extents,
            trip=int(machine.context[Place.TRIP]),
            cycle=int(machine.context[Place.CYCLE]),
            entries=int(machine.context[Place.ENTRIES]),
        )

    def _words(self, machine: MachineState) -> State:
        cells = self._cells
        state: State = [None] * cells.volatile + machine.constants.tolist() + [1]
        for constant, bit in self._layout.bits.items():
            if not machine.is_set(self._layout, bit):
                state[cells.constant(constant.pe, constant.entry)] = None
        return state

    def _write_back(self, tile: Tile, machine: MachineState) -> None:
        machine.context[Place.TRIP] = tile.trip
        machine.context[Place.CYCLE] = tile.cycle
        machine.context[Place.ENTRIES] = tile.entries
        machine.scratchpad[:] = tile.memory
        words = tile.state[self._cells.volatile : self._cells.true]
        machine.constants[:] = [word or 0 for word in words]
        for constant, bit in self._layout.bits.items():
            if tile.state[self._cells.constant(constant.pe, constant.entry)] is not None:
                place = self._layout.valid_word(bit)
                machine.context[place] |= np.uint64(1 << bit % BITS).astype(np.int64)


def _totals(run: RegionState, overlap: int) -> Totals:
    """What a run counted that began so many cycles before the region before it was over."""
    issued: Counter[str] = Counter()
    moved = run.activity()
    registers, constants = moved.register_reads, 0
    for count in run.region.counts:
        issues = run.issues_of(count.time)
        if issues:
            issued[count.op] += issues
            registers += count.first_register_reads + (issues - 1) * count.register_reads
            constants += count.first_constant_reads + (issues - 1) * count.constant_reads
    activity = replace(moved, register_reads=registers, constant_reads=constants)
    times = (1, run.iterations, run.cycles - overlap, run.stalls)
    return Totals((*times, *astuple(activity)), issued)
