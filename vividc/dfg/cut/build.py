"""Cuts a kernel in SSA form into regions: one DFG for each innermost loop and for each other block.

A value that one region computes and another reads becomes the variable "%<id>"; a phi of a block
outside loops is a variable that its predecessors write.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from vividc.dfg.cut.addresses import Address, fold_addresses
from vividc.dfg.cut.build_loop import LoopParts, build_loop
from vividc.dfg.cut.build_straight import build_straight
from vividc.dfg.cut.carry_elements import carry_elements
from vividc.dfg.cut.entries import Entries, join_entries
from vividc.dfg.cut.share_divisors import share_divisors
from vividc.dfg.ir import DFG
from vividc.dfg.regions import Kernel, Region
from vividc.errors import SourceLoc
from vividc.host.watch import run_passes
from vividc.ssa.analysis.counted import Trip, count_loop
from vividc.ssa.edit import defined_types, incoming, uses
from vividc.ssa.flow import Loop, pipelined_loops, preheader_of
from vividc.ssa.ir import Block, Function, Ref, Value
from vividc.ssa.polyhedral.distances.meetings import Meetings
from vividc.ssa.rewrite.diamonds import merge_diamonds
from vividc.ssa.rewrite.hoist import hoist_invariants
from vividc.ssa.rewrite.hoist_loads import hoist_loads
from vividc.ssa.rewrite.normalize import copy_exit_values, normalize
from vividc.ssa.rewrite.number_values import merge_recurrences


@dataclass(frozen=True)
class _Plan:
    """A normalised function with what was found out about its innermost loops (by header)."""

    function: Function
    loops: dict[str, Loop]
    trips: dict[str, Trip | None]
    addresses: dict[str, dict[int, Address]]
    entries: Entries


SHAPING = (
    normalize,
    hoist_loads,
    carry_elements,
    merge_diamonds,
    merge_recurrences,
    share_divisors,
    copy_exit_values,
)
"""Passes that bring a function into the shape that regions are cut from."""


def build_kernel(function: Function) -> Kernel:
    """Cuts `function` into regions.

    Raises
    ------
    KernelError
        If the control flow is irreducible, or a loop can neither end nor return.
    """
    return Cut(function).kernel()


class Cut:
    """The regions of `function`, each built when it is asked for.

    Raises
    ------
    KernelError
        As `build_kernel`.
    """

    def __init__(self, function: Function) -> None:
        self._function = function
        self._cutter = _Cutter(_plan(run_passes(SHAPING, function)))
        self._built: dict[int, Region] = {}

    def loops_first(self) -> Iterator[Region]:
        """Loops, those with the most instructions first, then straight regions in order, without
        empty ones: what isl is asked about straight code depends on what it was asked before.
        """
        cutter = self._cutter
        positions = sorted(range(len(cutter.order)), key=cutter.loop_size, reverse=True)
        for region in map(self._region, positions):
            if not _is_empty(region):
                yield region

    def kernel(self) -> Kernel:
        """All of them."""
        regions = [self._region(position) for position in range(len(self._cutter.order))]
        function = self._function
        return Kernel(
            function.name,
            function.params,
            tuple(_drop_empty(regions)),
            function.returns,
            function.file,
            function.locals,
            function.spaced,
            function.results,
        )

    def _region(self, position: int) -> Region:
        if position not in self._built:
            self._built[position] = self._cutter.region(position)
        return self._built[position]


def _plan(function: Function) -> _Plan:
    loops = {loop.header: loop for loop in pipelined_loops(function)}
    trips: dict[str, Trip | None] = {}
    addresses: dict[str, dict[int, Address]] = {}
    for header, loop in loops.items():
        preheader = preheader_of(function, loop)
        function, trips[header] = count_loop(function, loop, preheader)
        function, addresses[header] = fold_addresses(function, loop, preheader)
    function = hoist_invariants(function)
    reads = {header: [*_read_besides(trips[header], addresses[header])] for header in loops}
    return _Plan(function, loops, trips, addresses, join_entries(function, reads))


def _read_besides(trip: Trip | None, addresses: Mapping[int, Address]) -> Iterator[Value]:
    """What a loop takes from its preheader, apart from what its blocks name."""
    if trip is not None:
        yield trip.value
    for address in addresses.values():
        yield from (address.base, address.index)


class _Cutter:
    """Emits the regions of one plan in block order."""

    def __init__(self, plan: _Plan) -> None:
        self.plan = plan
        self.function = plan.entries.function
        self.blocks = self.function.by_name
        self.loop_of = {name: header for header, loop in plan.loops.items() for name in loop.blocks}
        self.order = [
            block.name
            for block in self.function.blocks
            if block.name not in self.loop_of or block.name in plan.loops
        ]
        self.index = {name: position for position, name in enumerate(self.order)}
        self.read = self._values_read_elsewhere()
        self.meetings = Meetings(plan.entries.explained)

    def region(self, position: int) -> Region:
        """The region at a place; a loop stands where its header stood."""
        name = self.order[position]
        is_loop = name in self.plan.loops
        return self._loop(name, position) if is_loop else self._straight(name, position)

    def loop_size(self, position: int) -> int:
        """Instructions of the loop at a place; -1 for a straight region."""
        loop = self.plan.loops.get(self.order[position])
        blocks = self.plan.function.by_name
        return -1 if loop is None else sum(len(blocks[name].instrs) for name in loop.blocks)

    def _home(self, block: str) -> str:
        """The block that names the region `block` is in."""
        return self.loop_of.get(block, block)

    def _values_read_elsewhere(self) -> set[int]:
        """Ids of values that some region other than the defining one reads."""
        defined: dict[int, str] = {}
        for block in self.function.blocks:
            defined |= dict.fromkeys(defined_types(block), self._home(block.name))
        elsewhere: set[int] = set()
        for block in self.function.blocks:
            home = self._home(block.name)
            inside = block.name in self.loop_of
            for value in self._loop_reads(block) if inside else self._straight_reads(block):
                if isinstance(value, Ref) and defined[value.id] != home:
                    elsewhere.add(value.id)
        return elsewhere

    def _loop_reads(self, block: Block) -> Iterable[Value]:
        yield from uses(block)
        for phi in block.phis:
            yield from (value for _, value in phi.incoming)
        for phi in self.blocks[self.plan.loops[self.loop_of[block.name]].exits[0][1]].phis:
            yield from (value for _, value in phi.incoming)
        addresses = self.plan.addresses[self.loop_of[block.name]]
        yield from (addresses[i.id].base for i in block.instrs if i.id in addresses)

    def _straight_reads(self, block: Block) -> Iterable[Value]:
        yield from uses(block)
        yield from (value for _, value in self._phi_writes(block))
        trip = self._trip_after(block)
        if trip is not None:
            yield trip

    def _straight(self, name: str, position: int) -> Region:
        block = self.blocks[name]
        dfg = build_straight(
            f"straight{position}",
            block,
            writes=self._writes(block),
            trip=self._trip_after(block),
            meetings=self.meetings,
        )
        branch = block.branch
        conditional = branch.cond is not None
        fall = branch.otherwise if conditional else branch.target
        return Region(
            dfg.name,
            "straight",
            dfg,
            next=None if fall is None else self.index[fall],
            branch=self.index[branch.target] if conditional and branch.target else None,
            header=name,
            loc=_first_loc(block),
        )

    def _writes(self, block: Block) -> list[tuple[int, Value]]:
        """Variables that a straight block writes: its own values read elsewhere, and the phis it
        feeds.
        """
        own: list[tuple[int, Value]] = [
            (instr.id, Ref(instr.id)) for instr in block.instrs if instr.id in self.read
        ]
        return own + self._phi_writes(block)

    def _phi_writes(self, block: Block) -> list[tuple[int, Value]]:
        result: list[tuple[int, Value]] = []
        if block.name in self.plan.entries.empty:
            return result
        for target in dict.fromkeys(block.branch.successors):
            if target in self.plan.loops:
                result += self._initial_exit_values(target)
                continue
            known = {phi.id: incoming(phi, block.name) for phi in self.blocks[target].phis}
            result += known.items()
            if target in self.plan.entries.empty:
                starts = self._initial_exit_values(self.plan.entries.behind(target))
                result += [(ident, _at_end(value, known)) for ident, value in starts]
        return result

    def _initial_exit_values(self, header: str) -> list[tuple[int, Value]]:
        """What the loop's exit variables hold if it runs no iteration, or does not write them in
        its last.
        """
        loop = self.plan.loops[header]
        parts = LoopParts(self.plan.function, loop, self.plan.trips[header], {})
        return [
            (phi.id, value)
            for phi in self.blocks[loop.exits[0][1]].phis
            if (value := parts.initial_exit_value(phi)) is not None
        ]

    def _trip_after(self, block: Block) -> Value | None:
        if block.name in self.plan.entries.empty:
            return None
        for target in block.branch.successors:
            known = {phi.id: incoming(phi, block.name) for phi in self.blocks[target].phis}
            trip = self.plan.trips.get(self.plan.entries.behind(target))
            if trip is not None:
                return _at_end(trip.value, known)
        return None

    def _loop(self, header: str, position: int) -> Region:
        plan = self.plan
        loop = plan.loops[header]
        parts = LoopParts(plan.function, loop, plan.trips[header], plan.addresses[header])
        exit_name = loop.exits[0][1]
        dfg: DFG = build_loop(f"loop{position}", parts, self.blocks[exit_name].phis)
        return Region(
            dfg.name,
            "loop",
            dfg,
            next=self.index[exit_name],
            counted=plan.trips[header] is not None,
            header=header,
            loc=self.blocks[header].branch.loc,
        )


def _at_end(value: Value, known: Mapping[int, Value]) -> Value:
    """`value` at the end of a block that knows what phis of the next are."""
    return known.get(value.id, value) if isinstance(value, Ref) else value


def _first_loc(block: Block) -> SourceLoc | None:
    locs = [i.loc for i in block.instrs if i.loc is not None]
    return locs[0] if locs else block.branch.loc


def _drop_empty(regions: list[Region]) -> list[Region]:
    """Removes straight regions that do nothing but run on to the next one."""

    def follow(index: int | None, *, is_branch: bool = False) -> int | None:
        seen = set()
        while index is not None and index not in seen and _is_empty(regions[index]):
            if is_branch and regions[index].next is None:
                return index  # a branch needs a region to go to, even to end there
            seen.add(index)
            index = regions[index].next
        return index

    first = follow(0)
    if first is None:
        return [regions[0]]
    kept: list[int] = []
    work = [first]
    while work:
        index = work.pop(0)
        if index not in kept:
            kept.append(index)
            taken = follow(regions[index].branch, is_branch=True)
            targets = (follow(regions[index].next), taken)
            work += [target for target in targets if target is not None]
    kept = [first, *sorted(index for index in kept if index != first)]
    renamed = {old: new for new, old in enumerate(kept)}

    def target(index: int | None, *, is_branch: bool = False) -> int | None:
        kept_target = follow(index, is_branch=is_branch)
        return None if kept_target is None else renamed[kept_target]

    return [
        Region(
            region.name,
            region.kind,
            region.dfg,
            target(region.next),
            target(region.branch, is_branch=True),
            region.counted,
            region.header,
            region.loc,
        )
        for region in (regions[index] for index in kept)
    ]


def _is_empty(region: Region) -> bool:
    return region.kind == "straight" and region.branch is None and not region.dfg.placed
