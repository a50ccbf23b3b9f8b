"""If-conversion outside pipelined loops: a small if/else becomes part of the block around it.

Each arm of a branch is a region of its own, with a region switch on either side and words that
travel through constant stores. A few operations are better computed whether they are wanted or not
(Allen et al. 1983); loads and stores get a predicate. An arm that ends with an access that stands
for an exception is part of the block, too: no witness runs on where that happens.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

from vividc.machine.opcodes import ELEMENTARY, MEMORY, OPCODES, Opcode, Type
from vividc.machine.params import TRAP
from vividc.ssa.analysis.conjunctions import Implications
from vividc.ssa.edit import FreshIds, incoming, with_blocks
from vividc.ssa.flow import blocks_of_pipelined_loops, predecessors
from vividc.ssa.ir import Block, Branch, Const, Function, Instr, Kind, Phi, Ref, Undefined, Value
from vividc.ssa.rewrite.blocks import merge_chains

_MOST_OPERATIONS = 16
"""In an arm: about what a tile issues in the cycles that a region of its own would cost."""


@dataclass(frozen=True, slots=True)
class _Diamond:
    """`top` branches to the arms, which are jumped over, lead to `bottom`, or raise; None: an empty
    arm.
    """

    top: Block
    then: Block | None
    other: Block | None
    bottom: Block

    @property
    def names(self) -> set[str]:
        """Of its blocks."""
        blocks = (self.top, self.then, self.other, self.bottom)
        return {block.name for block in blocks if block is not None}


def merge_diamonds(function: Function) -> Function:
    """The same function with every small if/else outside pipelined loops in one block.

    The function is normalised, and stays so. An arm qualifies if it is one block of at most
    16 instructions, none of which is expanded later (divisions, elementary functions), and leads to
    where the other one does, or raises what the simulator reports.
    """
    while True:
        chosen = _apart(_diamonds(function))
        if not chosen:
            return function
        function = _merged(function, chosen)
        function = merge_chains(function, apart=blocks_of_pipelined_loops(function))


def _apart(diamonds: Iterable[_Diamond]) -> list[_Diamond]:
    """Those that have no block in common with one before: they can be merged at once."""
    chosen: list[_Diamond] = []
    used: set[str] = set()
    for diamond in diamonds:
        if used.isdisjoint(diamond.names):
            used |= diamond.names
            chosen.append(diamond)
    return chosen


def _diamonds(function: Function) -> Iterator[_Diamond]:
    by_name = {block.name: block for block in function.blocks}
    pipelined, before = blocks_of_pipelined_loops(function), predecessors(function)

    def arm(name: str) -> Block | None:
        block = by_name[name]
        alone = len(before[name]) == 1 and name not in pipelined
        after = block.branch.successors
        jumps = (len(after) == 1 and after[0] not in pipelined) or _raises(block)
        return block if alone and jumps and not block.phis and _is_small(block) else None

    def end(arm: Block | None, name: str, otherwise: str) -> str:
        if arm is None:
            return name
        return otherwise if _raises(arm) else arm.branch.successors[0]

    for top in function.blocks:
        targets = top.branch.successors
        if top.branch.cond is None or top.name in pipelined or targets[0] == targets[1]:
            continue
        then, other = arm(targets[0]), arm(targets[1])
        ends = [end(then, *targets), end(other, *reversed(targets))]
        if then is not None and ends[0] == targets[1]:  # if without else
            yield _Diamond(top, then, None, by_name[ends[0]])
        elif other is not None and ends[1] == targets[0]:
            yield _Diamond(top, None, other, by_name[ends[1]])
        elif then is not None and other is not None and ends[0] == ends[1]:
            yield _Diamond(top, then, other, by_name[ends[0]])


def _raises(block: Block) -> bool:
    """Whether it ends the kernel by an access that stands for an exception."""
    return not block.branch.successors and any(i.array.startswith(TRAP) for i in block.instrs)


def _is_small(block: Block) -> bool:
    expanded = any(instr.op in ELEMENTARY for instr in block.instrs)
    return len(block.instrs) <= _MOST_OPERATIONS and not expanded


def _merged(function: Function, diamonds: Iterable[_Diamond]) -> Function:
    changed: dict[str, Block] = {}
    gone: set[str] = set()
    fresh = FreshIds(function)
    for diamond in diamonds:
        edit = Arms(function, fresh, [*diamond.top.instrs])
        changed |= _merged_blocks(diamond, edit)
        gone |= diamond.names - {diamond.top.name, diamond.bottom.name}
    kept = tuple(block for block in function.blocks if block.name not in gone)
    return with_blocks(replace(function, blocks=kept), changed.values())


def _merged_blocks(diamond: _Diamond, edit: Arms) -> dict[str, Block]:
    """The top, which now leads to the bottom only, and the bottom, by name."""
    top, bottom = diamond.top, diamond.bottom
    cond = top.branch.cond
    assert cond is not None
    sources = []
    for block, taken in ((diamond.then, True), (diamond.other, False)):
        sources.append(top.name if block is None or _raises(block) else block.name)
        if block is not None:
            edit.add(block, cond, taken=taken)
    phis = []
    for phi in bottom.phis:
        value = edit.choose(phi, cond, *(incoming(phi, source) for source in sources))
        rest = tuple(item for item in phi.incoming if item[0] not in sources)
        phis.append(replace(phi, incoming=(*rest, (top.name, value))))
    jump = Branch(bottom.name, loc=top.branch.loc)
    top = replace(top, instrs=tuple(edit.instrs), branch=jump)
    if bottom.name == top.name:
        return {top.name: replace(top, phis=tuple(phis))}
    return {top.name: top, bottom.name: replace(bottom, phis=tuple(phis))}


@dataclass
class Arms:
    """The instructions of a block of `function`, and behind them those of arms of its branch."""

    function: Function
    fresh: FreshIds
    instrs: list[Instr]
    inverted: Value | None = field(default=None)

    def add(self, block: Block, cond: Value, *, taken: bool) -> None:
        """Appends an arm that runs if `cond` is `taken`."""
        known = Implications(self.function, {instr.id: instr for instr in block.instrs})
        for instr in block.instrs:
            if instr.op not in MEMORY:
                self.instrs.append(instr)
                continue
            count = OPCODES[instr.op].arity + 1
            own = instr.operands[count:]  # of an arm in an arm, or of a mask
            if not (taken and own and known.holds(own[0], cond)):
                pred = cond if taken else self._inverse(cond)
                own = (self._emit(Opcode.AND, Type.PRED, (pred, *own)) if own else pred,)
            self.instrs.append(replace(instr, operands=(*instr.operands[:count], *own)))

    def choose(self, phi: Phi, cond: Value, then: Value, other: Value) -> Value:
        """What stands for a phi at the bottom."""
        if then == other or isinstance(other, Undefined):
            return then
        if isinstance(then, Undefined):
            return other
        return self._emit(Opcode.SELECT, phi.type, (cond, then, other), phi)

    def _inverse(self, cond: Value) -> Value:
        if self.inverted is None:
            self.inverted = self._emit(Opcode.XOR, Type.PRED, (cond, Const(1)))
        return self.inverted

    def _emit(
        self, op: Opcode, kind: Kind, operands: tuple[Value, ...], like: Phi | None = None
    ) -> Value:
        loc = None if like is None else like.loc
        self.instrs.append(Instr(self.fresh(), op, kind, operands, loc=loc))
        return Ref(self.instrs[-1].id)
