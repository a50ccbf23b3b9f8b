"""Dimensions that a branch has shown to be equal get one name.

Behind a test that a matrix is square LLVM writes one dimension for the other, now and then: rows
are of one length then, and the loops along them end at another. Where a test like that leads, all
names of a number are one here, that of the length of rows if it is among them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from vividc.machine.opcodes import Opcode, Type
from vividc.ssa.analysis.order import Order, Sum
from vividc.ssa.edit import map_values, with_blocks
from vividc.ssa.ir import Block, Function, Input, Value, is_dimension, is_pitch

_Names = dict[Value, Value]


def with_one_name(function: Function) -> Function:
    """The function with one name for dimensions that are equal wherever a block runs; pitches, by
    which elements are addressed, stay.
    """
    if not any(_compares_dimensions(block) for block in function.blocks):
        return function
    order, ranks = Order(function), _ranks(function)
    names = {block.name: dict(_names(order.facts(block.name), ranks)) for block in function.blocks}
    changed = (_renamed(block, names) for block in function.blocks)
    return with_blocks(function, changed) if any(names.values()) else function


def _compares_dimensions(block: Block) -> bool:
    return any(
        one.type is Type.PRED
        and one.op not in (Opcode.AND, Opcode.OR, Opcode.XOR)
        and all(map(_is_named, one.operands))
        for one in block.instrs
    )


def _is_named(value: Value) -> bool:
    return is_dimension(value) and not is_pitch(value)


def _ranks(function: Function) -> dict[Value, int]:
    """The dimensions of parameters: lengths of rows first, then in their order."""
    axes = [(param, axis) for param in function.params for axis in range(param.ndim)]
    axes.sort(key=lambda one: one[1] < one[0].ndim - 1)
    return {Input(f"{param.name}.shape{axis}"): at for at, (param, axis) in enumerate(axes)}


def _names(facts: Iterable[Sum], ranks: dict[Value, int]) -> Iterator[tuple[Value, Value]]:
    """Dimensions, and what each is called where these sums are not negative: nor is that of two
    which are equal, one less the other, the other way round.
    """
    known = frozenset(facts)
    groups: list[set[Value]] = []
    for one in facts:
        pair = {value for value, _ in one.terms}
        is_difference = not one.constant and sorted(times for _, times in one.terms) == [-1, 1]
        if not is_difference or not pair <= ranks.keys() or Sum(()).less(one) not in known:
            continue
        joined = pair.union(*(group for group in groups if group & pair))
        groups = [*(group for group in groups if not group & pair), joined]
    for group in groups:
        first = min(group, key=ranks.__getitem__)
        yield from ((value, first) for value in group if value != first)


def _renamed(block: Block, names: dict[str, _Names]) -> Block:
    """A block with its names; phis read by those of the blocks before it."""
    own = names[block.name]
    phis = tuple(
        replace(phi, incoming=tuple((at, names[at].get(one, one)) for at, one in phi.incoming))
        for phi in block.phis
    )
    rest = map_values(replace(block, phis=()), lambda value: own.get(value, value))
    return replace(rest, phis=phis)
