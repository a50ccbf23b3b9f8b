"""`vividc.simulate`: one tile, all tiles, or arrays in a TPU-like mode."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import overload

import numpy as np

from vividc import arch
from vividc.arch import Accelerator, Fabric
from vividc.errors import ArchError, ArgumentError, demand_type
from vividc.gemm.kernels.choice import accelerator_of, choose_for
from vividc.gemm.kernels.nests import simulate_products
from vividc.gemm.kernels.sequence import Launch, Unfit
from vividc.gemm.kernels.sequence import Sequence as Steps
from vividc.gemm.modes import check_mode
from vividc.gemm.passes import with_arrays
from vividc.launch import Job, JobResult, Spread, nests_cycles, nests_job, spread
from vividc.machine.product import AUTO, GPU
from vividc.program import Program
from vividc.sim.bind import arguments
from vividc.sim.engine import Observer, Progress
from vividc.sim.run import CYCLE_LIMIT, Result, check_run, returned_value
from vividc.sim.run import simulate as simulate_tile

Machine = str | os.PathLike[str] | Accelerator


@overload
def simulate(
    program: Program,
    *args: object,
    fabric: Fabric | None = None,
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
    fabric: Machine | Fabric | None = None,
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
        (docs/accelerator.md); the result is a JobResult. The tile that the program was compiled
        for: it alone, whose scratchpad holds all arrays. None: what the program was compiled for,
        or one tile of that if somebody observes.
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
    machine = _machine_of(program, fabric, observer)
    if machine is None:
        return simulate_tile(
            program,
            *args,
            progress=progress,
            cycle_limit=cycle_limit,
            engine=engine,
            observer=observer,
            **kwargs,
        )
    check_run(cycle_limit, progress, observer)
    if program.results is None:
        return _simulate_all(program, args, kwargs, machine, engine, cycle_limit)
    arrays, inputs = arguments(program, args, kwargs)
    made = {param.name: arrays[param.name] for param in program.params if param.made}
    kwargs = {**kwargs, **made}  # several graphs may be tried, each with the same arrays
    result = _simulate_all(program, args, kwargs, machine, engine, cycle_limit)
    value = returned_value(program, arrays, inputs)
    return result if program.returns is not None else replace(result, value=value)


def _simulate_all(
    program: Program,
    args: Sequence[object],
    kwargs: Mapping[str, object],
    machine: Accelerator,
    engine: str,
    cycle_limit: int,
) -> JobResult:
    """On all tiles, or in a TPU-like mode."""
    if program.products is not None:
        result = _simulate_products(program, args, kwargs, machine, engine, cycle_limit)
        if result is not None:
            return result
    return _simulate_loops(program, args, kwargs, machine, engine, cycle_limit)


def _machine_of(
    program: Program, fabric: Machine | Fabric | None, observer: Observer | None
) -> Accelerator | None:
    """Where a program is to run; None: one tile."""
    if fabric is None:
        is_known = isinstance(program, Program) and observer is None
        return accelerator_of(program) if is_known else None
    if isinstance(program, Program) and _is_tile_of(program, fabric):
        return None
    _check_spread(program, fabric, observer)
    if isinstance(fabric, Accelerator):
        return fabric
    assert not isinstance(fabric, Fabric)
    return arch.load_accelerator(fabric)


def _simulate_loops(
    program: Program,
    args: Sequence[object],
    kwargs: Mapping[str, object],
    machine: Accelerator,
    engine: str,
    cycle_limit: int,
) -> JobResult:
    """The kernel as it is, unless that fits no scratchpad, its nests move less, or some of them are
    matrix products that take less in a TPU-like mode.
    """
    whole, refused = _whole(program, args, kwargs, machine)
    if program.parallel is None and any(nest.products for nest in program.nests):
        result = simulate_products(
            program,
            args,
            kwargs,
            machine,
            on_one_tile=whole is not None,
            engine=engine,
            cycle_limit=cycle_limit,
        )
        if result is not None:
            return result
    job = _whole_or_nests(program, args, kwargs, machine, whole, refused)
    return job.simulate(engine=engine, cycle_limit=cycle_limit)


def _whole(
    program: Program, args: Sequence[object], kwargs: Mapping[str, object], machine: Accelerator
) -> tuple[Spread | None, ArgumentError | None]:
    """The launch graph of the kernel as it is, or why it has none, if it has nests instead.

    Raises
    ------
    ArgumentError
        It has none, and no nests.
    """
    try:
        return spread(program, args, kwargs, machine), None
    except ArgumentError as error:
        if program.order is None:
            raise
        return None, error


def _whole_or_nests(
    program: Program,
    args: Sequence[object],
    kwargs: Mapping[str, object],
    machine: Accelerator,
    whole: Spread | None,
    refused: ArgumentError | None,
) -> Spread | Job:
    """The launch graph of the kernel, or of its nests."""
    if whole is not None and (program.order is None or program.parallel is None):
        return whole
    try:
        nests = nests_job(program, args, kwargs, machine)
    except ArgumentError:
        if whole is not None:
            return whole
        if program.parallel is not None and refused is not None:
            raise refused from None  # it is of the loop over `prange` that the user wrote
        raise
    return nests if whole is None or nests.moved < whole.job.moved else whole


def _predicted_blocks(
    program: Program,
    args: Sequence[object],
    kwargs: Mapping[str, object],
    machine: Accelerator,
) -> int | None:
    """Cycles of a launch by blocks of nests; None: it would not run so."""
    if program.order is None or _whole(program, args, kwargs, machine)[0] is not None:
        return None
    try:
        return nests_cycles(program, args, kwargs, machine)
    except ArgumentError:
        return None


def _is_tile_of(program: Program, fabric: Machine | Fabric) -> bool:
    if isinstance(fabric, Fabric):
        return fabric == program.fabric
    return isinstance(fabric, str) and fabric == program.fabric_name


def _check_spread(program: object, fabric: object, observer: Observer | None) -> None:
    """Refuse arguments that cannot be run on an accelerator.

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


def _simulate_products(
    program: Program,
    args: Sequence[object],
    kwargs: Mapping[str, object],
    machine: Accelerator,
    engine: str,
    cycle_limit: int,
) -> JobResult | None:
    """The launch in a TPU-like mode; None: it runs in GPU-like mode."""
    products = program.products
    assert products is not None
    if products.mode == GPU:
        return None
    arrays, inputs = arguments(program, args, kwargs)
    floats = {
        name: array.view(np.float32) for name, array in arrays.items() if array.dtype == np.float32
    }
    launch = Launch(products, floats, inputs)
    try:
        machine = with_arrays(machine)
        launch.check()
    except (ArchError, Unfit) as error:
        if products.mode == AUTO:
            return None
        raise ArgumentError(
            f"{program.name} cannot run in mode {products.mode}: {error.reason}",
            hint="compile it with mode gpu, or auto",
        ) from error
    blocks = _predicted_blocks(program, args, kwargs, machine) if products.mode == AUTO else None
    mode = choose_for(program, launch, machine, blocks=blocks).mode
    if mode == GPU:
        return None
    steps = Steps(launch, check_mode(mode), machine)
    job = Job(machine)
    steps.add(job)
    result = job.simulate(engine=engine, cycle_limit=cycle_limit)
    steps.write()
    return replace(result, value=None)
