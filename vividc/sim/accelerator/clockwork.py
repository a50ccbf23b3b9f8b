"""The events of a simulation in order of time, and resources that serve one at a time."""

from __future__ import annotations

import heapq
from collections.abc import Callable

Action = Callable[[int], None]


class Clock:
    """Calls actions in order of (cycle, rank, order of scheduling).

    All that arrives in a cycle (rank 0) is known before anything is granted in it (rank 1).
    """

    def __init__(self) -> None:
        self._heap: list[tuple[int, int, int, Action]] = []
        self._count = 0

    def at(self, cycle: int, action: Action, rank: int = 0) -> None:
        """Call `action(cycle)` in that cycle."""
        heapq.heappush(self._heap, (cycle, rank, self._count, action))
        self._count += 1

    def run(self) -> None:
        """Until nothing is left to happen."""
        heap, pop = self._heap, heapq.heappop
        while heap:
            cycle, _, _, action = pop(heap)
            action(cycle)


class Server:
    """Serves requests one after another: the one that waits longest, then the one of the lowest
    number.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._waiting: list[tuple[int, int, int, int, Action]] = []
        self._free_from = 0
        self._count = 0
        self._looks_at = -1
        self.busy_cycles = 0

    def request(self, cycle: int, number: int, holds: int, granted: Action) -> None:
        """Ask in `cycle` for `holds` cycles; `granted` is called with the first of them."""
        heapq.heappush(self._waiting, (cycle, number, self._count, holds, granted))
        self._count += 1
        self._look(max(cycle, self._free_from))

    def _look(self, cycle: int) -> None:
        """See who waits in `cycle`, once however many ask for that: it serves one a cycle."""
        if cycle != self._looks_at:
            self._looks_at = cycle
            self._clock.at(cycle, self._grant, rank=1)

    def _grant(self, cycle: int) -> None:
        if cycle == self._looks_at:
            self._looks_at = -1
        if not self._waiting or cycle < self._free_from:
            return
        _, _, _, holds, granted = heapq.heappop(self._waiting)
        self._free_from = cycle + holds
        self.busy_cycles += holds
        if self._waiting:
            self._look(self._free_from)
        granted(cycle)
