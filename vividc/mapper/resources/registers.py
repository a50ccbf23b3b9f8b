"""Exact register allocation of one register file under a modulo schedule.

Each stay of a word in a register is an arc of the circle of II slots; arcs in one register may not
overlap. The model counts words per slot only, and circular arcs may need more registers than the
fullest slot has words (Tucker 1975), so the allocation is a search of its own. It is monotone:
taking arcs away, or cutting one in two, never makes it harder.
"""

from __future__ import annotations

from collections.abc import Sequence

from vividc.mapper.resources.rotating_registers import allocate_rotating
from vividc.mapper.resources.stay import Stay

__all__ = ["Stay", "allocate", "conflict"]


def allocate(
    stays: Sequence[Stay], ii: int, registers: int, *, rotating: bool = False
) -> tuple[int, ...] | None:
    """Register of each stay, or None if no allocation exists; of a rotating file the register's
    name at the start of the iteration (`rotating_registers`).

    The circle is cut at slot 0. Stays across the cut are pairwise in conflict, so each has a
    register of its own, free between its two ends; the rest are intervals, placed by begin with
    backtracking. Registers that are free over the same time are interchangeable, and a state that
    failed is never entered again.
    """
    if rotating:
        return allocate_rotating(stays, ii, registers)
    if any(stay.last - stay.first >= ii for stay in stays):
        raise ValueError("a stay lasts longer than II cycles")
    crossing = [i for i, stay in enumerate(stays) if _crosses(stay, ii)]
    if len(crossing) > registers:
        return None
    order = sorted(
        (i for i in range(len(stays)) if i not in set(crossing)),
        key=lambda i: (stays[i].first % ii, stays[i].last - stays[i].first),
    )
    free = [((stays[i].last % ii) + 1, stays[i].first % ii) for i in crossing]
    free += [(0, ii)] * (registers - len(crossing))
    chosen = dict(zip(crossing, range(len(crossing)), strict=True))
    if not _place([(stays[i].first % ii, _end(stays[i], ii), i) for i in order], free, chosen):
        return None
    return tuple(chosen[i] for i in range(len(stays)))


def conflict(
    stays: Sequence[Stay], ii: int, registers: int, *, rotating: bool = False
) -> tuple[Stay, ...]:
    """A minimal subset without an allocation; `stays` must have none."""
    core = list(stays)
    for stay in stays:
        rest = [other for other in core if other != stay]
        if allocate(rest, ii, registers, rotating=rotating) is None:
            core = rest
    return tuple(core)


def _end(stay: Stay, ii: int) -> int:
    return stay.first % ii + stay.last - stay.first + 1


def _crosses(stay: Stay, ii: int) -> bool:
    return _end(stay, ii) > ii


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
        begin, end, stay = intervals[depth]
        tried: set[int] = set()
        for index, (free_from, until) in enumerate(registers):
            # A register free before `begin` is as good as any other with the same end.
            if free_from > begin or end > until or until in tried:
                continue
            tried.add(until)
            chosen[stay] = index
            if descend(depth + 1, (*registers[:index], (end, until), *registers[index + 1 :])):
                return True
        failed.add(state)
        return False

    return descend(0, tuple(free))
