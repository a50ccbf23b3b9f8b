"""Variables of straight regions that share their places in constant stores: of those that are never
needed at the same time, one word is enough (registers by colouring: Chaitin 1982).

A kernel with hundreds of regions has more variables than there are entries. Those that loops read
or write keep their own: they live where the loops' operations lie.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from vividc.dfg.ir import DFG
from vividc.dfg.lives import needed_after, variables_read, variables_written
from vividc.dfg.regions import RETURN_HIGH, RETURN_VARIABLE, Kernel, Region


def with_shared_variables(kernel: Kernel) -> Kernel:
    """The kernel with as few variables as are needed at once; the same one if those are all."""
    names = _own_of_straight_regions(kernel)
    renamed = _renamed(names, _conflicts(kernel, names))
    if all(old == new for old, new in renamed.items()):
        return kernel
    regions = tuple(_with_names(region, renamed) for region in kernel.regions)
    return replace(kernel, regions=regions)


def _own_of_straight_regions(kernel: Kernel) -> list[str]:
    """Variables that no loop reads or writes, and that hold no result, as they first occur."""
    found: dict[str, None] = {}
    others = {RETURN_VARIABLE, RETURN_HIGH}
    for region in kernel.regions:
        used = variables_read(region.dfg) | variables_written(region.dfg)
        if region.kind == "loop":
            others |= used
        found |= dict.fromkeys(sorted(used))
    return [name for name in found if name not in others]


def _conflicts(kernel: Kernel, names: Sequence[str]) -> dict[str, set[str]]:
    """By variable, those that are needed when it is written, and those written beside it."""
    ours = set(names)
    written = [variables_written(region.dfg) & ours for region in kernel.regions]
    found: dict[str, set[str]] = {name: set() for name in names}
    for wrote, after in zip(written, needed_after(kernel), strict=True):
        for name in wrote:
            beside = (wrote | (after & ours)) - {name}
            found[name] |= beside
            for other in beside:
                found[other].add(name)
    return found


@dataclass(slots=True)
class _Place:
    """A word for variables of which no two conflict: the name of the first, and all conflicts."""

    name: str
    conflicts: set[str] = field(default_factory=set)


def _renamed(names: Sequence[str], conflicts: Mapping[str, set[str]]) -> dict[str, str]:
    """The first place without a conflict for each."""
    places: list[_Place] = []
    chosen: dict[str, str] = {}
    for name in names:
        place = next((one for one in places if name not in one.conflicts), None)
        if place is None:
            place = _Place(name)
            places.append(place)
        place.conflicts |= conflicts[name]
        chosen[name] = place.name
    return chosen


def _with_names(region: Region, renamed: Mapping[str, str]) -> Region:
    if region.kind == "loop":
        return region
    nodes = tuple(
        replace(node, name=renamed[node.name]) if node.name in renamed else node
        for node in region.dfg.nodes
    )
    return replace(region, dfg=DFG(region.dfg.name, nodes, region.dfg.edges))
