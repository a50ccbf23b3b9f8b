"""Pointers that are null where nothing is accessed through them: LLVM makes them of a row that a
loop's last, empty step does not have.
"""

from __future__ import annotations

from dataclasses import replace

from vividc.ssa.edit import substitute
from vividc.ssa.ir import Function, Instr, Int, Named, Phi, Ref, Value
from vividc.ssa.rewrite.dead import remove_unused

_OBSERVES = frozenset({"icmp", "ptrtoint", "ptrtoaddr"})


def drop_null_choices(function: Function) -> Function:
    """A choice between a pointer and null is the pointer, as an access through null is undefined;
    where two ways meet, of which one brings null, it brings the start of the other's array.

    Not where the function looks at addresses: it may ask which of the two it was.
    """
    if any(_observes(op) for block in function.blocks for op in block.instrs):
        return function
    function = _drop_null_merges(function)
    chosen = {
        op.id: pointer
        for block in function.blocks
        for op in block.instrs
        if (pointer := _only_pointer(op)) is not None
    }
    if not chosen:
        return function
    return remove_unused(substitute(function, {name: _last(chosen, name) for name in chosen}))


def _drop_null_merges(function: Function) -> Function:
    definitions = function.definitions

    def start(pointer: Value) -> Named | None:
        """The parameter that a pointer points into, where no other choice lies between."""
        while isinstance(pointer, Named):
            definition = definitions.get(pointer.key)
            if definition is None:
                return pointer
            if not isinstance(definition, Instr) or definition.op != "getelementptr":
                return None
            pointer = definition.operands[0]
        return None

    def without_null(phi: Phi) -> Phi:
        if phi.type != "ptr" or not any(isinstance(value, Int) for _, value in phi.incoming):
            return phi
        arrays = {start(value) for _, value in phi.incoming if not isinstance(value, Int)}
        array = arrays.pop() if len(arrays) == 1 else None
        if array is None:
            return phi
        incoming = ((pred, array if isinstance(v, Int) else v) for pred, v in phi.incoming)
        return replace(phi, incoming=tuple(incoming))

    if not any(phi.type == "ptr" for block in function.blocks for phi in block.phis):
        return function
    blocks = (
        replace(block, phis=tuple(without_null(phi) for phi in block.phis))
        for block in function.blocks
    )
    return replace(function, blocks=tuple(blocks))


def _observes(op: Instr) -> bool:
    return op.op in _OBSERVES and (op.op != "icmp" or op.type == "ptr")


def _only_pointer(op: Instr) -> Named | None:
    if op.op != "select" or op.type != "ptr":
        return None
    pointers = [arg for arg in op.operands[1:] if isinstance(arg, Named)]
    nulls = [arg for arg in op.operands[1:] if isinstance(arg, Int)]
    return pointers[0] if len(pointers) == len(nulls) == 1 else None


def _last(chosen: dict[int, Named], id_: int) -> Value:
    """What the choice stands for in the end: one choice may be of another."""
    pointer = chosen[id_]
    while isinstance(pointer, Ref) and pointer.id in chosen:
        pointer = chosen[pointer.id]
    return pointer
