"""A kernel as nests of loops that are run one after the other, some of them again and again: each
is a function of its own, and what they leave in the arrays is all that one hands to the next.

A loop in which no store's place depends on its counter, as one over time steps, is repeated by the
host; any other one that is outermost is a nest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from vividc.errors import KernelError, SourceLoc
from vividc.machine.opcodes import MEMORY, Opcode
from vividc.machine.parallel import REPEAT, Order, Repeat
from vividc.ssa.analysis.counters import Counter, counter_of
from vividc.ssa.analysis.induction import computed_from
from vividc.ssa.analysis.levels import with_own_latches
from vividc.ssa.edit import read_values, rename_incoming, retarget, substitute
from vividc.ssa.flow import Loop, find_loops
from vividc.ssa.ir import Block, Branch, Function, Input, Instr, Ref, Value
from vividc.ssa.parallel.spread_proof import is_exact
from vividc.ssa.parallel.terms import TermTable
from vividc.ssa.rewrite.dead import remove_unused
from vividc.ssa.rewrite.normalize import canonical_loops

_ENTRY, _END = "nest.entry", "nest.end"
_DEPTH = 2
"""Loops inside one that is repeated, at least: a single one is too little for a launch of all
tiles.
"""


@dataclass(frozen=True, slots=True)
class FoundNest:
    """A nest as a function that runs it alone, and its outermost loop in there."""

    function: Function
    header: str


@dataclass(frozen=True, slots=True)
class FoundNests:
    """The nests of a kernel, numbered in the order of its text, and the order of their runs."""

    nests: tuple[FoundNest, ...]
    order: Order


def nests_of(function: Function) -> FoundNests:
    """The nests of a kernel.

    Raises
    ------
    KernelError
        It returns something, makes arrays, stores outside its loops, branches around them, or a
        loop hands values to what comes after it otherwise than in arrays.
    """
    function = canonical_loops(function)
    for loop in _outermost(function, None):
        function = with_own_latches(function, loop.header)
    if function.returns is not None:
        raise _refused("it returns a value", None)
    if any(local.contents is None for local in function.locals):
        raise _refused("it makes arrays of its own", None)
    return _Finder(function).found()


def _refused(reason: str, loc: SourceLoc | None) -> KernelError:
    return KernelError(
        f"the kernel is not a sequence of loops over arrays: {reason}",
        loc=loc,
        hint="write loops one after the other that hand on results in arrays",
    )


def _outermost(function: Function, within: Loop | None) -> list[Loop]:
    """The loops directly inside a loop, or inside the function."""
    inside = [
        loop
        for loop in find_loops(function)
        if within is None or (loop.header in within.blocks and loop.header != within.header)
    ]
    return [
        loop
        for loop in inside
        if not any(loop.header in other.blocks for other in inside if other is not loop)
    ]


@dataclass(frozen=True, slots=True)
class _Item:
    """What a level does: the code of blocks outside inner loops, or an inner loop."""

    blocks: tuple[Block, ...] = ()
    loop: Loop | None = None


class _Finder:
    def __init__(self, function: Function) -> None:
        self._function = function
        self._nests: list[FoundNest] = []
        self._repeats = 0
        self._table = TermTable(function, -1)

    def found(self) -> FoundNests:
        entry = self._function.blocks[0].name
        items = self._items(None, entry)
        order = self._order(items, (), {})
        if not self._nests:
            raise _refused("it has no loops", None)
        return FoundNests(tuple(self._nests), Order(tuple(self._table.terms), order))

    def _items(self, within: Loop | None, first: str) -> list[_Item]:
        """What runs from a block on, to the end of the function or of an iteration."""
        loops = {loop.header: loop for loop in _outermost(self._function, within)}
        blocks, items = self._function.by_name, list[_Item]()
        name: str | None = first
        while name is not None and (within is None or name != within.header):
            if name in loops:
                loop = loops[name]
                targets = {target for _, target in loop.exits}
                if len(targets) != 1 or len(loop.exits) != 1 or loop.exits[0][0] != name:
                    raise _refused("a loop is left early", blocks[name].branch.loc)
                items.append(_Item(loop=loop))
                name = targets.pop()
                continue
            block = blocks[name]
            if block.branch.cond is not None or block.phis:
                raise _refused("it branches outside its loops", block.branch.loc)
            if any(instr.op is Opcode.STORE for instr in block.instrs):
                raise _refused("it stores outside its loops", block.branch.loc)
            items.append(_Item((block,)))
            name = block.branch.target
        return items

    def _order(
        self, items: Sequence[_Item], before: tuple[Instr, ...], keys: dict[int, Value]
    ) -> tuple[int | Repeat, ...]:
        """The nests and repetitions of a level.

        Parameters
        ----------
        before
            What the levels around have computed before it.
        keys
            Inputs in place of the counters around.
        """
        order: list[int | Repeat] = []
        for item in items:
            if item.loop is None:
                before = (*before, *(i for block in item.blocks for i in block.instrs))
                continue
            written = self._stored_in(item.loop)
            counter = self._repeated(item.loop)
            if counter is None:
                order.append(self._nest(item.loop, before, keys))
            else:
                order.append(self._repeat(item.loop, counter, before, keys))
            before = tuple(i for i in before if i.op not in MEMORY or i.array not in written)
        return tuple(order)

    def _stored_in(self, loop: Loop) -> set[str]:
        return {
            instr.array
            for block in self._function.blocks
            if block.name in loop.blocks
            for instr in block.instrs
            if instr.op is Opcode.STORE
        }

    def _repeated(self, loop: Loop) -> Counter | None:
        """The counter of a loop that the host repeats; None: it is a nest."""
        counter = counter_of(self._function, loop)
        header = self._function.by_name[loop.header]
        inside = [one for one in find_loops(self._function) if one.blocks < loop.blocks]
        if counter is None or len(header.phis) != 1 or len(inside) < _DEPTH:
            return None
        known = [self._table.of(value) for value in (counter.initial, counter.limit)]
        if not all(is_exact(self._table, number) for number in known):
            return None
        blocks = [block for block in self._function.blocks if block.name in loop.blocks]
        moved = computed_from(blocks, Ref(counter.phi.id))
        stores = (i for block in blocks for i in block.instrs if i.op is Opcode.STORE)
        return None if any(store.operands[1] in moved for store in stores) else counter

    def _repeat(
        self, loop: Loop, counter: Counter, before: tuple[Instr, ...], keys: dict[int, Value]
    ) -> Repeat:
        key = f"{REPEAT}{self._repeats}"
        self._repeats += 1
        header = self._function.by_name[loop.header]
        inside = (s for s in header.branch.successors if s in loop.blocks)
        written = self._stored_in(loop)
        kept = tuple(i for i in before if i.op not in MEMORY or i.array not in written)
        return Repeat(
            key,
            self._table.of(counter.initial),
            self._table.of(counter.limit),
            counter.step,
            self._order(
                self._items(loop, next(inside)),
                (*kept, *header.instrs),
                {**keys, counter.phi.id: Input(key)},
            ),
        )

    def _nest(self, loop: Loop, before: tuple[Instr, ...], keys: dict[int, Value]) -> int:
        """Number of a new nest: what is computed before the loop, and the loop."""
        function = self._function
        blocks = [block for block in function.blocks if block.name in loop.blocks]
        outside = {s for phi in function.by_name[loop.header].phis for s, _ in phi.incoming}
        outside -= loop.blocks
        ((_, target),) = loop.exits

        def inside(block: Block) -> Block:
            branch = retarget(block.branch, target, _END)
            phis = block.phis
            for source in outside:
                phis = tuple(rename_incoming(phi, source, _ENTRY) for phi in phis)
            return replace(block, phis=phis, branch=branch)

        entry = Block(_ENTRY, (), before, Branch(loop.header))
        made = (entry, *map(inside, blocks), Block(_END, (), (), Branch()))
        alone = remove_unused(substitute(replace(function, blocks=made), keys))
        self._demand_closed(alone, loop)
        self._nests.append(FoundNest(alone, loop.header))
        return len(self._nests) - 1

    def _demand_closed(self, alone: Function, loop: Loop) -> None:
        """Everything that a nest reads is computed in it."""
        known = alone.definitions
        read = (value for block in alone.blocks for value in read_values(block))
        if any(isinstance(value, Ref) and value.id not in known for value in read):
            loc = self._function.by_name[loop.header].branch.loc
            raise _refused("a loop reads a number that another one computes", loc)
