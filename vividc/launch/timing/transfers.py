"""Transfers on their engines: bursts through DRAM's channel and NoC (docs/accelerator.md). Compiled
functions.
"""

from __future__ import annotations

from vividc.launch.timing.clock import (
    ARRIVE_AT_DRAM,
    ARRIVE_AT_NOC,
    ARRIVE_AT_TILE,
    ASK,
    END_TRANSFER,
    START_TRANSFERS,
    WRITTEN,
    at,
    granted_at,
    request,
)
from vividc.launch.timing.compiled import inlined
from vividc.launch.timing.flow import take_banks
from vividc.launch.timing.queues import pop
from vividc.launch.timing.state import (
    CHANNEL,
    DRAM_BYTES,
    DRAM_CYCLES,
    DRAM_READ,
    DRAM_WANTED,
    DRAM_WRITTEN,
    MOVE_OUT,
    NETWORK,
    NOC,
    NOC_CYCLES,
    NOTHING,
    OWNER,
    PAD_CYCLES,
    SCRATCHPAD_IN,
    SCRATCHPAD_OUT,
    SIZE,
    TRANSFERS,
    Graph,
    Machine,
    Queues,
    State,
)


@inlined
def start_transfers(
    graph: Graph, queues: Queues, state: State, machine: Machine, cycle: int
) -> None:
    """The free engines of the lowest numbers take the transfers that were ready first."""
    for engine in range(len(state.is_free)):
        if queues.length[TRANSFERS] == 0:
            return
        if state.is_free[engine]:
            state.is_free[engine] = 0
            _, _, _, step = pop(queues, TRANSFERS)
            state.start[step] = cycle
            state.engine[step] = engine
            state.age[step] = state.started[0]
            state.started[0] += 1
            first, ready = graph.index_begin[step], cycle + machine.setup_cycles
            _go_on(graph, queues, step, first, ready)


@inlined
def _go_on(graph: Graph, queues: Queues, step: int, burst: int, cycle: int) -> None:
    """Ask for a transfer's burst in a cycle, or end there if it has no more."""
    if burst < graph.data_end[step]:
        at(queues, cycle, ASK, burst)
    else:
        at(queues, cycle, END_TRANSFER, step)


@inlined
def ask(graph: Graph, queues: Queues, state: State, burst: int, cycle: int) -> None:
    """The engine asks for its next burst where that begins."""
    server = NETWORK if _leaves_tile(graph, burst) else CHANNEL
    ask_for(graph, queues, state, server, burst, cycle)


@inlined
def _is_list(graph: Graph, burst: int) -> bool:
    """Whether a burst brings a transfer's indices or count from a scratchpad: it never crosses the
    channel.
    """
    return bool(graph.bursts[burst, DRAM_CYCLES] == 0)


@inlined
def _leaves_tile(graph: Graph, burst: int) -> bool:
    """Whether a burst comes from a scratchpad; a scatter's indices may come from DRAM."""
    step = graph.bursts[burst, OWNER]
    if burst < graph.data_begin[step]:
        return _is_list(graph, burst)
    return bool(graph.kind[step] == MOVE_OUT)


@inlined
def ask_for(
    graph: Graph, queues: Queues, state: State, server: int, burst: int, cycle: int
) -> None:
    """A burst asks for channel or NoC."""
    age = state.age[graph.bursts[burst, OWNER]]
    holds = graph.bursts[burst, NOC_CYCLES if server == NETWORK else DRAM_CYCLES]
    request(queues, state, server, cycle, (age, holds, burst))


