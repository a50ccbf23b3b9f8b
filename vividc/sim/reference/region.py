"""One run of one region on the reference engine: from cycle to cycle."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from itertools import cycle
from typing import Final

from vividc.errors import SimulationError
from vividc.machine.words import WORD_MASK
from vividc.program import RegionRow
from vividc.sim.engine import Activity
from vividc.sim.reference.cycle import ENDLESS, Cycle
from vividc.sim.reference.predecode import RegionCode, Slot
from vividc.sim.reference.tile import Tile

_PROGRESS_EVERY: Final = 1 << 13


def iterations(row: RegionRow, trip: int) -> int:
    """Iterations to issue if no exit node stops the region."""
    if row.kind == "straight":
        return 1
    return max(trip, 0) if row.counted else ENDLESS


class RegionState(Cycle):
    """A region under way. Cycles count from its start, without stalls: a stall freezes all.

    Parameters
    ----------
    limit
        Iterations to issue, unless an exit node stops them.
    before
        The region that is still under way when this one begins: a loop whose last iterations are
        among the region's words, or the straight region whose words a loop's first ones are among.
    ended
        Told of that loop when it has ended.
    regions
        All of the program, of which one may begin before this one has ended; none: none does.
    """

    def __init__(
        self,
        tile: Tile,
        region: RegionCode,
        limit: int,
        before: RegionState | None = None,
        ended: Callable[[RegionState], None] = lambda _: None,
        regions: Sequence[RegionCode] = (),
    ) -> None:
        super().__init__(tile, region, limit, before)
        row = None if before is None else before.region.row
        self._shared = 0 if row is None else row.drain or row.fill
        self._drained = before
        self._looked_at = (0, 0)  # cycle and stalls where the contexts began anew
        self._ended, self._regions = ended, regions
        self._rest = deque(() if before is None else before.region.rest)
        self._trip = limit
        self._exited_at = 0
        self._end = ENDLESS
        self._set_end()
        self.behind: RegionState | None = None  # a loop that has begun

    @property
    def region(self) -> RegionCode:
        """What runs."""
        return self._region

    @property
    def iterations(self) -> int:
        """Live iterations of the finished run."""
        return self._limit

    @property
    def is_left(self) -> bool:
        """Whether it has ended early: the region behind it does what is left."""
        return bool(self._region.rest) and self._limit > 0

    @property
    def begins_next(self) -> bool:
        """Whether the loop behind it begins while it ends, known once that would be."""
        ahead, row = self._region.ahead, self._region.row
        if ahead is None or self._tile.trip < ahead.least:
            return False
        return (row.branch if self.branch else row.next) == ahead.loop

    @property
    def cycles(self) -> int:
        """Cycles of the finished run, without those in which the region before was under way."""
        return self.cycle + self.stalls - self._shared

    def activity(self) -> Activity:
        """Words moved; operands' reads are counted elsewhere."""
        return Activity(**self._counted)

    def issues_of(self, time: int) -> int:
        """Times an operation placed at `time` has issued: in live iterations and in killed ones."""
        if self._exited < 0:
            return self._limit
        ii = self._region.row.ii
        before_exit = -(-(self._exited_at - time) // ii)
        return max(self._limit, min(before_exit, self._trip))

    def run(self) -> None:
        """Run to the end, or to where the region behind it begins, and set the tile's time."""
        tile = self._tile
        reported = 0
        if 0 < self._end <= self.cycle and not (self.is_left and self.cycle % self._region.row.ii):
            tile.check_limit(self._region.index, self.now)
        while self.cycle < self._end:
            self._contexts()
            if not (self.is_left and self.cycle % self._region.row.ii):
                tile.check_limit(self._region.index, self.now)
            if tile.progress is not None and self.cycle - reported >= _PROGRESS_EVERY:
                reported = self.cycle
                tile.progress(self.now)
        while self._exits:
            self._resolve()
        self._resolved = self._limit
        self._settle_misses()
        if self.behind is not None:
            self._hand_over(self.behind)
        tile.cycle = self.now

    def _set_end(self) -> None:
        row = self._region.row
        if self._limit == 0:
            self._end = 0
        elif self._limit < ENDLESS:
            self._end = (self._limit - 1) * row.ii + row.span - row.drain

    def _contexts(self) -> None:
        """Walk through the region's contexts, to the last one."""
        region = self._region
        newest, first = divmod(self.cycle, region.row.ii)
        self._count(region.counters, newest)
        if self._rest and self._drained is not None:
            self._drained.count_from_end()
        for slot in region.slots[first:]:
            if self._exits and self._exits[0][0] == self.cycle:
                self._resolve()
            if self.cycle >= self._end:
                return
            if self._rest:
                self._cycle_of_drain(slot)
            elif self._is_filling():
                self._cycle_of_fill(slot)
            else:
                self._cycle(slot, newest)
            self.cycle += 1

    def _count(self, counters: tuple[tuple[int, int], ...], newest: int) -> None:
        for cell, stage in counters:
            self._state[cell] = newest - stage & WORD_MASK

    # --- a loop's end ---

    def count_from_end(self) -> None:
        """What is left of a loop has its iterations counted from the end."""
        self._count(self._region.rest_counters, self._limit)

    def finish(self) -> None:
        """Do what is left of a loop, with nothing beside it."""
        self.count_from_end()
        rest = deque(self._region.rest)
        while rest:
            self._cycle(rest.popleft(), self._limit)
            self._step(is_last=not rest)
        self._tile.cycle = self.now

    def _step(self, *, is_last: bool) -> None:
        """A cycle of what is left of a loop is over: its time is looked at as if it ran alone."""
        self.cycle += 1
        if is_last or self.cycle % self._region.row.ii == 0:
            self._tile.check_limit(self._region.index, self.now)

    def _cycle_of_drain(self, slot: Slot) -> None:
        """A cycle in which the loop before is still under way."""
        before = self._drained
        assert before is not None
        left = self._rest.popleft()

        def finish_before() -> None:
            before._end_cycle(left, before.iterations)
            self._end_step(before)
            while self._rest:
                before._cycle(self._rest.popleft(), before.iterations)
                self._end_step(before)

        self._both((before, left, before.iterations), (self, slot, 0), finish_before)
        self._end_step(before)

    def _end_step(self, before: RegionState) -> None:
        before._step(is_last=not self._rest)
        if not self._rest:
            self._ended(before)
            self.go_on_alone()
            self._drained = None

    # --- a loop's begin ---

    def _is_filling(self) -> bool:
        """Whether the loop behind it has begun, which it does now if it may."""
        ahead, row = self._region.ahead, self._region.row
        if ahead is None or not self._regions:
            return False
        if self.cycle == row.ii - row.fill and self.begins_next:
            code, regions = self._regions[ahead.loop], self._regions
            limit = iterations(code.row, self._tile.trip)
            self.behind = RegionState(self._tile, code, limit, self, self._ended, regions)
            self._count(ahead.counters, row.stages - 1)
        return self.behind is not None

    def _cycle_of_fill(self, slot: Slot) -> None:
        """A cycle in which the loop behind has begun."""
        behind, region = self.behind, self._region
        assert behind is not None
        assert region.ahead is not None
        ahead, newest = region.ahead.slots[behind.cycle], region.row.stages - 1

        def finish_self() -> None:
            self._end_cycle(slot, 0)
            self.cycle += 1
            for left in region.slots[self.cycle :]:
                self._cycle(left, 0)
                self.cycle += 1
            self._tile.check_limit(region.index, self.now)
            behind._check_limit_then()

        self._both((self, slot, 0), (behind, ahead, newest), finish_self)
        behind.cycle += 1
        if behind.cycle % behind.region.row.ii == 0:
            behind._looked_at = behind.cycle, behind.stalls

    def _check_limit_then(self) -> None:
        """The limit where the contexts last began anew, which was in the region before."""
        cycle, stalls = self._looked_at
        if cycle:
            now = self.now - (self.cycle - cycle) - (self.stalls - stalls)
            self._tile.check_limit(self._region.index, now)

    def _hand_over(self, behind: RegionState) -> None:
        """Of links, registers and output registers, the loop behind finds what it put there. What
        it alone would have passed on of no iteration since has not come to a register here.
        """
        ahead, cells = self._region.ahead, self._tile.cells
        assert ahead is not None
        kept = {cells.out_base + pe for pe, _ in behind._outputs}
        for slot, whole in zip(ahead.slots, cycle(behind.region.slots), strict=False):
            kept.difference_update(whole.writes.targets, whole.writes_from_registers.targets)
            kept.update(slot.writes.targets, slot.writes_from_registers.targets)
        kept.update(ahead.slots[-1].links.targets, ahead.slots[-1].links_from_registers.targets)
        for cell in set(range(cells.volatile)) - kept:
            self._state[cell] = None
        behind._check_limit_then()
        behind.go_on_alone()
        behind._drained = None

    # --- a cycle ---

    def _resolve(self) -> None:
        """An exit node's result acts: later iterations are dead from now on, or it goes on."""
        _, iteration, ends = self._exits.popleft()
        if iteration >= self._limit:
            return
        self._resolved = iteration
        if ends:
            self._limit = iteration + 1
            self._exited = iteration
            self._exited_at = self.cycle
            self._set_end()
        if self._misses:
            self._settle_misses()

    def _look(self, slot: Slot, newest: int, now: int) -> None:
        assert self._tile.watch is not None
        self._tile.watch.see(now, self._region, slot, newest, self._limit, self._state)

    def _cycle(self, slot: Slot, newest: int) -> None:
        if self._tile.watch is not None:
            self._look(slot, newest, self.now)
        self._work(slot, newest)
        self._end_cycle(slot, newest)

    def _end_cycle(self, slot: Slot, newest: int) -> None:
        done = self._completions()
        moved = self._moved(slot, newest)
        self._fade(slot)
        self._write(slot, moved)
        self._clear_outputs()
        self._set_outputs(done)

    def _both(
        self,
        first: tuple[RegionState, Slot, int],
        second: tuple[RegionState, Slot, int],
        finish_first: Callable[[], None],
    ) -> None:
        """A cycle in which two are under way: each step of it for both.

        `finish_first`: the first goes on to its end, as its fault comes first if it has one, when
        the second has failed. That fails again, by the same words, at the time that it is by then.
        """
        pairs = (first, second)
        if self._tile.watch is not None:
            now = max(one.now for one, *_ in pairs)
            for one, slot, newest in pairs if second[0] is self else pairs[::-1]:
                one._look(slot, newest, now)
        one, slot, newest = first
        one._work(slot, newest)
        one, slot, newest = second
        try:
            one._work(slot, newest)
        except SimulationError:
            words = self._state[: self._tile.cells.volatile]
            finish_first()
            self._state[: self._tile.cells.volatile] = words
            one._work(slot, newest)
            raise
        done = [one._completions() for one, *_ in pairs]
        moved = [one._moved(slot, newest) for one, slot, newest in pairs]
        for one, slot, _ in pairs:
            one._fade(slot)
        for (one, slot, _), words_of in zip(pairs, moved, strict=True):
            one._write(slot, words_of)
        for one, *_ in pairs:
            one._clear_outputs()
        for (one, *_), results in zip(pairs, done, strict=True):
            one._set_outputs(results)
