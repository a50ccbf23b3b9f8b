"""When each part of a systolic array works: a modulo schedule in closed form.

One iteration of the loop is one block of C. Each PE accumulates its element in a chain of FMAs,
each as long after the one before as an FMA takes; the chains of several blocks interleave, so that
the PE issues an FMA in almost every cycle. What the chain of one block leaves open is filled by the
blocks after it, so that no block waits for another to fill or drain the array. A slot is a cycle
modulo the II.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate, pairwise, permutations
from typing import Final, NamedTuple

from vividc.gemm.systolic.array import SystolicArray
from vividc.gemm.systolic.precision import PRODUCTS, Form, lanes
from vividc.machine.opcodes import OPCODES, LatencyClass, Opcode

_FOUR: Final = 4
"""Results of a word that has passed two drains more when it is stored."""
_PASSED: Final = 2
"""The column whose drain such words pass first."""


_BLOCKS: Final = 48
"""Of a launch: a drain that loads where B lies saves a cycle a block, and the first one begins so
much earlier (64 words a block: 61 cycles; the renderers' products have 40 or fewer).
"""


class Homes(NamedTuple):
    """Which PEs do what several could."""

    drain_b: bool = False
    """The drain loads where a block of B lies and sends it north, where all slots are taken."""
    north_c: bool = False
    """The PE in the north loads where a block of C lies for its drain, which has no slot."""
    early: bool = False
    """PEs that multiply take max(x, 0) of their sums, and words of four are packed on the third
    drain: each link carries one word of a row. Else drains take it, of words of four the third as
    they pass from the last one to the first, and a link carries two.
    """


_HOMES: Final = (
    Homes(),
    Homes(drain_b=True),
    Homes(early=True),
    Homes(north_c=True),
    Homes(north_c=True, early=True),
)
"""The first one that is possible is taken."""


def least_ii(array: SystolicArray, form: Form) -> int:
    """Least II of a block of a product, in which its PEs have slots for all that they do."""
    ii = max(form.depth + 1, array.rows, array.cols)
    while homes(array, form, ii) is None:
        ii += 1
    return ii


def chosen_ii(array: SystolicArray, form: Form, contexts: int) -> int:
    """The II at which `_BLOCKS` blocks take the fewest cycles: the least one, or the next if there
    are so many contexts.
    """
    least = least_ii(array, form)
    if least >= contexts:
        return least
    iis = [ii for ii in (least, least + 1) if homes(array, form, ii) is not None]
    return min(iis, key=lambda ii: SystolicSchedule(array, form, ii).span + _BLOCKS * ii)


def homes(array: SystolicArray, form: Form, ii: int) -> Homes | None:
    """Which PEs do what at an II; None: their slots do not suffice."""
    some = _HOMES[:1] if form.added else _HOMES
    return next((one for one in some if _fits(array, form, ii, one)), None)


def _fits(array: SystolicArray, form: Form, ii: int, some: Homes) -> bool:
    # A PE in the north loads the words of B and the bias, or if sums are added to a matrix one of
    # each of its rows and their place.
    words = form.depth + (array.rows + 1 if form.added else 1)
    count = lanes(form.results)
    if words + (not some.drain_b) + some.north_c > ii:
        return False
    if count == _FOUR and not some.early and ii < 2 * array.rows:
        return False
    if some.early and form.relu and turns(array, form, ii) is None:
        return False
    free = [drain_slots(array, ii, drain_ops(array, form, some, lane)) for lane in range(count)]
    if None in free or not (free[0] or some.north_c):
        return False
    return not some.drain_b or drain_leads(array, form, ii) is not None


def drain_leads(array: SystolicArray, form: Form, ii: int) -> tuple[int, ...] | None:
    """Cycles from a drain's load of a place to the load of the first word in the north, by column
    of a word: the places of a block lie in one bank, so that no two columns load in one cycle.
    None: no such slots are free.
    """
    fma = array.latency(OPCODES[PRODUCTS[form.precision]].latency_class)
    load, convert = array.latency(LatencyClass.LOAD), array.latency(LatencyClass.CONVERT)
    steps = steps_of(fma, form.depth, ii)
    # From the first result of a column to what its drain first does.
    waits = {
        1: (0,),
        2: (1 + convert, 0),
        4: (4 + 2 * convert, 0, 2 * convert, convert - 1),
    }[lanes(form.results)]
    least = ii - steps[form.depth] % ii + load
    earliest: list[dict[int, int]] = []
    for lane, wait in enumerate(waits):
        free = drain_slots(array, ii, drain_ops(array, form, Homes(drain_b=True), lane)) or ()
        since = steps[form.depth - 1] + fma + wait + load + 1
        slots = free[1:] if lane == 0 else free
        leads = [n for n in range(least, least + ii) if (-n - since) % ii in slots]
        # Of each of the cycles in which a word's columns can load in turn.
        earliest.append({(lane - n) % len(waits): n for n in reversed(leads)})
    found = [
        tuple(leads[cycle] for leads, cycle in zip(earliest, cycles, strict=True))
        for cycles in permutations(range(len(waits)))
        if all(cycle in leads for leads, cycle in zip(earliest, cycles, strict=True))
    ]
    return min(found, key=max, default=None)


def turns(array: SystolicArray, form: Form, ii: int) -> Turns | None:
    """When a PE that multiplies takes max(x, 0), too; None: its slots or registers do not suffice.

    At most one operation of a PE completes in a cycle. So the sum's FMAs leave two slots: the one
    of the comparison, and that of an FMA which would complete with it.
    """
    fma = array.latency(OPCODES[PRODUCTS[form.precision]].latency_class)
    registers = array.fabric.pes[array.multiplier(0, 0)].registers
    compare = array.latency(LatencyClass.COMPARE)
    if not array.compares:
        return None
    found: list[Turns] = []
    for slot in range(ii):
        left = {slot, (slot + compare - fma) % ii}
        if 0 in left:  # the first FMA's
            continue
        if form.depth + len(left) > ii:
            return None
        steps = steps_of(fma, form.depth, ii, left)
        ready = steps[form.depth - 1] + fma
        if waits_of(steps, fma)[form.depth] < registers - 1:
            found.append(Turns(steps, ready + (slot - ready) % ii))
    return min(found, key=lambda made: made.compare, default=None)


class Turns(NamedTuple):
    """Cycles of a PE that multiplies, from its first FMA of a block on."""

    steps: tuple[int, ...]
    """Of FMA k, and of slots that no FMA has."""
    compare: int
    """Of max(x, 0)."""


def steps_of(fma: int, depth: int, ii: int, left: Collection[int] = ()) -> tuple[int, ...]:
    """Cycles of FMAs: the least that give each a slot of its own, an FMA's latency or more apart;
    of the `depth` first not those that are `left`. As many as the II has slots.
    """
    steps, used = [0], {0}
    while len(steps) < ii:
        time = steps[-1] + fma
        while time % ii in used or (len(steps) < depth and time % ii in left):
            time += 1
        steps.append(time)
        used.add(time % ii)
    return tuple(steps)


def waits_of(steps: Sequence[int], fma: int) -> tuple[int, ...]:
    """How often a sum has waited longer than an FMA takes, up to each FMA."""
    return (0, *accumulate(after - before > fma for before, after in pairwise(steps)))


def drain_ops(array: SystolicArray, form: Form, some: Homes, lane: int) -> tuple[int, ...]:
    """Latencies of what the drain of a column does with a row's result, cycle by cycle.

    The first of a word's columns stores, the second packs, the last or the third packs what makes
    words of four.
    """
    compare, convert = array.latency(LatencyClass.COMPARE), array.latency(LatencyClass.CONVERT)
    store, four = array.latency(LatencyClass.STORE), lanes(form.results) == _FOUR
    late = form.relu and not some.early
    if lane == 0:
        return (compare, store) if late and not four else (store,)
    if lane == 1:
        return (convert,)
    if some.early:
        return (convert,) if lane == _PASSED else ()
    if lane == _PASSED:
        return (compare,) if late else ()
    return (convert,)


def drain_slots(array: SystolicArray, ii: int, ops: tuple[int, ...]) -> tuple[int, ...] | None:
    """Slots, counted from the first result's, in which a drain can load places, the last one first.

    Results of a column come 2 cycles apart: one for the skew of the rows, one for the link more.
    None: results of two blocks meet.
    """
    times = [(2 * i + n, latency) for i in range(array.rows) for n, latency in enumerate(ops)]
    issued = {time % ii for time, _ in times}
    completed = {(time + latency - 1) % ii for time, latency in times}
    if min(len(issued), len(completed)) < len(times):
        return None
    done = array.latency(LatencyClass.LOAD) - 1
    return tuple(
        slot
        for slot in range(ii - 1, -1, -1)
        if slot not in issued and (slot + done) % ii not in completed
    )


@dataclass(frozen=True)
class SystolicSchedule:
    """Issue cycles of one block; `i` is a row, `j` a column, `k` an inner index."""

    array: SystolicArray
    form: Form
    ii: int

    @property
    def depth(self) -> int:
        """Inner indices, in words."""
        return self.form.depth

    @property
    def op(self) -> Opcode:
        """What adds a word's products to a sum."""
        return PRODUCTS[self.form.precision]

    @cached_property
    def lanes(self) -> int:
        """Results to a word: 1, 2 or 4, of neighbouring columns."""
        return lanes(self.form.results)

    @cached_property
    def homes(self) -> Homes:
        """Which PEs do what."""
        found = homes(self.array, self.form, self.ii)
        assert found is not None
        return found

    @cached_property
    def product_latency(self) -> int:
        """Cycles of what adds to a sum."""
        return self.array.latency(OPCODES[self.op].latency_class)

    @cached_property
    def _turns(self) -> Turns:
        if self.compares:
            found = turns(self.array, self.form, self.ii)
            assert found is not None
            return found
        return Turns(steps_of(self.product_latency, self.depth, self.ii), 0)

    @property
    def compares(self) -> bool:
        """Whether PEs that multiply take max(x, 0)."""
        return self.form.relu and self.homes.early

    @property
    def late(self) -> bool:
        """Whether drains take max(x, 0)."""
        return self.form.relu and not self.homes.early

    def step(self, k: int) -> int:
        """Cycles from a PE's first FMA of a block to its FMA k; those of `depth` and more are slots
        that no FMA has.
        """
        return self._turns.steps[k]

    @cached_property
    def waits(self) -> tuple[int, ...]:
        """How often the sum has waited longer than an FMA takes, up to each FMA."""
        return waits_of(self._turns.steps, self.product_latency)

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
        return self.load_b(j, 0) - self._place_b_leads[j % self.lanes]

    def place_c(self, j: int) -> int:
        """As `place_a`, before the first result is stored."""
        before = self.store(0, j) - self._load
        if self.homes.north_c:
            return self._latest(before, self.load_b(j, 0) + self.step(self.depth + 2))
        free = drain_slots(self.array, self.ii, drain_ops(self.array, self.form, self.homes, 0))
        assert free is not None
        return self._latest(before, self.leave(0, j) + free[0])

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
        if self.compares:
            return self.compare(i, j) + self.array.latency(LatencyClass.COMPARE)
        return self.multiply(i, j, self.depth - 1) + self.product_latency

    def compare(self, i: int, j: int) -> int:
        """The PE that multiplies takes max(x, 0) of its sum."""
        return self.multiply(i, j, 0) + self._turns.compare

    def drain(self, i: int, j: int) -> int:
        """The result is on the link to the drain of column j."""
        return self.result(i, j) + i

    def pack(self, i: int, j: int) -> int:
        """Columns j and j + 1 become a word on the drain of the latter, as both come."""
        return self.drain(i, j) + 1

    def pack_high(self, i: int, j: int) -> int:
        """Columns j + 2 and j + 3 join that word on the last drain, two links east, or on the one
        before, as the last column's result has come there.
        """
        return self.pack(i, j) + self._convert + 1

    def activate(self, i: int, j: int) -> int:
        """max(x, 0) of the word of columns j, ...: of four results, on the third's drain."""
        return self.pack_high(i, j) + self._convert if self.lanes == _FOUR else self.leave(i, j)

    def store(self, i: int, j: int) -> int:
        """The word of columns j, ... is stored."""
        return self.leave(i, j) + (self.late and self.lanes < _FOUR)

    def leave(self, i: int, j: int) -> int:
        """The word of columns j, ... is on drain j; j is a multiple of `lanes`.

        The words of a block's rows are two cycles apart on each drain and each link between drains,
        where what travels either way at other times is an odd number of cycles apart.
        """
        made = {
            1: self.drain(i, j),
            2: self.pack(i, j) + self._convert,
            4: self.pack_high(i, j) + self._convert + (1 if self.homes.early else 2),
        }
        return made[self.lanes]

    @cached_property
    def span(self) -> int:
        """Cycles from a block's first load to its last store."""
        return self.store(self.array.rows - 1, self.array.cols - self.lanes) + 1

    @cached_property
    def _convert(self) -> int:
        return self.array.latency(LatencyClass.CONVERT)

    @cached_property
    def _load(self) -> int:
        return self.array.latency(LatencyClass.LOAD)

    def _latest(self, time: int, slot: int) -> int:
        """The latest cycle up to `time` in a slot."""
        return time - (time - slot) % self.ii

    @cached_property
    def _place_b_leads(self) -> tuple[int, ...]:
        """Cycles from the load of a place to that of the first word, by column of a word."""
        if not self.homes.drain_b:
            return (self._place_lead,) * self.lanes
        found = drain_leads(self.array, self.form, self.ii)
        assert found is not None
        return found

    def _lead(self, i: int) -> int:
        first = self.depth + (not self.homes.drain_b)
        return self.ii - self.step(first + (i if self.form.added else 0)) % self.ii

    @cached_property
    def _longest_lead(self) -> int:
        return max(map(self._lead, range(self.array.rows)))

    @cached_property
    def _place_lead(self) -> int:
        latest = (0 if self.form.added else -self._longest_lead) - self._load
        return (latest - self.step(self.depth)) % self.ii - latest

    @cached_property
    def _start_lead(self) -> int:
        latest = -self._longest_lead - self._load
        return (latest - self.step(self.depth + 1 + self.array.rows)) % self.ii - latest

    @cached_property
    def _origin(self) -> int:
        """PE (0, 0)'s first FMA: early enough that nothing is issued before cycle 0."""
        lead = max(
            self._place_lead,
            self._start_lead if self.form.added else 0,
            *self._place_b_leads,
        )
        fed = self._load + 1 + lead
        drained = self.ii + self._load - self.step(self.depth - 1)
        return max(fed, drained)
