"""The event loop of a job: the compiled function that Python calls."""

from __future__ import annotations

from vividc.launch.timing.clock import (
    ARRIVE_AT_DRAM,
    ARRIVE_AT_NOC,
    ARRIVE_AT_TILE,
    ASK,
    CONFIGURED,
    END_RUN,
    END_TRANSFER,
    GRANT,
    READY,
    START_STREAM,
    START_TRANSFERS,
    WRITTEN,
    at,
    serve,
)
from vividc.launch.timing.compiled import compiled, inlined
from vividc.launch.timing.flow import end_configuration, end_run, finish, make_ready, start_stream
from vividc.launch.timing.queues import pop
from vividc.launch.timing.state import (
    CHANNEL,
    EVENTS,
    FIRST_CYCLE,
    NETWORK,
    NOTHING,
    Graph,
    Machine,
    Queues,
    State,
)
from vividc.launch.timing.transfers import (
    arrive,
    ask,
    ask_for,
    end_transfer,
    reach_tiles,
    start_transfers,
    take_channel,
    take_noc,
)


@compiled
def simulate(graph: Graph, queues: Queues, state: State, machine: Machine) -> None:
    """Process events from cycle 0 until none is left."""
    for step in range(len(graph.kind)):
        if state.left[step] == 0:
            at(queues, FIRST_CYCLE, READY, step)
    while queues.length[EVENTS]:
        when, _, what, item = pop(queues, EVENTS)
        cycle = when // 2
        done = NOTHING
        if what == END_RUN:
            done = end_run(graph, queues, state, item, cycle)
        elif what == READY:
            make_ready(graph, queues, state, item, cycle)
        elif what == START_STREAM:
            start_stream(graph, queues, state, machine, cycle)
        elif what == CONFIGURED:
            end_configuration(queues, state, cycle)
            done = item
        else:
            done = _transfer(graph, queues, state, machine, (cycle, what, item))
        if done != NOTHING:
            finish(graph, queues, state, done, cycle)


@inlined
def _transfer(
    graph: Graph, queues: Queues, state: State, machine: Machine, event: tuple[int, int, int]
) -> int:
    """What happens to transfers; the one that is done by it, or `NOTHING`."""
    cycle, what, item = event
    if what == ARRIVE_AT_TILE:
        return reach_tiles(graph, queues, state, item, cycle)
    if what == WRITTEN:
        return arrive(graph, queues, state, item, cycle)
    if what == END_TRANSFER:
        return end_transfer(queues, state, item, cycle)
    if what == GRANT:
        _grant(graph, queues, state, machine, item, cycle)
    elif what == ASK:
        ask(graph, queues, state, item, cycle)
    elif what == ARRIVE_AT_NOC:
        ask_for(graph, queues, state, NETWORK, item, cycle)
    elif what == ARRIVE_AT_DRAM:
        ask_for(graph, queues, state, CHANNEL, item, cycle)
    elif what == START_TRANSFERS:
        start_transfers(graph, queues, state, machine, cycle)
    return NOTHING


@inlined
def _grant(
    graph: Graph, queues: Queues, state: State, machine: Machine, server: int, cycle: int
) -> None:
    burst = serve(queues, state, server, cycle)
    if burst == NOTHING:
        return
    if server == CHANNEL:
        take_channel(graph, queues, state, machine, burst, cycle)
    else:
        take_noc(graph, queues, state, machine, burst, cycle)
