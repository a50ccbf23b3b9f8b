"""Sums that begin with what they are added to: of `a[i, j] -= x @ y` the sum of products begins
with a[i, j], from which each product is taken, as loops by hand do.

It rounds otherwise: only where sums of floats may be reassociated. What began with 0 needs no
operation behind its loop, and may wait in the element where it is stored in the end.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import Final

from vividc.machine.opcodes import MEMORY, Opcode
from vividc.ssa.edit import read_values, replaced, with_blocks
from vividc.ssa.flow import Loop, find_loops, flow_of, predecessors, preheader_of
from vividc.ssa.ir import Block, Const, Function, Instr, Phi, Ref, Value, definition_of

_ZEROS: Final = (Const(0), Const(0x80000000))

_TAKEN: Final = {Opcode.FADD: Opcode.FSUB, Opcode.FMA: Opcode.FNMA}
"""What takes from a sum what an operation adds."""


def begun_sums(function: Function) -> Function:
    """The function with the sums of its loops begun so."""
    for header in [loop.header for loop in find_loops(function)]:
        for phi in function.by_name[header].phis:
            loop = next(one for one in find_loops(function) if one.header == header)
            function = _begun(function, loop, phi) or function
    return function


def _begun(function: Function, loop: Loop, phi: Phi) -> Function | None:
    """With the sum that a phi is begun with what is added to it behind the loop."""
    starts = [name for name, value in phi.incoming if value in _ZEROS and name not in loop.blocks]
    sums = [value for name, value in phi.incoming if name in loop.blocks]
    added = _addition(function, sums[0], phi) if len(starts) == len(sums) == 1 else None
    if added is None or len(phi.incoming) != len(starts) + len(sums):
        return None
    uses = Counter(value for block in function.blocks for value in read_values(block))
    last = _last(function, phi, added)
    if last is None or uses[Ref(phi.id)] != len((added, last)) or uses[Ref(added.id)] != 1:
        return None
    start = next(value for value in last.operands if value != Ref(phi.id))
    if function.block_of[last.id] in loop.blocks:
        return None
    if not _is_before(function, start, loop):
        moved = _loaded_before(function, start, loop)
        return None if moved is None else _begun(moved, loop, phi)
    terms = tuple(value for value in added.operands if value != Ref(phi.id))
    is_product = added.op is Opcode.FMA
    operands = (*terms, Ref(phi.id)) if is_product else (Ref(phi.id), *terms)
    op = _TAKEN[added.opcode] if last.op is Opcode.FSUB else added.op
    summed = replace(added, op=op, operands=operands)
    incoming = tuple((name, start if name in starts else value) for name, value in phi.incoming)
    changed: list[Block] = []
    for name in (loop.header, function.block_of[added.id]):
        block = next((one for one in changed if one.name == name), function.by_name[name])
        phis = tuple(replace(p, incoming=incoming) if p.id == phi.id else p for p in block.phis)
        instrs = tuple(summed if one.id == added.id else one for one in block.instrs)
        changed = [one for one in changed if one.name != name]
        changed.append(replace(block, phis=phis, instrs=instrs))
    return replaced(with_blocks(function, changed), {last.id: Ref(phi.id)})


def _addition(function: Function, value: Value, phi: Phi) -> Instr | None:
    """What adds a number or a product to a phi."""
    made = definition_of(function, value)
    if not isinstance(made, Instr) or made.op not in _TAKEN:
        return None
    places = [place for place, one in enumerate(made.operands) if one == Ref(phi.id)]
    return made if places in ([[2]] if made.op is Opcode.FMA else [[0], [1]]) else None


def _last(function: Function, phi: Phi, added: Instr) -> Instr | None:
    """What the sum is added to, or taken from."""
    for block in function.blocks:
        for one in block.instrs:
            if one.id == added.id or one.operands.count(Ref(phi.id)) != 1:
                continue
            is_taken = one.op is Opcode.FSUB and one.operands[1] == Ref(phi.id)
            return one if one.op is Opcode.FADD or is_taken else None
    return None


def _loaded_before(function: Function, start: Value, loop: Loop) -> Function | None:
    """With what is loaded right behind a loop loaded before it; None if it may be stored between,
    or where it lies is not known before.
    """
    load, entry = definition_of(function, start), preheader_of(function, loop)
    exits = {target for _, target in loop.exits}
    if not isinstance(load, Instr) or load.op is not Opcode.LOAD:
        return None
    home = function.by_name[function.block_of[load.id]]
    follows = exits == {home.name} and predecessors(function)[home.name] == (loop.header,)
    if not follows or len(function.by_name[entry].branch.successors) != 1:
        return None
    needed = _needed(function, load, home, loop)
    passed = [i for name in loop.blocks for i in function.by_name[name].instrs]
    passed += home.instrs[: home.instrs.index(load)]
    if needed is None or any(i.op is Opcode.STORE and i.array == load.array for i in passed):
        return None
    rest = tuple(instr for instr in home.instrs if instr not in needed)
    before = function.by_name[entry]
    changed = [replace(home, instrs=rest), replace(before, instrs=(*before.instrs, *needed))]
    return with_blocks(function, changed)


def _needed(function: Function, load: Instr, home: Block, loop: Loop) -> list[Instr] | None:
    """A load and what its block computes for it; None if it needs what the loop leaves."""
    needed = [load]
    for instr in reversed(home.instrs[: home.instrs.index(load)]):
        if any(Ref(instr.id) in other.operands for other in needed):
            needed.insert(0, instr)
    own = {Ref(instr.id) for instr in needed}
    values = {value for instr in needed for value in instr.operands} - own
    is_pure = all(instr.op not in MEMORY for instr in needed[:-1])
    return needed if is_pure and all(_is_before(function, v, loop) for v in values) else None


def _is_before(function: Function, value: Value, loop: Loop) -> bool:
    """Whether a value is there when a loop begins."""
    if not isinstance(value, Ref):
        return True
    home = function.block_of[value.id]
    return home not in loop.blocks and flow_of(function).dominates(home, loop.header)
