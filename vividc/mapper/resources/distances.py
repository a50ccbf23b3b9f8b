"""Hop distances between the PEs of a fabric."""

from __future__ import annotations

from collections import deque
from typing import Final

from vividc.arch.fabric import Fabric
from vividc.host.once import once_each

FAR: Final = 1 << 20
"""Distance to a PE that no links lead to."""


@once_each
def hop_distances(fabric: Fabric) -> tuple[tuple[int, ...], ...]:
    """Links on a shortest path from each PE to each other; `FAR` if there is none."""
    return tuple(_hops_from(fabric, pe.id) for pe in fabric.pes)


def hops_a_cycle(fabric: Fabric) -> int:
    """The most links that a word comes on in a cycle: those it passes, and one more where it is
    read at the other end without a register there.
    """
    return fabric.routing.hops + fabric.routing.shared


def cycles_for(hops: int, a_cycle: int) -> int:
    """Cycles for `hops` links at `a_cycle` links a cycle; 0 links take none."""
    if hops <= 0:
        return 0
    return -(-hops // a_cycle) if a_cycle and hops < FAR else FAR


def _hops_from(fabric: Fabric, origin: int) -> tuple[int, ...]:
    hops = [FAR] * len(fabric.pes)
    hops[origin] = 0
    queue = deque([origin])
    while queue:
        pe = queue.popleft()
        for link in fabric.links_from[pe]:
            if hops[link.dst] == FAR:
                hops[link.dst] = hops[pe] + 1
                queue.append(link.dst)
    return tuple(hops)
