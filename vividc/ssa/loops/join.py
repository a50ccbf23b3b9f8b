"""A loop that runs once around two loops that follow one another, so that they are one nest."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from vividc.machine.opcodes import Opcode, Type
from vividc.ssa.edit import (
    FreshIds,
    block_of,
    defined_types,
    first_free,
    read_values,
    rename_incoming,
    retarget,
)
from vividc.ssa.flow import Loop, predecessors, preheader_of
from vividc.ssa.ir import Block, Branch, Const, Function, Instr, Phi, Ref
from vividc.ssa.rewrite.refusal import Refusal


@dataclass(frozen=True)
class Joined:
    """A function with a loop at `header` around others."""

    function: Function
    header: str


def between(function: Function, first: Loop, second: Loop) -> tuple[str, ...] | None:
    """The blocks that lead from one loop to another and nowhere else; None if there are others."""
    if len(first.exits) != 1:
        return None
    found: list[str] = []
    [(last, name)] = first.exits
    while name != second.header:
        branch = block_of(function, name).branch
        if predecessors(function)[name] != (last,) or len(branch.successors) != 1 or name in found:
            return None
        found.append(name)
        last, name = name, branch.successors[0]
    return tuple(found)


def join(function: Function, first: Loop, second: Loop) -> Joined | Refusal:
    """Puts two loops, one right after the other, into a loop that runs once."""
    middle = between(function, first, second)
    if middle is None:
        return Refusal("they do not follow one another")
    if second.exits != ((second.header, second.exits[0][1]),):
        return Refusal("a loop has exits in its body")
    inside = first.blocks | second.blocks | set(middle)
    if _read_outside(function, inside):
        return Refusal("a value of theirs is read after them")
    return _Writer(function, first, second, inside).joined()


def _read_outside(function: Function, inside: Iterable[str]) -> bool:
    """Whether another block reads a value of these."""
    names = set(inside)
    made = {i for block in function.blocks if block.name in names for i in defined_types(block)}
    return any(
        isinstance(value, Ref) and value.id in made
        for block in function.blocks
        if block.name not in names
        for value in read_values(block)
    )


@dataclass(frozen=True)
class _Writer:
    function: Function
    first: Loop
    second: Loop
    inside: frozenset[str]

    def joined(self) -> Joined:
        """The function with the loop around."""
        before = preheader_of(self.function, self.first)
        after = self.second.exits[0][1]
        taken = {block.name for block in self.function.blocks}
        header = first_free(taken, "both")
        body, latch = (first_free(taken, f"{header}.{stem}") for stem in ("body", "latch"))
        loc = block_of(self.function, self.first.header).branch.loc
        ids = FreshIds(self.function)
        counter, test, following = ids(), ids(), ids()
        phi = Phi(counter, Type.I32, ((before, Const(0)), (latch, Ref(following))), loc)
        runs = Instr(test, Opcode.ICMP_SLT, Type.PRED, (Ref(counter), Const(1)), loc=loc)
        step = (Ref(counter), Const(1))
        more = Instr(following, Opcode.ADD, Type.I32, step, exact=True, loc=loc)
        own = [
            Block(header, (phi,), (runs,), Branch(body, Ref(test), after, loc=loc)),
            Block(body, (), (), Branch(self.first.header, loc=loc)),
            Block(latch, (), (more,), Branch(header, loc=loc)),
        ]
        blocks: list[Block] = []
        for block in self.function.blocks:
            if block.name == self.first.header:
                blocks += own
            branch, phis = block.branch, block.phis
            if block.name == before:
                branch = retarget(branch, self.first.header, header)
            if block.name == self.first.header:
                phis = tuple(rename_incoming(phi, before, body) for phi in phis)
            if block.name == self.second.header:
                branch = retarget(branch, after, latch)
            if block.name == after:
                phis = tuple(rename_incoming(phi, self.second.header, header) for phi in phis)
            blocks.append(replace(block, branch=branch, phis=phis))
        return Joined(replace(self.function, blocks=tuple(blocks)), header)
