"""When a systolic array does what: a modulo schedule in closed form.

One iteration of the loop is one block of C. Each PE accumulates its element in a chain of FMAs, each
as long after the one before as an FMA takes; the chains of several blocks interleave, so that the PE
issues an FMA in every cycle. What the chain of one block leaves open is filled by the blocks after
it, so that no block waits for another to fill or drain the array.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import gcd

from vividc.dfg.opcodes import LatencyClass
from vividc.mapper.systolic.array import SystolicArray


def least_ii(depth: int, rows: int, *, activated: bool) -> int:
    """Least II of a block of `rows` rows with inner dimension `depth`.

    A PE issues `depth` FMAs a block. A column's results leave through one PE, 2 cycles apart (one
    for the skew of the rows, one for the link more): in different slots if the II is odd and at
    least `rows`, or even and at least 2 `rows`. With an activation that PE does two things for each
    result, in a row.
    """
    if activated:
        return max(depth, 2 * rows)
    ii = max(depth, rows)
    return ii + 1 if ii % 2 == 0 and ii < 2 * rows else ii


@dataclass(frozen=True)
class SystolicSchedule:
    """Issue cycles of one block; `i` is a row, `j` a column, `k` an index of the inner dimension."""

    array: SystolicArray
    depth: int
    ii: int

    def step(self, k: int) -> int:
        """Cycles from a PE's first FMA of a block to its FMA k: the least that give each k a slot
        of its own, an FMA's latency or one cycle more apart.
        """
        return self.array.latency(LatencyClass.FMA) * k + self.turn(k)

    def turn(self, k: int) -> int:
        """How often the steps of an FMA's latency have come round to a slot in use before FMA k."""
        return k // (self.ii // gcd(self.array.latency(LatencyClass.FMA), self.ii))

    def multiply(self, i: int, j: int, k: int) -> int:
        """A(i, k) and B(k, j) are on the PE's incoming links in this cycle."""
        return self.array.latency(LatencyClass.LOAD) + 1 + i + j + self.step(k)

    def load_a(self, i: int, k: int) -> int:
        """The word is on the link to column 0 when its load completes."""
        return self.multiply(i, 0, k) - self.array.latency(LatencyClass.LOAD)

    def load_b(self, j: int, k: int) -> int:
        """As `load_a`, with the row of drains on the way."""
        return self.multiply(0, j, k) - self.array.latency(LatencyClass.LOAD) - 1

    def result(self, i: int, j: int) -> int:
        """The result is in the output register, and on the link to the north."""
        fma = self.array.latency(LatencyClass.FMA)
        return self.multiply(i, j, self.depth - 1) + fma

    def drain(self, i: int, j: int) -> int:
        """The result is on the link to the drain of column j."""
        return self.result(i, j) + i
