"""Several iterations of a counted loop as one, perhaps each with partial results of its own.

What iterations add to one scalar, they add to one each there; the partial results are combined
behind the loop, pairs first. Float sums are rounded otherwise than in the source's order.
Iterations that do not fill the last group are masked: no loop for the rest follows, so that short
loops gain, too.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from vividc.machine.opcodes import Opcode, Type
from vividc.machine.parallel import Reduction
from vividc.machine.words import WORD_BITS, WORD_MASK, signed
from vividc.ssa.analysis.counted import count_loop
from vividc.ssa.analysis.induction import Induction, induction_of
from vividc.ssa.analysis.reductions import FoundReduction, reduction_of
from vividc.ssa.edit import (
    FreshIds,
    block_of,
    first_free,
    fresh_name,
    incoming,
    read_values,
    rename_incoming,
    retarget,
    substitute,
    with_blocks,
)
from vividc.ssa.flow import Loop, find_loops, preheader_of
from vividc.ssa.ir import Block, Branch, Const, Function, Instr, Phi, Ref, Value
from vividc.ssa.rewrite.clone import Clone, clone_blocks
from vividc.ssa.rewrite.refusal import Refusal

_HALF = 1 << WORD_BITS - 1


@dataclass(frozen=True)
class Grouped:
    """`main` is the header of the loop, which takes the old one's place."""

    function: Function
    main: str


def with_partial_results(function: Function, loop: Loop, factor: int) -> Grouped | Refusal:
    """Runs `factor` iterations of an innermost loop as one, with a partial result of each scalar
    that they only add to.

    The loop has one preheader and one latch, and ends in its header only.
    """
    roles = _roles(function, loop)
    if not roles.sums:
        return Refusal("its iterations add to no scalar")
    return _made(function, loop, factor, roles)


def unroll_masked(function: Function, loop: Loop, factor: int) -> Grouped | Refusal:
    """Runs `factor` iterations of an innermost loop as one, one after the other.

    The loop is as for `with_partial_results`.
    """
    return _made(function, loop, factor, _Roles(_roles(function, loop).steps, {}))


def _made(function: Function, loop: Loop, factor: int, roles: _Roles) -> Grouped | Refusal:
    if factor < 2 or factor & (factor - 1):  # noqa: PLR2004 - copies
        return Refusal("the factor is no power of two")
    if (reason := _objection(function, loop, roles)) is not None:
        return Refusal(reason)
    preheader = preheader_of(function, loop)
    function, trip = count_loop(function, loop, preheader)
    if trip is None:
        return Refusal(
            "its trip count is not known when it starts, as that of a loop over a range is"
        )
    return _Making(function, loop, factor, roles, preheader, trip.value).made()


def _objection(function: Function, loop: Loop, roles: _Roles) -> str | None:
    loops = find_loops(function)
    if any(other.header in loop.blocks and other.header != loop.header for other in loops):
        return "it contains another loop"
    if len(loop.exits) != 1 or loop.exits[0][0] != loop.header:
        return "it has exits in its body"
    read = _read_outside(function, loop)
    if read - {phi.id for phi in block_of(function, loop.header).phis} or read & roles.steps.keys():
        return "what its iterations count is read after it"
    return None


@dataclass(frozen=True)
class _Roles:
    """What the phis of a header are, by id: counters, and scalars that iterations add to; any other
    goes from one iteration to the next.
    """

    steps: Mapping[int, Induction]
    sums: Mapping[int, FoundReduction]


def _roles(function: Function, loop: Loop) -> _Roles:
    steps: dict[int, Induction] = {}
    sums: dict[int, FoundReduction] = {}
    read = _read_outside(function, loop)
    for phi in block_of(function, loop.header).phis:
        step = induction_of(function, loop.blocks, phi)
        found = reduction_of(function, loop, phi)
        if found is not None and (step is None or phi.id in read):
            sums[phi.id] = found
        elif step is not None:
            steps[phi.id] = step
    return _Roles(steps, sums)


def _read_outside(function: Function, loop: Loop) -> set[int]:
    """Ids of the loop's values that are read after it."""
    own = {i.id for b in function.blocks if b.name in loop.blocks for i in b.items}
    outside = (block for block in function.blocks if block.name not in loop.blocks)
    read = {v.id for block in outside for v in read_values(block) if isinstance(v, Ref)}
    return own & read


