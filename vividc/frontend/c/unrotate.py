"""Turns loops that clang rotated back into `while` loops: `if (a < b) do ... while (++i != b)`
becomes `while (i < b) ...`, which the tile controller can count.

A rotated loop tests for its next iteration at its end. The test may be moved to the start if it is
known to hold when the loop is entered: by the ranges of the values, by a comparison on the way to
the loop, or because the loop's counter would overflow otherwise, which C leaves undefined.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from vividc.errors import SourceLoc
from vividc.frontend.ranges.interval import compare
from vividc.frontend.ranges.ranges import Ranges
from vividc.host.once import once_within
from vividc.ssa.analysis.induction import induction_of
from vividc.ssa.edit import FreshIds, map_values, read_values, retarget
from vividc.ssa.flow import Flow, flow_of
from vividc.ssa.ir import (
    Block,
    Branch,
    Float,
    Function,
    Instr,
    Int,
    Named,
    Phi,
    Ref,
    Value,
    type_of,
)

_SWAPPED = {"eq": "eq", "ne": "ne", "slt": "sgt", "sle": "sge", "ult": "ugt", "ule": "uge"}
_SWAPPED |= {v: k for k, v in _SWAPPED.items()}
_NEGATED = {"eq": "ne", "slt": "sge", "sgt": "sle", "ult": "uge", "ugt": "ule"}
_NEGATED |= {v: k for k, v in _NEGATED.items()}
_IMPLIED_BY = {
    "slt": ("slt",),
    "sle": ("slt", "sle", "eq"),
    "sgt": ("sgt",),
    "sge": ("sgt", "sge", "eq"),
    "ult": ("ult",),
    "ule": ("ult", "ule", "eq"),
    "ugt": ("ugt",),
    "uge": ("ugt", "uge", "eq"),
}


_After = dict[str, dict[Value, Value]]
"""What replaces values in each block."""


@dataclass(frozen=True, slots=True)
class _Test:
    """The loop goes on while `next pred limit`, where `next` is the latch's value of `phi`."""

    phi: Phi
    step: int
    pred: str
    limit: Value
    op: Instr
    flags: frozenset[str]


@dataclass(frozen=True, slots=True)
class _Rotated:
    """A loop whose test can be moved from its latch to its start."""

    header: Block
    latch: Block
    body: frozenset[str]
    outside: str
    only_exit: bool
    test: _Test


def unrotate(function: Function) -> Function:
    """The function with every loop in `while` form whose first iteration is sure to be run.

    Parameters
    ----------
    function
        A function without unreachable blocks and without pointers.
    """
    refused: set[str] = set()
    while True:
        flow = flow_of(function)
        for rotated in _rotated_loops(function, flow, refused):
            changed = _with_test_first(function, flow, rotated)
            if changed is not None:
                function = changed
                break
            refused.add(rotated.header.name)
        else:
            return function


def _rotated_loops(function: Function, flow: Flow, refused: set[str]) -> Iterator[_Rotated]:
    for header, body in flow.loops.items():
        latches = [name for name in flow.predecessors[header] if name in body]
        if header in refused or header == flow.entry or len(latches) != 1:
            continue
        latch = function.by_name[latches[0]]
        outside = [name for name in latch.branch.successors if name not in body]
        if len(outside) != 1 or header not in latch.branch.successors:
            continue
        test = _test(function, function.by_name[header], latch, body)
        if test is not None:
            exits = [t for n in body for t in flow.successors[n] if t not in body]
            only = len(exits) == 1
            yield _Rotated(function.by_name[header], latch, body, outside[0], only, test)


def _test(function: Function, header: Block, latch: Block, body: frozenset[str]) -> _Test | None:
    op = _definition(function, latch.branch.cond)
    if not isinstance(op, Instr) or op.op != "icmp" or op.type not in ("i32", "i64"):
        return None
    stays = op.pred if latch.branch.successors[0] == header.name else _NEGATED[op.pred]
    left, right = op.operands
    for value, limit, pred in ((left, right, stays), (right, left, _SWAPPED[stays])):
        if not _is_invariant(function, limit, body):
            continue
        for phi in header.phis:
            phi_test = _test_of_phi(function, phi, body, (value, pred, limit, op))
            if phi_test is not None:
                return phi_test
    return None


