"""Copies of a loop's iterations in front of it: peeling, and full unrolling as its limit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from vividc.ssa.edit import block_of, incoming, retarget, with_blocks
from vividc.ssa.flow import Loop, preheader_of
from vividc.ssa.ir import Block, Function, Value
from vividc.ssa.rewrite.clone import Clone, clone_blocks, extend_phis, repair_uses


@dataclass(frozen=True)
class Peeled:
    """`origin`: the block that each copy is one of, by name."""

    function: Function
    origin: Mapping[str, str]


def peel(function: Function, loop: Loop, iterations: int) -> Peeled:
    """The same function with the first iterations of `loop` copied in front of it.

    Each copy keeps its tests; what they decide is left to `simplify`, which also removes the loop
    if no copy leads into it any more. The loop has one preheader and one latch
    (`normalize.canonical_loops`).
    """
    header = block_of(function, loop.header)
    (latch,) = loop.latches
    last = preheader_of(function, loop)
    entering: dict[int, Value] = {phi.id: incoming(phi, last) for phi in header.phis}
    clones: list[Clone] = []
    for number in range(iterations):
        clone = clone_blocks(function, loop.blocks, given=entering, stem=f"peel{number}")
        clone = with_back_edge_to(clone, loop, loop.header)
        function = _jump(extend_phis(function, clone), last, loop.header, clone.names[loop.header])
        entering = {phi.id: clone.value(incoming(phi, latch)) for phi in header.phis}
        last = clone.names[latch]
        clones.append(clone)
    phis = tuple(
        replace(phi, incoming=((last, entering[phi.id]), (latch, incoming(phi, latch))))
        for phi in header.phis
    )
    function = with_blocks(function, (replace(block_of(function, loop.header), phis=phis),))
    origin = {new: old for clone in clones for old, new in clone.names.items()}
    return Peeled(repair_uses(function, loop.blocks, clones), origin)


def with_back_edge_to(clone: Clone, loop: Loop, target: str) -> Clone:
    """`clone` of `loop`, with the copied back edge leading to the block `target`."""
    copied = clone.names[loop.header]
    (latch,) = loop.latches

    def changed(block: Block) -> Block:
        if block.name != clone.names[latch]:
            return block
        return replace(block, branch=retarget(block.branch, copied, target))

    return replace(clone, blocks=tuple(changed(block) for block in clone.blocks))


def _jump(function: Function, source: str, old: str, new: str) -> Function:
    block = block_of(function, source)
    return with_blocks(function, (replace(block, branch=retarget(block.branch, old, new)),))
