"""Launches of kernels that are matrix products: the choice of a mode, and `vividc.simulate`."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, overload

import numpy as np
from numpy.typing import NDArray

from vividc import arch
from vividc.arch import Accelerator
from vividc.errors import ArchError, ArgumentError, demand_type, quoted
from vividc.gemm.job import mlp_job
from vividc.gemm.layer import Layer, Matrix
from vividc.gemm.modes import MODES, LayerShape, Mode, check_mode
from vividc.gemm.passes import lay_out, with_arrays
from vividc.gemm.systolic import SystolicError
from vividc.launch import JobResult, spread
from vividc.machine.product import Factor, Product, Size
from vividc.program import Program
from vividc.sim.bind import arguments
from vividc.sim.engine import Observer, Progress
from vividc.sim.run import CYCLE_LIMIT, Result
from vividc.sim.run import simulate as simulate_tile

AUTO: Final = "auto"
GPU: Final = "gpu"
ASSUMED: Final = (4096, 64, 64)
"""Rows, columns and inner indices where a launch decides them, for what is said before it."""

_LARGEST: Final = float(np.finfo(np.float32).max) / 4

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


def choose_for(
    program: Program,
    product: Product,
    sizes: tuple[int, int, int],
    machine: Accelerator,
) -> KernelChoice:
    """The mode in which a product of this size (rows, columns, inner indices) runs.

    Raises
    ------
    SystolicError
        The program asks for a TPU-like mode, and the product does not fit its arrays.
    """
    rows, cols, depth = sizes
    shape = LayerShape(depth, cols, product.relu)
    if product.mode != AUTO:
        cycles = {}
        if product.mode != GPU:
            asked = check_mode(product.mode)
            cycles = {product.mode: lay_out(rows, [shape], asked, machine).cycles}
        return KernelChoice(product.mode, "asked for", cycles)
    tiles = 1 if program.parallel is None else len(machine.tiles)
    terms = rows * cols * depth
    costs = {GPU: int(terms * product.cycles_a_term / tiles)}
    refused = ""
    for mode in MODES:
        try:
            costs[mode] = lay_out(rows, [shape], mode, machine).cycles
        except SystolicError as error:
            refused += f"; {mode} not: {error.reason}"
    best = min(costs, key=lambda mode: costs[mode])
    listed = ", ".join(f"{mode} {count} cycles" for mode, count in costs.items())
    on = f" ({tiles} tile{'s' if tiles > 1 else ''})"
    listed = listed.replace(f"{GPU} ", f"{GPU}{on} ", 1)
    return KernelChoice(best, f"fewest cycles predicted: {listed}{refused}", costs)


def explain(program: Program, machine: Accelerator) -> str:
    """What a program's matrix product is, and how it would run with assumed sizes; "" if none."""
    product = program.product
    if product is None:
        return ""
    wanted = (product.rows, product.cols, product.depth)
    sizes = [
        size if isinstance(size, int) else assumed
        for size, assumed in zip(wanted, ASSUMED, strict=True)
    ]
    rows, cols, depth = sizes
    try:
        choice = choose_for(program, product, (rows, cols, depth), with_arrays(machine))
        how = f"mode {choice.mode}, {choice.reason}"
    except (ArchError, SystolicError) as error:
        how = f"mode {GPU}: {error.reason}"
    order = "" if product.starts else "; in TPU-like modes the sum starts from the bias"
    return f"matrix product {product.text}: {rows}x{depth} by {depth}x{cols}: {how}{order}"


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
    if program.product is not None:
        result = _simulate_product(
            program, program.product, args, kwargs, fabric, engine, cycle_limit
        )
        if result is not None:
            return result
    return spread(program, args, kwargs, fabric).simulate(engine=engine, cycle_limit=cycle_limit)


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


