"""Words of straight regions parted into their own, those of loops that end while they begin, and
those of loops that begin while they end.

It is checked that the words are what follows from the loops', and that neither of two regions that
are under way in the same cycles changes what the other reads: whoever runs one to its end and then
the next, each by its own words, gets the same.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from vividc.dfg.regions import loop_behind
from vividc.errors import BundleError
from vividc.host.once import once_within
from vividc.program.dataflow import RegionFlow, trace
from vividc.program.overlaps.drains import drain_fault, rest_of
from vividc.program.overlaps.fills import ahead_of, demand_known, fill_fault
from vividc.program.overlaps.sides import Side, demand_apart
from vividc.program.overlaps.words import Contexts, Contradiction, demand, regular, without
from vividc.program.program import Program


@dataclass(frozen=True, slots=True)
class Parts:
    """The words of a program's regions.

    Attributes
    ----------
    own
        Of each region: the contexts that are its own, without what is left of a loop before it and
        what the one behind it has begun with.
    rests
        By loop that ends early: what is left of it, in the contexts of the region behind it.
    aheads
        By straight region under whose end a loop begins: that loop's part of its last contexts.
    flows
        The dataflow of these loops and straight regions.
    faults
        What contradicts the machine's rules; with any, nothing else holds.
    """

    own: tuple[Contexts, ...]
    rests: Mapping[int, Contexts]
    aheads: Mapping[int, Contexts]
    flows: Mapping[int, RegionFlow]
    faults: tuple[str, ...] = ()


@once_within
def parts(program: Program) -> Parts:
    """Part the words of a program."""
    parting = _Parting(program)
    faults = []
    for region, row in enumerate(program.table):
        if row.drain and (fault := drain_fault(program, region)):
            faults.append(f"region {region} cannot end {row.drain} cycles early: {fault}")
        if row.fill and (fault := fill_fault(program, region)):
            what = f"no loop can begin in the last {row.fill} cycles of region {region}"
            faults.append(f"{what}: {fault}")
        if row.kind == "straight":
            faults += parting.part(region)
    return Parts(tuple(parting.own), parting.rests, parting.aheads, parting.flows, tuple(faults))


def sound_parts(program: Program) -> Parts:
    """The parts of a program that may be run.

    Raises
    ------
    BundleError
        The words of a region do not fit the loop before it, or behind it.
    """
    made = parts(program)
    for fault in made.faults:
        raise BundleError(f"{program.name}: {fault}", hint="compile the kernel again")
    return made


class _Parting:
    def __init__(self, program: Program) -> None:
        self._program, self._table = program, program.table
        self.own = [program.entries[row.context : row.context + row.ii] for row in program.table]
        self.rests: dict[int, Contexts] = {}
        self.aheads: dict[int, Contexts] = {}
        self.flows: dict[int, RegionFlow] = {}

    def part(self, region: int) -> list[str]:
        """Part a straight region's words; what is wrong with them."""
        program, row = self._program, self._table[region]
        loops = [n for n, one in enumerate(self._table) if one.drain and one.next == region]
        drained = loops[0] if loops and drain_fault(program, loops[0]) is None else None
        faults = [
            f"region {loop} cannot end {self._table[loop].drain} cycles early: "
            "another loop ends there, too"
            for loop in loops[1:]
        ]
        is_filled = row.fill and fill_fault(program, region) is None
        behind = loop_behind(self._table, region) if is_filled else None
        try:
            before = None if drained is None else self._rest(drained)
            after = None if behind is None else self._ahead(region, behind)
            if before is not None and behind is not None:
                begun = self._table[behind].begun(row.fill)
                demand(before.last_stage < row.stages - begun, "both loops have a stage")
            if before is not None or after is not None:
                self._check(region, before, after)
        except Contradiction as wrong:
            faults.append(f"{self._told(region, drained, behind)}: {wrong}")
        return faults

    def _told(self, region: int, drained: int | None, behind: int | None) -> str:
        if behind is None and drained is not None:
            return f"region {drained} cannot end {self._table[drained].drain} cycles early"
        return f"region {region} does not fit the loops around it"

    def _rest(self, loop: int) -> Side:
        side = rest_of(self._table[loop], self.own[loop], self._flow(loop))
        self.rests[loop] = side.contexts
        return side

    def _ahead(self, region: int, loop: int) -> Side:
        row = self._table[region]
        side = ahead_of(row, self._table[loop], self.own[loop], self._flow(loop))
        self.aheads[region] = side.contexts[row.ii - row.fill :]
        return side

    def _flow(self, loop: int) -> RegionFlow:
        if loop not in self.flows:
            self.flows[loop] = regular(trace(self._program, loop, self.own[loop]), "its words")
        return self.flows[loop]

    def _check(self, region: int, before: Side | None, after: Side | None) -> None:
        """Take the parts of both loops out, and look at what is left beside them."""
        own = self.own[region]
        for cycle in range(len(own)):
            for side in (before, after):
                if side is not None and cycle < len(side.contexts):
                    pairs = zip(own[cycle], side.contexts[cycle], strict=True)
                    own[cycle] = [without(whole, part) for whole, part in pairs]
        flow = regular(trace(self._program, region, own), "the words beside it")
        self.flows[region] = flow
        straight = Side.of_straight(own, flow)
        if before is not None:
            demand_apart(self._program, before, straight)
        if after is not None:
            demand_known(self._program, region, flow)
            demand_apart(self._program, straight, after)
