"""The configuration stream: one program at a time into the shadow memories of its tiles."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from vividc.arch import Configuration
from vividc.sim.accelerator.steps import Configure, Execute, Step

_Held = tuple[int, int]
"""A configuration step and a tile."""


class Stream:
    """Which program is loaded next (docs/accelerator.md, Configuration).

    A program may be loaded once each of its tiles has a memory for it: with double-buffered
    memories when the program loaded before has started there, else when it has run for the last
    time. Of those that may be loaded the earliest step is.
    """

    def __init__(
        self,
        configuration: Configuration,
        steps: Sequence[Step],
        sharing: Sequence[frozenset[int]] = (),
    ) -> None:
        self._configuration = configuration
        self._ready: set[int] = set()
        self._is_loading = False
        self._started: set[_Held] = set()
        self._runs_left: Counter[_Held] = Counter(
            (step.configured_by, step.tile) for step in steps if isinstance(step, Execute)
        )
        self._replaced = _replaced(steps, sharing)

    def cycles(self, step: Configure) -> int:
        """How long it takes to load."""
        return -(-step.entries // self._configuration.entries_per_cycle)

    def ready(self, number: int) -> None:
        """All that this configuration waits for is done."""
        self._ready.add(number)

    def started(self, step: Execute) -> None:
        """A tile runs the program it was given."""
        self._started.add((step.configured_by, step.tile))

    def ended(self, step: Execute) -> None:
        """A tile has run a program once more."""
        self._runs_left[step.configured_by, step.tile] -= 1

    def loaded(self) -> None:
        """The stream is free."""
        self._is_loading = False

    def take(self) -> int | None:
        """The configuration to load now."""
        if self._is_loading:
            return None
        for number in sorted(self._ready):
            if all(self._is_free(held) for held in self._replaced[number]):
                self._ready.remove(number)
                self._is_loading = True
                return number
        return None

    def _is_free(self, held: _Held) -> bool:
        """Whether the memory that `held` was loaded into may be written, or its twin."""
        if self._runs_left[held] == 0:
            return True
        return self._configuration.double_buffered and held in self._started


def _replaced(steps: Sequence[Step], sharing: Sequence[frozenset[int]]) -> dict[int, list[_Held]]:
    """What each configuration finds in its tiles, in whatever form they were."""
    held: dict[int, int] = {}
    found: dict[int, list[_Held]] = {}
    for number, step in enumerate(steps):
        if isinstance(step, Configure):
            units = set(step.tiles)
            for tile in step.tiles if sharing else ():
                units |= sharing[tile]
            found[number] = [(held[unit], unit) for unit in sorted(units) if unit in held]
            for unit in units:
                held.pop(unit, None)
            held.update(dict.fromkeys(step.tiles, number))
    return found