@dataclass
class _Making:
    """`sums`: the partial results of each sum, by its phi; `others`: what else the iterations
    before leave. `names`: of the blocks before each iteration of a group, and behind the last.
    """

    function: Function
    loop: Loop
    factor: int
    roles: _Roles
    preheader: str
    trip: Value
    blocks: list[Block] = field(default_factory=list)
    sums: dict[int, list[Value]] = field(default_factory=dict)
    others: dict[int, Value] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.ids = FreshIds(self.function)
        self.header = block_of(self.function, self.loop.header)
        self.latch = self.loop.latches[0]
        self.main = fresh_name(self.function, f"{self.loop.header}.groups")
        self.end = fresh_name(self.function, f"{self.loop.header}.done")
        taken = {block.name for block in self.function.blocks}
        stems = (f"{self.main}.before{number}" for number in range(self.factor))
        self.names = [first_free(taken, stem) for stem in (*stems, f"{self.main}.after")]
        self.loc = self.header.branch.loc

    def made(self) -> Grouped:
        """The function with the loop in place of the old one."""
        before, limits = self._before()
        phis = self._phis()
        start = (dict(self.others), {ident: list(parts) for ident, parts in self.sums.items()})
        main = self._main(limits[0])
        last = self._iterations(limits)
        main = replace(main, phis=(*self._closed(phis, last),))
        end, totals = self._end(*start)
        [(_, after)] = self.loop.exits
        entered = block_of(self.function, after)
        own = tuple(rename_incoming(phi, self.loop.header, self.end) for phi in entered.phis)
        self.function = with_blocks(
            self.function, (before, replace(entered, phis=own), main, *self.blocks, end)
        )
        kept = tuple(b for b in self.function.blocks if b.name not in self.loop.blocks)
        return Grouped(substitute(replace(self.function, blocks=kept), totals), self.main)

    def _before(self) -> tuple[Block, list[Value]]:
        """The preheader, with how often the new loop runs, and then below which iteration each but
        the first of its iterations runs.
        """
        shift = Const(self.factor.bit_length() - 1)
        instrs: list[Instr] = []
        trips = self._emit(instrs, Opcode.SMAX, self.trip, Const(0))
        last = self._emit(instrs, Opcode.ADD, trips, Const(WORD_MASK))
        groups = self._emit(instrs, Opcode.ASHR, last, shift)
        limits: list[Value] = [self._emit(instrs, Opcode.ADD, groups, Const(1))]
        for number in range(1, self.factor):
            limits.append(self._emit(instrs, Opcode.SUB, trips, Const(number)))
        block = block_of(self.function, self.preheader)
        branch = retarget(block.branch, self.loop.header, self.main)
        return replace(block, instrs=(*block.instrs, *instrs), branch=branch), limits

    def _phis(self) -> list[Phi]:
        """The phis of the header, without what iterations leave: first of all the counter."""
        phis = [Phi(self.ids("counter"), Type.I32, ((self.preheader, Const(0)),))]
        for phi in self.header.phis:
            first = incoming(phi, self.preheader)
            if phi.id not in self.roles.sums:
                made = Phi(self.ids(), phi.type, ((self.preheader, first),), phi.loc)
                self.others[phi.id] = Ref(made.id)
                phis.append(made)
                continue
            same = self.roles.sums[phi.id].how.identity
            starts = [first, *[first if same is None else Const(same)] * (self.factor - 1)]
            parts = [Phi(self.ids(), phi.type, ((self.preheader, s),), phi.loc) for s in starts]
            self.sums[phi.id] = [Ref(part.id) for part in parts]
            phis += parts
        return phis

    def _main(self, groups: Value) -> Block:
        """The header, which counts groups of iterations."""
        instrs: list[Instr] = []
        count = Ref(self.ids("counter"))
        test = self._emit(instrs, Opcode.ICMP_SLT, count, groups, kind=Type.PRED)
        self._emit(instrs, Opcode.ADD, count, Const(1), key="counted", exact=True)
        entry = self.names[0]
        return Block(self.main, (), tuple(instrs), Branch(entry, test, self.end, loc=self.loc))

    def _iterations(self, limits: list[Value]) -> str:
        """Writes the iterations of a group; the name of the block that ends them."""
        instrs: list[Instr] = []
        shift = Const(self.factor.bit_length() - 1)
        at = self._emit(instrs, Opcode.SHL, Ref(self.ids("counter")), shift)
        starts = {ident: self.others[ident] for ident in self.roles.steps}
        phis: tuple[Phi, ...] = ()
        for number in range(self.factor):
            for ident, step in self.roles.steps.items():
                self.others[ident] = self._stepped(instrs, starts[ident], step, number)
            given = {**self.others, **{i: parts[number] for i, parts in self.sums.items()}}
            clone = self._copied(given, number)
            entered = clone.names[self.loop.header]
            branch = Branch(entered, loc=self.loc)
            if number:
                test = self._emit(instrs, Opcode.ICMP_SLT, at, limits[number], kind=Type.PRED)
                branch = Branch(entered, test, self.names[number + 1], loc=self.loc)
            guard = Block(self.names[number], phis, tuple(instrs), branch)
            self.blocks += [guard, *clone.blocks]
            phis, instrs = self._joined(clone, number), []
        for ident, step in self.roles.steps.items():
            self.others[ident] = self._stepped(instrs, starts[ident], step, self.factor)
        name = self.names[self.factor]
        self.blocks.append(Block(name, phis, tuple(instrs), Branch(self.main, loc=self.loc)))
        return name

    def _stepped(self, into: list[Instr], start: Value, step: Induction, number: int) -> Value:
        """A counter so many iterations later; what it adds may wrap where the steps did not."""
        if not number:
            return start
        by: Value = step.by
        exact = step.update.exact
        if isinstance(by, Const):
            exact = exact and -_HALF <= signed(by.word) * number < _HALF
            by = Const(by.word * number & WORD_MASK)
        elif number > 1:
            by, exact = self._emit(into, Opcode.MUL, by, Const(number)), False
        return self._emit(into, step.update.opcode, start, by, exact=exact)

    def _copied(self, given: Mapping[int, Value], number: int) -> Clone:
        """One iteration, without the test in its header, that goes on to the next."""
        stem = f"group{number}"
        clone = clone_blocks(self.function, self.loop.blocks, given=given, stem=stem, ids=self.ids)
        first, last = clone.names[self.loop.header], clone.names[self.latch]
        made = []
        for block in clone.blocks:
            branch = block.branch
            if block.name == first:
                stays = next(n for n in branch.successors if n in clone.names.values())
                branch = Branch(stays, loc=branch.loc)
            if block.name == last:
                branch = retarget(branch, first, self.names[number + 1])
            made.append(replace(block, branch=branch))
        return replace(clone, blocks=tuple(made))

    def _joined(self, clone: Clone, number: int) -> tuple[Phi, ...]:
        """What an iteration leaves, or what was there before if it does not run."""
        phis: list[Phi] = []
        last = clone.names[self.latch]

        def joined(phi: Phi, old: Value) -> Value:
            new = clone.value(incoming(phi, self.latch))
            if not number or new == old:
                return new
            ways = ((last, new), (self.names[number], old))
            phis.append(Phi(self.ids(), phi.type, ways, phi.loc))
            return Ref(phis[-1].id)

        for phi in self.header.phis:
            if phi.id in self.sums:
                parts = self.sums[phi.id]
                parts[number] = joined(phi, parts[number])
            elif phi.id not in self.roles.steps:
                self.others[phi.id] = joined(phi, self.others[phi.id])
        return tuple(phis)

    def _closed(self, phis: list[Phi], last: str) -> list[Phi]:
        """The header's phis with what a group of iterations leaves."""
        left: list[Value] = [Ref(self.ids("counted"))]
        for phi in self.header.phis:
            left += self.sums.get(phi.id) or [self.others[phi.id]]
        closed = zip(phis, left, strict=True)
        return [replace(phi, incoming=(*phi.incoming, (last, value))) for phi, value in closed]

    def _end(
        self, others: Mapping[int, Value], sums: Mapping[int, list[Value]]
    ) -> tuple[Block, dict[int, Value]]:
        """The block that combines partial results, and what stands for the old loop's phis."""
        instrs: list[Instr] = []
        totals = dict(others)
        types = {phi.id: phi.type for phi in self.header.phis}
        for ident, parts in sums.items():
            how, left = self.roles.sums[ident].how, parts
            while len(left) > 1:
                pairs = zip(left[::2], left[1::2], strict=True)
                left = [self._combined(instrs, how, types[ident], *pair) for pair in pairs]
            [totals[ident]] = left
        [(_, after)] = self.loop.exits
        return Block(self.end, (), tuple(instrs), Branch(after, loc=self.loc)), totals

    def _combined(
        self, into: list[Instr], how: Reduction, kind: object, total: Value, partial: Value
    ) -> Value:
        assert isinstance(kind, Type)
        if how.taken is None:
            return self._emit(into, Opcode(how.op), total, partial, kind=kind)
        pair = (total, partial) if how.swapped else (partial, total)
        test = self._emit(into, Opcode(how.op), *pair, kind=Type.PRED)
        choice = (partial, total) if how.taken else (total, partial)
        return self._emit(into, Opcode.SELECT, test, *choice, kind=kind)

    def _emit(
        self,
        into: list[Instr],
        op: Opcode,
        *operands: Value,
        kind: Type = Type.I32,
        key: str = "",
        exact: bool = False,
    ) -> Ref:
        ident = self.ids(key) if key else self.ids()
        into.append(Instr(ident, op, kind, operands, exact=exact, loc=self.loc))
        return Ref(ident)
