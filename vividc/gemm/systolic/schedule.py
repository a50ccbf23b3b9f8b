"""When each part of a systolic array works: a modulo schedule in closed form.

One iteration of the loop is one block of C. Each PE accumulates its element in a chain of FMAs,
each as long after the one before as an FMA takes; the chains of several blocks interleave, so that
the PE issues an FMA in almost every cycle. What the chain of one block leaves open is filled by the
blocks after it, so that no block waits for another to fill or drain the array. A slot is a cycle
modulo the II.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import gcd

from vividc.gemm.systolic.array import SystolicArray
from vividc.machine.opcodes import OPCODES, LatencyClass, Opcode


def least_ii(array: SystolicArray, depth: int, *, activated: bool, added: bool = False) -> int:
    """Least II of a block with inner dimension `depth`.

    A PE issues `depth` FMAs a block, and a PE in the north as many loads, one of the bias and one
    of the place where the block's columns of B lie; if sums are added to a matrix (`added`), one of
    each of its rows instead of the bias, and one of their place. The bound of a drain is in
    `drain_slot`.
    """
    ii = max(depth + 1 + (array.rows + 1 if added else 1), array.rows, array.cols)
    while drain_slot(array, ii, activated=activated) is None:
        ii += 1
    return ii


def drain_slot(array: SystolicArray, ii: int, *, activated: bool) -> int | None:
    """Slot, counted from the first result, in which a drain loads the place of the block of C.

    Results of a column come 2 cycles apart: one for the skew of the rows, one for the link more.
    Each is stored at once, or after its activation in the cycle after. None: no slot is free, or
    results of two blocks meet.
    """
    last = 1 if activated else 0
    taken = [(2 * i + n) % ii for i in range(array.rows) for n in range(last + 1)]
    if len(set(taken)) < len(taken):
        return None
    done = array.latency(LatencyClass.LOAD) - 1
    for slot in range(ii - 1, -1, -1):
        if slot not in taken and (slot + done) % ii not in taken:
            return slot
    return None


@dataclass(frozen=True)
class SystolicSchedule:
    """Issue cycles of one block; `i` is a row, `j` a column, `k` an inner index."""

    array: SystolicArray
    depth: int
    ii: int
    activated: bool
    op: Opcode = Opcode.FMA
    lanes: int = 1
    """Results to a word: 1, 2 or 4, of neighbouring columns."""
    added: bool = False
    """Whether sums start from the elements of a matrix, not from a bias."""

    @cached_property
    def product_latency(self) -> int:
        """Cycles of what adds to a sum."""
        return self.array.latency(OPCODES[self.op].latency_class)

    def step(self, k: int) -> int:
        """Cycles from a PE's first FMA of a block to its FMA k: the least that give each k a slot
        of its own, an FMA's latency or one cycle more apart. Those of `depth` and more are slots
        that no FMA has.
        """
        return self.product_latency * k + self.turn(k)

    def turn(self, k: int) -> int:
        """How often the steps of an FMA's latency have come round to a slot in use before FMA k."""
        return k // (self.ii // gcd(self.product_latency, self.ii))

    def multiply(self, i: int, j: int, k: int) -> int:
        """A(i, k) and B(k, j) are on the PE's incoming links in this cycle."""
        return self._origin + i + j + self.step(k)

    def load_a(self, i: int, k: int) -> int:
        """The word is on the link to column 0 when its load completes."""
        return self.multiply(i, 0, k) - self._load

    def load_b(self, j: int, k: int) -> int:
        """As `load_a`, with the row of drains on the way."""
        return self.multiply(0, j, k) - self._load - 1

    def place_a(self, i: int) -> int:
        """The place of the block of A is loaded, before its first word."""
        return self.load_a(i, 0) - self._place_lead

    def place_b(self, j: int) -> int:
        """As `place_a`, before the bias."""
        return self.load_b(j, 0) - self._place_lead

    def place_c(self, j: int) -> int:
        """As `place_a`, before the first result is stored."""
        first = self.leave(0, j)
        slot = drain_slot(self.array, self.ii, activated=self.activated)
        assert slot is not None
        latest = first + self.activated - self._load
        return latest - (latest - first - slot) % self.ii

    def place_start(self, j: int) -> int:
        """As `place_a`, before the first of what the sums of column j start from."""
        return self.load_b(j, 0) - self._start_lead

    def load_start(self, i: int, j: int) -> int:
        """The bias, or what the sum of row i starts from, goes the way of B(0, j) in a slot that B
        leaves free, before it.
        """
        return self.load_b(j, 0) - self._lead(i)

    def result(self, i: int, j: int) -> int:
        """The result is in the output register, and on the link to the north."""
        fma = self.product_latency
        return self.multiply(i, j, self.depth - 1) + fma

    def drain(self, i: int, j: int) -> int:
        """The result is on the link to the drain of column j."""
        return self.result(i, j) + i

    def pack(self, i: int, j: int) -> int:
        """Columns j and j + 1 become a word on the drain of the latter, as both come."""
        return self.drain(i, j) + 1

    def pack_high(self, i: int, j: int) -> int:
        """Columns j + 2 and j + 3 join that word on the last drain, two links east."""
        return self.pack(i, j) + self._convert + 1

    def leave(self, i: int, j: int) -> int:
        """The word of columns j, ... is on drain j; j is a multiple of `lanes`.

        The words of a block's rows are two cycles apart on each drain and each link between drains,
        where what travels either way at other times is an odd number of cycles apart.
        """
        made = {
            1: self.drain(i, j),
            2: self.pack(i, j) + self._convert,
            4: self.pack_high(i, j) + self._convert + 2,
        }
        return made[self.lanes]

    @cached_property
    def span(self) -> int:
        """Cycles from a block's first load to its last store."""
        last = self.leave(self.array.rows - 1, self.array.cols - self.lanes)
        return last + self.activated + 1

    @cached_property
    def _convert(self) -> int:
        return self.array.latency(LatencyClass.CONVERT)

    @cached_property
    def _load(self) -> int:
        return self.array.latency(LatencyClass.LOAD)

    def _lead(self, i: int) -> int:
        return self.ii - self.step(self.depth + 1 + (i if self.added else 0)) % self.ii

    @cached_property
    def _longest_lead(self) -> int:
        return max(map(self._lead, range(self.array.rows)))

    @cached_property
    def _place_lead(self) -> int:
        latest = (0 if self.added else -self._longest_lead) - self._load
        return (latest - self.step(self.depth)) % self.ii - latest

    @cached_property
    def _start_lead(self) -> int:
        latest = -self._longest_lead - self._load
        return (latest - self.step(self.depth + 1 + self.array.rows)) % self.ii - latest

    @cached_property
    def _origin(self) -> int:
        """PE (0, 0)'s first FMA: early enough that nothing is issued before cycle 0."""
        lead = max(self._place_lead, self._start_lead if self.added else 0)
        fed = self._load + 1 + lead
        drained = self.ii + self._load - self.step(self.depth - 1)
        return max(fed, drained)