def _simulate_product(
    program: Program,
    product: Product,
    args: Sequence[object],
    kwargs: Mapping[str, object],
    fabric: Machine,
    engine: str,
    cycle_limit: int,
) -> JobResult | None:
    """The launch in a TPU-like mode; None: it runs in GPU-like mode."""
    if product.mode == GPU:
        return None
    machine = fabric if isinstance(fabric, Accelerator) else arch.load_accelerator(fabric)
    arrays, inputs = arguments(program, args, kwargs)
    launch = _Launch(product, arrays, inputs)
    reason = launch.refusal()
    try:
        machine = with_arrays(machine)
    except ArchError as error:
        reason = error.reason
    if reason:
        if product.mode == AUTO:
            return None
        raise ArgumentError(
            f"{program.name} cannot run in mode {product.mode}: {reason}",
            hint="compile it with mode gpu, or auto",
        )
    mode = choose_for(program, product, launch.sizes, machine).mode
    return None if mode == GPU else launch.run(check_mode(mode), machine, engine, cycle_limit)


class _Launch:
    """A product with its arguments."""

    def __init__(
        self,
        product: Product,
        arrays: Mapping[str, NDArray[np.generic]],
        inputs: Mapping[str, int],
    ) -> None:
        self._product = product
        self._arrays = arrays
        self._inputs = inputs

    @property
    def sizes(self) -> tuple[int, int, int]:
        """Rows, columns and inner indices."""
        product = self._product
        return self._size(product.rows), self._size(product.cols), self._size(product.depth)

    def refusal(self) -> str:
        """Return why no TPU-like mode is possible; "": one is."""
        product = self._product
        rows, cols, depth = self.sizes
        if min(rows, cols, depth) < 1:
            return f"nothing to compute: the sizes are {rows}, {cols} and {depth}"
        wanted = {
            product.left: (rows, depth),
            product.right: (depth, cols),
            product.result: (rows, cols),
        }
        for factor, sizes in wanted.items():
            shape = self._arrays[factor.array].shape
            if shape != (sizes[::-1] if factor.transposed else sizes):
                return f"the loops do not run over all of {factor.array}, {shape[0]}x{shape[1]}"
            if self._size(factor.stride) != shape[1]:
                return f"{factor.array} is not indexed by its own rows"
        if product.bias and self._arrays[product.bias].shape != (cols,):
            return f"the loops do not run over all of {product.bias}"
        return self._overflow() if product.relu else ""

    def run(self, mode: Mode, machine: Accelerator, engine: str, cycle_limit: int) -> JobResult:
        """The result, written into its array, and the job."""
        product = self._product
        bias = self._array(product.bias) if product.bias else None
        layer = Layer(self._matrix(product.right), bias, "relu" if product.relu else "none")
        x = self._matrix(product.left)
        done = mlp_job(
            x, [layer], mode=mode, accelerator=machine, engine=engine, cycle_limit=cycle_limit
        )
        self._arrays[product.result.array][...] = done.values
        return replace(done.job, value=None)

    def _overflow(self) -> str:
        """Return why a sum could be NaN, of which the array makes 0; "": none can."""
        depth = self.sizes[2]
        names = {*self._product.arrays} - {self._product.result.array}
        if not all(np.isfinite(self._array(name)).all() for name in names):
            return "an operand is not finite, and max(x, 0) of a NaN would be 0"
        left, right = self._matrix(self._product.left), self._matrix(self._product.right)
        most = float(np.abs(left).max()) * float(np.abs(right).max()) * depth
        if self._product.bias:
            most += float(np.abs(self._array(self._product.bias)).max())
        return "" if most < _LARGEST else "a sum might overflow, and max(x, 0) of a NaN would be 0"

    def _size(self, size: Size) -> int:
        if isinstance(size, int):
            return size
        word = self._inputs[size]
        return word - ((word >> 31) << 32)

    def _array(self, name: str) -> Matrix:
        array: Matrix = self._arrays[name].astype(np.float32, copy=False)
        return array

    def _matrix(self, factor: Factor) -> Matrix:
        array = self._array(factor.array)
        return np.ascontiguousarray(array.T if factor.transposed else array)
