"""Carries an element that all iterations of a loop load and store in a register.

`y[i] += a[i, j] * x[j]` is a recurrence through memory, three cycles longer than through a
register. The element is loaded before the loop, under a predicate that the loop runs at all, and
stored after it (register promotion: Lu and Cooper, 1997).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from vividc.machine.opcodes import MEMORY, Opcode, Type
from vividc.machine.words import WORD_BYTES
from vividc.ssa.edit import block_of, defined_types, substitute, with_blocks
from vividc.ssa.flow import Loop, find_loops, pipelined_loops, predecessors
from vividc.ssa.ir import Block, Function, Input, Instr, Phi, Ref, Value
from vividc.ssa.polyhedral.distances.linear import Distances, Place
from vividc.ssa.polyhedral.distances.meetings import Meetings
from vividc.ssa.rewrite.hoist_loads import Preface

_LOAD, _STORE = 2, 3
"""Operands of accesses without a predicate."""

_NEVER = Distances()


def carry_elements(function: Function) -> Function:
    """Carries elements at fixed addresses in registers, through innermost loops of one block behind
    their test.

    The function is normalised, and so is the result.
    """
    for header in [loop.header for loop in pipelined_loops(function)]:
        while True:
            loop = next(item for item in find_loops(function) if item.header == header)
            done = _carried(function, loop)
            if done is None:
                break
            function = done
    return function


def _carried(function: Function, loop: Loop) -> Function | None:
    """The function with the first such element of a loop in a register."""
    header = block_of(function, loop.header)
    if len(loop.blocks) != 2 or len(loop.exits) != 1 or loop.exits[0][0] != header.name:  # noqa: PLR2004 - header, body
        return None
    after = block_of(function, loop.exits[0][1])
    [body] = (block_of(function, name) for name in loop.blocks if name != header.name)
    outside = set(predecessors(function)[header.name]) - {body.name}
    alone = predecessors(function)[after.name] == (header.name,)
    if len(outside) != 1 or not alone or any(instr.op in MEMORY for instr in header.instrs):
        return None
    for group in _groups(function, loop, body):
        if _is_apart(function, loop, body, group):
            return _in_register(Preface(function, loop), header, body, after, group)
    return None


def _groups(function: Function, loop: Loop, body: Block) -> Iterator[list[Instr]]:
    """Accesses of a word at one address that does not change, a load first, with a store."""
    inside = {i for name in loop.blocks for i in defined_types(block_of(function, name))}
    found: dict[object, list[Instr]] = {}
    for instr in body.instrs:
        if instr.op not in MEMORY or instr.width != WORD_BYTES or instr.lane is not None:
            continue
        fixed = not any(isinstance(v, Ref) and v.id in inside for v in instr.operands[:2])
        if fixed and instr.operands[0] == Input(f"&{instr.array}"):
            key = (instr.array, instr.operands[:2], instr.shift, instr.offset)
            found.setdefault(key, []).append(instr)
    for group in found.values():
        counts = {Opcode.LOAD: _LOAD, Opcode.STORE: _STORE}
        plain = all(len(instr.operands) == counts[instr.opcode] for instr in group)
        stores = any(instr.op is Opcode.STORE for instr in group)
        if plain and stores and group[0].op is Opcode.LOAD and _is_of_one_type(body, group):
            yield group


def _is_of_one_type(body: Block, group: list[Instr]) -> bool:
    """Whether what is stored has the type that is loaded."""
    types = {**defined_types(body)}
    loaded = {instr.type for instr in group if instr.op is Opcode.LOAD}
    stored = {
        types.get(value.id)
        for instr in group
        if instr.op is Opcode.STORE and isinstance(value := instr.operands[2], Ref)
    }
    return len(loaded | stored) == 1 and loaded <= {Type.I32, Type.F32}


def _is_apart(function: Function, loop: Loop, body: Block, group: list[Instr]) -> bool:
    """Whether no other access of the array is to the element."""
    own = {id(instr) for instr in group}
    [element, *_] = group
    others = [i for i in body.instrs if i.op in MEMORY and i.array == element.array]
    others = [instr for instr in others if id(instr) not in own]
    meetings = Meetings(function, loop)
    order = {id(instr): number for number, instr in enumerate(body.instrs)}
    for other in others:
        pair = sorted((element, other), key=lambda instr: order[id(instr)])
        first, second = (Place(instr, body.name) for instr in pair)
        if meetings.between(first, second, now=True) != _NEVER:
            return False
    return True


def _in_register(
    preface: Preface, header: Block, body: Block, after: Block, group: list[Instr]
) -> Function | None:
    """The function with the accesses of a group replaced by what a phi carries."""
    runs = preface.entered(header)
    if runs is None:
        return None
    load = group[0]
    entered = preface.emit(replace(load, operands=(*load.operands, runs)))
    carried, left = preface.free, preface.free + 1
    now: Value = Ref(carried)
    values: dict[int, Value] = {}
    last = load
    for instr in group:
        if instr.op is Opcode.LOAD:
            values[instr.id] = now
        else:
            now, last = values.get(getattr(instr.operands[2], "id", -1), instr.operands[2]), instr
    preheader = preface.preheader()
    kept = tuple(instr for instr in body.instrs if not any(instr is one for one in group))
    phi = Phi(carried, load.type, ((preheader.name, entered), (body.name, now)), load.loc)
    closing = Phi(left, load.type, ((header.name, Ref(carried)),), load.loc)
    store = replace(last, operands=(*last.operands[:2], Ref(left), runs))
    changed = (
        preheader,
        replace(header, phis=(*header.phis, phi)),
        replace(body, instrs=kept),
        replace(after, phis=(*after.phis, closing), instrs=(store, *after.instrs)),
    )
    return substitute(with_blocks(preface.function, changed), values)
