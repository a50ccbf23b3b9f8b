"""When steps become ready, start and end, transfers aside; compiled."""

from __future__ import annotations

from vividc.launch.timing.clock import (
    CONFIGURED,
    END_RUN,
    START_STREAM,
    START_TRANSFERS,
    at,
    granted_at,
)
from vividc.launch.timing.compiled import inlined
from vividc.launch.timing.queues import push
from vividc.launch.timing.state import (
    BANKS_TAKEN,
    CONFIGURATION_WAIT,
    CONFIGURE,
    DEPENDENCY_WAIT,
    DMA_WAIT,
    LAUNCH,
    NOTHING,
    RUN,
    TRANSFERS,
    Graph,
    Machine,
    Queues,
    State,
)


@inlined
def make_ready(graph: Graph, queues: Queues, state: State, step: int, cycle: int) -> None:
    """All that a step waits for is done."""
    state.ready[step] = cycle
    if graph.kind[step] == RUN:
        _start_run(graph, queues, state, step, cycle)
    elif graph.kind[step] == CONFIGURE:
        state.is_waiting[step] = 1
        granted_at(queues, cycle, START_STREAM, NOTHING)
    else:
        push(queues, TRANSFERS, (cycle, step, NOTHING, step))
        granted_at(queues, cycle, START_TRANSFERS, NOTHING)


@inlined
def finish(graph: Graph, queues: Queues, state: State, step: int, cycle: int) -> None:
    """A step is done: some that wait for it may be ready."""
    state.end[step] = cycle
    for place in range(graph.next_begin[step], graph.next_begin[step + 1]):
        follower = graph.next_items[place]
        state.left[follower] -= 1
        if state.left[follower] == 0:
            make_ready(graph, queues, state, follower, cycle)


@inlined
def start_stream(graph: Graph, queues: Queues, state: State, machine: Machine, cycle: int) -> None:
    """Load the earliest of the programs that may be loaded."""
    if state.is_loading[0]:
        return
    for step in graph.configurations:
        if state.is_waiting[step] and _may_load(graph, state, machine, step):
            state.is_waiting[step] = 0
            state.is_loading[0] = 1
            state.start[step] = cycle
            at(queues, cycle + graph.cycles[step], CONFIGURED, step)
            return


@inlined
def _may_load(graph: Graph, state: State, machine: Machine, step: int) -> bool:
    """Whether each of its tiles has a memory for it: with two of them, if the program before has
    started there, else if it has run for the last time.
    """
    for place in range(graph.taken_begin[step], graph.taken_begin[step + 1]):
        held = graph.taken_items[place]
        is_replaceable = machine.double_buffered and state.is_started[held]
        if state.runs_left[held] > 0 and not is_replaceable:
            return False
    return True


@inlined
def end_configuration(queues: Queues, state: State, cycle: int) -> None:
    """A program is loaded, and the stream is free."""
    state.is_loading[0] = 0
    granted_at(queues, cycle, START_STREAM, NOTHING)


@inlined
def _start_run(graph: Graph, queues: Queues, state: State, step: int, cycle: int) -> None:
    tile = graph.tile_items[graph.tile_begin[step]]
    _charge_wait(graph, state, step, tile, cycle)
    state.start[step] = cycle
    state.running[tile] = step
    state.stalls[tile, LAUNCH] += graph.launch_words[step]
    state.issue_from[tile] = cycle + graph.launch_words[step]
    state.is_started[graph.held[step]] = 1
    granted_at(queues, cycle, START_STREAM, NOTHING)
    _stop_at(queues, state, tile, state.issue_from[tile] + graph.cycles[step])


@inlined
def _charge_wait(graph: Graph, state: State, step: int, tile: int, cycle: int) -> None:
    """Charge the whole wait to whatever ended last."""
    wait = cycle - state.free_from[tile]
    if wait <= 0:
        return
    last = NOTHING
    for place in range(graph.wait_begin[step], graph.wait_begin[step + 1]):
        other = graph.wait_items[place]
        if last == NOTHING or state.end[other] >= state.end[last]:  # they are in ascending order
            last = other
    cause = DMA_WAIT
    if graph.kind[last] == CONFIGURE:
        cause = CONFIGURATION_WAIT
    elif graph.kind[last] == RUN:
        cause = DEPENDENCY_WAIT
    state.stalls[tile, cause] += wait


@inlined
def _stop_at(queues: Queues, state: State, tile: int, cycle: int) -> None:
    """A tile's run will end in a cycle; what was said before does not count any more."""
    state.stop[tile] = cycle
    state.version[tile] += 1
    at(queues, cycle, END_RUN, state.version[tile] * len(state.stop) + tile)


@inlined
def take_banks(queues: Queues, state: State, tile: int, cycles: int, cycle: int) -> None:
    """Give DMA the banks of a tile for some cycles, in which a program that runs there stalls."""
    is_running = state.running[tile] != NOTHING
    if is_running and state.issue_from[tile] <= cycle < state.stop[tile]:
        state.stalls[tile, BANKS_TAKEN] += cycles
        _stop_at(queues, state, tile, state.stop[tile] + cycles)


@inlined
def end_run(graph: Graph, queues: Queues, state: State, item: int, cycle: int) -> int:
    """End a run; return `NOTHING` if it stalled meanwhile and so ends later."""
    tile, version = item % len(state.stop), item // len(state.stop)
    step = state.running[tile]
    if version != state.version[tile] or step == NOTHING:
        return NOTHING
    state.running[tile] = NOTHING
    state.free_from[tile] = cycle
    state.runs_left[graph.held[step]] -= 1
    granted_at(queues, cycle, START_STREAM, NOTHING)
    return int(step)
