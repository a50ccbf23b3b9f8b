"""One run of one region on the reference engine: the cycle."""

from __future__ import annotations

import sys
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal, Protocol

from vividc.errors import CycleLimit, SimulationError
from vividc.machine.words import WORD_BYTES, WORD_MASK, loaded, stored
from vividc.program import Program, Use, trapped
from vividc.sim.engine import Activity, Progress
from vividc.sim.reference.predecode import LiveOut, Moves, Op, RegionCode, Slot, State, StateMap

_ENDLESS: Final = sys.maxsize
_PROGRESS_EVERY: Final = 1 << 13
_RAISED: Final = "numba raises it, too, for these arguments: check them on the host"
_SIGN_BIT: Final = 0x80000000
_COUNTERS: Final = (
    "link_words",
    "register_reads",
    "register_writes",
    "constant_writes",
    "scratchpad_reads",
    "scratchpad_writes",
)

Completion = tuple[int, int | None]
"""(PE, word of the result); a store completes with no word."""


class Watch(Protocol):
    """Sees every cycle before it happens."""

    def see(
        self, cycle: int, region: RegionCode, slot: Slot, newest: int, limit: int, state: State
    ) -> None:
        """Look at a cycle; nothing may be changed.

        Parameters
        ----------
        cycle
            Since the launch, stalls included.
        newest, limit
            Iteration of stage 0; iterations from `limit` on are dead.
        state
            The words that PEs can read in this cycle (see `predecode.StateMap`).
        """

    def touch(self, words: Sequence[int]) -> None:
        """Look at what the cycle that was seen last accesses: indices of words of the scratchpad,
        one for each access.
        """


@dataclass
class Tile:
    """What outlives a region: words, memory, the trip register, time, and counters of activity."""

    program: Program
    cells: StateMap
    state: State
    memory: list[int]
    cycle_limit: int
    progress: Progress | None
    extents: Mapping[str, tuple[int, int]]
    watch: Watch | None = None
    trip: int = 0
    cycle: int = 0
    entries: int = 0
    link_words: int = 0
    register_reads: int = 0
    register_writes: int = 0
    constant_writes: int = 0
    scratchpad_reads: int = 0
    scratchpad_writes: int = 0

    def take_activity(self) -> Activity:
        """What was counted since the last call; operands' reads are counted elsewhere."""
        counted = Activity(**{name: getattr(self, name) for name in _COUNTERS})
        for name in _COUNTERS:
            setattr(self, name, 0)
        return counted

    def check_limit(self, region: int, cycles: int = 0) -> None:
        """Stop a run whose time, `cycles` of region `region` included, exceeds the limit.

        Regions entered count too, so regions without a cycle cannot go on for ever.
        """
        if self.cycle + cycles <= self.cycle_limit and self.entries <= self.cycle_limit:
            return
        report = self.program.regions[region]
        raise CycleLimit(
            f"{self.program.name} is in region {report.name} after {self.cycle_limit} cycles",
            loc=report.loc,
            hint="raise cycle_limit, or look for a loop that never ends",
        )


