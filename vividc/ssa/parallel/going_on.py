"""Loops that an error of the simulation leaves go on behind it, so that they have one way out:
nobody sees what they do then.
"""

from __future__ import annotations

from dataclasses import replace

from vividc.machine.opcodes import Opcode
from vividc.ssa.edit import FreshIds, fresh_name, incoming, retarget, with_blocks
from vividc.ssa.flow import find_loops
from vividc.ssa.ir import Block, Branch, Function
from vividc.ssa.parallel.spread_proof import ends_simulation
from vividc.ssa.rewrite.blocks import remove_unreachable_blocks


def going_on(function: Function) -> Function:
    """The function whose loops are not left where they store to an array of no words, which ends
    the simulation: where slices of different sizes meet, say.
    """
    ends = {block.name: block for block in function.blocks if _is_error(block)}
    loops = find_loops(function) if ends else ()
    ids, given = FreshIds(function), function
    for block in given.blocks:
        out = [name for name in block.branch.successors if name in ends]
        stays = [name for name in block.branch.successors if name not in ends]
        if len(out) == len(stays) == 1 and any({block.name, *stays} <= one.blocks for one in loops):
            function = _bent(function, block.name, ends[out[0]], stays[0], ids)
    return function if function is given else remove_unreachable_blocks(function)


def _bent(function: Function, source: str, end: Block, stays: str, ids: FreshIds) -> Function:
    """The function that goes on, behind what a way out stores, where the block stays."""
    through = fresh_name(function, f"{source}.error")
    stores = tuple(replace(instr, id=ids()) for instr in end.instrs)
    made = Block(through, (), stores, Branch(stays, loc=end.branch.loc))
    block, target = function.by_name[source], function.by_name[stays]
    phis = tuple(
        replace(phi, incoming=(*phi.incoming, (through, incoming(phi, source))))
        for phi in target.phis
    )
    changed = replace(block, branch=retarget(block.branch, end.name, through))
    return with_blocks(function, (changed, replace(target, phis=phis), made))


def _is_error(block: Block) -> bool:
    """Whether a block does nothing but end the simulation with an error."""
    return (
        block.branch.target is None
        and not block.phis
        and ends_simulation(block)
        and all(instr.op is Opcode.STORE for instr in block.instrs)
    )
