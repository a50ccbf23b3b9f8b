"""The event queue, and servers that take one request at a time; compiled."""

from __future__ import annotations

from vividc.launch.timing.compiled import inlined
from vividc.launch.timing.queues import pop, push
from vividc.launch.timing.state import EVENTS, NOTHING, Queues, State

(
    READY,
    START_TRANSFERS,
    START_STREAM,
    CONFIGURED,
    ASK,
    ARRIVE_AT_NOC,
    ARRIVE_AT_TILE,
    ARRIVE_AT_DRAM,
    WRITTEN,
    END_TRANSFER,
    END_RUN,
    GRANT,
) = range(12)
"""What may happen; the item is a step, a burst, for `GRANT` what serves, and for `END_RUN` tile and
version.
"""


@inlined
def at(queues: Queues, cycle: int, what: int, item: int) -> None:
    """Something arrives in a cycle: what does so in the same cycle comes in order of scheduling."""
    push(queues, EVENTS, (2 * cycle, queues.pushed[EVENTS], what, item))


@inlined
def granted_at(queues: Queues, cycle: int, what: int, item: int) -> None:
    """Something is granted in a cycle, when all that arrives in it is known."""
    push(queues, EVENTS, (2 * cycle + 1, queues.pushed[EVENTS], what, item))


@inlined
def request(
    queues: Queues, state: State, server: int, cycle: int, who: tuple[int, int, int]
) -> None:
    """Ask for channel or NoC: `who` is a transfer's age, for how many cycles, and its burst. The
    oldest transfer is served first.
    """
    age, holds, burst = who
    push(queues, server, (age, queues.pushed[server], holds, burst))
    look(queues, state, server, max(cycle, state.free_at[server]))


@inlined
def look(queues: Queues, state: State, server: int, cycle: int) -> None:
    """Look for a waiting request in `cycle`: once a cycle, however often this is called."""
    if cycle != state.looks_at[server]:
        state.looks_at[server] = cycle
        granted_at(queues, cycle, GRANT, server)


@inlined
def serve(queues: Queues, state: State, server: int, cycle: int) -> int:
    """Return the burst of the oldest transfer that waits; `NOTHING` if the server is busy, or
    nobody waits.
    """
    if cycle == state.looks_at[server]:
        state.looks_at[server] = NOTHING
    if queues.length[server] == 0 or cycle < state.free_at[server]:
        return NOTHING
    _, _, holds, burst = pop(queues, server)
    state.free_at[server] = cycle + holds
    state.busy[server] += holds
    if queues.length[server]:
        look(queues, state, server, state.free_at[server])
    return burst