def _test_of_phi(
    function: Function,
    phi: Phi,
    body: frozenset[str],
    comparison: tuple[Value, str, Value, Instr],
) -> _Test | None:
    value, pred, limit, op = comparison
    induction = induction_of(function, body, phi)
    by = None if induction is None else induction.step
    if induction is None or by is None:
        return None
    flags = induction.update.flags
    if value == Ref(induction.update.id):
        return _Test(phi, by, pred, limit, op, flags)
    if value == Ref(phi.id) and isinstance(limit, Int) and "nsw" in flags:
        # `phi pred limit` is `phi + by pred limit + by` where neither sum wraps.
        moved = limit.value + by
        bits = 31 if op.type == "i32" else 63
        if pred[0] == "s" and -(1 << bits) <= moved < 1 << bits:
            return _Test(phi, by, pred, Int(moved), op, flags)
    return None


@once_within
def _ranges(function: Function) -> Ranges:
    return Ranges(function, {})


def _with_test_first(function: Function, flow: Flow, rotated: _Rotated) -> Function | None:
    pred = _moved_predicate(function, rotated)
    if pred is None:
        return None
    carried = _Carried(function, rotated)
    replaced = _values_after(function, flow, rotated, carried)
    return None if replaced is None else _rebuilt(function, rotated, pred, carried, replaced)


def _moved_predicate(function: Function, rotated: _Rotated) -> str | None:
    """How the counter compares with the limit before each iteration, the first included."""
    test = rotated.test
    if test.pred == "eq":
        return None
    if test.pred != "ne":
        return test.pred if _holds_first(function, rotated, test.pred) else None
    up = test.step > 0
    signed, unsigned = ("slt", "ult") if up else ("sgt", "ugt")
    if rotated.only_exit and ("nsw" in test.flags or (up and "nuw" in test.flags)):
        return signed if "nsw" in test.flags else unsigned
    # Another step may miss the limit.
    preds = (signed, unsigned) if abs(test.step) == 1 else ()
    return next((p for p in preds if _holds_first(function, rotated, p)), None)


def _holds_first(function: Function, rotated: _Rotated, pred: str) -> bool:
    """Whether the counter's first value compares so with the limit, on every way into the loop."""
    limit, ranges = rotated.test.limit, _ranges(function)
    for source, start in rotated.test.phi.incoming:
        if source == rotated.latch.name:
            continue
        known = compare(pred, ranges.at(start, source), ranges.at(limit, source))
        if known is not True and not _compared_before(function, source, (start, pred, limit)):
            return False
    return True


def _compared_before(
    function: Function,
    block: str,
    claim: tuple[Value, str, Value],
) -> bool:
    """Whether a branch that leads to the block has compared the same two values."""
    start, pred, limit = claim
    wanted = [(_unextended(function, start, block), _unextended(function, limit, block))]
    for fact in _ranges(function).facts(block):
        left = _unextended(function, fact.value, block)
        right = _unextended(function, fact.other, block)
        if (left, right) in wanted and fact.pred in _IMPLIED_BY[pred]:
            return True
        if (right, left) in wanted and _SWAPPED[fact.pred] in _IMPLIED_BY[pred]:
            return True
    return False


def _unextended(function: Function, operand: Value, block: str) -> Value:
    """The word that was extended, where extending it keeps the signed order."""
    while isinstance(operand, Named):
        definition = _definition(function, operand)
        if not isinstance(definition, Instr) or definition.source != "i32":
            return operand
        if definition.op == "zext" and _ranges(function).at(definition.operands[0], block)[0] < 0:
            return operand
        if definition.op not in ("sext", "zext"):
            return operand
        operand = definition.operands[0]
    return operand


class _Carried:
    """Values of the loop as they are when its test, moved to the start, fails."""

    def __init__(self, function: Function, rotated: _Rotated) -> None:
        self.phis: list[Phi] = []
        self.ids = FreshIds(function)
        self._function = function
        self._rotated = rotated
        latch = rotated.latch.name
        self._known = {dict(phi.incoming)[latch]: phi.id for phi in rotated.header.phis}

    def value(self, value: Named) -> Value:
        """Of the iteration that was the last one."""
        if value not in self._known:
            type_ = type_of(self._function, value)
            nothing: Value = Float(0.0) if type_ in ("float", "double") else Int(0)
            latch = self._rotated.latch.name
            before = [s for s, _ in self._rotated.header.phis[0].incoming if s != latch]
            incoming = (*((source, nothing) for source in before), (latch, value))
            phi = Phi(self.ids(), type_, incoming, _place(self._function, value))
            self.phis.append(phi)
            self._known[value] = phi.id
        return Ref(self._known[value])


