"""Rotation of a loop: the test for the next iteration is made at the end of this one.

The loop keeps the test in its header, which now fails only if the loop is entered with nothing to
do. An iteration then knows that it is the last, which is what flattening needs: the code after the
loop can run in the same iteration.
"""

from __future__ import annotations

from dataclasses import replace

from vividc.machine.opcodes import MEMORY, Opcode, Type
from vividc.ssa.analysis.counters import Counter, counter_of, defined_in, moved_limit
from vividc.ssa.edit import (
    block_of,
    defined_types,
    fresh_name,
    incoming,
    map_values,
    next_id,
    read_values,
    rename_incoming,
    retarget,
    with_blocks,
)
from vividc.ssa.flow import Loop, preheader_of
from vividc.ssa.ir import Block, Branch, Const, Function, Instr, Phi, Ref, Undefined, Value
from vividc.ssa.rewrite.clone import clone_blocks, repair_uses


def rotate(function: Function, loop: Loop, outer: Loop) -> Function:
    """The same function with `loop` rotated; the same object where its header does not test, or
    loads or stores, or is the whole loop.

    A loop that ends by a counter alone compares the counter of this iteration with a limit that is
    moved by one step, so that the comparison does not wait for the step (height reduction).

    Parameters
    ----------
    loop
        A loop inside `outer`; both have one preheader and one latch (`normalize.canonical_loops`).
        The moved limit is computed before `outer` if it does not change there.
    """
    if not can_rotate(function, loop):
        return function
    counter = counter_of(function, loop)
    if counter is not None and [source for source, _ in loop.exits] == [loop.header]:
        return _Counted(function, loop, counter, outer).run()
    return _by_copied_test(function, loop)


def can_rotate(function: Function, loop: Loop) -> bool:
    """Whether the header tests whether to leave, without loads and stores, before the body."""
    header = block_of(function, loop.header)
    leaving = [name for name in header.branch.successors if name not in loop.blocks]
    if len(leaving) != 1 or header.branch.cond is None or loop.latches == (header.name,):
        return False
    return not any(instr.op in MEMORY for instr in header.instrs)


def _by_copied_test(function: Function, loop: Loop) -> Function:
    """A copy of the header at the end of the loop."""
    function = _with_own_latch_values(function, loop)
    header = block_of(function, loop.header)
    (latch,) = loop.latches
    given = {phi.id: incoming(phi, latch) for phi in header.phis}
    clone = clone_blocks(function, {header.name}, given=given, stem="next")
    (test,) = clone.blocks
    [stays] = [name for name in header.branch.successors if name in loop.blocks]
    [target] = [name for name in header.branch.successors if name not in loop.blocks]
    test = replace(test, branch=retarget(test.branch, stays, header.name))
    changed = {block.name: block for block in function.blocks}
    changed[latch] = replace(
        changed[latch], branch=retarget(changed[latch].branch, header.name, test.name)
    )
    changed[header.name] = replace(
        header, phis=tuple(rename_incoming(phi, latch, test.name) for phi in header.phis)
    )
    changed[target] = replace(
        changed[target],
        phis=tuple(
            replace(
                phi,
                incoming=(*phi.incoming, (test.name, clone.value(incoming(phi, header.name)))),
            )
            for phi in changed[target].phis
        ),
    )
    function = with_blocks(function, (*changed.values(), test))
    return repair_uses(function, {header.name}, [clone])


def _with_own_latch_values(function: Function, loop: Loop) -> Function:
    """Copies, in the latch, of values that the header defines and hands on to its own phis: a
    repair of SSA would take them for the values of the next visit.
    """
    header = block_of(function, loop.header)
    (latch,) = loop.latches
    own = defined_types(header)
    read = dict.fromkeys(
        value.id
        for value in (incoming(phi, latch) for phi in header.phis)
        if isinstance(value, Ref) and value.id in own
    )
    if not read:
        return function
    free = next_id(function)
    copies: dict[int, Value] = {old: Ref(free + number) for number, old in enumerate(read)}
    moves = tuple(
        Instr(free + number, Opcode.MOV, own[old], (Ref(old),)) for number, old in enumerate(read)
    )

    def copied(name: str, value: Value) -> Value:
        return copies.get(value.id, value) if name == latch and isinstance(value, Ref) else value

    phis = tuple(
        replace(phi, incoming=tuple((name, copied(name, value)) for name, value in phi.incoming))
        for phi in header.phis
    )
    function = with_blocks(function, (replace(header, phis=phis),))
    block = block_of(function, latch)
    return with_blocks(function, (replace(block, instrs=(*block.instrs, *moves)),))


