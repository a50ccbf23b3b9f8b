"""Links, register files and their ports, slot by slot: who wants them, what one more would pay."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from vividc.arch.fabric import Fabric

_LINK_COST: Final = 1.0
_HOLD_COST: Final = 0.25
_PORT_COST: Final = 0.15
_FIRST_PRESSURE: Final = 0.6
_PRESSURE_GROWTH: Final = 1.2
_MOST_PRESSURE: Final = 40.0
_HISTORY: Final = 0.6

Word = tuple[int, int]
"""(producer, cycle of the producer's iteration)."""


class Market:
    """Resources are numbers: `link`, `file`, `read` and `write` are where each kind begins; each
    has one number for every link or PE and slot.

    A register file counts as a pool; registers are named when all routes are known.

    Attributes
    ----------
    price
        What one more word would pay for each resource.
    """

    def __init__(self, fabric: Fabric, ii: int) -> None:
        self.ii = ii
        pes = len(fabric.pes) * ii
        self.link = 0
        self.file = len(fabric.links) * ii
        self.read = self.file + pes
        self.write = self.read + pes
        self.capacity = [1] * self.file
        self.base = [_LINK_COST] * self.file
        for sizes, cost in (
            ([pe.registers for pe in fabric.pes], _HOLD_COST),
            ([pe.read_ports for pe in fabric.pes], _PORT_COST),
            ([pe.write_ports for pe in fabric.pes], _PORT_COST),
        ):
            self.capacity += [size for size in sizes for _ in range(ii)]
            self.base += [cost] * pes
        self.users: list[set[Word]] = [set() for _ in self.capacity]
        self.history = [1.0] * len(self.capacity)
        self.pressure = _FIRST_PRESSURE
        self.price = list(self.base)

    def enter(self, wants: Iterable[tuple[int, Word]]) -> None:
        """Words take resources."""
        for resource, word in wants:
            self.users[resource].add(word)
            self._reprice(resource)

    def leave(self, wants: Iterable[tuple[int, Word]]) -> None:
        """Words give resources back."""
        for resource, word in wants:
            self.users[resource].discard(word)
            self._reprice(resource)

    def crowded(self) -> list[int]:
        """What more words want than there is of it."""
        return [
            resource
            for resource, words in enumerate(self.users)
            if len(words) > self.capacity[resource]
        ]

    def raise_prices(self, crowded: Iterable[int]) -> None:
        """After a round: what is crowded now stays dear, and crowding costs more."""
        for resource in crowded:
            excess = len(self.users[resource]) - self.capacity[resource]
            self.history[resource] += _HISTORY * excess
        self.pressure = min(self.pressure * _PRESSURE_GROWTH, _MOST_PRESSURE)
        for resource in range(len(self.price)):
            self._reprice(resource)

    def shrink_file(self, pe: int) -> bool:
        """Let the words of a register file do with one register less; False if it has none left."""
        first = self.file + pe * self.ii
        if self.capacity[first] <= 1:
            return False
        for resource in range(first, first + self.ii):
            self.capacity[resource] -= 1
            self._reprice(resource)
        return True

    def _reprice(self, resource: int) -> None:
        over = len(self.users[resource]) + 1 - self.capacity[resource]
        price = self.base[resource] * self.history[resource]
        self.price[resource] = price * (1.0 + self.pressure * over) if over > 0 else price
