"""Times a job: flattens its steps, simulates them, and collects the result."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vividc.arch import Accelerator
from vividc.errors import InternalError
from vividc.launch.flat import Ints
from vividc.launch.functional import Outcome
from vividc.launch.steps import Step
from vividc.launch.timing.pack import new_graph, new_queues, new_state
from vividc.launch.timing.record import Record
from vividc.launch.timing.simulation import simulate
from vividc.launch.timing.state import (
    BANKS_TAKEN,
    CHANNEL,
    CONFIGURATION_WAIT,
    DEPENDENCY_WAIT,
    DMA_WAIT,
    DRAM_READ,
    DRAM_WANTED,
    DRAM_WRITTEN,
    LAUNCH,
    NETWORK,
    NOC,
    SCRATCHPAD_IN,
    SCRATCHPAD_OUT,
    SIZE,
    Graph,
    Machine,
    State,
)

_CAUSES = {
    "dma": DMA_WAIT,
    "configuration": CONFIGURATION_WAIT,
    "dependency": DEPENDENCY_WAIT,
    "launch": LAUNCH,
    "scratchpad": BANKS_TAKEN,
}


@dataclass(frozen=True, slots=True)
class Moved:
    """Bytes at each level.

    `dram_read` and `dram_written` are what DRAM moves, whole granules; `dram_wanted` is what of it
    was asked for. A word that goes to several tiles crosses the NoC once.
    """

    dram_read: int = 0
    dram_written: int = 0
    dram_wanted: int = 0
    noc: int = 0
    scratchpad_in: int = 0
    scratchpad_out: int = 0


@dataclass(frozen=True, slots=True)
class TileClock:
    """Where a tile's cycles went, up to its last run's end in cycle `free_from`.

    `stalls`: by cause, "dma": waits for transfers; "configuration": bubbles of a switch;
    "dependency": waits for other tiles; "launch": the controller writes launch words;
    "scratchpad": DMA has the banks.
    """

    free_from: int
    stalls: Mapping[str, int]


@dataclass(frozen=True, slots=True, eq=False)
class Timing:
    """The outcome.

    Attributes
    ----------
    spans
        [n, 3] int64, by step: when all it waits for was done, when it started, when it was done.
    tiles
        What the tiles waited for.
    busy
        Cycles that DRAM and NoC were busy.
    """

    cycles: int
    spans: Ints
    tiles: tuple[TileClock, ...]
    moved: Moved
    record: Record
    busy: Mapping[str, int]


def schedule(
    accelerator: Accelerator,
    steps: Sequence[Step],
    waits: Sequence[tuple[int, ...]],
    outcome: Outcome,
) -> Timing:
    """Simulate the job's timing.

    Parameters
    ----------
    waits
        Steps that each step waits for.
    outcome
        Cycles of the runs, and the rows that transfers by a list or a count moved.
    """
    graph = new_graph(accelerator, steps, waits, outcome)
    state = new_state(accelerator, graph)
    machine = Machine(
        accelerator.dram.latency,
        accelerator.noc.latency,
        accelerator.dma.setup_cycles,
        accelerator.configuration.double_buffered,
    )
    simulate(graph, new_queues(graph), state, machine)
    if state.left.any():
        raise InternalError("a launch graph came to a standstill")
    return _timing(steps, graph, state)


def _timing(steps: Sequence[Step], graph: Graph, state: State) -> Timing:
    stalls, free_from = state.stalls.tolist(), state.free_from.tolist()
    tiles = tuple(
        TileClock(free, {cause: row[place] for cause, place in _CAUSES.items()})
        for row, free in zip(stalls, free_from, strict=True)
    )
    moved = state.moved.tolist()
    return Timing(
        cycles=int(state.end.max(initial=0)),
        spans=np.stack((state.ready, state.start, state.end), axis=1),
        tiles=tiles,
        moved=Moved(
            dram_read=moved[DRAM_READ],
            dram_written=moved[DRAM_WRITTEN],
            dram_wanted=moved[DRAM_WANTED],
            noc=moved[NOC],
            scratchpad_in=moved[SCRATCHPAD_IN],
            scratchpad_out=moved[SCRATCHPAD_OUT],
        ),
        record=_record(steps, graph, state),
        busy={"dram": int(state.busy[CHANNEL]), "noc": int(state.busy[NETWORK])},
    )


def _record(steps: Sequence[Step], graph: Graph, state: State) -> Record:
    before = np.zeros(len(graph.bursts) + 1, dtype=np.int64)
    np.cumsum(graph.bursts[:, SIZE], out=before[1:])
    sizes = before[graph.data_end] - before[graph.data_begin]
    return Record(steps, state.start, state.end, state.engine, sizes)
