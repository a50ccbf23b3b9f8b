"""Exact allocation of one register file, rotating or not, under a modulo schedule.

A lifetime of a word in a register is an arc of the circle of II slots; arcs in one register may not
overlap. The model counts words per slot only, and circular arcs may need more registers than the
fullest slot has words (Tucker 1975), so the allocation is a search of its own. It is monotone:
taking arcs away, or cutting one in two, never makes it harder.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, order=True)
class Lifetime:
    """Word of node `word` in one register of a PE, readable in cycles `first` .. `last` (at most II
    of them, but in rotating files).
    """

    word: int
    first: int
    last: int


def allocate(
    lifetimes: Sequence[Lifetime], ii: int, registers: int, *, rotating: bool = False
) -> tuple[int, ...] | None:
    """Register of each lifetime, or None if no allocation exists; of a rotating file the register's
    name at the start of the iteration.

    The circle is cut at slot 0. Lifetimes across the cut are pairwise in conflict, so each has a
    register of its own, free between its two ends; the rest are intervals, placed by begin with
    backtracking. Registers that are free over the same time are interchangeable, and a state that
    failed is never entered again.
    """
    if rotating:
        return _allocate_rotating(lifetimes, ii, registers)
    if any(lifetime.last - lifetime.first >= ii for lifetime in lifetimes):
        raise ValueError("a lifetime lasts longer than II cycles")
    crossing = [i for i, lifetime in enumerate(lifetimes) if _crosses(lifetime, ii)]
    if len(crossing) > registers:
        return None
    order = sorted(
        (i for i in range(len(lifetimes)) if i not in set(crossing)),
        key=lambda i: (lifetimes[i].first % ii, lifetimes[i].last - lifetimes[i].first),
    )
    free = [((lifetimes[i].last % ii) + 1, lifetimes[i].first % ii) for i in crossing]
    free += [(0, ii)] * (registers - len(crossing))
    chosen = dict(zip(crossing, range(len(crossing)), strict=True))
    if not _place(
        [(lifetimes[i].first % ii, _end(lifetimes[i], ii), i) for i in order], free, chosen
    ):
        return None
    return tuple(chosen[i] for i in range(len(lifetimes)))


def conflict(
    lifetimes: Sequence[Lifetime], ii: int, registers: int, *, rotating: bool = False
) -> tuple[Lifetime, ...]:
    """A minimal subset without an allocation; `lifetimes` must have none."""
    core = list(lifetimes)
    for lifetime in lifetimes:
        rest = [other for other in core if other != lifetime]
        if allocate(rest, ii, registers, rotating=rotating) is None:
            core = rest
    return tuple(core)


def _end(lifetime: Lifetime, ii: int) -> int:
    return lifetime.first % ii + lifetime.last - lifetime.first + 1


def _crosses(lifetime: Lifetime, ii: int) -> bool:
    return _end(lifetime, ii) > ii


def _place(
    intervals: Sequence[tuple[int, int, int]],
    free: Sequence[tuple[int, int]],
    chosen: dict[int, int],
) -> bool:
    """Depth-first search; `free` is (free from, until) of each register, `chosen` is filled on
    success.
    """
    failed: set[tuple[int, tuple[tuple[int, int], ...]]] = set()

    def descend(depth: int, registers: tuple[tuple[int, int], ...]) -> bool:
        if depth == len(intervals):
            return True
        state = (depth, tuple(sorted(registers)))
        if state in failed:
            return False
        begin, end, lifetime = intervals[depth]
        tried: set[int] = set()
        for index, (free_from, until) in enumerate(registers):
            # A register free before `begin` is as good as any other with the same end.
            if free_from > begin or end > until or until in tried:
                continue
            tried.add(until)
            chosen[lifetime] = index
            if descend(depth + 1, (*registers[:index], (end, until), *registers[index + 1 :])):
                return True
        failed.add(state)
        return False

    return descend(0, tuple(free))


def _allocate_rotating(
    lifetimes: Sequence[Lifetime], ii: int, registers: int
) -> tuple[int, ...] | None:
    """The same of a rotating file (Rau et al. 1992, "Register allocation for software pipelined
    loops").

    Iteration i finds the register that it calls r in place (r + i) mod R. Follow one place through
    R * II cycles: it meets each name once, so it holds each lifetime once, and every other place
    repeats the pattern by multiples of II later. The file is therefore one circle of R * II cycles;
    a lifetime that begins in cycle f under the name r is the arc that begins at f - II * r. Arcs
    may not overlap, and each may be turned by multiples of II.

    Depth-first, long lifetimes first; the first of all keeps name 0, since turning all arcs
    together changes nothing. A set of occupied cycles that failed is not entered again.
    """
    around = registers * ii
    if sum(lifetime.last - lifetime.first + 1 for lifetime in lifetimes) > around:
        return None
    order = sorted(range(len(lifetimes)), key=lambda i: (lifetimes[i].first - lifetimes[i].last, i))
    names: dict[int, int] = {}
    failed: set[tuple[int, int]] = set()

    def descend(depth: int, taken: int) -> bool:
        if depth == len(order):
            return True
        if (depth, taken) in failed:
            return False
        lifetime = lifetimes[order[depth]]
        for name in range(registers if depth else 1):
            begin, length = lifetime.first - ii * name, lifetime.last - lifetime.first + 1
            arc = _arc(begin % around, length, around)
            if taken & arc:
                continue
            names[order[depth]] = name
            if descend(depth + 1, taken | arc):
                return True
        failed.add((depth, taken))
        return False

    return tuple(names[i] for i in range(len(lifetimes))) if descend(0, 0) else None


def _arc(begin: int, length: int, around: int) -> int:
    """The cycles of an arc as bits."""
    bits = (1 << length) - 1 << begin
    return bits >> around | bits & (1 << around) - 1
