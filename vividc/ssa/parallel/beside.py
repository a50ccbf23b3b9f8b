"""Loops before and after the one over `prange` that store to arrays of the launch, between inputs
of their own: a launch can share their iterations among chunks, such as what fills an array.

Nothing but what they store leaves such a loop, and each iteration needs only its own number, so
that any of them may run on any tile if no chunk touches what another one writes, which the launch
proves. Arrays of the kernel's own that only these loops and the parallel one access are shared in
the same way.
"""

from __future__ import annotations

from collections.abc import Mapping as ReadOnly
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import networkx as nx

from vividc.errors import KernelError
from vividc.machine.opcodes import MEMORY, Opcode
from vividc.machine.parallel import Beside, beside_keys
from vividc.machine.params import TRAP
from vividc.ssa.analysis.counters import Counter, counter_of, defined_in
from vividc.ssa.edit import read_values, with_blocks
from vividc.ssa.flow import Loop, block_graph, dominators, find_loops
from vividc.ssa.ir import Block, Function, Input, Instr, Phi, Ref, Value
from vividc.ssa.parallel.spread_proof import ends_simulation, is_exact, is_made_in, runs_for_certain
from vividc.ssa.parallel.terms import TermTable


@dataclass(frozen=True, slots=True)
class Companion:
    """A loop beside the parallel one, with its number and its own bounds.

    `is_before`: all of it runs before the parallel loop.
    """

    number: int
    loop: Loop
    counter: Counter
    is_before: bool

    def described(self, table: TermTable) -> Beside:
        """What the launch is told of it."""
        ends = (table.of(self.counter.initial), table.of(self.counter.limit))
        return Beside(*ends, self.is_before)


@dataclass(frozen=True, slots=True)
class Sharing:
    """The loops that chunks may share with a parallel one, in the order of the text, and the arrays
    of the kernel's own of which each chunk has a slice: only these loops access them.
    """

    companions: tuple[Companion, ...]
    sliced: frozenset[str]


NOTHING_SHARED: Final = Sharing((), frozenset())


def sharing_of(function: Function, parallel: Loop, unproved: ReadOnly[str, KernelError]) -> Sharing:
    """What chunks may share.

    Parameters
    ----------
    unproved
        The kernel's own arrays of which tiles may not each have one of their own, and why.

    Raises
    ------
    KernelError
        Such an array is accessed elsewhere, too.
    """
    finder = _Finder(function, parallel)
    sliced = finder.sliced(frozenset(unproved))
    found = finder.companions(sliced)
    inside = parallel.blocks.union(*(one.loop.blocks for one in found))
    for block in function.blocks:
        if block.name not in inside and _accessed(block) & sliced:
            raise next(iter(unproved.values()))
    return Sharing(found, sliced)


class _Finder:
    def __init__(self, function: Function, parallel: Loop) -> None:
        self._function = function
        self._parallel = parallel
        loops = [loop for loop in find_loops(function) if loop.blocks.isdisjoint(parallel.blocks)]
        places = {block.name: place for place, block in enumerate(function.blocks)}
        outermost = (one for one in loops if not any(one.blocks < other.blocks for other in loops))
        self._loops = sorted(outermost, key=lambda loop: places[loop.header])
        self._table = TermTable(function, -1)
        self._own = {one.name for one in function.locals if not one.name.startswith(TRAP)}

    def sliced(self, unproved: frozenset[str]) -> frozenset[str]:
        """These arrays, and those that loops which access them store to: of one that each tile has
        for itself they would store a part only.
        """
        found = unproved
        while True:
            loops = (one for one in self._loops if self._accessed(one) & found)
            more = found.union(*(stored_in(self._function, loop) & self._own for loop in loops))
            if more == found:
                return found
            found = more

    def companions(self, sliced: frozenset[str]) -> tuple[Companion, ...]:
        """The loops that store to arrays of the launch or to sliced ones only."""
        graph = block_graph(self._function)
        found: list[Companion] = []
        for loop in self._loops:
            counter = counter_of(self._function, loop)
            stored = stored_in(self._function, loop)
            if counter is None or not stored or not stored.isdisjoint(self._own - sliced):
                continue
            if self._is_closed(loop, counter):
                is_before = self._parallel.header not in nx.ancestors(graph, loop.header)
                found.append(Companion(len(found), loop, counter, is_before))
        return tuple(found)

    def _is_closed(self, loop: Loop, counter: Counter) -> bool:
        """Whether it counts up by one between bounds that the launch knows, and hands on nothing
        but what it stores.
        """
        header = self._function.by_name[loop.header]
        if counter.step != 1 or len(header.phis) != 1 or header.branch.cond is None:
            return False
        if len(loop.exits) != 1 or loop.exits[0][0] != loop.header:
            return False
        ends = (counter.initial, counter.limit)
        if not all(is_exact(self._table, self._table.of(end)) for end in ends):
            return False
        inside = defined_in(self._function, loop)
        outside = (b for b in self._function.blocks if b.name not in loop.blocks)
        read = (value for block in outside for value in read_values(block))
        return not any(isinstance(value, Ref) and value.id in inside for value in read)

    def _accessed(self, loop: Loop) -> set[str]:
        blocks = (block for block in self._function.blocks if block.name in loop.blocks)
        return {name for block in blocks for name in _accessed(block)}


