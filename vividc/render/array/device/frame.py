"""The result of rendering on the array: the picture, and the cost of each stage."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from time import perf_counter

import numpy as np
import numpy.typing as npt

from vividc.launch import JobResult, JobStats
from vividc.render.arrays import Float32Array


@dataclass(slots=True)
class Stage:
    """One stage of a frame, over all its jobs.

    Attributes
    ----------
    name, mode
        As in the tables: "blend", "colour network"; "gpu", "tpu-unified" or "tpu-partitioned".
    cycles
        Of its jobs one after the other, with transfers and configuration.
    jobs, runs
        Launch graphs, and runs of programs in them.
    stats
        Of each job: where the cycles of the tiles went, and the bytes moved.
    seconds
        The host took to simulate it.
    whole
        Simulated for the whole frame, even if only some blocks of pixels are.
    once
        One job, however many blocks of pixels there are.
    """

    name: str
    mode: str = "gpu"
    cycles: int = 0
    jobs: int = 0
    runs: int = 0
    stats: list[JobStats] = field(default_factory=list)
    seconds: float = 0.0
    whole: bool = False
    once: bool = False

    @property
    def cold(self) -> float:
        """Cycles in which its jobs begin and end: a tile waits for programs, or has run its last
        launch; the mean of a job's tiles.
        """
        return sum(
            (stats["stalls"]["configuration"] + stats["cycles_by_use"]["idle"])
            / len(stats["tiles"])
            for stats in self.stats
            if stats["tiles"]
        )

    def predicted(self, share: float, batches: float) -> float:
        """Return the cycles of the whole frame, of which a share of the blocks was simulated, as
        those of so many batches: a job's beginning and end are as long, whatever is between them.
        """
        if self.whole or share == 1:
            return self.cycles
        jobs = 1.0 if self.once else batches
        return (self.cycles - self.cold) / share + self.cold * jobs


@dataclass(slots=True)
class Ledger:
    """Stages of a frame under way, in the order in which they first ran."""

    stages: dict[str, Stage] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)

    def add(self, name: str, result: JobResult, mode: str = "gpu") -> None:
        """Book a simulated job under a stage."""
        self._take(Stage(name, mode, result.cycles, 1, len(result.values), [result.stats]))

    def merge(self, other: Ledger) -> None:
        """Append what another ledger has booked."""
        for stage in other.stages.values():
            self._take(stage)
        self.count(**other.counts)

    def _take(self, more: Stage) -> None:
        stage = self.stages.setdefault(more.name, Stage(more.name, more.mode))
        stage.cycles += more.cycles
        stage.jobs += more.jobs
        stage.runs += more.runs
        stage.stats += more.stats
        stage.seconds += more.seconds
        stage.whole |= more.whole
        stage.once |= more.once

    def count(self, **numbers: int) -> None:
        """Add to named counts: samples, survivors, exps."""
        for name, number in numbers.items():
            self.counts[name] = self.counts.get(name, 0) + number

    @contextmanager
    def timed(self, name: str, mode: str = "gpu") -> Iterator[None]:
        """Book the host's seconds of the block under a stage."""
        start = perf_counter()
        try:
            yield
        finally:
            self._take(Stage(name, mode, seconds=perf_counter() - start))


@dataclass(frozen=True, slots=True, eq=False)
class ArrayFrame:
    """A picture that the simulated array computed.

    Attributes
    ----------
    image
        [height, width, 3] float32 over white, not clipped.
    stages
        In processing order.
    counts
        Work done and avoided: "density_samples", "colour_samples", "exponentials", ...
    clock_ghz
        Of the tiles.
    sampled
        Share of the blocks that were simulated; below 1 the other pixels are white, and cycles
        are of the simulated blocks only.
    batches
        How much of `Stage.cold` the whole frame has, over what was simulated: as many times as it
        has batches; of 3DGS, where a job is shared out whole, the square root of the screen tiles.
    simulated
        [height, width] bool: pixels of those blocks; None: all.
    late
        Programs whose mapping the clock ended (`Programs.late`): an idle machine may give other
        words, and other cycles.
    """

    image: Float32Array
    stages: tuple[Stage, ...]
    counts: dict[str, int]
    clock_ghz: float
    sampled: float = 1.0
    batches: float = 1.0
    simulated: npt.NDArray[np.bool_] | None = None
    late: tuple[str, ...] = ()

    @property
    def cycles(self) -> int:
        """Of the whole frame, stage after stage."""
        return total_cycles(self.stages)

    @property
    def frames_a_second(self) -> float:
        """At the tiles' clock; of a frame that is sampled, as predicted."""
        cycles = sum(self.predicted.values())
        return self.clock_ghz * 1e9 / cycles if cycles else 0.0

    @property
    def predicted(self) -> dict[str, float]:
        """Cycles of each stage of the whole frame: of one that is sampled, each block counts as the
        average, and a batch's jobs begin and end as often as there are batches.
        """
        share, batches = self.sampled, self.batches
        return {stage.name: stage.predicted(share, batches) for stage in self.stages}


def total_cycles(stages: Iterable[Stage]) -> int:
    """Return the cycles of all stages, one after the other."""
    return sum(stage.cycles for stage in stages)
