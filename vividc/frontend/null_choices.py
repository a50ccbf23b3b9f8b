"""Pointers that are null where nothing is accessed through them: LLVM makes them of a row that a
loop's last, empty step does not have.
"""

from __future__ import annotations

from vividc.frontend.ssa import Int, Local, Op, Operand, WideFunction, remove_dead, substitute

_OBSERVES = frozenset({"icmp", "ptrtoint", "ptrtoaddr"})


def drop_null_choices(function: WideFunction) -> WideFunction:
    """A choice between a pointer and null is the pointer, as an access through null is undefined.

    Not where the function looks at addresses: it may ask which of the two it was.
    """
    if any(_observes(op) for block in function.blocks for op in block.ops):
        return function
    chosen = {
        op.name: pointer
        for block in function.blocks
        for op in block.ops
        if (pointer := _only_pointer(op)) is not None
    }
    if not chosen:
        return function
    return remove_dead(substitute(function, {name: _last(chosen, name) for name in chosen}))


def _observes(op: Op) -> bool:
    return op.op in _OBSERVES and (op.op != "icmp" or op.type == "ptr")


def _only_pointer(op: Op) -> Local | None:
    if op.op != "select" or op.type != "ptr":
        return None
    pointers = [arg for arg in op.args[1:] if isinstance(arg, Local)]
    nulls = [arg for arg in op.args[1:] if isinstance(arg, Int)]
    return pointers[0] if len(pointers) == len(nulls) == 1 else None


def _last(chosen: dict[str, Local], name: str) -> Operand:
    """What the name stands for in the end: one choice may be of another."""
    pointer = chosen[name]
    while pointer.name in chosen:
        pointer = chosen[pointer.name]
    return pointer