class RegionState:
    """A region under way. Cycles count from its start, without stalls: a stall freezes all."""

    def __init__(self, tile: Tile, region: RegionCode, limit: int) -> None:
        self._tile = tile
        self._region = region
        row = region.row
        self._state = tile.state
        self._trip = limit
        self._limit = limit  # iterations from this one on are dead
        self._resolved = -1 if row.has_exit else _ENDLESS  # last iteration known to go on or end
        self._exits: deque[tuple[int, int, bool]] = deque()  # (acts at, iteration, ends the loop)
        self._exited = -1  # the iteration that ended the loop
        self._exited_at = 0
        self._misses: list[tuple[int, bool, SimulationError]] = []  # of loads that may not count
        self._anywhere = (0, WORD_BYTES * len(tile.memory))
        latencies = tile.program.fabric.latencies.values()
        self._ring: list[list[Completion]] = [[] for _ in range(max(latencies))]
        self._outputs: list[Completion] = []  # what is in the output registers in this cycle
        self._completed = [-1] * len(tile.program.fabric.pes)  # cycle of the last completion
        self._end = _ENDLESS
        self._set_end()
        self.branch = False
        self.cycle = 0
        self.stalls = 0

    @property
    def iterations(self) -> int:
        """Live iterations of the finished run."""
        return self._limit

    def issues_of(self, time: int) -> int:
        """Times an operation placed at `time` has issued: in live iterations and in killed ones."""
        if self._exited < 0:
            return self._limit
        ii = self._region.row.ii
        before_exit = -(-(self._exited_at - time) // ii)
        return max(self._limit, min(before_exit, self._trip))

    def run(self) -> None:
        """Run to the end and add the time to the tile's."""
        tile = self._tile
        reported = 0
        while self.cycle < self._end:
            self._contexts()
            tile.check_limit(self._region.index, self.cycle + self.stalls)
            if tile.progress is not None and self.cycle - reported >= _PROGRESS_EVERY:
                reported = self.cycle
                tile.progress(tile.cycle + self.cycle + self.stalls)
        while self._exits:
            self._resolve()
        self._resolved = self._limit
        self._settle_misses()
        tile.cycle += self.cycle + self.stalls

    def _set_end(self) -> None:
        row = self._region.row
        if self._limit == 0:
            self._end = 0
        elif self._limit < _ENDLESS:
            self._end = (self._limit - 1) * row.ii + row.span

    def _contexts(self) -> None:
        """Walk once through the region's contexts: II cycles."""
        region = self._region
        newest = self.cycle // region.row.ii
        for cell, stage in region.counters:
            self._state[cell] = newest - stage & WORD_MASK
        for slot in region.slots:
            if self._exits and self._exits[0][0] == self.cycle:
                self._resolve()
            if self.cycle >= self._end:
                return
            if self._tile.watch is not None:
                self._look(slot, newest)
            self._cycle(slot, newest)
            self.cycle += 1

    def _look(self, slot: Slot, newest: int) -> None:
        tile = self._tile
        assert tile.watch is not None
        now = tile.cycle + self.cycle + self.stalls
        tile.watch.see(now, self._region, slot, newest, self._limit, self._state)

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

    def _settle_misses(self) -> None:
        """Raise the first miss of a load that does count, forget those that do not."""
        open_ones = []
        for iteration, unless_exit, error in self._misses:
            if iteration >= self._limit or (unless_exit and iteration == self._exited):
                continue
            if iteration - (not unless_exit) <= self._resolved:
                raise error
            open_ones.append((iteration, unless_exit, error))
        self._misses = open_ones

    def _cycle(self, slot: Slot, newest: int) -> None:
        if slot.alu:
            self._issue(slot.alu, newest)
        if slot.control:
            self._issue_control(slot.control, newest)
        if slot.loads or slot.stores:
            self._access(slot, newest)
        self._move(slot, newest)

    def _issue(self, ops: tuple[Op, ...], newest: int) -> None:
        state, ring, limit, cycle = self._state, self._ring, self._limit, self.cycle
        size = len(ring)
        for op in ops:
            stage, delay, pe, function, fetch, fetch_first, *_ = op
            iteration = newest - stage
            if not 0 <= iteration < limit:
                continue
            words = fetch(state) if iteration else fetch_first(state)
            if None in words:
                raise self._nothing_read(pe, "issue")
            ring[(cycle + delay) % size].append((pe, function(*words)))

    def _issue_control(self, ops: tuple[Op, ...], newest: int) -> None:
        for op in ops:
            words = self._operands(op, newest)
            if words is not None:
                word = op.function(*words)
                self._complete(op, word)
                self._inform_controller(op, newest, word)

    def _operands(self, op: Op, newest: int) -> tuple[int, ...] | None:
        """Words of a live operation, None if its iteration is not live."""
        iteration = newest - op.stage
        if not 0 <= iteration < self._limit:
            return None
        words = (op.fetch if iteration else op.fetch_first)(self._state)
        if None in words:
            raise self._nothing_read(op.pe, "issue")
        return words  # type: ignore[return-value]  # the line above leaves ints only

    def _complete(self, op: Op, word: int | None) -> None:
        """Let `word` complete after the operation's latency."""
        ring = self._ring
        ring[(self.cycle + op.delay) % len(ring)].append((op.pe, word))

    def _inform_controller(self, op: Op, newest: int, word: int) -> None:
        use = op.issue.use
        if use is Use.EXIT:
            latency = op.delay + 1 + self._tile.program.fabric.controller.control_latency
            self._exits.append((self.cycle + latency, newest - op.stage, word == 1))
        elif use is Use.BRANCH:
            self.branch = word == 1
        else:
            self._tile.trip = word - ((word & _SIGN_BIT) << 1)

    def _access(self, slot: Slot, newest: int) -> None:
        """Loads see the scratchpad as before this cycle; of two stores the higher PE wins."""
        touched = self._load(slot.loads, newest) if slot.loads else []
        written = self._store(slot.stores, newest) if slot.stores else []
        self._tile.scratchpad_reads += len(touched)
        self._tile.scratchpad_writes += len(written)
        memory = self._tile.memory
        for address, word, width in written:
            cell = address // WORD_BYTES
            memory[cell] = stored(memory[cell], word, address, width)
            touched.append(cell)
        if self._tile.watch is not None:
            self._tile.watch.touch(touched)
        if len(touched) > 1:
            self._stall(touched)

    def _load(self, ops: tuple[Op, ...], newest: int) -> list[int]:
        """Issue the loads of a slot; the word addresses they read."""
        state, limit, memory = self._state, self._limit, self._tile.memory
        extents, anywhere = self._tile.extents, self._anywhere
        scratchpad_end = anywhere[1]
        touched = []
        for op in ops:
            iteration = newest - op.stage
            if not 0 <= iteration < limit:
                continue
            words = op.fetch(state) if iteration else op.fetch_first(state)
            if None in words:
                raise self._nothing_read(op.pe, "issue")
            base, index, predicate = words
            issue = op.issue
            word = 0
            if predicate:
                address = base + (index << issue.shift) + issue.offset & WORD_MASK  # type: ignore[operator]
                first, end = extents.get(op.array, anywhere)
                width = issue.width
                if not first <= address <= end - width or address % width:
                    self._miss(op, iteration, address)
                if address < scratchpad_end and not address % width:
                    touched.append(address // WORD_BYTES)
                    word = memory[address // WORD_BYTES]
                    if width < WORD_BYTES:
                        word = loaded(word, address, width, issue.signed)
            self._complete(op, word)
            if issue.use is not Use.NONE:
                self._inform_controller(op, newest, word)
        return touched

    def _store(self, ops: tuple[Op, ...], newest: int) -> list[tuple[int, int, int]]:
        """Issue the stores of a slot; the (byte address, word, width) triples they write, lower PE
        first.
        """
        extents, anywhere = self._tile.extents, self._anywhere
        written = []
        for op in ops:
            words = self._operands(op, newest)
            if words is None:
                continue
            base, index, word, predicate = words
            issue = op.issue
            self._complete(op, None)
            if not predicate or (issue.unless_exit and newest - op.stage == self._exited):
                continue
            address = base + (index << issue.shift) + issue.offset & WORD_MASK
            first, end = extents.get(op.array, anywhere)
            if not first <= address <= end - issue.width or address % issue.width:
                raise self._bad_address(op, address)
            written.append((address, word, issue.width))
        return written

    def _miss(self, op: Op, iteration: int, address: int) -> None:
        """A load outside its array: an error, now or when it turns out to count."""
        error = self._bad_address(op, address)
        if not self._region.row.has_exit:
            raise error
        self._misses.append((iteration, op.issue.unless_exit, error))
        self._settle_misses()

    def _bad_address(self, op: Op, address: int) -> SimulationError:
        exception = trapped(op.array)
        if exception is not None:
            return self._fault(op.pe, "issue", f"the kernel raises {exception}", hint=_RAISED)
        what = "a misaligned" if address % op.issue.width else "an out-of-bounds"
        first, end = self._tile.extents.get(op.array, self._anywhere)
        place = f"the array {op.array}" if op.array in self._tile.extents else "the scratchpad"
        byte = address - first if address - first < _SIGN_BIT else address - first - (1 << 32)
        return self._fault(
            op.pe,
            "issue",
            f"{what} access at byte {byte} of {place}, which has {end - first}",
            hint="an index may leave its array",
        )

    def _stall(self, touched: list[int]) -> None:
        count = self._tile.program.fabric.scratchpad.banks
        banks = [address % count for address in touched]
        self.stalls += max(map(banks.count, banks)) - 1

    def _move(self, slot: Slot, newest: int) -> None:
        """The end of the cycle: read every source first, then write every target."""
        state, tile, cells = self._state, self._tile, self._tile.cells
        ring = self._ring
        place = self.cycle % len(ring)
        done = ring[place]
        ring[place] = []
        res, out = cells.res_base, cells.out_base
        for pe, word in done:
            if self._completed[pe] == self.cycle:
                raise self._fault(pe, None, "two operations complete in one cycle")
            self._completed[pe] = self.cycle
            state[res + pe] = word
        links, links_rf = slot.links.fetch(state), slot.links_from_registers.fetch(state)
        writes, writes_rf = slot.writes.fetch(state), slot.writes_from_registers.fetch(state)
        captured = self._captured(slot.live_outs, newest) if slot.live_outs else ()
        for cell in slot.fades:
            state[cell] = None
        tile.link_words += self._write(slot.links, links)
        tile.register_writes += self._write(slot.writes, writes)
        if links_rf:
            words = self._write(slot.links_from_registers, links_rf)
            tile.link_words += words
            tile.register_reads += words
        if writes_rf:
            words = self._write(slot.writes_from_registers, writes_rf)
            tile.register_writes += words
            tile.register_reads += words
        for target, word in captured:
            state[target] = word
        for pe, _ in self._outputs:
            state[out + pe] = None
        for pe, word in done:
            state[res + pe] = None
            state[out + pe] = word
        self._outputs = done

    def _write(self, moves: Moves, words: tuple[int | None, ...]) -> int:
        """Write the targets; how many of the words are words."""
        state = self._state
        for cell, word in zip(moves.targets, words, strict=True):
            state[cell] = word
        return len(words) - words.count(None)

    def _captured(self, live_outs: tuple[LiveOut, ...], newest: int) -> list[tuple[int, int]]:
        """(constant-store cell, word) of the live-outs that happen in this cycle."""
        captured = []
        for live_out in live_outs:
            iteration = newest - live_out.stage
            if not 0 <= iteration < self._limit:
                continue
            if live_out.unless_exit and iteration == self._exited:
                continue
            word = self._state[live_out.source]
            if word is None:
                raise self._nothing_read(live_out.pe, "live_out")
            captured.append((live_out.target, word))
            self._tile.register_reads += live_out.from_register
        self._tile.constant_writes += len(captured)
        return captured

    def _nothing_read(self, pe: int, role: Literal["issue", "live_out"]) -> SimulationError:
        return self._fault(pe, role, "a live operation reads nothing")

    def _fault(
        self,
        pe: int,
        role: Literal["issue", "live_out"] | None,
        what: str,
        hint: str | None = None,
    ) -> SimulationError:
        program, region = self._tile.program, self._region
        slot = self.cycle % region.row.ii
        row = program.debug_row(region.index, slot, pe, role) if role is not None else None
        op = "" if row is None else f" ({row.op} {row.name}".rstrip() + ")"
        cycle = self._tile.cycle + self.cycle + self.stalls
        name = program.regions[region.index].name
        return SimulationError(
            f"{what}: PE {pe}{op}, region {name}, cycle {cycle}",
            loc=row.loc if row is not None else program.regions[region.index].loc,
            hint=hint,
        )
