"""Removal of operations that nothing reads, from functions."""

from __future__ import annotations

from dataclasses import replace

from vividc.machine.opcodes import MEMORY
from vividc.ssa.edit import uses
from vividc.ssa.ir import Function, Ref


def without_dead(function: Function) -> Function:
    """Without operations that nothing reads; accesses to memory and phis stay."""
    while True:
        read = {
            value.id
            for block in function.blocks
            for value in (
                *uses(block),
                *(value for phi in block.phis for _, value in phi.incoming),
            )
            if isinstance(value, Ref)
        }
        blocks = tuple(
            replace(b, instrs=tuple(i for i in b.instrs if i.id in read or i.op in MEMORY))
            for b in function.blocks
        )
        if blocks == function.blocks:
            return function
        function = replace(function, blocks=blocks)
