"""Straighten loops that run exactly once: numba wraps a ufunc of a scalar, such as np.exp, into
one.

LLVM leaves them, since a pass that threads branches through loop headers would rotate the other
loops too.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from vividc.frontend.ranges.interval import compare
from vividc.ssa.edit import FreshIds, fresh_name, map_values, rename_incoming, retarget
from vividc.ssa.flow import Flow, flow_of
from vividc.ssa.ir import Block, Branch, Function, Instr, Int, Ref, Value, definition_of
from vividc.ssa.rewrite.blocks import remove_unreachable_blocks
from vividc.ssa.rewrite.dead import remove_unused


@dataclass(frozen=True, slots=True)
class _Once:
    """A loop left only from its header, whose test succeeds at the first visit and fails at the
    second.
    """

    header: Block
    body: frozenset[str]
    latch: str
    stay: str
    leave: str


def straighten_single_trips(function: Function) -> Function:
    """Turn each loop that runs exactly once into straight code."""
    while True:
        flow = flow_of(function)
        single = next(
            (once for header in flow.loops if (once := _once(function, flow, header))), None
        )
        if single is None:
            return function
        function = remove_unused(remove_unreachable_blocks(_straightened(function, single)))


def _once(function: Function, flow: Flow, name: str) -> _Once | None:
    body = flow.loops[name]
    header = function.by_name[name]
    entries = [pred for pred in flow.predecessors[name] if pred not in body]
    latches = [pred for pred in flow.predecessors[name] if pred in body]
    exits = [block for block in body for target in flow.successors[block] if target not in body]
    if len(entries) != 1 or len(latches) != 1 or exits != [name] or latches == [name]:
        return None
    first: dict[int, int | None] = {}
    second: dict[int, int | None] = {}
    for phi in header.phis:
        incoming = dict(phi.incoming)
        first[phi.id] = _constant(function, incoming[entries[0]], {})
    for phi in header.phis:
        second[phi.id] = _constant(function, dict(phi.incoming)[latches[0]], first)
    stay, leave = header.branch.successors
    if stay not in body:
        stay, leave = leave, stay
    wanted = int(stay == header.branch.successors[0])
    cond = header.branch.cond
    assert cond is not None
    if (
        _constant(function, cond, first) != wanted
        or _constant(function, cond, second) != 1 - wanted
    ):
        return None
    return _Once(header, body, latches[0], stay, leave)


def _constant(function: Function, operand: Value, phis: Mapping[int, int | None]) -> int | None:
    """Value of an operand if it follows from the header's phis; only what a counter needs."""
    if isinstance(operand, Int):
        return operand.value
    if isinstance(operand, Ref) and operand.id in phis:
        return phis[operand.id]
    definition = definition_of(function, operand)
    if not isinstance(definition, Instr) or definition.op not in ("add", "icmp"):
        return None
    left, right = (_constant(function, arg, phis) for arg in definition.operands)
    if left is None or right is None:
        return None
    if definition.op == "add":
        small = definition.type != "i1" and abs(left) + abs(right) < 1 << 30
        return left + right if small else None
    outcome = compare(definition.pred, (left, left), (right, right))
    return None if outcome is None else int(outcome)


def _straightened(function: Function, once: _Once) -> Function:
    """The header's second visit becomes a block of its own, after the body."""
    header, ids = once.header, FreshIds(function)
    last = fresh_name(function, f"{header.name}.last")
    final: dict[Value, Value] = {Ref(phi.id): dict(phi.incoming)[once.latch] for phi in header.phis}
    final |= {Ref(op.id): Ref(ids(op.id)) for op in header.instrs}

    def at_last(operand: Value) -> Value:
        return final.get(operand, operand)

    instrs = tuple(
        replace(op, id=ids(op.id), operands=tuple(map(at_last, op.operands)))
        for op in header.instrs
    )
    visit = Block(last, (), instrs, Branch(once.leave, loc=header.branch.loc))
    blocks: list[Block] = []
    for block in function.blocks:
        if block.name == header.name:
            blocks += [_entered_once(header, once), visit]
        elif block.name in once.body:
            blocks.append(replace(block, branch=retarget(block.branch, header.name, last)))
        else:
            changed = map_values(block, at_last)
            phis = tuple(rename_incoming(phi, header.name, last) for phi in changed.phis)
            blocks.append(replace(changed, phis=phis))
    return replace(function, blocks=tuple(blocks))


def _entered_once(header: Block, once: _Once) -> Block:
    phis = tuple(
        replace(phi, incoming=tuple(item for item in phi.incoming if item[0] != once.latch))
        for phi in header.phis
    )
    return Block(header.name, phis, header.instrs, Branch(once.stay, loc=header.branch.loc))
