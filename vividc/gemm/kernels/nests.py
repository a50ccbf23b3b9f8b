"""Matrix products between other loops of a kernel: its nests one after the other, each product in
the mode that is predicted to take fewest cycles.

What is no product, or takes less on the tiles as they are, runs there as the graph of
`vividc.launch.nests_job`. Where a nest of one kind follows one of the other, it waits until all of
that is done, as the tiles change their mode.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby

import numpy as np

from vividc.arch import Accelerator
from vividc.errors import ArchError
from vividc.gemm.kernels.choice import choose_for
from vividc.gemm.kernels.sequence import Launch, Unfit
from vividc.gemm.kernels.sequence import Sequence as Steps
from vividc.gemm.modes import check_mode
from vividc.gemm.passes import with_arrays
from vividc.gemm.systolic import SystolicError
from vividc.launch import Job, JobResult, joined, nests_job, runs_of
from vividc.machine.parallel import Run
from vividc.machine.product import GPU
from vividc.machine.words import WORD_MASK
from vividc.program import Program
from vividc.sim.bind import Array, arguments, named


def simulate_products(
    program: Program,
    args: Sequence[object],
    kwargs: Mapping[str, object],
    machine: Accelerator,
    *,
    on_one_tile: bool,
    engine: str,
    cycle_limit: int,
) -> JobResult | None:
    """Run a kernel nest by nest; None if no product of it takes fewer cycles in a TPU-like mode.

    Parameters
    ----------
    on_one_tile
        What a product is compared with: the kernel would run on a single tile otherwise.

    Raises
    ------
    ArgumentError
        The arguments do not fit the kernel, or an iteration of a nest no scratchpad.
    SimulationError
        A run failed; no array is changed.
    """
    if not any(nest.products for nest in program.nests):
        return None
    try:
        arrays, inputs = arguments(program, args, kwargs)
        turns = _Turns(program, with_arrays(machine), arrays, inputs, on_one_tile)
        runs = list(turns.modes(runs_of(program, inputs)))
    except ArchError:
        return None
    if all(mode == GPU for _, mode in runs):
        return None
    mine = {name: array.copy() for name, array in arrays.items()}
    scalars = {name: v for name, v in named(program, args, kwargs).items() if name not in mine}
    results = []
    for mode, group in groupby(runs, key=lambda run: run[1]):
        nests = [run for run, _ in group]
        if mode == GPU:
            job = nests_job(program, (), {**mine, **scalars}, machine, nests)
            results.append(job.simulate(engine=engine, cycle_limit=cycle_limit))
            continue
        for number, counters in nests:
            launch = turns.launch(number, counters, mine)
            steps = Steps(launch, check_mode(mode), turns.machine)
            job = Job(turns.machine)
            steps.add(job)
            results.append(job.simulate(engine=engine, cycle_limit=cycle_limit))
            steps.write()
    for name in program.stored_arrays:
        arrays[name][...] = mine[name]
    return joined(results)


@dataclass
class _Turns:
    """The modes of a launch's nests."""

    program: Program
    machine: Accelerator
    arrays: Mapping[str, Array]
    inputs: Mapping[str, int]
    on_one_tile: bool
    known: dict[tuple[int, tuple[int, ...]], str] = field(default_factory=dict)

    def modes(self, runs: Iterable[Run]) -> Iterator[tuple[Run, str]]:
        """Each run of a nest with its mode."""
        for number, counters in runs:
            key = number, tuple(counters.values())
            if key not in self.known:
                self.known[key] = self._mode(number, counters)
            yield (number, counters), self.known[key]

    def _mode(self, number: int, counters: Mapping[str, int]) -> str:
        nest = self.program.nests[number]
        if nest.products is None:
            return GPU
        launch = self.launch(number, counters, self.arrays)
        tiles = 1 if self.on_one_tile else len(self.machine.tiles)
        try:
            launch.check()
            return choose_for(nest, launch, self.machine, tiles).mode
        except (SystolicError, Unfit):
            return GPU

    def launch(
        self, number: int, counters: Mapping[str, int], arrays: Mapping[str, Array]
    ) -> Launch:
        """A nest's products with the words and arrays of a run."""
        products = self.program.nests[number].products
        assert products is not None
        words = {key: value & WORD_MASK for key, value in counters.items()}
        floats = {
            name: array.view(np.float32)
            for name, array in arrays.items()
            if array.dtype == np.float32
        }
        return Launch(products, floats, {**self.inputs, **words})