@inlined
def take_channel(
    graph: Graph, queues: Queues, state: State, machine: Machine, burst: int, cycle: int
) -> None:
    """DRAM's channel is granted to a burst."""
    step = graph.bursts[burst, OWNER]
    left = cycle + graph.bursts[burst, DRAM_CYCLES]
    state.moved[DRAM_WANTED] += graph.bursts[burst, SIZE]
    if _leaves_tile(graph, burst):
        state.moved[DRAM_WRITTEN] += graph.bursts[burst, DRAM_BYTES]
        at(queues, left, WRITTEN, burst)
        return
    state.moved[DRAM_READ] += graph.bursts[burst, DRAM_BYTES]
    following, known = burst + 1, left + machine.dram_latency
    if following == graph.data_begin[step]:
        # The first row is asked for when the last index is known.
        _go_on(graph, queues, step, following, known)
        return
    if following < graph.data_end[step]:
        at(queues, left, ASK, following)
    if burst >= graph.data_begin[step]:
        at(queues, known, ARRIVE_AT_NOC, burst)


@inlined
def take_noc(
    graph: Graph, queues: Queues, state: State, machine: Machine, burst: int, cycle: int
) -> None:
    """The NoC's trunk is granted to a burst; a busy port keeps it waiting, but not the trunk."""
    step = graph.bursts[burst, OWNER]
    passed = _pass_ports(graph, state, burst, cycle + machine.noc_latency)
    state.moved[NOC] += graph.bursts[burst, SIZE]
    if not _leaves_tile(graph, burst):
        at(queues, passed, ARRIVE_AT_TILE, burst)
        return
    is_list = _is_list(graph, burst)
    state.moved[SCRATCHPAD_OUT] += graph.bursts[burst, SIZE]
    tile = graph.tile_items[graph.tile_begin[step]]
    take_banks(queues, state, tile, graph.bursts[burst, PAD_CYCLES], cycle)
    following = burst + 1
    if is_list and following == graph.data_begin[step]:
        _go_on(graph, queues, step, following, passed)
    elif following < graph.data_end[step]:
        at(queues, passed - machine.noc_latency, ASK, following)
    if not is_list:
        at(queues, passed, ARRIVE_AT_DRAM, burst)


@inlined
def _pass_ports(graph: Graph, state: State, burst: int, cycle: int) -> int:
    """Return when a burst that reaches its tiles' ports in a cycle has passed them all, a line of
    the scratchpads a cycle. Ports pass one burst after the other, as the trunk grants them.
    """
    step = graph.bursts[burst, OWNER]
    for place in range(graph.tile_begin[step], graph.tile_begin[step + 1]):
        cycle = max(cycle, state.port_free[graph.tile_items[place]])
    cycle += max(graph.bursts[burst, NOC_CYCLES], graph.bursts[burst, PAD_CYCLES])
    for place in range(graph.tile_begin[step], graph.tile_begin[step + 1]):
        state.port_free[graph.tile_items[place]] = cycle
    return cycle


@inlined
def reach_tiles(graph: Graph, queues: Queues, state: State, burst: int, cycle: int) -> int:
    """A burst arrives in the scratchpads that it is for; what that ends (see `arrive`)."""
    step = graph.bursts[burst, OWNER]
    for place in range(graph.tile_begin[step], graph.tile_begin[step + 1]):
        state.moved[SCRATCHPAD_IN] += graph.bursts[burst, SIZE]
        tile = graph.tile_items[place]
        take_banks(queues, state, tile, graph.bursts[burst, PAD_CYCLES], cycle)
    return arrive(graph, queues, state, burst, cycle)


@inlined
def arrive(graph: Graph, queues: Queues, state: State, burst: int, cycle: int) -> int:
    """A burst is where it should be; the last one ends its transfer, others `NOTHING`."""
    step = graph.bursts[burst, OWNER]
    state.arrived[step] += 1
    if state.arrived[step] < graph.data_end[step] - graph.data_begin[step]:
        return NOTHING
    return end_transfer(queues, state, step, cycle)


@inlined
def end_transfer(queues: Queues, state: State, step: int, cycle: int) -> int:
    """A transfer is complete, and its engine is free."""
    state.is_free[state.engine[step]] = 1
    granted_at(queues, cycle, START_TRANSFERS, NOTHING)
    return step
