"""`simulate`: a program on numpy arrays, as numba would run the kernel, and what it cost."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from vividc.errors import ArgumentError, demand_callable, demand_type, quoted
from vividc.host.html import table
from vividc.host.watch import to_tell
from vividc.program import Program
from vividc.sim.bind import Array, bind, returned
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
        What the kernel returned: a scalar, an array, or a tuple of them; None if it returns
        nothing. A returned array that an argument holds is a view of that.
    stats
        Where the cycles went and what was active.
    """

    cycles: int
    value: Any
    stats: Stats

    def __repr__(self) -> str:
        value = "" if self.value is None else f", value {shown(self.value)}"
        busy = f"{self.stats['utilization']:.0%} of the PEs' cycles used"
        return f"<Result: {self.cycles} cycles{value}, {busy}>"

    def _repr_html_(self) -> str:
        return _of_regions(self)


def shown(value: object) -> str:
    """A returned value in a line: of an array its type and shape."""
    if isinstance(value, np.ndarray):
        return f"{value.dtype}{list(value.shape)}"
    if isinstance(value, tuple):
        return f"({', '.join(map(shown, value))})"
    return repr(value)


def returned_value(program: Program, arrays: Mapping[str, Array], inputs: Mapping[str, int]) -> Any:
    """The arrays or tuple that a launch has returned, from its arrays afterwards."""
    return None if program.results is None else program.results.value(arrays, inputs)


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
    launch = Launch(
        bound.memory, bound.inputs, cycle_limit, bound.extents, to_tell(progress), observer
    )
    run = tile.run(launch)
    bound.copy_back(run.memory, program.stored_arrays)
    value = returned_value(program, bound.arrays, bound.inputs)
    if program.returns is not None and run.value is not None:
        value = returned(program.returns, run.value)
    return Result(run.cycles, value, statistics(program, run))
