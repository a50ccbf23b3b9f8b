"""`vividc.simulate`: a program on one tile, or spread over an accelerator."""

from __future__ import annotations

import os
from typing import overload

from vividc.arch import Accelerator
from vividc.errors import ArgumentError, demand_type
from vividc.launch.result import JobResult
from vividc.launch.tiles.spread import spread
from vividc.program import Program
from vividc.sim.engine import Observer, Progress
from vividc.sim.run import CYCLE_LIMIT, Result
from vividc.sim.run import simulate as simulate_tile
from vividc.sim.tile import AUTO

Machine = str | os.PathLike[str] | Accelerator


@overload
def simulate(
    program: Program,
    *args: object,
    fabric: None = None,
    progress: Progress | None = None,
    cycle_limit: int = CYCLE_LIMIT,
    engine: str = AUTO,
    observer: Observer | None = None,
    **kwargs: object,
) -> Result: ...


@overload
def simulate(
    program: Program,
    *args: object,
    fabric: Machine,
    progress: Progress | None = None,
    cycle_limit: int = CYCLE_LIMIT,
    engine: str = AUTO,
    observer: Observer | None = None,
    **kwargs: object,
) -> JobResult: ...


def simulate(
    program: Program,
    *args: object,
    fabric: Machine | None = None,
    progress: Progress | None = None,
    cycle_limit: int = CYCLE_LIMIT,
    engine: str = AUTO,
    observer: Observer | None = None,
    **kwargs: object,
) -> Result | JobResult:
    """Run a program; arrays the kernel writes are updated in place, but only if the run succeeds.

    Parameters
    ----------
    args, kwargs
        The kernel's arguments, by position or by parameter name: C-contiguous numpy arrays of
        exactly the declared dtype, Python or numpy scalars.
    fabric
        An accelerator, by name, YAML file or as an object: the loop over `numba.prange` is spread
        over its tiles, and arrays are cut into slices that fit the scratchpads
        (docs/accelerator.md). None: one tile, whose scratchpad holds all arrays.
    progress
        Called now and then with the cycles run so far; of one tile only.
    cycle_limit
        Cycles after which the run of a tile is given up.
    engine
        Name of the engine, a key of `sim.ENGINES`, or "auto": the one that is done first.
    observer
        Told of every run of a region, in order; of one tile only. See `sim.view.Timeline`.

    Raises
    ------
    ArgumentError
        The arguments do not fit the kernel's signature or the scratchpads, the loop cannot be
        spread, the engine is unknown, or an observer was given for more than one tile.
    ArchError
        The fabric is unknown, faulty or a single tile.
    SimulationError
        The program broke a rule of the machine, or ran past `cycle_limit`.
    """
    if fabric is None:
        return simulate_tile(
            program,
            *args,
            progress=progress,
            cycle_limit=cycle_limit,
            engine=engine,
            observer=observer,
            **kwargs,
        )
    check_spread(program, fabric, observer)
    return spread(program, args, kwargs, fabric).simulate(engine=engine, cycle_limit=cycle_limit)


def check_spread(program: object, fabric: object, observer: Observer | None) -> None:
    """Refuse what no accelerator can run.

    Raises
    ------
    ArgumentError
        No program, no accelerator, or an observer, which watches one tile.
    """
    demand_type(program, Program, "the program", "compile a kernel, or vividc.load a .vivid file")
    hint = "give an accelerator's name, its YAML file, or an Accelerator"
    demand_type(fabric, (str, os.PathLike, Accelerator), "the fabric", hint)
    if observer is not None:
        raise ArgumentError(
            "an observer watches one tile, and a fabric was given",
            hint="leave fabric out, or read the events of the result",
        )
