"""In which mode matrix products of a kernel run: what each is predicted to take."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from vividc import arch
from vividc.arch import Accelerator
from vividc.errors import ArchError, ArgumentError, quoted
from vividc.gemm.kernels.sequence import Launch, Unfit
from vividc.gemm.kernels.sequence import Sequence as Steps
from vividc.gemm.layer import Matrix
from vividc.gemm.modes import MODES, check_mode
from vividc.gemm.passes import with_arrays
from vividc.gemm.systolic import SystolicError
from vividc.machine.params import DType
from vividc.machine.product import AUTO, ENDLESS, GPU
from vividc.program import Program

ASSUMED: Final = (4096, 64, 64)
"""Rows, columns and inner indices where a launch decides them, for what is said before it."""


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


def accelerator_of(program: Program) -> Accelerator | None:
    """The accelerator that a program was compiled for; None: it was one tile.

    Raises
    ------
    ArchError
        Its text, which came in a file, describes none.
    """
    text = program.accelerator
    return arch.load_accelerator_text(text, f"{program.name}.vivid") if text else None


def choose_for(
    program: Program,
    launch: Launch,
    machine: Accelerator,
    tiles: int | None = None,
    blocks: int | None = None,
) -> KernelChoice:
    """The mode in which a launch of products runs.

    Parameters
    ----------
    tiles
        How many run it in GPU-like mode; None: all if it has a parallel loop, otherwise one.
    blocks
        Cycles that blocks of the kernel's nests are predicted to take, if those would run in
        GPU-like mode.

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
    if tiles is None:
        tiles = 1 if program.parallel is None else len(machine.tiles)
    costs = {GPU: _on_tiles(program, launch, machine, tiles) if blocks is None else blocks}
    refused = ""
    for mode in MODES:
        try:
            launch.check()
            costs[mode] = Steps(launch, mode, machine).cycles()
        except (SystolicError, Unfit) as error:
            refused += f"; {mode} not: {error.reason}"
    best = min(costs, key=lambda mode: costs[mode])
    listed = ", ".join(f"{mode} {_told(count)}" for mode, count in costs.items())
    on = f" ({tiles} tile{'s' if tiles > 1 else ''})" if blocks is None else " (blocks of nests)"
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
    used = {view.array for step in products.steps for view in (step.result, *step.views)}
    moved = sum(launch.arrays[name].nbytes for name in used)
    entries = tiles * len(program.fabric.pes) * len(program.words)
    return int(
        terms * products.cycles_a_term / tiles
        + moved / machine.dram.bytes_per_cycle
        + entries / machine.configuration.entries_per_cycle
    )


def explain(program: Program, machine: Accelerator) -> str:
    """What a program's matrix products are, or those of its nests, and how they would run with
    assumed sizes; "" if it has none.
    """
    if program.products is not None:
        return _explained(program, machine)
    told = []
    for nest in program.nests:
        if nest.products is not None and nest.parallel is not None:
            told.append(f"{nest.parallel.loc}: {_explained(nest, machine)}")
    return "\n".join(told)


def _explained(program: Program, machine: Accelerator) -> str:
    products = program.products
    assert products is not None
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
