"""Launches of kernels that are matrix products: the choice of a mode, and `vividc.simulate`."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, overload

import numpy as np

from vividc import arch
from vividc.arch import Accelerator
from vividc.errors import ArchError, ArgumentError, demand_type, quoted
from vividc.gemm.layer import Matrix
from vividc.gemm.modes import MODES, check_mode
from vividc.gemm.passes import with_arrays
from vividc.gemm.sequence import Launch, Unfit
from vividc.gemm.sequence import Sequence as Steps
from vividc.gemm.systolic import SystolicError
from vividc.launch import Job, JobResult, Spread, nests_job, spread
from vividc.machine.params import DType
from vividc.machine.product import ENDLESS
from vividc.program import Program
from vividc.sim.bind import arguments
from vividc.sim.engine import Observer, Progress
from vividc.sim.run import CYCLE_LIMIT, Result
from vividc.sim.run import simulate as simulate_tile

AUTO: Final = "auto"
GPU: Final = "gpu"
ASSUMED: Final = (4096, 64, 64)
"""Rows, columns and inner indices where a launch decides them, for what is said before it."""

Machine = str | os.PathLike[str] | Accelerator


@dataclass(frozen=True, slots=True)
class KernelChoice:
    """How a launch of a product runs.

    Attributes
    ----------
    mode
        "gpu", "tpu-unified" or "tpu-partitioned".
    reason
        Why.
    cycles
        Predicted, by mode, of those that are possible.
    """

    mode: str
    reason: str
    cycles: Mapping[str, int]


def check_kernel_mode(mode: str) -> None:
    """Refuse an unknown mode.

    Raises
    ------
    ArgumentError
        There is no such mode.
    """
    known = (AUTO, GPU, *MODES)
    if not isinstance(mode, str) or mode not in known:
        raise ArgumentError(f"unknown mode {quoted(mode)}", hint=f"modes: {', '.join(known)}")


def choose_for(program: Program, launch: Launch, machine: Accelerator) -> KernelChoice:
    """The mode in which a launch of products runs.

    Raises
    ------
    SystolicError, Unfit
        The program asks for a TPU-like mode, and the products do not fit its arrays.
    """
    products = launch.products
    if products.mode == GPU:
        return KernelChoice(GPU, "asked for", {})
    if products.mode != AUTO:
        launch.check()
        asked = check_mode(products.mode)
        cycles = Steps(launch, asked, machine).cycles()
        return KernelChoice(asked, "asked for", {asked: cycles})
    tiles = 1 if program.parallel is None else len(machine.tiles)
    costs = {GPU: _on_tiles(program, launch, machine, tiles)}
    refused = ""
    for mode in MODES:
        try:
            launch.check()
            costs[mode] = Steps(launch, mode, machine).cycles()
        except (SystolicError, Unfit) as error:
            refused += f"; {mode} not: {error.reason}"
    best = min(costs, key=lambda mode: costs[mode])
    listed = ", ".join(f"{mode} {_told(count)}" for mode, count in costs.items())
    on = f" ({tiles} tile{'s' if tiles > 1 else ''})"
    listed = listed.replace(f"{GPU} ", f"{GPU}{on} ", 1)
    return KernelChoice(best, f"fewest cycles predicted: {listed}{refused}", costs)


def _told(cycles: int) -> str:
    return "does not fit" if cycles >= ENDLESS else f"{cycles} cycles"


def _on_tiles(program: Program, launch: Launch, machine: Accelerator, tiles: int) -> int:
    """Cycles in GPU-like mode: runs, as they were measured, transfers and configuration."""
    products = launch.products
    if products.cycles_a_term >= ENDLESS:
        return int(ENDLESS)
    terms = sum(launch.sizes(product).terms for product in products.products)
    moved = sum(array.nbytes for array in launch.arrays.values())
    entries = tiles * len(program.fabric.pes) * len(program.words)
    return int(
        terms * products.cycles_a_term / tiles
        + moved / machine.dram.bytes_per_cycle
        + entries / machine.configuration.entries_per_cycle
    )


def explain(program: Program, machine: Accelerator) -> str:
    """What a program's matrix products are, and how they would run with assumed sizes; "" if it
    has none.
    """
    products = program.products
    if products is None:
        return ""
    words = assumed_words(program, ASSUMED)
    launch = Launch(products, assumed_arrays(program, words), words)
    try:
        choice = choose_for(program, launch, with_arrays(machine))
        how = f"mode {choice.mode}, {choice.reason}"
    except (ArchError, SystolicError, Unfit) as error:
        how = f"mode {GPU}: {error.reason}"
    sizes = (launch.sizes(product) for product in products.products)
    told = "; ".join(
        f"{product.text}: {size.rows}x{size.depth} by {size.depth}x{size.cols}"
        for product, size in zip(products.products, sizes, strict=True)
    )
    several = "s" if len(products.products) > 1 else ""
    return f"matrix product{several} {told}: {how}"


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
    _check_spread(program, fabric, observer)
    if program.products is not None:
        result = _simulate_products(program, args, kwargs, fabric, engine, cycle_limit)
        if result is not None:
            return result
    job = _on_tiles_or_nests(program, args, kwargs, fabric)
    return job.simulate(engine=engine, cycle_limit=cycle_limit)


def _on_tiles_or_nests(
    program: Program, args: Sequence[object], kwargs: Mapping[str, object], fabric: Machine
) -> Spread | Job:
    """The launch graph: of the kernel as it is, unless that fits no scratchpad, or its nests move
    less.
    """
    refused: ArgumentError | None = None
    try:
        whole = spread(program, args, kwargs, fabric)
    except ArgumentError as error:
        if program.order is None:
            raise
        refused = error
    if refused is None and (program.order is None or program.parallel is None):
        return whole
    try:
        nests = nests_job(program, args, kwargs, fabric)
    except ArgumentError:
        if refused is None:
            return whole
        if program.parallel is not None:
            raise refused from None  # it is of the loop over `prange` that the user wrote
        raise
    return nests if refused is not None or nests.moved < whole.job.moved else whole


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
    fabric: Machine,
    engine: str,
    cycle_limit: int,
) -> JobResult | None:
    """The launch in a TPU-like mode; None: it runs in GPU-like mode."""
    products = program.products
    assert products is not None
    if products.mode == GPU:
        return None
    machine = fabric if isinstance(fabric, Accelerator) else arch.load_accelerator(fabric)
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
    mode = choose_for(program, launch, machine).mode
    if mode == GPU:
        return None
    steps = Steps(launch, check_mode(mode), machine)
    job = Job(machine)
    steps.add(job)
    result = job.simulate(engine=engine, cycle_limit=cycle_limit)
    steps.write()
    return replace(result, value=None)


def assumed_words(program: Program, sizes: Sequence[int]) -> dict[str, int]:
    """Launch words with these rows, columns and inner indices where nothing is known of them.

    What a coordinate of a product goes up to is taken to be of its size; sizes that are equal where
    all run over whole arrays, equal.
    """
    assert program.products is not None
    words: dict[str, int] = {}
    for param in program.params:
        known = param.known or (0,) * max(param.ndim, 1)
        keys = [f"{param.name}.shape{n}" for n in range(param.ndim)] or [param.name]
        words |= dict(zip(keys, known, strict=True))
    for product in program.products.products:
        for one, size in zip(product.ranges, sizes, strict=True):
            for key, _ in one.limit.terms:
                words[key] = words.get(key) or size
    words |= {key: size or sizes[0] for key, size in words.items()}
    return _with_whole_arrays(program, words)


def _with_whole_arrays(program: Program, words: dict[str, int]) -> dict[str, int]:
    """Words with arrays as large as the steps need them, where their sizes are not known."""
    assert program.products is not None
    fixed = {f"{p.name}.shape{n}" for p in program.params if p.known for n in range(p.ndim)}
    for step in program.products.steps:
        fixed |= {key for one in step.ranges for key, _ in (*one.first.terms, *one.limit.terms)}
    for step in program.products.steps:
        for view in (step.result, *step.views):
            for number, axis in enumerate(view.axes):
                key = f"{view.array}.shape{number}"
                if key not in fixed and axis.coordinate >= 0:
                    one = step.ranges[axis.coordinate]
                    ends = [axis.factor * n for n in (one.first.at(words), one.limit.at(words) - 1)]
                    words[key] = max(ends) + axis.offset.at(words) + 1
    return words


def assumed_arrays(program: Program, words: Mapping[str, int]) -> dict[str, Matrix]:
    """Arrays of zeros of these sizes."""
    return {
        p.name: np.zeros([words[f"{p.name}.shape{n}"] for n in range(p.ndim)], np.float32)
        for p in program.params
        if p.ndim and p.dtype is DType.F32
    }
