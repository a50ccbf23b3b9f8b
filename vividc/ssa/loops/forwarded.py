"""Elements of a kernel's own arrays that are loaded where they were stored: the value stored.

Where loops of array expressions are fused, what one leaves in an array for the next one is loaded
in the iteration that stored it. Arrays that nothing loads any more are not stored to.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from vividc.machine.opcodes import MEMORY, Opcode
from vividc.machine.params import TRAP
from vividc.machine.words import WORD_BYTES
from vividc.ssa.analysis.polynomial import Polynomial, Polynomials, constant
from vividc.ssa.edit import replaced
from vividc.ssa.flow import Flow, flow_of
from vividc.ssa.ir import Function, Instr, Ref, Value, definition_of


def own_arrays(function: Function) -> list[str]:
    """Arrays that a kernel makes and nobody sees behind it."""
    kept = {one.name for one in function.locals if one.contents is None}
    kept -= {name for name in kept if name.startswith(TRAP)}
    kept -= set() if function.results is None else {*function.results.made}
    return sorted(kept)


def is_plain(access: Instr) -> bool:
    """Whether an access is to a whole word, and no predicate's."""
    return access.width == WORD_BYTES and is_unconditional(access)


def is_unconditional(access: Instr) -> bool:
    """Whether an access is no predicate's, and to no lane of a word."""
    plain = 2 if access.op is Opcode.LOAD else 3
    return len(access.operands) == plain and access.lane is None


def forwarded(function: Function) -> Function:
    """The function without loads of what the same iteration has stored, and without stores that
    nothing loads.
    """
    flow, polynomials = flow_of(function), Polynomials(function)
    values: dict[int, Value] = {}
    for name in own_arrays(function):
        accesses = [
            i for b in function.blocks for i in b.instrs if i.op in MEMORY and i.array == name
        ]
        if not all(map(is_plain, accesses)) or len({one.shift for one in accesses}) != 1:
            continue
        stores = [one for one in accesses if one.op is Opcode.STORE]
        loads = [one for one in accesses if one.op is Opcode.LOAD]
        for load in loads:
            stored = _stored(function, flow, polynomials, load, stores)
            if stored is not None:
                values[load.id] = stored
        if all(load.id in values for load in loads):
            values |= {store.id: store.operands[1] for store in stores}
    made = replaced(function, values)
    return replaced(made, dict(_loaded_before(made)))


def _loaded_before(function: Function) -> Iterator[tuple[int, Value]]:
    """Loads of an element that the block has loaded before, as loops that were fused do, and what
    that load gave.
    """
    polynomials = Polynomials(function)
    for block in function.blocks:
        known: list[Instr] = []
        for one in (one for one in block.instrs if one.op in MEMORY):
            if one.op is Opcode.STORE:
                known = [load for load in known if load.array != one.array]
                continue
            same = (load for load in known if _is_same(polynomials, load, one))
            first = next(same, None)
            if first is not None:
                yield one.id, Ref(first.id)
            elif is_plain(one):
                known.append(one)


def _is_same(polynomials: Polynomials, one: Instr, other: Instr) -> bool:
    """Whether two loads are of one element."""
    if one.array != other.array or one.type is not other.type or not is_plain(other):
        return False
    return _index(polynomials, one).plus(_index(polynomials, other), -1).constant == 0


def _stored(
    function: Function,
    flow: Flow,
    polynomials: Polynomials,
    load: Instr,
    stores: Iterable[Instr],
) -> Value | None:
    """What a load gives, if one store to its element comes before it in each iteration, and no
    other one between them.
    """
    home = function.block_of[load.id]
    loops = [header for header, body in flow.loops.items() if home in body]
    for store in stores:
        place = function.block_of[store.id]
        around = [header for header, body in flow.loops.items() if place in body]
        if not set(around) <= set(loops) or not _comes_before(function, flow, store, load):
            continue
        away = _index(polynomials, load).plus(_index(polynomials, store), -1).constant
        made = definition_of(function, store.operands[2])
        is_same_type = made is not None and made.type is load.type
        if away != 0 or not is_same_type:
            continue
        between = _between(flow, around, place, home)
        others = (one for one in stores if function.block_of[one.id] in between)
        kept = (
            one for one in others if not _is_passed(function, one, store, load, around == loops)
        )
        differences = (_index(polynomials, load).plus(_index(polynomials, x), -1) for x in kept)
        if all(one.constant for one in differences):
            return store.operands[2]
    return None


def _index(polynomials: Polynomials, access: Instr) -> Polynomial:
    """Where an element lies, in bytes."""
    index = polynomials.of(access.operands[1]).times(constant(1 << access.shift))
    return index.plus(constant(access.offset))


def _comes_before(function: Function, flow: Flow, store: Instr, load: Instr) -> bool:
    """Whether a store has run whenever a load does."""
    place, home = (function.block_of[one.id] for one in (store, load))
    return flow.dominates(place, home) and (place != home or _is_ahead(function, store, load))


def _is_ahead(function: Function, one: Instr, other: Instr) -> bool:
    """Whether one instruction is in the block of another, and before it."""
    block = function.by_name[function.block_of[other.id]]
    ids = [instr.id for instr in block.instrs]
    return one.id in ids and ids.index(one.id) < ids.index(other.id)


def _between(flow: Flow, around: list[str], place: str, home: str) -> set[str]:
    """Blocks that may run behind `place` and before `home` in one iteration of the loop that
    `place` is in, the innermost of those `around`.
    """
    header = min(around, key=lambda one: len(flow.loops[one]), default="")
    after = reached(flow.successors, {place}, header)
    return after & reached(flow.predecessors, {home}, header)


def _is_passed(
    function: Function, other: Instr, store: Instr, load: Instr, is_as_deep: bool
) -> bool:
    """Whether another store is the store itself, or runs before it or behind the load in an
    iteration, in whose blocks it is.
    """
    if other is store or _is_ahead(function, other, store):
        return True
    return is_as_deep and _is_ahead(function, load, other)


def reached(edges: Mapping[str, tuple[str, ...]], starts: set[str], without: str) -> set[str]:
    """Blocks that edges lead to, not through one of them."""
    found, work = set(starts), list(starts)
    while work:
        for name in edges[work.pop()]:
            if name not in found and name != without:
                found.add(name)
                work.append(name)
    return found
