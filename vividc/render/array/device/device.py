"""The accelerator that a frame is rendered on: its compiled kernels, and how they are run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import vividc
from vividc.launch import Job, JobResult
from vividc.machine.words import WORD_BYTES
from vividc.render.array.device.frame import Ledger
from vividc.render.array.device.programs import Programs
from vividc.render.array.options import NetworkMode


@dataclass(frozen=True, slots=True)
class Device:
    """An accelerator, the programs of its tiles, the engine that simulates them, and the mode of
    networks (`ArrayOptions.mode`).
    """

    programs: Programs
    engine: str = "auto"
    mode: NetworkMode = "auto"

    @property
    def tiles(self) -> int:
        """How many there are."""
        return len(self.programs.machine.tiles)

    @property
    def scratchpad_bytes(self) -> int:
        """Of each tile."""
        return self.programs.machine.fabric.scratchpad.size_bytes

    @property
    def line_bytes(self) -> int:
        """A word of each bank: what it takes at most that an array starts in a certain bank."""
        return WORD_BYTES * self.programs.machine.fabric.scratchpad.banks

    @property
    def clock_ghz(self) -> float:
        """Of the tiles."""
        return self.programs.machine.fabric.clock_ghz

    def new_job(self) -> Job:
        """Return an empty launch graph."""
        return Job(self.programs.machine)

    def spread(
        self, ledger: Ledger, stage: str, kernel: str, *arguments: object, **options: object
    ) -> JobResult:
        """Spread a kernel's loop over `numba.prange` over the tiles, and book it under a stage.

        `kernel` and `options` are as in `Programs.get`; arrays are updated in place.
        """
        program = self.programs.get(kernel, **options)
        with ledger.timed(stage):
            machine = self.programs.machine
            result = vividc.simulate(program, *arguments, fabric=machine, engine=self.engine)
        ledger.add(stage, result)
        return result

    def finish(self, ledger: Ledger, stage: str, job: Job) -> JobResult:
        """Simulate a launch graph and book it under a stage."""
        with ledger.timed(stage):
            result = job.simulate(engine=self.engine)
        ledger.add(stage, result)
        return result


def open_device(
    fabric: str = "vivid",
    engine: str = "auto",
    tell: Callable[[str], None] | None = None,
    mode: NetworkMode = "auto",
) -> Device:
    """Return an accelerator by name or YAML file; `tell` gets a line for each kernel it compiles.

    The engine "auto" is the native one: the trial on the reference engine took 0.1 s of each
    program in each corner of the accelerator, 4.4 s of a frame.

    Raises
    ------
    ArchError
        The fabric is unknown, faulty or a single tile.
    """
    if engine == "auto":  # renderers run each program often
        engine = "native"
    return Device(Programs(vividc.arch.load_accelerator(fabric), tell), engine, mode)
