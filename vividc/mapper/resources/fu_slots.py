"""The issue slots of FUs that a mapping takes: for operations, FUs kept busy, and moves."""

from __future__ import annotations

from collections import Counter, defaultdict
from itertools import pairwise

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG, Node
from vividc.mapper.mapping import Mapping


def utilization(dfg: DFG, fabric: Fabric, mapping: Mapping) -> float:
    """Share of the FUs' issue slots that the mapping takes, 0 .. 1."""
    return fu_slots(dfg, fabric, mapping) / (len(fabric.pes) * mapping.ii)


def fu_slots(dfg: DFG, fabric: Fabric, mapping: Mapping) -> int:
    """Issue slots that the mapping takes, of all FUs together."""
    return fu_slots_by_pe(dfg, fabric, mapping).total()


def fu_slots_by_pe(dfg: DFG, fabric: Fabric, mapping: Mapping) -> Counter[int]:
    """Issue slots of each PE's FU that the mapping takes, by PE id; what takes none is left out."""
    slots = Counter(place.pe for node, place in mapping.places.items() if dfg.by_id[node].uses_fu)
    slots.update(pe for pe, _ in kept(dfg, fabric, mapping))
    for (pe, _), words in moved(dfg, fabric, mapping).items():
        slots[pe] += len(words)
    return slots


def kept(dfg: DFG, fabric: Fabric, mapping: Mapping) -> dict[tuple[int, int], Node]:
    """The node that keeps the FU at (PE, slot), which it began to use in an earlier one."""
    return {
        (place.pe, (place.time + later) % mapping.ii): dfg.by_id[node]
        for node, place in mapping.places.items()
        if dfg.by_id[node].uses_fu
        for later in range(1, fabric.occupancy(dfg.by_id[node]))
    }


def moved(dfg: DFG, fabric: Fabric, mapping: Mapping) -> dict[tuple[int, int], tuple[int, ...]]:
    """Ids of the nodes whose words the FU moves at (PE, slot).

    A move: a word enters an output register, or registers that only the FU writes, from another
    place.
    """
    words: dict[tuple[int, int], set[int]] = defaultdict(set)
    for edge, steps in mapping.routes.items():
        for before, step in pairwise(steps):
            by_fu = step.kind == "out" or (step.kind == "reg" and fabric.pes[step.pe].written_by_fu)
            same = (before.kind, before.pe, before.index) == (step.kind, step.pe, step.index)
            stays = same and (step.kind == "reg" or fabric.routing.holds)
            if by_fu and not stays:
                words[step.pe, (step.time - 1) % mapping.ii].add(dfg.edges[edge].src)
    return {key: tuple(sorted(values)) for key, values in words.items()}
