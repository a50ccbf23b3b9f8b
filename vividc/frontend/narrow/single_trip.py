"""Straighten loops that run exactly once: numba wraps a ufunc of a scalar, such as np.exp, into
one.

LLVM leaves them, since a pass that threads branches through loop headers would rotate the other
loops too.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from vividc.frontend.llvm.ir import (
    Exit,
    Flow,
    Int,
    Local,
    Op,
    Operand,
    WideBlock,
    WideFunction,
    flow_of,
    map_operands,
    remove_dead,
    remove_unreachable,
)
from vividc.frontend.ranges.interval import compare

_SUFFIX = ".last"


@dataclass(frozen=True, slots=True)
class _Once:
    """A loop left only from its header, whose test succeeds at the first visit and fails at the
    second.
    """

    header: WideBlock
    body: frozenset[str]
    latch: str
    stay: str
    leave: str


def straighten_single_trips(function: WideFunction) -> WideFunction:
    """Turn each loop that runs exactly once into straight code."""
    while True:
        flow = flow_of(function)
        found = next(
            (once for header in flow.loops if (once := _once(function, flow, header))), None
        )
        if found is None:
            return function
        function = remove_dead(remove_unreachable(_straightened(function, found)))


def _once(function: WideFunction, flow: Flow, name: str) -> _Once | None:
    body = flow.loops[name]
    header = function.by_name[name]
    entries = [pred for pred in flow.predecessors[name] if pred not in body]
    latches = [pred for pred in flow.predecessors[name] if pred in body]
    exits = [block for block in body for target in flow.successors[block] if target not in body]
    if len(entries) != 1 or len(latches) != 1 or exits != [name] or latches == [name]:
        return None
    first: dict[str, int | None] = {}
    second: dict[str, int | None] = {}
    for phi in header.phis:
        incoming = dict(phi.incoming)
        first[phi.name] = _constant(function, incoming[entries[0]], {})
    for phi in header.phis:
        second[phi.name] = _constant(function, dict(phi.incoming)[latches[0]], first)
    stay, leave = header.exit.targets
    if stay not in body:
        stay, leave = leave, stay
    wanted = int(stay == header.exit.targets[0])
    cond = header.exit.cond
    assert cond is not None
    if (
        _constant(function, cond, first) != wanted
        or _constant(function, cond, second) != 1 - wanted
    ):
        return None
    return _Once(header, body, latches[0], stay, leave)


def _constant(
    function: WideFunction, operand: Operand, phis: Mapping[str, int | None]
) -> int | None:
    """Value of an operand if it follows from the header's phis; only what a counter needs."""
    if not isinstance(operand, Local):
        return operand.value if isinstance(operand, Int) else None
    if operand.name in phis:
        return phis[operand.name]
    definition = function.definitions.get(operand.name)
    if not isinstance(definition, Op) or definition.op not in ("add", "icmp"):
        return None
    left, right = (_constant(function, arg, phis) for arg in definition.args)
    if left is None or right is None:
        return None
    if definition.op == "add":
        small = definition.type != "i1" and abs(left) + abs(right) < 1 << 30
        return left + right if small else None
    outcome = compare(definition.pred, (left, left), (right, right))
    return None if outcome is None else int(outcome)


def _straightened(function: WideFunction, once: _Once) -> WideFunction:
    """The header's second visit becomes a block of its own, after the body."""
    header = once.header
    last = header.name + _SUFFIX
    final: dict[str, Operand] = {phi.name: dict(phi.incoming)[once.latch] for phi in header.phis}
    final.update((op.name, Local(op.name + _SUFFIX)) for op in header.ops if op.name)

    def at_last(operand: Operand) -> Operand:
        return final.get(operand.name, operand) if isinstance(operand, Local) else operand

    ops = tuple(
        replace(op, name=op.name and op.name + _SUFFIX, args=tuple(map(at_last, op.args)))
        for op in header.ops
    )
    visit = WideBlock(last, (), ops, Exit((once.leave,), loc=header.exit.loc))
    blocks: list[WideBlock] = []
    for block in function.blocks:
        if block.name == header.name:
            blocks += [_entered_once(header, once), visit]
        elif block.name in once.body:
            blocks.append(_retargeted(block, header.name, last))
        else:
            blocks.append(_renamed(map_operands(block, at_last), header.name, last))
    return replace(function, blocks=tuple(blocks))


def _entered_once(header: WideBlock, once: _Once) -> WideBlock:
    phis = tuple(
        replace(phi, incoming=tuple(item for item in phi.incoming if item[0] != once.latch))
        for phi in header.phis
    )
    return WideBlock(header.name, phis, header.ops, Exit((once.stay,), loc=header.exit.loc))


def _retargeted(block: WideBlock, old: str, new: str) -> WideBlock:
    targets = tuple(new if target == old else target for target in block.exit.targets)
    return replace(block, exit=replace(block.exit, targets=targets))


def _renamed(block: WideBlock, old: str, new: str) -> WideBlock:
    phis = tuple(
        replace(phi, incoming=tuple((new if p == old else p, v) for p, v in phi.incoming))
        for phi in block.phis
    )
    return replace(block, phis=phis)
