"""The steps of a job as flat arrays, and the arrays of its simulation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vividc.arch import Accelerator
from vividc.launch.flat import Ints, flat
from vividc.launch.functional import Outcome
from vividc.launch.steps import Configure, Execute, Step, Transfer, tiles_of
from vividc.launch.timing.bursts import cut_of, cut_pieces, line_bytes
from vividc.launch.timing.state import (
    CHANNEL,
    CONFIGURE,
    DRAM_BYTES,
    DRAM_CYCLES,
    EVENTS,
    MOVE_IN,
    MOVE_OUT,
    NETWORK,
    NOTHING,
    OWNER,
    RUN,
    TRANSFERS,
    Graph,
    Queues,
    State,
)
from vividc.program import WORD_BYTES

_EVENTS_OF_A_STEP = 10
_EVENTS_OF_A_BURST = 10
"""At most, beside one for each tile that it reaches."""


def new_graph(
    accelerator: Accelerator,
    steps: Sequence[Step],
    waits: Sequence[tuple[int, ...]],
    outcome: Outcome,
) -> Graph:
    """Return the steps of a job as flat arrays (see `schedule`)."""
    wait_begin, wait_items = flat(waits)
    next_begin, next_items = _inverted(wait_begin, wait_items)
    tile_begin, tile_items = flat([tiles_of(step) for step in steps])
    taken = _replaced(steps, accelerator.sharing, tile_begin.tolist())
    taken_begin, taken_items = flat(taken)
    kinds = np.array([_kind(step) for step in steps], dtype=np.int64)
    index_begin, data_begin, data_end, bursts = _bursts(accelerator, steps, outcome)
    return Graph(
        kind=kinds,
        cycles=_cycles(accelerator, steps, outcome),
        launch_words=_launch_words(steps),
        wait_begin=wait_begin,
        wait_items=wait_items,
        next_begin=next_begin,
        next_items=next_items,
        tile_begin=tile_begin,
        tile_items=tile_items,
        held=_held(steps, tile_begin.tolist()),
        taken_begin=taken_begin,
        taken_items=taken_items,
        configurations=np.flatnonzero(kinds == CONFIGURE),
        index_begin=index_begin,
        data_begin=data_begin,
        data_end=data_end,
        bursts=bursts,
    )


def new_state(accelerator: Accelerator, graph: Graph) -> State:
    """Everything as it is before cycle 0."""
    steps, tiles = len(graph.kind), len(accelerator.units)
    held = len(graph.tile_items)
    return State(
        left=np.diff(graph.wait_begin),
        ready=_zeros(steps),
        start=_zeros(steps),
        end=_zeros(steps),
        engine=_zeros(steps),
        age=_zeros(steps),
        arrived=_zeros(steps),
        started=_zeros(1),
        running=np.full(tiles, NOTHING, dtype=np.int64),
        issue_from=_zeros(tiles),
        stop=_zeros(tiles),
        version=_zeros(tiles),
        free_from=_zeros(tiles),
        stalls=np.zeros((tiles, 5), dtype=np.int64),
        is_free=np.ones(accelerator.dma.engines, dtype=np.int64),
        port_free=_zeros(tiles),
        free_at=_zeros(3),
        looks_at=np.full(3, NOTHING, dtype=np.int64),
        busy=_zeros(3),
        is_waiting=_zeros(steps),
        is_started=_zeros(held),
        runs_left=np.bincount(graph.held[graph.kind == RUN], minlength=held).astype(np.int64),
        is_loading=_zeros(1),
        moved=_zeros(6),
    )


def new_queues(graph: Graph) -> Queues:
    """Return empty queues with room for the most that can ever be in them; the system allocates
    only the pages that are written.
    """
    steps, bursts = len(graph.kind), len(graph.bursts)
    reached = int(np.diff(graph.tile_begin)[graph.bursts[:, OWNER]].sum())
    events = _EVENTS_OF_A_STEP * steps + _EVENTS_OF_A_BURST * bursts + reached
    rooms = {EVENTS: events, CHANNEL: bursts, NETWORK: bursts, TRANSFERS: steps}
    ends = np.cumsum([rooms[queue] for queue in sorted(rooms)])
    begin = np.concatenate(([0], ends[:-1]))
    return Queues(np.empty((ends[-1], 4), dtype=np.int64), begin, _zeros(4), _zeros(4))


def _zeros(count: int) -> Ints:
    return np.zeros(count, dtype=np.int64)


def _inverted(begin: Ints, items: Ints) -> tuple[Ints, Ints]:
    """For each number the lists that it is in, in ascending order."""
    lists = np.repeat(np.arange(len(begin) - 1), np.diff(begin))
    inverted = _zeros(len(begin))
    np.cumsum(np.bincount(items, minlength=len(begin) - 1), out=inverted[1:])
    return inverted, lists[np.argsort(items, kind="stable")]


def _kind(step: Step) -> int:
    if isinstance(step, Execute):
        return RUN
    if isinstance(step, Configure):
        return CONFIGURE
    return MOVE_OUT if step.to_dram else MOVE_IN


def _cycles(accelerator: Accelerator, steps: Sequence[Step], outcome: Outcome) -> Ints:
    """Return the cycles of each run once it issues, and of each configuration in the stream."""
    cycles = _zeros(len(steps))
    for number, run in outcome.runs.items():
        cycles[number] = run.cycles
    for number, step in enumerate(steps):
        if isinstance(step, Configure):
            cycles[number] = -(-step.entries // accelerator.configuration.entries_per_cycle)
    return cycles


def _launch_words(steps: Sequence[Step]) -> Ints:
    known: dict[int, int] = {}
    words = _zeros(len(steps))
    for number, step in enumerate(steps):
        if isinstance(step, Execute):
            if id(step.program) not in known:
                known[id(step.program)] = step.launch_words
            words[number] = known[id(step.program)]
    return words


def _held(steps: Sequence[Step], tile_begin: Sequence[int]) -> Ints:
    """Of each run, the place in the list of all steps' tiles of its configuration and its tile."""
    held = np.full(len(steps), NOTHING, dtype=np.int64)
    for number, step in enumerate(steps):
        if isinstance(step, Execute):
            held[number] = _place(steps, tile_begin, step.configured_by, step.tile)
    return held


