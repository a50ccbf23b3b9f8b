"""Which sums of integers are exact, by what is known where they are read.

A loop of Python's adds to its counter before it tests it: of a counter that may be the greatest
word, that sum wraps where the loop ends, and no proof may take it for one more than the counter.
It is computed behind the test here, where it is read. Other sums are exact by what is assumed of
inputs: of n from 1 to the length of an array n - 1 is, and n - 1 below n. Comparisons without signs
become those that count loops.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import replace
from typing import Final

from vividc.machine.opcodes import Opcode, Type
from vividc.machine.params import MAX_ELEMENTS
from vividc.ssa.analysis.order import Order, Sum
from vividc.ssa.edit import with_blocks
from vividc.ssa.flow import Flow, flow_of
from vividc.ssa.ir import Block, Function, Instr, Ref, Value, is_dimension

_LEAST: Final = -(1 << 31)
_MOST: Final = (1 << 31) - 1
_SUMS: Final = frozenset({Opcode.ADD, Opcode.SUB})
_PAIR: Final = 2
_SIGNED: Final = {Opcode.ICMP_ULT: Opcode.ICMP_SLT, Opcode.ICMP_ULE: Opcode.ICMP_SLE}
"""Comparisons without signs, and those of loops, which are the same of numbers without signs."""

_Range = tuple[int, int]


def with_exact_sums(function: Function) -> Function:
    """The function with sums marked that prove to be exact where they are read, and computed there
    if they are not elsewhere; with comparisons of natural numbers as signed words.
    """
    order, flow = Order(function), flow_of(function)
    readers: dict[int, str] | None = None
    marked: dict[str, set[int]] = defaultdict(set)
    moved: dict[str, list[Instr]] = defaultdict(list)
    for block in (function.by_name[name] for name in flow.order):
        for instr in block.instrs:
            if instr.op not in _SUMS or instr.exact or instr.type is not Type.I32:
                continue
            if _is_exact(order, instr, block.name):
                marked[block.name].add(instr.id)
                continue
            readers = _readers(function, flow) if readers is None else readers
            where = readers.get(instr.id, block.name)
            is_near = _around(flow, where) == _around(flow, block.name)
            if where != block.name and is_near and _is_exact(order, instr, where):
                moved[where].append(replace(instr, exact=True))
    for block in function.blocks:
        for instr in block.instrs:
            if instr.op in _SIGNED and all(order.is_natural(v, block.name) for v in instr.operands):
                marked[block.name].add(instr.id)
    if not marked and not moved:
        return function
    gone = {instr.id for instrs in moved.values() for instr in instrs}
    changed = (
        _changed(block, marked[block.name], moved[block.name], gone) for block in function.blocks
    )
    return with_blocks(function, [one for one in changed if one is not None])


def _changed(block: Block, marked: set[int], moved: list[Instr], gone: set[int]) -> Block | None:
    """A block with sums marked, and with some at its beginning that others are without."""
    if not (marked or moved or any(one.id in gone for one in block.instrs)):
        return None
    kept = (one for one in block.instrs if one.id not in gone)
    instrs = (_marked(one) if one.id in marked else one for one in kept)
    return replace(block, instrs=(*moved, *instrs))


def _marked(instr: Instr) -> Instr:
    if instr.op in _SIGNED:
        return replace(instr, op=_SIGNED[instr.opcode])
    return replace(instr, exact=True)


def _readers(function: Function, flow: Flow) -> dict[int, str]:
    """The block nearest to all that read a value which dominates them, by the value's id."""
    found: dict[int, str] = {}

    def read(values: Iterable[Value | None], block: str) -> None:
        for value in values:
            if isinstance(value, Ref):
                before = found.get(value.id)
                found[value.id] = block if before is None else _common(flow, before, block)

    for name in flow.order:
        block = function.by_name[name]
        for phi in block.phis:
            for source, value in phi.incoming:
                read((value,), source)
        for instr in block.instrs:
            read(instr.operands, name)
        read(block.branch.read, name)
    return found


def _around(flow: Flow, block: str) -> list[str]:
    """Headers of the loops that a block is in."""
    return [header for header, body in flow.loops.items() if block in body]


def _common(flow: Flow, one: str, other: str) -> str:
    """The nearest block that dominates two."""
    around = set(flow.dominators(one))
    return next(name for name in flow.dominators(other) if name in around)


def _is_exact(order: Order, instr: Instr, block: str) -> bool:
    """Whether a sum or difference is one of words where `block` runs."""
    facts = order.facts(block)
    left, right = (_range(order.sum_of(value), facts) for value in instr.operands)
    if instr.op is Opcode.SUB:
        right = (-right[1], -right[0])
    return left[0] + right[0] >= _LEAST and left[1] + right[1] <= _MOST


def _range(sum_: Sum, facts: Iterable[Sum]) -> _Range:
    """The least and the most that a sum of words is, which is a word itself."""
    low = high = sum_.constant
    for value, times in sum_.terms:
        ends = [times * end for end in _word(value, facts)]
        low, high = low + min(ends), high + max(ends)
    return max(low, _LEAST), min(high, _MOST)


def _word(value: Value, facts: Iterable[Sum]) -> _Range:
    """The least and the most that a value is where these sums are not negative."""
    low, high = _alone(value, facts)
    for fact in facts:
        times = fact.factor(value)
        if abs(times) != 1 or len(fact.terms) != _PAIR:
            continue
        [(other, factor)] = [term for term in fact.terms if term[0] != value]
        most = max(factor * end for end in _alone(other, facts))
        if times == 1:  # value >= -rest - constant
            low = max(low, -most - fact.constant)
        else:  # value <= rest + constant
            high = min(high, most + fact.constant)
    return low, high


def _alone(value: Value, facts: Iterable[Sum]) -> _Range:
    """The same by those sums that are of no other value."""
    low, high = (0, MAX_ELEMENTS) if is_dimension(value) else (_LEAST, _MOST)
    for fact in facts:
        if fact.terms == ((value, 1),):
            low = max(low, -fact.constant)
        elif fact.terms == ((value, -1),):
            high = min(high, fact.constant)
    return low, high
