"""Loops directly inside a parallel one, between two inputs of their own: a launch can give each
tile a block of both.
"""

from __future__ import annotations

from dataclasses import replace

from vividc.machine.opcodes import Opcode, Type
from vividc.machine.parallel import BLOCK_FIRST, BLOCK_LAST
from vividc.ssa.analysis.counters import Counter, counter_of, header_test
from vividc.ssa.analysis.induction import computed_from
from vividc.ssa.analysis.levels import Level, level_of
from vividc.ssa.edit import FreshIds, with_blocks
from vividc.ssa.flow import Loop
from vividc.ssa.ir import Function, Input, Instr, Ref, Value

Bounds = tuple[Value, Value]
"""First value and limit of a loop's counter."""


def blocked(function: Function, header: str) -> tuple[Function, tuple[Bounds, ...]]:
    """The function whose loops directly inside the one at `header` go no further than from
    `BLOCK_FIRST` to `BLOCK_LAST`, and their own bounds; without bounds, the function as it is: they
    do not count up by one, they are not all that an iteration stores, or what they store does not
    depend on where they are.
    """
    level = level_of(function, header)
    own = level.loop.blocks - {n for c in level.children.values() for n in c.loop.blocks}
    if any(i.op is Opcode.STORE for name in own for i in level.blocks[name].instrs):
        return function, ()
    found = [(child, _counter(function, child)) for child in level.children.values()]
    bounds: list[Bounds] = []
    ids, made = FreshIds(function), function
    for child, counter in found:
        if counter is None:
            return function, ()
        made = _between(made, child.loop, counter, ids)
        bounds.append((counter.initial, counter.limit))
    return made, tuple(bounds)


def _counter(function: Function, child: Level) -> Counter | None:
    """The only variable of a loop that moves all its stores by its steps of one."""
    counter = counter_of(function, child.loop)
    if counter is None or counter.step != 1 or len(child.header.phis) != 1 or child.leaving:
        return None
    test = header_test(function, child.loop)
    if test != (Ref(counter.phi.id), counter.limit) or len(child.loop.exits) != 1:
        return None
    moved = computed_from(child.blocks.values(), Ref(counter.phi.id))
    stores = (i for b in child.blocks.values() for i in b.instrs if i.op is Opcode.STORE)
    return counter if all(store.operands[1] in moved for store in stores) else None


def _between(function: Function, loop: Loop, counter: Counter, ids: FreshIds) -> Function:
    """The function with a loop that stays within a block."""
    header = function.by_name[loop.header]
    ((source, _),) = [edge for edge in counter.phi.incoming if edge[0] not in loop.blocks]
    start = _bound(ids(), Opcode.SMAX, counter.initial, BLOCK_FIRST)
    limit = _bound(ids(), Opcode.SMIN, counter.limit, BLOCK_LAST)
    before = function.by_name[source]
    before = replace(before, instrs=(*before.instrs, start, limit))
    incoming = tuple(
        (name, value if name in loop.blocks else Ref(start.id))
        for name, value in counter.phi.incoming
    )

    def tested(instr: Instr) -> Instr:
        if Ref(instr.id) != header.branch.cond:
            return instr
        operands = tuple(Ref(limit.id) if v == counter.limit else v for v in instr.operands)
        return replace(instr, operands=operands)

    changed = replace(
        header,
        phis=(replace(counter.phi, incoming=incoming),),
        instrs=tuple(map(tested, header.instrs)),
    )
    return with_blocks(function, (before, changed))


def _bound(ident: int, op: Opcode, value: Value, key: str) -> Instr:
    return Instr(ident, op, Type.I32, (value, Input(key)))
