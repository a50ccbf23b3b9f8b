"""Which accesses of an iteration are never made together: those in different arms of branches."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from vividc.dfg.ir import DFG, Edge, Node, is_order
from vividc.machine.compare import INVERSES
from vividc.machine.opcodes import PRED, Opcode

_Word = tuple[int, int]
"""A node's result, so many iterations ago."""

_Test = tuple[Hashable, bool]
"""A condition, and whether it is to hold."""

_BRANCH: Final = 2
"""So many arms has a branch."""


@dataclass(frozen=True, slots=True)
class Arm:
    """One of `count` alternatives, by number, of a choice."""

    choice: str
    number: int
    count: int


def arms_of(dfg: DFG, accesses: Sequence[Node]) -> dict[int, tuple[Arm, ...]]:
    """The arms in which each access is that has a predicate, by id.

    Of the conditions in a predicate's conjunction those count of which another access demands the
    opposite. Where there are none: stores to one element are in order, but for those of which at
    most one is made.
    """
    guarded = [node for node in accesses if dfg.operand(node.id, PRED) is not None]
    tests = {node.id: frozenset(_tests(dfg, node)) for node in guarded}
    every = frozenset[_Test]().union(*tests.values())
    found = {
        ident: tuple(
            Arm(repr(condition), int(holds), _BRANCH)
            for condition, holds in wanted
            if (condition, not holds) in every
        )
        for ident, wanted in tests.items()
    }
    return found | _unordered(dfg, [node for node in guarded if not found[node.id]])


def _unordered(dfg: DFG, accesses: Sequence[Node]) -> dict[int, tuple[Arm, ...]]:
    ordered = {frozenset({e.src, e.dst}) for e in dfg.edges if is_order(e) and not e.distance}
    groups: dict[Hashable, list[Node]] = {}
    for node in accesses:
        is_store = node.op is Opcode.STORE and node.address is not None
        group = groups.setdefault((node.name, node.address) if is_store else node.id, [])
        if any(frozenset({one.id, node.id}) in ordered for one in group):
            group = groups.setdefault(node.id, [])
        group.append(node)
    return {
        node.id: (Arm("", at, len(group)),)
        for group in groups.values()
        for at, node in enumerate(group)
    }


def _tests(dfg: DFG, access: Node) -> Iterator[_Test]:
    """What its predicate is the conjunction of."""
    edges, seen = [dfg.operand(access.id, PRED)], set[_Word]()
    while edges:
        edge = edges.pop()
        assert edge is not None
        if (edge.src, edge.distance) in seen:
            continue
        seen.add((edge.src, edge.distance))
        node = dfg.by_id[edge.src]
        if node.op is Opcode.AND and not edge.distance:
            edges += [dfg.operand(node.id, 0), dfg.operand(node.id, 1)]
        else:
            yield _test(dfg, edge)


def _test(dfg: DFG, edge: Edge, *, holds: bool = True) -> _Test:
    """One form for a condition and its opposite: of comparisons that of which the name is less."""
    node = dfg.by_id[edge.src]
    operands = [dfg.operand(node.id, port) for port in range(len(node.info.operands))]
    words = [(one.src, one.distance) for one in operands if one is not None]
    if edge.distance:
        return (edge.src, edge.distance), holds
    if node.op is Opcode.XOR and dfg.by_id[words[1][0]].const == 1 and operands[0] is not None:
        return _test(dfg, operands[0], holds=not holds)
    op = node.op
    if op not in INVERSES:
        return (edge.src, 0), holds
    inverse, swapped = INVERSES[op]
    if inverse.value < op.value:
        op, holds = inverse, not holds
        words = words[::-1] if swapped else words
    return (op, *words), holds
