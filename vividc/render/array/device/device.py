"""The accelerator that a frame is rendered on: its compiled kernels, and how they are run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import vividc
from vividc.launch import Job
from vividc.machine.words import WORD_BYTES
from vividc.render.array.device.frame import Ledger
from vividc.render.array.device.launch import Launch
from vividc.render.array.device.launches import Phase, Shares, add_phases, dealt
from vividc.render.array.device.programs import Programs
from vividc.render.array.options import NetworkMode


@dataclass(slots=True)
class Device:
    """An accelerator that is given jobs, each of which is booked under the name of a stage.

    Attributes
    ----------
    programs
        Of its tiles.
    engine
        That simulates them.
    mode
        Of networks, as in `ArrayOptions`.
    ledger
        What was booked.
    """

    programs: Programs
    engine: str = "auto"
    mode: NetworkMode = "auto"
    ledger: Ledger = field(default_factory=Ledger)

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

    def fitting(self, record: int, held: int = 0, arrays: int = 0, copies: int = 2) -> int:
        """Return how many records of so many words a launch may have, so that `copies` launches fit
        a scratchpad: one runs while the next is moved in.

        Parameters
        ----------
        held
            Words of what lies beside them.
        arrays
            Of a launch; each may lose a word of each bank to where it begins.
        """
        line = self.line_bytes // WORD_BYTES
        free = self.scratchpad_bytes // WORD_BYTES - held - copies * arrays * line
        return max(free, 0) // (copies * record)

    @property
    def clock_ghz(self) -> float:
        """Of the tiles."""
        return self.programs.machine.fabric.clock_ghz

    def settle(self) -> Ledger:
        """Return what was booked, and begin a new ledger."""
        done, self.ledger = self.ledger, Ledger()
        return done

    def run(self, stage: str, kernel: str, launches: Sequence[Launch]) -> list[int]:
        """Run launches on all tiles in one job, dealt out by cost; return what each returned: 0 of
        a kernel that returns nothing.

        `kernel` is as in `Programs.get`; outputs are updated in place.

        Raises
        ------
        SceneError
            A launch does not fit the scratchpad.
        """
        numbers = dealt(launches, self.tiles)
        shares = [[launches[number] for number in share] for share in numbers]
        returned = [0] * len(launches)
        for share, values in zip(numbers, self.run_shares(stage, kernel, shares), strict=True):
            for number, value in zip(share, values, strict=True):
                returned[number] = value
        return returned

    def run_shares(self, stage: str, kernel: str | None, shares: Shares) -> list[list[int]]:
        """As `run`, of each tile's share of launches."""
        return self.run_phases(stage, [Phase(kernel, shares)])[0]

    def run_phases(self, stage: str, phases: Sequence[Phase]) -> list[list[list[int]]]:
        """As `run_shares`, of several phases in one job (`add_phases`); without launches there is
        none.
        """
        if not any(any(phase.shares) for phase in phases):
            return [[[] for _ in phase.shares] for phase in phases]
        job = Job(self.programs.machine)
        programs = [
            self.programs.get(phase.kernel, **phase.options) if phase.kernel else None
            for phase in phases
        ]
        with self.ledger.timed(stage):
            runs = add_phases(job, programs, phases)
            result = job.simulate(engine=self.engine)
        self.ledger.add(stage, result)
        values = result.values
        ends = [values.get(run) for shares in runs for one in shares for run in one]
        self.ledger.count(words_read_by_host=sum(value is not None for value in ends))
        return [[[int(values.get(run) or 0) for run in one] for one in shares] for shares in runs]

    def spread(self, stage: str, kernel: str, *arguments: object) -> None:
        """Spread a kernel's loop over `numba.prange` over the tiles; arrays change in place."""
        program = self.programs.get(kernel)
        with self.ledger.timed(stage):
            machine = self.programs.machine
            result = vividc.simulate(program, *arguments, fabric=machine, engine=self.engine)
        self.ledger.add(stage, result)


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
