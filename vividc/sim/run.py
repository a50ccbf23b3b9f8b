"""`simulate`: a program on numpy arrays, as numba would run the kernel, and what it cost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from vividc.errors import ArgumentError, demand_callable, demand_type, quoted
from vividc.host.html import table
from vividc.program import Program
from vividc.sim.bind import bind, returned
from vividc.sim.engine import Launch, Observer, Progress
from vividc.sim.stats import Stats, statistics
from vividc.sim.tile import AUTO, Tile

CYCLE_LIMIT: Final = 100_000_000


@dataclass(frozen=True, slots=True)
class Result:
    """The outcome of `simulate`.

    Attributes
    ----------
    cycles
        Cycles of the tile, stalls and region switches included.
    value
        The returned scalar, None if the kernel returns nothing.
    stats
        Where the cycles went and what was active.
    """

    cycles: int
    value: int | float | bool | None
    stats: Stats

    def __repr__(self) -> str:
        value = "" if self.value is None else f", value {self.value!r}"
        busy = f"{self.stats['utilization']:.0%} of the PEs' cycles used"
        return f"<Result: {self.cycles} cycles{value}, {busy}>"

    def _repr_html_(self) -> str:
        return _of_regions(self)


def _of_regions(result: Result) -> str:
    header = ("region", "kind", "II", "entries", "iterations", "cycles", "bank stalls")
    rows = (
        (
            *(region["name"], region["kind"], region["ii"], region["entries"]),
            *(region["iterations"], region["cycles"], sum(region["stalls"].values())),
        )
        for region in result.stats["regions"]
    )
    return table(header, rows, repr(result)[1:-1])


def check_run(cycle_limit: int, progress: object = None, observer: object = None) -> None:
    """Refuse a limit that is no positive integer, and callbacks that cannot be called.

    Raises
    ------
    ArgumentError
        `cycle_limit` is no whole number from 1 on, or `progress` or `observer` no function.
    """
    hint = "give a whole number of cycles from 1 on"
    demand_type(cycle_limit, (int, np.integer), "cycle_limit", hint)
    if cycle_limit < 1:
        raise ArgumentError(f"cycle_limit cannot be {quoted(cycle_limit)}", hint=hint)
    demand_callable(progress, "progress")
    demand_callable(observer, "observer")


def simulate(
    program: Program,
    *args: object,
    progress: Progress | None = None,
    cycle_limit: int = CYCLE_LIMIT,
    engine: str = AUTO,
    observer: Observer | None = None,
    **kwargs: object,
) -> Result:
    """Run a program; arrays the kernel writes are updated in place, but only if the run succeeds.

    Parameters
    ----------
    args, kwargs
        The kernel's arguments, by position or by parameter name: C-contiguous numpy arrays of
        exactly the declared dtype, Python or numpy scalars.
    progress
        Called now and then with the cycles run so far.
    cycle_limit
        Cycles after which the run is given up.
    engine
        Name of the engine, a key of `tile.ENGINES`, or "auto": the one that is done first. Results
        are the same; `stats` says which ran.
    observer
        Told of every run of a region, in order; see `sim.view.Timeline`.

    Raises
    ------
    ArgumentError
        The arguments do not fit the kernel's signature or the scratchpad, or the engine is unknown.
    SimulationError
        The program broke a rule of the machine, or ran past `cycle_limit`.
    """
    demand_type(program, Program, "the program", "compile a kernel, or vividc.load a .vivid file")
    check_run(cycle_limit, progress, observer)
    tile = Tile(program, engine)
    bound = bind(program, args, kwargs)
    launch = Launch(bound.memory, bound.inputs, cycle_limit, bound.extents, progress, observer)
    run = tile.run(launch)
    bound.copy_back(run.memory, program.stored_arrays)
    value = None
    if program.returns is not None and run.value is not None:
        value = returned(program.returns, run.value)
    return Result(run.cycles, value, statistics(program, run))