class _Counted:
    """Rotates a loop that ends by its counter alone: body and no body join before the next test.

    header: c = j < limit, t = j < moved limit; if c: body
    join:   what is left behind; if t: header, else out
    """

    def __init__(self, function: Function, loop: Loop, counter: Counter, outer: Loop) -> None:
        self.function = function
        self.loop = loop
        self.counter = counter
        self.outer = outer
        self.header = block_of(function, loop.header)
        (self.latch,) = loop.latches
        ((_, self.target),) = loop.exits
        self.free = next_id(function)
        self.used = used_outside(function, loop)

    def run(self) -> Function:
        """The rotated loop."""
        header = self.header
        limit = self._place_limit()
        pair = (Ref(self.counter.phi.id), limit)
        operands = pair if self.counter.step > 0 else pair[::-1]
        test = Instr(self._id(), Opcode.ICMP_SLT, Type.PRED, operands, loc=header.branch.loc)
        join = fresh_name(self.function, f"{header.name}.join")
        back = fresh_name(self.function, f"{header.name}.back")
        out = fresh_name(self.function, f"{header.name}.out")
        left, carried = self._phis_of_join()
        phis = tuple(
            replace(
                phi,
                incoming=tuple(
                    (back, carried[phi.id]) if name == self.latch else (name, value)
                    for name, value in phi.incoming
                ),
            )
            for phi in header.phis
        )
        instrs, names = self._left_behind(left)
        branch = retarget(header.branch, self.target, join)
        latch = block_of(self.function, self.latch)
        changed = {latch.name: replace(latch, branch=retarget(latch.branch, header.name, join))}
        changed[header.name] = replace(
            header, phis=phis, instrs=(*header.instrs, test), branch=branch
        )
        loc = header.branch.loc
        new = (
            Block(join, tuple(self.joined), (), Branch(back, Ref(test.id), out, loc=loc)),
            Block(back, (), (), Branch(header.name, loc=loc)),
            Block(out, (), instrs, Branch(self.target, loc=loc)),
        )
        outside = self._outside(out, names)
        return with_blocks(self.function, (*outside, *changed.values(), *new))

    def _id(self) -> int:
        self.free += 1
        return self.free - 1

    def _place_limit(self) -> Value:
        """Computes the moved limit before the loop."""
        value: Value = self.counter.limit
        steps = moved_limit(self.counter)
        if isinstance(value, Const):
            return _folded(value, steps)
        place = block_of(self.function, self._place_of(value))
        instrs = []
        for op, word in steps:
            operands = (value, Const(word & 0xFFFFFFFF))
            instrs.append(Instr(self._id(), op, Type.I32, operands, loc=self.header.branch.loc))
            value = Ref(instrs[-1].id)
        place = replace(place, instrs=(*place.instrs, *instrs))
        self.function = with_blocks(self.function, (place,))
        return value

    def _place_of(self, limit: Value) -> str:
        """The preheader of the outermost of the two loops that `limit` does not change in."""
        inside = defined_in(self.function, self.outer)
        varies = isinstance(limit, Ref) and limit.id in inside
        return preheader_of(self.function, self.loop if varies else self.outer)

    def _phis_of_join(self) -> tuple[dict[int, Value], dict[int, Value]]:
        """What each header phi leaves behind, and what it carries on.

        Where the loop goes on, the body has run. A float that is also left behind is carried
        through the same phi: one select, or one predicated operation, does for both. A counter is
        not, lest its recurrence get longer.
        """
        self.joined: list[Phi] = []
        left: dict[int, Value] = {}
        carried: dict[int, Value] = {}
        for phi in self.header.phis:
            ahead = incoming(phi, self.latch)
            if self.used:
                left[phi.id] = self._joined(phi, Ref(phi.id), ahead)
            if self.used and phi.type is Type.F32:
                carried[phi.id] = left[phi.id]
            else:
                carried[phi.id] = self._joined(phi, Undefined(), ahead)
        return left, carried

    def _joined(self, phi: Phi, idle: Value, ahead: Value) -> Value:
        own = {instr.id for instr in self.header.instrs}
        anyway = isinstance(ahead, Ref) and ahead.id in own
        if idle == ahead or (isinstance(idle, Undefined) and anyway):
            return ahead
        new = Phi(self._id(), phi.type, ((self.header.name, idle), (self.latch, ahead)), phi.loc)
        self.joined.append(new)
        return Ref(new.id)

    def _left_behind(self, left: dict[int, Value]) -> tuple[tuple[Instr, ...], dict[int, Value]]:
        """The header's instructions on the words left behind, and what stands for its ids."""
        if not self.used:
            return (), {}
        names = dict(left)
        instrs = []
        for instr in self.header.instrs:
            operands = tuple(
                names.get(value.id, value) if isinstance(value, Ref) else value
                for value in instr.operands
            )
            instrs.append(replace(instr, id=self._id(), operands=operands))
            names[instr.id] = Ref(instrs[-1].id)
        return tuple(instrs), names

    def _outside(self, out: str, names: dict[int, Value]) -> list[Block]:
        """The blocks outside the loop, which read what it leaves behind."""

        def change(value: Value) -> Value:
            return names.get(value.id, value) if isinstance(value, Ref) else value

        changed = []
        for block in self.function.blocks:
            if block.name in self.loop.blocks:
                continue
            phis = block.phis
            if block.name == self.target:
                phis = tuple(rename_incoming(phi, self.header.name, out) for phi in phis)
            changed.append(map_values(replace(block, phis=phis), change))
        return changed


def _folded(limit: Const, steps: tuple[tuple[Opcode, int], ...]) -> Const:
    value = limit.word - (1 << 32) if limit.word >> 31 else limit.word
    for op, word in steps:
        if op is Opcode.ADD:
            value += word
        else:
            value = max(value, word) if op is Opcode.SMAX else min(value, word)
    return Const(value & 0xFFFFFFFF)


def used_outside(function: Function, loop: Loop) -> bool:
    """Whether a value of the loop is read outside it."""
    inside = defined_in(function, loop)
    return any(
        isinstance(value, Ref) and value.id in inside
        for block in function.blocks
        if block.name not in loop.blocks
        for value in read_values(block)
    )