def own_stored(function: Function, loop: Loop) -> set[str]:
    """Arrays of the kernel's own that a loop stores to, but those that its iterations make."""
    own = {one.name for one in function.locals if not one.name.startswith(TRAP)}
    return stored_in(function, loop) & own


def stored_in(function: Function, loop: Loop) -> set[str]:
    """Arrays that a loop stores to, but those that each of its iterations makes."""
    blocks = (block for block in function.blocks if block.name in loop.blocks)
    made = {one.name for one in function.locals if is_made_in(function, loop, one)}
    stores = (i for block in blocks for i in block.instrs if i.op is Opcode.STORE)
    return {instr.array for instr in stores} - made


def _accessed(block: Block) -> set[str]:
    return {instr.array for instr in block.instrs if instr.op in MEMORY}


def between_inputs(function: Function, found: Sequence[Companion]) -> Function:
    """The function whose loops beside the parallel one start and end at inputs."""
    for one in found:
        first, last = beside_keys(one.number)
        function = _started(function, one, Input(first), Input(last))
    return function


def _started(function: Function, one: Companion, first: Value, last: Value) -> Function:
    header, counter = function.by_name[one.loop.header], one.counter

    def started(phi: Phi) -> Phi:
        incoming = tuple(
            (source, value if source in one.loop.blocks else first)
            for source, value in phi.incoming
        )
        return replace(phi, incoming=incoming)

    def limited(instr: Instr) -> Instr:
        if Ref(instr.id) != header.branch.cond:
            return instr
        operands = tuple(last if value == counter.limit else value for value in instr.operands)
        return replace(instr, operands=operands)

    changed = replace(
        header, phis=tuple(map(started, header.phis)), instrs=tuple(map(limited, header.instrs))
    )
    return with_blocks(function, (changed,))


class Beginnings:
    """Which stores of loops beside the parallel one happen in any case, and before any load."""

    def __init__(self, function: Function, found: Sequence[Companion], table: TermTable) -> None:
        self._found = found
        self._table = table
        self._runs = {one.number: runs_for_certain(function, one.loop) for one in found}
        self._before = dominators(function)
        self._loads = [
            (block.name, instr.array)
            for block in function.blocks
            for instr in block.instrs
            if instr.op in MEMORY and instr.op is not Opcode.STORE
        ]

    def of(self, block: str) -> Companion | None:
        """The loop that a block is in."""
        return next((one for one in self._found if block in one.loop.blocks), None)

    def counters(self, one: Companion, block: str) -> tuple[int, ...] | None:
        """Terms of the counters around a block that runs in every iteration of all these loops."""
        inside = self._table.counters_around(block, one.loop) if self._runs[one.number] else None
        if inside is None:
            return None
        return (*inside, self._table.counter_itself(one.loop.header, one.counter.phi.id))

    def leads(self, one: Companion, array: str) -> bool:
        """Whether each load of an array comes after the loop."""
        blocks = {block for block, loaded in self._loads if loaded == array}
        header = one.loop.header
        return all(
            block not in one.loop.blocks and header in self._before.get(block, {header})
            for block in blocks
        )


def alike(
    function: Function, parallel: Loop, found: Sequence[Companion], table: TermTable
) -> tuple[str, ...]:
    """Arrays of the launch to which every chunk stores the same, such as the shape of what is
    returned: outside these loops and on every way through the kernel, what the launch knows.
    """
    inside = parallel.blocks.union(*(one.loop.blocks for one in found))
    certain = _on_every_way(function)
    own = {local.name for local in function.locals}
    same: set[str] = set()
    other: set[str] = set()
    for block in function.blocks:
        for instr in block.instrs:
            if instr.op in MEMORY and instr.array not in own:
                is_same = (
                    instr.op is Opcode.STORE
                    and block.name in certain - inside
                    and all(is_exact(table, table.of(value)) for value in instr.operands[1:])
                )
                (same if is_same else other).add(instr.array)
    return tuple(sorted(same - other))


def _on_every_way(function: Function) -> frozenset[str]:
    """Blocks that every run comes through that does not end in an error of the simulation."""
    before = dominators(function)
    ends = [b.name for b in function.blocks if b.branch.target is None and not ends_simulation(b)]
    ways = [before[name] for name in ends if name in before]
    return frozenset.intersection(*ways) if ways else frozenset()