def _place(steps: Sequence[Step], tile_begin: Sequence[int], number: int, tile: int) -> int:
    return tile_begin[number] + tiles_of(steps[number]).index(tile)


def _replaced(
    steps: Sequence[Step], sharing: Sequence[frozenset[int]], tile_begin: Sequence[int]
) -> list[list[int]]:
    """What each configuration finds in its tiles, in whatever form they were."""
    held: dict[int, int] = {}
    lists: list[list[int]] = []
    for number, step in enumerate(steps):
        replaced: list[int] = []
        if isinstance(step, Configure):
            units = set(step.tiles).union(*(sharing[tile] for tile in step.tiles if sharing))
            for unit in sorted(units):
                if unit in held:
                    replaced.append(_place(steps, tile_begin, held.pop(unit), unit))
            held.update(dict.fromkeys(step.tiles, number))
        lists.append(replaced)
    return lists


def _bursts(
    accelerator: Accelerator, steps: Sequence[Step], outcome: Outcome
) -> tuple[Ints, Ints, Ints, Ints]:
    """By step the first burst for its indices or count, the first for its data and the one behind;
    and all bursts.
    """
    parts: list[Ints] = [np.empty((0, 2), dtype=np.int64)]
    counts = np.zeros((len(steps), 2), dtype=np.int64)
    lines, in_pads = _zeros(len(steps)), np.zeros(len(steps), dtype=np.bool_)
    for number, step in enumerate(steps):
        if isinstance(step, Transfer):
            lines[number] = line_bytes(accelerator, step)
            parts.append(_index_spans(step, outcome.listed.get(number, 0)))
            counts[number, 0] = len(parts[-1])
            in_pads[number] = step.told_at is not None
            parts.append(outcome.chosen.get(number, step.pieces).spans)
            counts[number, 1] = len(parts[-1])
    owners = np.repeat(np.arange(len(steps)), counts.sum(axis=1))
    first, bursts = cut_pieces(cut_of(accelerator), owners, lines[owners], np.concatenate(parts))
    ends = np.zeros(2 * len(steps) + 1, dtype=np.int64)
    np.cumsum(counts.reshape(-1), out=ends[1:])
    bounds = first[ends]
    spaced = bounds[0:-1:2], bounds[1::2], bounds[2::2]
    starts, data, behind = map(np.ascontiguousarray, spaced)
    for number in np.flatnonzero(in_pads).tolist():
        bursts[starts[number] : data[number], (DRAM_BYTES, DRAM_CYCLES)] = 0
    return starts, data, behind, bursts


def _index_spans(step: Transfer, listed: int) -> Ints:
    """Where a transfer's indices lie, in DRAM, or in a scratchpad so many behind their number; or
    where the count of a move out does.
    """
    if step.told_at is not None:
        return np.array([(step.told_at[0], WORD_BYTES * (1 + listed))], dtype=np.int64)
    if step.index_pieces is not None:
        return step.index_pieces.spans
    return np.empty((0, 2), dtype=np.int64)
