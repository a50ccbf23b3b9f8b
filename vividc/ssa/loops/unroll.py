"""Unrolling of counted loops by a factor, with the loop itself for the iterations left over."""

from __future__ import annotations

from dataclasses import dataclass, replace

from vividc.machine.opcodes import Opcode, Type
from vividc.ssa.analysis.counted import count_loop
from vividc.ssa.edit import block_of, fresh_name, incoming, next_id, retarget, with_blocks
from vividc.ssa.flow import Loop, find_loops, preheader_of
from vividc.ssa.ir import Block, Branch, Const, Function, Instr, Phi, Ref, Value
from vividc.ssa.rewrite.clone import Clone, clone_blocks, extend_phis, repair_uses
from vividc.ssa.rewrite.peel import with_back_edge_to
from vividc.ssa.rewrite.refusal import Refusal


@dataclass(frozen=True)
class Unrolled:
    """`main` is the header of the new loop, `rest` that of the loop for what is left over."""

    function: Function
    main: str
    rest: str


@dataclass(frozen=True)
class _MainLoop:
    """A loop put before another, still without a body: `header` counts to trips >> log2(factor).

    Attributes
    ----------
    function
        With the header, which is entered instead of the old loop and leaves to it.
    values
        The new header's phi for each header phi of the old loop.
    """

    function: Function
    header: str
    values: dict[int, Value]


def unroll(function: Function, loop: Loop, factor: int) -> Unrolled | Refusal:
    """Runs `factor` iterations of an innermost loop as one, then the rest one by one.

    The copies make no test of the count, but keep their other exits. The loop has one preheader and
    one latch.
    """
    if factor < 2 or factor & (factor - 1):  # noqa: PLR2004 - copies
        return Refusal("the factor is no power of two")
    if _holds_another(function, loop):
        return Refusal("it contains another loop")
    made = _main_loop(function, loop, factor)
    if isinstance(made, Refusal):
        return made
    function, entering = made.function, dict(made.values)
    header = block_of(function, loop.header)
    (latch,) = loop.latches
    last, clones = made.header, list[Clone]()
    for number in range(factor):
        clone = clone_blocks(function, loop.blocks, given=entering, stem=f"unroll{number}")
        clone = with_back_edge_to(_untested(clone, loop), loop, made.header)
        inner = clone.names[loop.header]
        function = _enter(extend_phis(function, clone), last, made.header, inner)
        entering = {phi.id: clone.value(incoming(phi, latch)) for phi in header.phis}
        last = clone.names[latch]
        clones.append(clone)
    function = _close_main_loop(function, made, last, entering)
    return Unrolled(repair_uses(function, loop.blocks, clones), made.header, loop.header)


def _main_loop(function: Function, loop: Loop, factor: int) -> _MainLoop | Refusal:
    """A header before `loop` that is to run `factor` iterations at a time.

    Its body has to be put in with `_close_main_loop`; until then its branch goes to itself.
    """
    preheader = preheader_of(function, loop)
    function, trip = count_loop(function, loop, preheader)
    if trip is None:
        return Refusal(
            "its trip count is not known when it starts, as that of a loop over a range is"
        )
    header = block_of(function, loop.header)
    name = fresh_name(function, f"{loop.header}.main")
    free = next_id(function)
    limit, count, test = Ref(free), Ref(free + 1), Ref(free + 2)
    shift = Const(factor.bit_length() - 1)
    loc = header.branch.loc
    total = Instr(limit.id, Opcode.ASHR, Type.I32, (trip.value, shift), loc=loc)
    before = block_of(function, preheader)
    before = replace(
        before,
        instrs=(*before.instrs, total),
        branch=retarget(before.branch, loop.header, name),
    )
    phis = [Phi(count.id, Type.I32, ((preheader, Const(0)),))]
    values: dict[int, Value] = {}
    kept = []
    for number, phi in enumerate(header.phis, start=free + 3):
        phis.append(Phi(number, phi.type, ((preheader, incoming(phi, preheader)),), phi.loc))
        values[phi.id] = Ref(number)
        rest = tuple(item for item in phi.incoming if item[0] != preheader)
        kept.append(replace(phi, incoming=((name, Ref(number)), *rest)))
    compare = Instr(test.id, Opcode.ICMP_SLT, Type.PRED, (count, limit), loc=loc)
    main = Block(name, tuple(phis), (compare,), Branch(name, test, loop.header, loc=loc))
    function = with_blocks(function, (before, replace(header, phis=tuple(kept)), main))
    return _MainLoop(function, name, values)


def _close_main_loop(
    function: Function, made: _MainLoop, latch: str, carried: dict[int, Value]
) -> Function:
    """The main loop's phis get what the body leaves: `carried`, by the old loop's phis."""
    header = block_of(function, made.header)
    counter, *others = header.phis
    step = Instr(next_id(function), Opcode.ADD, Type.I32, (Ref(counter.id), Const(1)), exact=True)
    values = {new.id: carried[old] for old, new in _refs(made.values)}
    phis = [replace(counter, incoming=(*counter.incoming, (latch, Ref(step.id))))]
    phis += [replace(phi, incoming=(*phi.incoming, (latch, values[phi.id]))) for phi in others]
    header = replace(header, phis=tuple(phis), instrs=(*header.instrs, step))
    return with_blocks(function, (header,))


def _untested(clone: Clone, loop: Loop) -> Clone:
    """`clone` of a counted loop whose header goes on into the body without a test."""
    copied = set(clone.names.values())

    def changed(block: Block) -> Block:
        if block.name != clone.names[loop.header]:
            return block
        stays = next(name for name in block.branch.successors if name in copied)
        return replace(block, branch=Branch(stays, loc=block.branch.loc))

    return replace(clone, blocks=tuple(changed(block) for block in clone.blocks))


def _refs(values: dict[int, Value]) -> list[tuple[int, Ref]]:
    return [(old, new) for old, new in values.items() if isinstance(new, Ref)]


def _enter(function: Function, source: str, old: str, new: str) -> Function:
    block = block_of(function, source)
    return with_blocks(function, (replace(block, branch=retarget(block.branch, old, new)),))


def _holds_another(function: Function, loop: Loop) -> bool:
    return any(
        other.header in loop.blocks and other.header != loop.header
        for other in find_loops(function)
    )
