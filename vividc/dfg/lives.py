"""In which regions of a kernel each variable is needed: variables of which no region needs two
may share an entry of a constant store (registers by colouring: Chaitin 1982).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from vividc.dfg.ir import DFG
from vividc.dfg.regions import (
    RETURN_HIGH,
    RETURN_VARIABLE,
    Kernel,
    is_variable,
    loop_behind,
    loops_before,
)
from vividc.machine.opcodes import Opcode


def variables_read(dfg: DFG) -> set[str]:
    """The variables whose words a region reads."""
    return {n.name for n in dfg.nodes if n.op is Opcode.LIVE_IN and is_variable(n.name)}


def variables_written(dfg: DFG) -> set[str]:
    """The variables that a region writes."""
    return {n.name for n in dfg.nodes if n.op is Opcode.LIVE_OUT}


def needed_after(kernel: Kernel) -> list[set[str]]:
    """By region, the variables that may be read before they are written again.

    A loop writes in its last iteration, if it has one: what is needed behind it is needed before
    it, too.
    """
    read = [variables_read(region.dfg) for region in kernel.regions]
    written = [
        set() if region.kind == "loop" else variables_written(region.dfg)
        for region in kernel.regions
    ]
    after: list[set[str]] = [set() for _ in kernel.regions]
    changed = True
    while changed:
        changed = False
        for index in reversed(range(len(kernel.regions))):
            region = kernel.regions[index]
            following = [one for one in (region.next, region.branch) if one is not None]
            needed = set().union(*(read[n] | (after[n] - written[n]) for n in following))
            if region.next is None:  # the host reads it
                needed |= {RETURN_VARIABLE, RETURN_HIGH}
            if needed != after[index]:
                after[index], changed = needed, True
    return after


ALWAYS: Final = -1
"""Bits of what every region needs."""


@dataclass(frozen=True, slots=True)
class Lives:
    """`regions`: by variable, a bit for each region that needs it: that reads or writes it, or runs
    before it is read. What a loop needs is needed by the straight region that may begin while it
    ends, and by the one under whose end it may begin, too.
    """

    regions: Mapping[str, int]

    @staticmethod
    def of(kernel: Kernel) -> Lives:
        """Those of a kernel's variables."""
        used = [variables_read(r.dfg) | variables_written(r.dfg) for r in kernel.regions]
        before = loops_before(kernel.regions)
        regions: dict[str, int] = {}
        for index, after in enumerate(needed_after(kernel)):
            loops = (before.get(index), loop_behind(kernel.regions, index))
            overlapping = [used[loop] for loop in loops if loop is not None]
            for name in set().union(used[index], after, *overlapping):
                regions[name] = regions.get(name, 0) | 1 << index
        return Lives(regions)

    def of_key(self, key: tuple[str, int | str]) -> int:
        """A bit for each region that needs an entry of a constant store; `ALWAYS` for constants and
        inputs, which are there from the launch on.
        """
        kind, name = key
        is_known = kind == "live_in" and is_variable(str(name))
        return self.regions.get(str(name), ALWAYS) if is_known else ALWAYS

    def together(self, regions: int) -> int:
        """A bit for each region that needs a variable which one of these needs."""
        bits = regions
        for one in self.regions.values():
            bits |= one if one & regions else 0
        return bits
