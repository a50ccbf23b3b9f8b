"""What a loop takes in its first cycles, and how soon it may begin while a region ends."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG
from vividc.mapper.mapping import Mapping
from vividc.mapper.problem import ConstantKey, Fill, MapProblem, Taken
from vividc.mapper.resources.taken import taken_of, uses_of

_At = tuple[int, ConstantKey]


def fill_of(
    dfg: DFG, fabric: Fabric, mapping: Mapping, cycles: int, begin: int = 0, expected: int = 0
) -> Fill:
    """What a counted loop without an exit takes in its first so many cycles; the others are as of
    `Fill`.
    """

    def first(time: int) -> range:
        return range(begin + time, begin + cycles, mapping.ii)

    read: dict[_At, int] = {}
    written: dict[_At, int] = {}
    for use in uses_of(dfg, fabric, mapping):
        some, at = written if use.writes else read, (use.pe, use.key)
        some[at] = min(some.get(at, use.time), use.time)
    taken = taken_of(dfg, fabric, mapping, first)
    return Fill(
        **vars(taken),
        cycles=cycles,
        entries_read=read,
        entries_written=written,
        begin=begin,
        expected=expected,
    )


def first_begin(fill: Fill, problem: MapProblem, mapping: Mapping, least: int = 0) -> int | None:
    """The first cycle of a scheduled straight region in which the loop behind it may begin; None:
    it has to end first.

    Parameters
    ----------
    problem, mapping
        The region, and its schedule.
    least
        It may not begin before.
    """
    return _Meeting(fill, problem, mapping).first(least)


class _Meeting:
    """A straight region's schedule, and a loop that begins somewhere in it."""

    def __init__(self, fill: Fill, problem: MapProblem, mapping: Mapping) -> None:
        self._fill, self._fabric, self._length = fill, problem.fabric, mapping.ii
        self._own: Taken = taken_of(problem.dfg, problem.fabric, mapping, lambda time: (time,))
        self._least = self._known_from(problem, mapping)
        self._ports_read = _ports(self._own.read)
        self._ports_written = _ports(self._own.written)
        self._last_read = _last(self._own.read)
        self._last_written = _last(self._own.written)
        self._accessed = {cycle for cycle, *_ in fill.accesses}
        kinds = {(array, is_store) for _, array, is_store in self._own.accesses}
        self._met = {one: min(fill.meeting(*one), default=mapping.ii) for one in kinds}
        self._first_written: dict[tuple[int, int], int] = {}
        for pe, register, cycle in sorted(fill.written, key=lambda one: -one[2]):
            self._first_written[pe, register] = cycle

    def first(self, least: int) -> int | None:
        """The first cycle, from `least` on."""
        least = max(least, self._least, self._length - self._fill.cycles)
        begins = range(least, self._length)
        return next(filter(self._is_free, begins), None)

    def _known_from(self, problem: MapProblem, mapping: Mapping) -> int:
        """From when on all is known that the loop must know: whether it runs, how often, and what
        it reads.
        """
        fabric, fill = problem.fabric, self._fill
        least = 0 if problem.drain is None else problem.drain.cycles
        for node in problem.dfg.placed:
            if node.control is not None:
                acts = mapping.places[node.id].time + fabric.latency(node)
                least = max(least, acts + fabric.controller.control_latency)
        never = 1 << 30
        for use in uses_of(problem.dfg, fabric, mapping):
            at, after = (use.pe, use.key), use.time + use.writes
            if use.writes:
                least = max(least, after - fill.entries_read.get(at, never))
            least = max(least, after - fill.entries_written.get(at, never))
        return least

    def _is_free(self, begin: int) -> bool:
        """Whether nothing of the two meets if the loop begins in this cycle."""
        own, fill = self._own, self._fill
        pairs = (
            (own.issued, fill.issued),
            (own.completed, fill.completed),
            (own.shown, fill.shown),
        )
        for taken, others in pairs:
            if any((pe, begin + cycle) in taken for pe, cycle in others):
                return False
        for kind, pe, index, cycle in fill.words:
            if kind == "link" and (kind, pe, index, begin + cycle) in own.words:
                return False
        return self._has_ports(begin) and self._has_registers(begin) and self._has_memory(begin)

    def _has_ports(self, begin: int) -> bool:
        pes = self._fabric.pes
        kinds = (
            (self._fill.read, self._ports_read, [pe.read_ports for pe in pes]),
            (self._fill.written, self._ports_written, [pe.write_ports for pe in pes]),
        )
        return all(
            count + own.get((pe, begin + cycle), 0) <= most[pe]
            for some, own, most in kinds
            for (pe, cycle), count in _ports(some).items()
            if begin + cycle < self._length
        )

    def _has_registers(self, begin: int) -> bool:
        """Of what the loop writes the region is done with."""
        return all(
            self._last_read.get(at, -1) <= begin + cycle
            and self._last_written.get(at, -1) < begin + cycle
            for at, cycle in self._first_written.items()
            if begin + cycle < self._length
        )

    def _has_memory(self, begin: int) -> bool:
        """Nothing is accessed by both in a cycle, nor by the loop before the region is done."""
        return all(
            cycle - begin not in self._accessed and cycle - begin <= self._met[array, is_store]
            for cycle, array, is_store in self._own.accesses
        )


def _ports(some: Iterable[tuple[int, int, int]]) -> Counter[tuple[int, int]]:
    return Counter((pe, cycle) for pe, _, cycle in some)


def _last(some: Iterable[tuple[int, int, int]]) -> dict[tuple[int, int], int]:
    last: dict[tuple[int, int], int] = {}
    for pe, register, cycle in some:
        last[pe, register] = max(last.get((pe, register), -1), cycle)
    return last
