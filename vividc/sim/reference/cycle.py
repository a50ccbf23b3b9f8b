"""What a region does in one cycle, on the reference engine."""

from __future__ import annotations

import sys
from collections import Counter, deque
from typing import Final

from vividc.errors import SimulationError
from vividc.machine.words import WORD_BYTES, WORD_MASK, loaded, stored
from vividc.program import Use, trapped
from vividc.sim.reference.predecode import LiveOut, Moves, Op, RegionCode, Slot
from vividc.sim.reference.tile import SIGN_BIT, Moment, Role, Tile

ENDLESS: Final = sys.maxsize
_RAISED: Final = "numba raises it, too, for these arguments: check them on the host"
Completion = tuple[int, int | None]
"""(PE, word of the result); a store completes with no word."""

_Words = tuple[int | None, ...]
_Moved = tuple[_Words, _Words, _Words, _Words, list[tuple[int, int]]]
"""Words for links and registers, each of results and links and then of registers, and live-outs."""


class Cycle:
    """A region in a cycle: what it issues, completes and moves.

    Parameters
    ----------
    limit
        Iterations to issue, unless an exit node stops them.
    before
        The region that is still under way when this one begins: while it stands still, so does
        this one.
    """

    def __init__(self, tile: Tile, region: RegionCode, limit: int, before: Cycle | None) -> None:
        self._tile = tile
        self._region = region
        self.cycle = 0
        self.stalls = 0
        self.branch = False
        self._before: Cycle | None = before
        self._start = tile.cycle if before is None else before.now
        self._held_up = 0 if before is None else before.stalls  # of them, until this one began
        self._counted: Counter[str] = Counter()
        self._state = tile.state
        self._limit = limit  # iterations from this one on are dead
        self._resolved = -1 if region.row.has_exit else ENDLESS  # last iteration known to go on
        self._exits: deque[tuple[int, int, bool]] = deque()  # (acts at, iteration, ends the loop)
        self._exited = -1  # the iteration that ended the loop
        self._misses: list[tuple[int, bool, SimulationError]] = []  # of loads that may not count
        self._anywhere = (0, WORD_BYTES * len(tile.memory))
        latencies = tile.program.fabric.latencies.values()
        self._ring: list[list[Completion]] = [[] for _ in range(max(latencies))]
        self._outputs: list[Completion] = []  # what is in the output registers in this cycle
        self._completed = [-1] * len(tile.program.fabric.pes)  # cycle of the last completion

    @property
    def now(self) -> int:
        """Cycles since the launch, those included in which the region before stood still."""
        stalls = self.stalls
        if self._before is not None:
            stalls += self._before.stalls - self._held_up
        return self._start + self.cycle + stalls

    def go_on_alone(self) -> None:
        """The region before is over: how long it stood still is known."""
        if self._before is not None:
            self._start += self._before.stalls - self._held_up
            self._before = None

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

    def _work(self, slot: Slot, newest: int) -> None:
        if slot.alu:
            self._issue(slot.alu, newest)
        if slot.control:
            self._issue_control(slot.control, newest)
        if slot.loads or slot.stores:
            self._access(slot, newest)

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
            self._tile.trip = word - ((word & SIGN_BIT) << 1)

    def _access(self, slot: Slot, newest: int) -> None:
        """Loads see the scratchpad as before this cycle; of two stores the higher PE wins."""
        touched = self._load(slot.loads, newest) if slot.loads else []
        written = self._store(slot.stores, newest) if slot.stores else []
        self._counted["scratchpad_reads"] += len(touched)
        self._counted["scratchpad_writes"] += len(written)
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
        what = self._tile.bad_address(op, address)
        return self._fault(op.pe, "issue", what, hint="an index may leave its array")

    def _stall(self, touched: list[int]) -> None:
        count = self._tile.program.fabric.scratchpad.banks
        banks = [address % count for address in touched]
        self.stalls += max(map(banks.count, banks)) - 1

    # --- the end of the cycle: every source is read first, then every target is written ---

    def _completions(self) -> list[Completion]:
        ring, place = self._ring, self.cycle % len(self._ring)
        done, ring[place] = ring[place], []
        state, res = self._state, self._tile.cells.res_base
        for pe, word in done:
            if self._completed[pe] == self.cycle:
                raise self._fault(pe, None, "two operations complete in one cycle")
            self._completed[pe] = self.cycle
            state[res + pe] = word
        return done

    def _moved(self, slot: Slot, newest: int) -> _Moved:
        state = self._state
        return (
            slot.links.fetch(state),
            slot.links_from_registers.fetch(state),
            slot.writes.fetch(state),
            slot.writes_from_registers.fetch(state),
            self._captured(slot.live_outs, newest) if slot.live_outs else [],
        )

    def _fade(self, slot: Slot) -> None:
        for cell in slot.fades:
            self._state[cell] = None

    def _write(self, slot: Slot, moved: _Moved) -> None:
        links, links_rf, writes, writes_rf, captured = moved
        counted = self._counted
        counted["link_words"] += self._set(slot.links, links)
        counted["register_writes"] += self._set(slot.writes, writes)
        if links_rf:
            words = self._set(slot.links_from_registers, links_rf)
            counted["link_words"] += words
            counted["register_reads"] += words
        if writes_rf:
            words = self._set(slot.writes_from_registers, writes_rf)
            counted["register_writes"] += words
            counted["register_reads"] += words
        for target, word in captured:
            self._state[target] = word

    def _clear_outputs(self) -> None:
        state, out = self._state, self._tile.cells.out_base
        for pe, _ in self._outputs:
            state[out + pe] = None

    def _set_outputs(self, done: list[Completion]) -> None:
        state, res, out = self._state, self._tile.cells.res_base, self._tile.cells.out_base
        for pe, word in done:
            state[res + pe] = None
            state[out + pe] = word
        self._outputs = done

    def _set(self, moves: Moves, words: tuple[int | None, ...]) -> int:
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
            self._counted["register_reads"] += live_out.from_register
        self._counted["constant_writes"] += len(captured)
        return captured

    def _nothing_read(self, pe: int, role: Role) -> SimulationError:
        return self._fault(pe, role, "a live operation reads nothing")

    def _fault(
        self, pe: int, role: Role | None, what: str, hint: str | None = None
    ) -> SimulationError:
        at = Moment(self._region.index, self.cycle % self._region.row.ii, self.now)
        return self._tile.fault(at, pe, role, what, hint)