def _values_after(
    function: Function, flow: Flow, rotated: _Rotated, carried: _Carried
) -> _After | None:
    """What replaces the loop's values in each block after it, and on the edge from the latch; None
    if a value is used where the loop's ways out have met.
    """
    latch = rotated.latch.name
    after: _After = {latch: {v: carried.value(v) for v in _handed_out(function, rotated)}}
    only_way = flow.predecessors[rotated.outside] == (latch,)
    reached = _reached(flow, rotated.outside)
    for block in function.blocks:
        if block.name in rotated.body or block.name not in reached:
            continue
        used = list(_used_outside(function, block, rotated.body))
        dominated = only_way and flow.dominates(rotated.outside, block.name)
        if used and not rotated.only_exit and not dominated:
            return None
        after[block.name] = {value: carried.value(value) for value in used}
    return after


def _handed_out(function: Function, rotated: _Rotated) -> Iterator[Named]:
    for phi in function.by_name[rotated.outside].phis:
        for source, value in phi.incoming:
            if source == rotated.latch.name and _is_of(function, value, rotated.body):
                assert isinstance(value, Named)
                yield value


def _used_outside(function: Function, block: Block, body: frozenset[str]) -> Iterator[Named]:
    """Values of the loop that the block uses, or hands to phis of its successors."""
    handed = [
        value
        for target in block.branch.successors
        for phi in function.by_name[target].phis
        for source, value in phi.incoming
        if source == block.name
    ]
    for operand in (*read_values(replace(block, phis=())), *handed):
        if isinstance(operand, Named) and _is_of(function, operand, body):
            yield operand


def _is_of(function: Function, value: Value, body: frozenset[str]) -> bool:
    return isinstance(value, Named) and function.block_of.get(value.key) in body


def _reached(flow: Flow, source: str) -> set[str]:
    """Blocks that may run after `source`, and itself."""
    seen = {source}
    pending = [source]
    while pending:
        new = [target for target in flow.successors[pending.pop()] if target not in seen]
        seen.update(new)
        pending.extend(new)
    return seen


def _rebuilt(
    function: Function,
    rotated: _Rotated,
    pred: str,
    carried: _Carried,
    after: _After,
) -> Function:
    header, latch, test = rotated.header, rotated.latch, rotated.test
    first, end = f"{header.name}.while", f"{header.name}.end"
    blocks: list[Block] = []
    for old in function.blocks:
        known = {} if old.name == latch.name else after.get(old.name, {})
        block = map_values(old, _replacer(known))
        from_latch = end if old.name == rotated.outside else latch.name
        phis = tuple(_incoming(phi, after, {latch.name: from_latch}) for phi in old.phis)
        block = replace(block, phis=() if old.name == header.name else phis)
        leave = retarget(block.branch, header.name, first)
        if old.name == latch.name:
            leave = Branch(first, loc=old.branch.loc)
        blocks.append(replace(block, branch=leave))
    args = (Ref(test.phi.id), test.limit)
    compared = Instr(carried.ids(), "icmp", test.op.type, args, pred=pred, loc=test.op.loc)
    way = Branch(header.name, Ref(compared.id), end, loc=latch.branch.loc)
    blocks.append(Block(first, (*header.phis, *carried.phis), (compared,), way))
    blocks.append(Block(end, (), (), Branch(rotated.outside, loc=latch.branch.loc)))
    return replace(function, blocks=tuple(blocks))


def _replacer(known: dict[Value, Value]) -> Callable[[Value], Value]:
    return lambda operand: known.get(operand, operand)


def _incoming(phi: Phi, after: _After, renamed: dict[str, str]) -> Phi:
    incoming = tuple(
        (renamed.get(source, source), after.get(source, {}).get(value, value))
        for source, value in phi.incoming
    )
    return replace(phi, incoming=incoming)


def _definition(function: Function, operand: Value | None) -> Instr | Phi | None:
    return function.definitions.get(operand.key) if isinstance(operand, Named) else None


def _is_invariant(function: Function, operand: Value, body: frozenset[str]) -> bool:
    return isinstance(operand, Int | Named) and not _is_of(function, operand, body)


def _place(function: Function, value: Named) -> SourceLoc | None:
    definition = function.definitions.get(value.key)
    return None if definition is None else definition.loc
