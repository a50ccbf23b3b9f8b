"""Exact allocation of a rotating register file under a modulo schedule (Rau et al. 1992).

Iteration i finds the register that it calls r in place (r + i) mod R. Follow one place through
R * II cycles: it meets each name once, so it holds each stay once, and every other place repeats
the pattern by multiples of II later. The file is therefore one circle of R * II cycles; a stay that
begins in cycle f under the name r is the arc that begins at f - II * r. Arcs may not overlap, and
each may be turned by multiples of II.
"""

from __future__ import annotations

from collections.abc import Sequence

from vividc.mapper.resources.stay import Stay


def allocate_rotating(stays: Sequence[Stay], ii: int, registers: int) -> tuple[int, ...] | None:
    """Name of each stay's register at the start of its iteration, or None if there is no
    allocation.

    Depth-first, long stays first; the first of all keeps name 0, since turning all arcs together
    changes nothing. A set of occupied cycles that failed is not entered again.
    """
    around = registers * ii
    if sum(stay.last - stay.first + 1 for stay in stays) > around:
        return None
    order = sorted(range(len(stays)), key=lambda i: (stays[i].first - stays[i].last, i))
    names: dict[int, int] = {}
    failed: set[tuple[int, int]] = set()

    def descend(depth: int, taken: int) -> bool:
        if depth == len(order):
            return True
        if (depth, taken) in failed:
            return False
        stay = stays[order[depth]]
        for name in range(registers if depth else 1):
            arc = _arc((stay.first - ii * name) % around, stay.last - stay.first + 1, around)
            if taken & arc:
                continue
            names[order[depth]] = name
            if descend(depth + 1, taken | arc):
                return True
        failed.add((depth, taken))
        return False

    return tuple(names[i] for i in range(len(stays))) if descend(0, 0) else None


def _arc(begin: int, length: int, around: int) -> int:
    """The cycles of an arc as bits."""
    bits = (1 << length) - 1 << begin
    return bits >> around | bits & (1 << around) - 1
