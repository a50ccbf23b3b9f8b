"""A job and the state of its simulation as flat arrays, which is what compiled functions read."""

from __future__ import annotations

from typing import Final, NamedTuple

from vividc.launch.flat import Ints, Ints2

MOVE_IN, MOVE_OUT, CONFIGURE, RUN = 0, 1, 2, 3
"""Kinds of steps; a gather is a move in, and a scatter a move out, whose indices are bursts, too,
as is the count of a move out that has one.
"""

SIZE, DRAM_BYTES, DRAM_CYCLES, NOC_CYCLES, PAD_CYCLES, OWNER = range(6)
"""Columns of `Graph.bursts`: bytes that are wanted; bytes that DRAM moves, whole granules; how long
the burst holds the channel, the NoC's trunk, and a tile's port and banks; its step.
"""

DRAM_READ, DRAM_WRITTEN, DRAM_WANTED, NOC, SCRATCHPAD_IN, SCRATCHPAD_OUT = range(6)
"""Positions in `State.moved`."""

DMA_WAIT, CONFIGURATION_WAIT, DEPENDENCY_WAIT, LAUNCH, BANKS_TAKEN = range(5)
"""Columns of `State.stalls`."""

EVENTS, CHANNEL, NETWORK, TRANSFERS = range(4)
"""Queues: what will happen; bursts that wait for DRAM's channel and for the NoC; transfers that
wait for an engine.
"""

NOTHING: Final = -1
FIRST_CYCLE: Final = 0


class Machine(NamedTuple):
    """The accelerator's numbers (docs/accelerator.md)."""

    dram_latency: int
    noc_latency: int
    setup_cycles: int
    double_buffered: bool


class Graph(NamedTuple):
    """The steps of a job. Lists of lists are `begin` and `items`: the items of i are
    `items[begin[i]:begin[i + 1]]`.

    Attributes
    ----------
    kind
        By step.
    cycles
        By step: of a run once it issues, of a configuration in the stream.
    launch_words
        By step, of runs.
    wait_begin, wait_items
        Steps that each step waits for; `next_begin`, `next_items`: that wait for it.
    tile_begin, tile_items
        Tiles that each step concerns.
    held
        By step: of a run, the position in `tile_items` of its configuration and its tile.
    taken_begin, taken_items
        By step: such positions whose programs a configuration replaces.
    configurations
        The configuration steps.
    index_begin, data_begin, data_end
        By step: the bursts that read a transfer's indices or count, and behind them those that move
        the data.
    bursts
        [n, 6]: see the columns.
    """

    kind: Ints
    cycles: Ints
    launch_words: Ints
    wait_begin: Ints
    wait_items: Ints
    next_begin: Ints
    next_items: Ints
    tile_begin: Ints
    tile_items: Ints
    held: Ints
    taken_begin: Ints
    taken_items: Ints
    configurations: Ints
    index_begin: Ints
    data_begin: Ints
    data_end: Ints
    bursts: Ints2


class Queues(NamedTuple):
    """Heaps of (first key, second key, what, item), the smallest keys on top.

    Attributes
    ----------
    rows
        int64 [room, 4] of all of them.
    begin, length, pushed
        By queue: its place in `rows`, how much it holds, how much it was ever given.
    """

    rows: Ints2
    begin: Ints
    length: Ints
    pushed: Ints


class State(NamedTuple):
    """What changes during the simulation.

    Attributes
    ----------
    left, ready, start, end, engine, age, arrived
        By step: steps that it waits for still; when all of them were done; when it ran; what served
        it, and how many transfers had started before; bursts that have arrived.
    started
        [1]: transfers that have started.
    running, issue_from, stop, version, free_from
        By tile: the step that runs or `NOTHING`; when it issues; when it will end, as far as is
        known, and how often that was changed; when the last run ended.
    stalls
        By tile and cause.
    is_free
        By DMA engine.
    port_free
        By tile: when its port of the NoC has passed all that it was given.
    free_at, looks_at, busy
        By `CHANNEL` and `NETWORK`: when it is free; the cycle in which it will see who waits, or
        `NOTHING`; cycles that it served.
    is_waiting, is_started, runs_left
        Configurations that wait for the stream, by step; programs that have started on their tile,
        and how often they will still run, by position in `tile_items`.
    is_loading
        [1]: the stream is.
    moved
        Bytes at each level.
    """

    left: Ints
    ready: Ints
    start: Ints
    end: Ints
    engine: Ints
    age: Ints
    arrived: Ints
    started: Ints
    running: Ints
    issue_from: Ints
    stop: Ints
    version: Ints
    free_from: Ints
    stalls: Ints2
    is_free: Ints
    port_free: Ints
    free_at: Ints
    looks_at: Ints
    busy: Ints
    is_waiting: Ints
    is_started: Ints
    runs_left: Ints
    is_loading: Ints
    moved: Ints
