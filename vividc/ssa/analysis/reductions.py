"""Scalars that the iterations of a loop only add to: partial results can be combined."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from vividc.machine.opcodes import Opcode
from vividc.machine.parallel import Reduction
from vividc.ssa.flow import Loop
from vividc.ssa.ir import Block, Function, Instr, Phi, Ref, Value

_ONE: Final = 0x3F800000
_MINUS_ZERO: Final = 0x80000000
_IDENTITIES: Final[dict[Opcode, int | None]] = {
    Opcode.ADD: 0,
    Opcode.MUL: 1,
    Opcode.AND: 0xFFFFFFFF,
    Opcode.OR: 0,
    Opcode.XOR: 0,
    Opcode.SMIN: None,
    Opcode.SMAX: None,
    Opcode.FADD: _MINUS_ZERO,
    Opcode.FMUL: _ONE,
    Opcode.FMIN: None,
    Opcode.FMAX: None,
}
"""What changes nothing; None: two results that start alike can be combined as they are."""
_SAME: Final = {
    Opcode.SUB: Opcode.ADD,
    Opcode.FSUB: Opcode.FADD,
    Opcode.FMA: Opcode.FADD,
    Opcode.FNMA: Opcode.FADD,
}
_TOTAL_AT: Final = {Opcode.SUB: 0, Opcode.FSUB: 0, Opcode.FMA: 2, Opcode.FNMA: 2}
"""The operand that is added to."""
_COMPARISONS: Final = frozenset(
    {
        Opcode.ICMP_SLT,
        Opcode.ICMP_SLE,
        Opcode.ICMP_ULT,
        Opcode.ICMP_ULE,
        Opcode.FCMP_OLT,
        Opcode.FCMP_OLE,
        Opcode.FCMP_ULT,
        Opcode.FCMP_ULE,
    }
)


@dataclass(frozen=True, slots=True)
class FoundReduction:
    """A reduction: its phi in the loop's header, its start, and how results are combined."""

    phi: int
    start: Value
    how: Reduction


def reduction_of(function: Function, loop: Loop, phi: Phi) -> FoundReduction | None:
    """The reduction that a phi of the loop's header is; None if it is none."""
    starts = {value for source, value in phi.incoming if source not in loop.blocks}
    blocks = [block for block in function.blocks if block.name in loop.blocks]
    carried = _carried(blocks, phi.id)
    if carried is None or len(starts) != 1:
        return None
    ways = set()
    for item in carried.items:
        if item.id == phi.id:
            continue
        way = _way(item, carried.ids, carried.tests)
        if way is None:
            return None
        ways |= way
    again = {value for source, value in phi.incoming if source in loop.blocks}
    if any(not isinstance(v, Ref) or v.id not in carried.ids for v in again) or len(ways) != 1:
        return None
    return FoundReduction(phi.id, starts.pop(), ways.pop())


@dataclass(frozen=True)
class _Carried:
    """All that is computed from the phi in the loop: values, and comparisons with it."""

    items: tuple[Phi | Instr, ...]
    ids: frozenset[int]
    tests: dict[int, Instr]


def _carried(blocks: list[Block], start: int) -> _Carried | None:
    """The transitive users of a phi; None if a store or a branch is one."""
    ids = {start}
    tests: dict[int, Instr] = {}
    items: dict[int, Phi | Instr] = {}
    changed = True
    while changed:
        changed = False
        for item in (item for block in blocks for item in block.items):
            if item.id in items or item.id in tests:
                continue
            reached = ids | tests.keys()
            if item.id != start and not any(_among(v, reached) for v in _operands(item)):
                continue
            if isinstance(item, Instr) and item.op is Opcode.STORE:
                return None
            if isinstance(item, Instr) and item.op in _COMPARISONS:
                tests[item.id] = item
            else:
                items[item.id] = item
                ids.add(item.id)
            changed = True
    for block in blocks:
        if any(_among(value, ids | tests.keys()) for value in block.branch.read):
            return None
    return _Carried(tuple(items.values()), frozenset(ids), tests)


def _operands(item: Phi | Instr) -> tuple[Value, ...]:
    if isinstance(item, Phi):
        return tuple(value for _, value in item.incoming)
    return item.operands


def _among(value: Value, ids: set[int] | frozenset[int]) -> bool:
    return isinstance(value, Ref) and value.id in ids


def _way(item: Phi | Instr, ids: frozenset[int], tests: dict[int, Instr]) -> set[Reduction] | None:
    """How an item adds to what it carries: nothing for one that hands it on, None if it does
    something else with it.
    """
    if isinstance(item, Phi):
        return set() if all(_among(value, ids) for value in _operands(item)) else None
    if any(_among(operand, set(tests)) for operand in item.operands):
        way = _by_comparison(item, ids, tests)
        return None if way is None else {way}
    if item.op is Opcode.SELECT:
        own = [_among(operand, ids) for operand in item.operands]
        return set() if own == [False, True, True] else None
    position = _TOTAL_AT.get(item.opcode)
    own_at = [port for port, value in enumerate(item.operands) if _among(value, ids)]
    if len(own_at) != 1 or position not in (None, own_at[0]):
        return None
    op = _SAME.get(item.opcode, item.opcode)
    if op not in _IDENTITIES:
        return None
    return {Reduction(op.value, _IDENTITIES[op], 0)}


def _by_comparison(item: Instr, ids: frozenset[int], tests: dict[int, Instr]) -> Reduction | None:
    """A minimum or maximum written as a choice between what is compared."""
    if item.op is not Opcode.SELECT or not isinstance(item.operands[0], Ref):
        return None
    test = tests.get(item.operands[0].id)
    if test is None or set(test.operands) != set(item.operands[1:]):
        return None
    own = [_among(value, ids) for value in test.operands]
    if own.count(True) != 1:
        return None
    swapped = own[0]  # total is the first operand of the comparison
    taken = _among(item.operands[2], ids)  # the new one is chosen where the test holds
    ordered = not test.mnemonic.startswith("fcmp.u")
    if test.mnemonic.startswith("fcmp") and ordered is not taken:
        return None  # a NaN would replace the total, and the order of iterations would matter
    return Reduction(test.mnemonic, None, 0, swapped=swapped, taken=taken)
