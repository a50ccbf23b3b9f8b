"""The reference interpreter: what a kernel's region graph means, one iteration after the other.

It knows nothing of time and place. Iterations run in order; within one, nodes run in a topological
order of the edges of distance 0. No iteration is speculative here, so an access that leaves the
memory is an error.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
import numpy.typing as npt

from vividc.dfg.interpret.executable import Executable, compile_dfg
from vividc.dfg.ir import DFG, Control, Node
from vividc.dfg.regions import RETURN_HIGH, RETURN_VARIABLE, Kernel, Region, is_variable
from vividc.errors import ArgumentError, DFGError, SimulationError, SourceLoc
from vividc.machine.params import DType, joined
from vividc.machine.words import WORD_MASK, signed

DEFAULT_ITERATION_LIMIT: Final = 50_000_000


@dataclass(frozen=True, slots=True)
class RegionRun:
    """One run of a region.

    Attributes
    ----------
    iterations
        Iterations that ran, the exiting one included; 1 for a straight region.
    written
        Word of each variable that a live-out wrote, the last iteration's last.
    branch
        Whether the BRANCH node gave 1.
    trip
        Word of the TRIP node, if there is one.
    """

    iterations: int
    written: Mapping[str, int]
    branch: bool = False
    trip: int | None = None


@dataclass(frozen=True, slots=True)
class InterpreterResult:
    """Outcome of a kernel.

    Attributes
    ----------
    variables
        Word of each variable that was written.
    value
        Word returned by the kernel, or None.
    iterations, runs
        Per region, in table order: iterations over all its runs, and how often it ran.
    operations
        FU operations executed, predicated-off ones included.
    """

    variables: Mapping[str, int]
    value: int | None
    iterations: tuple[int, ...]
    runs: tuple[int, ...]
    operations: int


class Watch:
    """Told what an interpreted kernel does to memory."""

    def enter(self) -> None:
        """A region begins."""

    def access(self, node: Node, byte: int) -> None:
        """A load or store is carried out at a byte address."""

    def leave(self, *, exited: bool) -> None:
        """An iteration ends, maybe by its exit predicate."""


_UNWATCHED: Final = Watch()


def interpret_region(
    dfg: DFG,
    kind: Literal["loop", "straight"],
    trip: int | None,
    env: Mapping[str, int],
    memory: bytearray | npt.NDArray[np.uint32],
    *,
    iteration_limit: int = DEFAULT_ITERATION_LIMIT,
) -> RegionRun:
    """Run one region.

    Parameters
    ----------
    kind
        A straight region runs one iteration, a loop until its trip count or its EXIT node ends it.
    trip
        Iterations of a counted loop (a word, signed); None if it is not counted.
    env
        Word of each live-in.
    memory
        The scratchpad, little-endian bytes; updated in place.
    iteration_limit
        Iterations after which the run is given up.

    Raises
    ------
    SimulationError
        An access leaves the memory or is not aligned, or the iteration limit is reached.
    DFGError
        The graph cannot be executed.
    ArgumentError
        A live-in is missing from `env`.
    """
    executable = compile_dfg(dfg)
    return run_executable(
        executable,
        kind,
        trip,
        env,
        words_of(memory),
        iteration_limit=iteration_limit,
        name=dfg.name,
    )


def interpret(
    kernel: Kernel,
    memory: bytearray | npt.NDArray[np.uint32],
    inputs: Mapping[str, int],
    *,
    iteration_limit: int = DEFAULT_ITERATION_LIMIT,
    watch: Watch = _UNWATCHED,
) -> InterpreterResult:
    """Run a kernel from its first region to its end.

    Parameters
    ----------
    memory
        The scratchpad, little-endian bytes; updated in place.
    inputs
        Word of each input the host supplies (see `cfg.Input.key`).
    iteration_limit
        Iterations over all regions after which the run is given up.
    watch
        Told of each access and iteration.

    Raises
    ------
    SimulationError, DFGError, ArgumentError
        As `interpret_region`; also a counted loop that no trip count reached.
    """
    accessed = None if watch is _UNWATCHED else watch.access
    executables = [compile_dfg(region.dfg, accessed) for region in kernel.regions]
    words = words_of(memory)
    env = {name: word & WORD_MASK for name, word in inputs.items()}
    iterations = [0] * len(kernel.regions)
    runs = [0] * len(kernel.regions)
    trip: int | None = None
    left = iteration_limit
    index: int | None = 0 if kernel.regions else None
    while index is not None:
        region = kernel.regions[index]
        watch.enter()
        run = run_executable(
            executables[index],
            region.kind,
            _trip_of(region, trip),
            env,
            words,
            iteration_limit=left,
            name=region.name,
            watch=watch,
        )
        env.update(run.written)
        trip = trip if run.trip is None else run.trip
        runs[index] += 1
        iterations[index] += run.iterations
        left -= run.iterations or 1  # an empty loop must not run for ever either
        if left < 0:
            raise _limit_reached(region.name, region.loc)
        index = region.branch if run.branch else region.next
    return _result_of(kernel.returns, env, executables, iterations, runs)


def words_of(memory: bytearray | npt.NDArray[np.uint32]) -> memoryview[int]:
    """View of a scratchpad as 32-bit words; writing to it writes the scratchpad."""
    view = memoryview(memory) if isinstance(memory, bytearray) else memory.data
    if view.nbytes % 4:
        raise ArgumentError(f"memory of {view.nbytes} bytes is not made of 4-byte words")
    return view.cast("B").cast("I")


def run_executable(
    executable: Executable,
    kind: Literal["loop", "straight"],
    trip: int | None,
    env: Mapping[str, int],
    words: memoryview[int],
    *,
    iteration_limit: int = DEFAULT_ITERATION_LIMIT,
    name: str = "",
    watch: Watch = _UNWATCHED,
) -> RegionRun:
    """Run a flattened region; see `interpret_region`."""
    values = _entry_values(executable, env)
    exit_slot = executable.control.get(Control.EXIT) if kind == "loop" else None
    limit = 1 if kind == "straight" else iteration_limit if trip is None else max(signed(trip), 0)
    if kind == "loop" and trip is None and exit_slot is None:
        raise DFGError(f"loop region {name} has neither a trip count nor an exit")
    written: dict[str, int] = {}
    iteration = 0
    exited = False
    while iteration < limit and not exited:
        if iteration >= iteration_limit:
            raise _limit_reached(name)
        for slot in executable.ivs:
            values[slot] = iteration & WORD_MASK
        for step in executable.steps:
            step(values, words)
        exited = exit_slot is not None and values[exit_slot] != 0
        _settle_misses(executable.misses, exited=exited)
        watch.leave(exited=exited)
        for variable, slot, unless_exit in executable.live_outs:
            if not (exited and unless_exit):
                written[variable] = values[slot]
        for slot, source, _ in executable.delays:
            values[slot] = values[source]
        iteration += 1
    if trip is None and kind == "loop" and not exited:
        raise _limit_reached(name)
    return _run_of(executable, values, iteration, written)


def _settle_misses(misses: list[SimulationError], *, exited: bool) -> None:
    """Raise what an `unless_exit` load met, unless its iteration exits."""
    if misses and not exited:
        raise misses[0]
    misses.clear()


def _result_of(
    returns: DType | None,
    env: Mapping[str, int],
    executables: Sequence[Executable],
    iterations: Sequence[int],
    runs: Sequence[int],
) -> InterpreterResult:
    counts = zip(iterations, executables, strict=True)
    low = env.get(RETURN_VARIABLE)
    value = None if low is None else joined(returns, low, env.get(RETURN_HIGH))
    return InterpreterResult(
        variables={name: word for name, word in env.items() if is_variable(name)},
        value=value,
        iterations=tuple(iterations),
        runs=tuple(runs),
        operations=sum(count * executable.operations for count, executable in counts),
    )


def _run_of(
    executable: Executable, values: Sequence[int], iterations: int, written: Mapping[str, int]
) -> RegionRun:
    branch = executable.control.get(Control.BRANCH)
    trip = executable.control.get(Control.TRIP)
    return RegionRun(
        iterations=iterations,
        written=written,
        branch=branch is not None and values[branch] != 0,
        trip=None if trip is None else values[trip],
    )


def _entry_values(executable: Executable, env: Mapping[str, int]) -> list[int]:
    values = [0] * executable.size
    for slot, word in executable.constants:
        values[slot] = word
    for slot, name in executable.live_ins:
        if name not in env:
            what = "variable is read before it is written" if is_variable(name) else "no such input"
            raise ArgumentError(f"live-in {name}: {what}")
        values[slot] = env[name] & WORD_MASK
    for slot, _, init in executable.delays:
        values[slot] = values[init]
    return values


def _trip_of(region: Region, trip: int | None) -> int | None:
    if not region.counted:
        return None
    if trip is None:
        raise DFGError(f"counted loop {region.name} runs before any TRIP node", loc=region.loc)
    return trip


def _limit_reached(name: str, loc: SourceLoc | None = None) -> SimulationError:
    return SimulationError(
        f"region {name}: the iteration limit is reached",
        loc=loc,
        hint="check that the loop ends, or raise iteration_limit",
    )
