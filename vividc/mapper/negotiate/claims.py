"""Who claims which slot of an FU, a constant store, the banks and the controller."""

from __future__ import annotations

from vividc.dfg.opcodes import Opcode
from vividc.mapper.mapping import Place
from vividc.mapper.problem import MapProblem


class Claims:
    """Counts of claims, one number for each slot of each resource of one use a slot."""

    def __init__(self, task: MapProblem, ii: int) -> None:
        self.ii = ii
        grid = ii * len(task.fabric.pes)
        self.completion, self.live_out, self.bank, self.control = (
            grid,
            2 * grid,
            3 * grid,
            3 * grid + ii,
        )
        self.counts = [0] * (3 * grid + 2 * ii)
        self.capacity = [1] * len(self.counts)
        self.capacity[self.bank : self.control] = [task.fabric.scratchpad.banks] * ii
        self.occupants: list[list[int]] = [[] for _ in range(grid)]
        self.is_live_out = {n.id: n.op is Opcode.LIVE_OUT for n in task.dfg.placed}
        self.is_memory = {n.id: n.is_memory for n in task.dfg.placed}
        self.is_control = {n.id: n.control is not None for n in task.dfg.placed}
        self.last = {n.id: task.fabric.latency(n) - 1 for n in task.dfg.placed}

    def of(self, node: int, place: Place) -> list[int]:
        """Numbers of the slots that `node` claims at `place`."""
        ii = self.ii
        row = place.pe * ii
        slot = place.time % ii
        if self.is_live_out[node]:
            return [self.live_out + row + slot]
        done = (place.time + self.last[node]) % ii
        claims = [row + slot, self.completion + row + done]
        if self.is_memory[node]:
            claims.append(self.bank + slot)
        if self.is_control[node]:
            claims.append(self.control + done)
        return claims

    def put(self, node: int, place: Place) -> None:
        """Enter the claims of `node`."""
        claims = self.of(node, place)
        for claim in claims:
            self.counts[claim] += 1
        if claims[0] < self.completion:
            self.occupants[claims[0]].append(node)

    def take(self, node: int, place: Place) -> None:
        """Withdraw the claims of `node`."""
        claims = self.of(node, place)
        for claim in claims:
            self.counts[claim] -= 1
        if claims[0] < self.completion:
            self.occupants[claims[0]].remove(node)

    def excess(self, node: int, place: Place) -> int:
        """Uses beyond capacity of the slots that `node` claims at `place`, as entered."""
        counts, capacity = self.counts, self.capacity
        return sum(
            counts[claim] - capacity[claim]
            for claim in self.of(node, place)
            if counts[claim] > capacity[claim]
        )

    def occupant(self, node: int, place: Place) -> int | None:
        """Another node that issues on the same FU in the same slot."""
        first = self.of(node, place)[0]
        if first >= self.completion:
            return None
        return next((other for other in self.occupants[first] if other != node), None)

    def crowded(self) -> bool:
        """Whether any slot is claimed beyond its capacity."""
        return any(n > limit for n, limit in zip(self.counts, self.capacity, strict=True))
