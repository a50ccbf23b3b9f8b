"""Loops that end after a number of iterations known at compile time.

An iteration is run on constants only (conditional constant propagation, Wegman and Zadeck 1991),
with what the one before left in the header's phis, until no path leads back to the header. So any
counter does (steps, shifts, several at once), in any form of loop, with or without `break`.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from vividc.host import time_limit
from vividc.host.once import once_each
from vividc.machine.opcodes import Opcode
from vividc.machine.semantics import SEMANTICS
from vividc.ssa.analysis.constants import constant_value
from vividc.ssa.edit import block_of, incoming
from vividc.ssa.flow import Loop, preheader_of
from vividc.ssa.ir import Block, Const, Function, Phi, Ref, Value

_MOST_VISITS = 10_000
"""Of blocks, for one loop: some 64 iterations of 50 blocks."""


@dataclass(frozen=True, slots=True)
class ConstantTrips:
    """Attributes
    ----------
    entries
        How often the header runs at most: the copies that `peel` needs to make the loop go.
    iterations
        Passes through the body at most; a last run of the header that only leaves does not count.
    """

    entries: int
    iterations: int


@once_each
def constant_trips(function: Function, loop: Loop, limit: int) -> ConstantTrips | None:
    """The loop's trips, or None if they are not constant, more than `limit`, or of a loop so long
    that finding out takes too many visits of blocks.

    The loop has one preheader and one latch.
    """
    blocks = [block for block in function.blocks if block.name in loop.blocks]
    inside = _possible_constants(blocks)
    if _always_repeats(loop, blocks, inside):
        return None
    header = block_of(function, loop.header)
    preheader = preheader_of(function, loop)
    (latch,) = loop.latches
    words = _constants({phi.id: incoming(phi, preheader) for phi in header.phis}, {})
    blocks = [_only(block, inside) for block in blocks]
    visits = 0
    for number in range(1, limit + 2):
        state = _Iteration(loop, blocks, inside, words)
        visits += state.run()
        if visits > _MOST_VISITS:
            return None
        if not state.repeats:
            only_header = state.reached == {loop.header} and len(loop.blocks) > 1
            iterations = number - 1 if only_header else number
            return ConstantTrips(number, iterations) if iterations <= limit else None
        carried = {phi.id: incoming(phi, latch) for phi in header.phis}
        following = _constants(carried, state.words)
        if following == words:  # and so forever
            return None
        words = following
    return None


def _possible_constants(blocks: list[Block]) -> frozenset[int]:
    """Ids that may be constants in some iteration: made of constants, whatever path is taken."""
    possible: set[int] = set()

    def may_be(value: Value) -> bool:
        return isinstance(value, Const) or (isinstance(value, Ref) and value.id in possible)

    before = -1
    while before != (before := len(possible)):
        for block in blocks:
            for phi in block.phis:
                if phi.id not in possible and any(may_be(value) for _, value in phi.incoming):
                    possible.add(phi.id)
            for instr in block.instrs:
                if instr.id not in possible and instr.op in SEMANTICS:
                    enough = any if instr.op in (Opcode.AND, Opcode.OR) else all
                    if enough(map(may_be, instr.operands)):
                        possible.add(instr.id)
    return frozenset(possible)


def _always_repeats(loop: Loop, blocks: list[Block], possible: frozenset[int]) -> bool:
    """Whether branches that no constant decides lead from the header back to it."""
    undecided = {
        block.name: block.branch.successors
        for block in blocks
        if not isinstance(block.branch.cond, Const)
        and not (isinstance(block.branch.cond, Ref) and block.branch.cond.id in possible)
    }
    work, seen = [loop.header], set[str]()
    while work:
        for target in undecided.get(work.pop(), ()):
            if target == loop.header:
                return True
            if target not in seen:
                seen.add(target)
                work.append(target)
    return False


def _only(block: Block, idents: frozenset[int]) -> Block:
    """`block` with the definitions of these ids alone."""
    return replace(
        block,
        phis=tuple(phi for phi in block.phis if phi.id in idents),
        instrs=tuple(instr for instr in block.instrs if instr.id in idents),
    )


def _constants(values: dict[int, Value], words: dict[int, int]) -> dict[int, int]:
    known = {}
    for ident, value in values.items():
        if isinstance(value, Const):
            known[ident] = value.word
        elif isinstance(value, Ref) and value.id in words:
            known[ident] = words[value.id]
    return known


@dataclass
class _Iteration:
    """One pass from the header, on the constants `entering` its phis.

    `inside` are the ids that may be constants, `varies` those known to be none in this iteration;
    of the others those without a word have not been reached.
    """

    loop: Loop
    blocks: list[Block]
    inside: frozenset[int]
    words: dict[int, int]
    varies: set[int] = field(default_factory=set)
    reached: set[str] = field(default_factory=set)
    taken: set[tuple[str, str]] = field(default_factory=set)
    repeats: bool = False

    def __post_init__(self) -> None:
        self.words = dict(self.words)
        header = next(block for block in self.blocks if block.name == self.loop.header)
        self.varies |= {phi.id for phi in header.phis if phi.id not in self.words}
        self.reached.add(self.loop.header)

    def run(self) -> int:
        """Visits blocks until nothing new is learnt; the number of visits."""
        before, visits = None, 0
        time_limit.step("trips of loops were counted")
        while before != (before := (len(self.words), len(self.varies), len(self.taken))):
            for block in self.blocks:
                if block.name in self.reached:
                    self._visit(block)
                    visits += 1
        return visits

    def _visit(self, block: Block) -> None:
        if block.name != self.loop.header:
            for phi in block.phis:
                self._meet(phi, block.name)
        for instr in block.instrs:
            if instr.id in self.varies:
                continue
            word = constant_value(instr, self.words)
            if word is not None:
                self.words[instr.id] = word
            elif not any(self._unknown_yet(value) for value in instr.operands):
                self._vary(instr.id)
        self._follow(block)

    def _meet(self, phi: Phi, name: str) -> None:
        if phi.id in self.varies:
            return
        values = [value for source, value in phi.incoming if (source, name) in self.taken]
        known = {self._word(value) for value in values if not self._unknown_yet(value)}
        if None in known or len(known) > 1:
            self._vary(phi.id)
        elif known:
            word = known.pop()
            assert word is not None
            if self.words.setdefault(phi.id, word) != word:
                self._vary(phi.id)

    def _follow(self, block: Block) -> None:
        branch = block.branch
        targets = branch.successors
        if branch.cond is not None:
            if self._unknown_yet(branch.cond):
                return
            word = self._word(branch.cond)
            if word is not None:
                targets = targets[:1] if word else targets[1:]
        for target in targets:
            self.taken.add((block.name, target))
            if target == self.loop.header:
                self.repeats = True
            elif target in self.loop.blocks:
                self.reached.add(target)

    def _word(self, value: Value) -> int | None:
        if isinstance(value, Const):
            return value.word
        return self.words.get(value.id) if isinstance(value, Ref) else None

    def _unknown_yet(self, value: Value) -> bool:
        """Defined inside, but not reached so far."""
        if not isinstance(value, Ref) or value.id not in self.inside:
            return False
        return value.id not in self.words and value.id not in self.varies

    def _vary(self, ident: int) -> None:
        self.words.pop(ident, None)
        self.varies.add(ident)
