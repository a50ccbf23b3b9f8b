"""Which values an integer can have: intervals over SSA, refined by the branches that lead to a
block.

Widening and narrowing as by Cousot and Cousot (1977). Values of type iN are signed, except i1 (0 or
1).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

from vividc.frontend.llvm.ir import (
    Flow,
    Int,
    Local,
    Op,
    Operand,
    WideBlock,
    WideFunction,
    WidePhi,
    flow_of,
)
from vividc.frontend.ranges.interval import (
    BOTTOM,
    Interval,
    comparable,
    compare,
    evaluate,
    full,
    intersect,
    refine,
    union,
    widen,
)
from vividc.frontend.ranges.trips import counter_bounds
from vividc.host import time_limit

_WIDEN_AFTER = 3
_NARROWINGS = 4
_DEPTH = 5
_NEGATED = {"eq": "ne", "slt": "sge", "sgt": "sle", "ult": "uge", "ugt": "ule"}
_NEGATED |= {v: k for k, v in _NEGATED.items()}
_SWAPPED = {"eq": "eq", "ne": "ne", "slt": "sgt", "sle": "sge", "ult": "ugt", "ule": "uge"}
_SWAPPED |= {v: k for k, v in _SWAPPED.items()}


@dataclass(frozen=True, slots=True)
class Fact:
    """`value pred other` holds; `type` is that of both."""

    value: Operand
    pred: str
    other: Operand
    type: str


_About = dict[str, tuple[tuple[str, Operand], ...]]
"""By name: (predicate, other operand) of each comparison that holds of the value."""


class Ranges:
    """Intervals of all integer values of a function.

    Parameters
    ----------
    function
        A function without unreachable blocks, memory resolved.
    bounds
        Intervals of parameters and of instructions that are tighter than their type.
    """

    def __init__(self, function: WideFunction, bounds: dict[str, Interval]) -> None:
        self._function = function
        self._definitions = function.definitions
        self._flow: Flow = flow_of(function)
        self._types = dict(function.params)
        self._bounds = bounds
        self._known: dict[str, Interval] = {}
        self._limits: dict[str, Interval] = {}
        self._facts: dict[str, tuple[Fact, ...]] = {}
        self._about: dict[str, _About] = {}
        for name in self._flow.order:  # a block comes after those that dominate it
            self._add_facts(name)
        self._solve()
        self._limits = counter_bounds(function, self._flow, self.at)
        if any(self._known[name] != limit for name, limit in self._limits.items()):
            self._known = {}
            self._solve()

    def at(self, operand: Operand, block: str) -> Interval:
        """Values that `operand` can have while `block` runs."""
        return self._at(operand, block, _DEPTH)

    def compare_at(self, op: Op, block: str) -> bool | None:
        """Whether the comparison is always true, always false, or neither."""
        if op.op != "icmp" or not comparable(op):
            return None
        return compare(op.pred, self.at(op.args[0], block), self.at(op.args[1], block))

    def facts(self, block: str) -> tuple[Fact, ...]:
        """Comparisons that hold wherever `block` runs: those of branches on every way to it."""
        return self._facts[block]

    @property
    def flow(self) -> Flow:
        """Dominators and loops of the function."""
        return self._flow

    def is_nonzero(self, operand: Operand, block: str) -> bool:
        """Whether `operand` is known not to be 0 while `block` runs."""
        low, high = self.at(operand, block)
        if low > 0 or high < 0:
            return True
        same = self._unextended(operand)
        return any(
            fact.pred == "ne" and fact.other == Int(0) and self._unextended(fact.value) == same
            for fact in self._facts[block]
        )

    def _unextended(self, operand: Operand) -> Operand:
        """What was sign- or zero-extended to the operand."""
        while isinstance(operand, Local):
            definition = self._definitions.get(operand.name)
            if not isinstance(definition, Op) or definition.op not in ("sext", "zext"):
                break
            operand = definition.args[0]
        return operand

    def _solve(self) -> None:
        blocks = [self._function.by_name[name] for name in self._flow.order]
        rounds = 0
        changed = True
        while changed:
            rounds += 1
            changed = any([self._ascend(block, rounds > _WIDEN_AFTER) for block in blocks])
        for _ in range(_NARROWINGS):
            if not any([self._descend(block) for block in blocks]):
                break

    def _ascend(self, block: WideBlock, widening: bool) -> bool:
        changed = False
        time_limit.step("ranges of values were found")
        for item in block.items:
            if not item.name or not _is_int(_result_type(item)):
                continue
            old = self._known.get(item.name, BOTTOM)
            new = union(old, self._transfer(item, block.name))
            if widening and isinstance(item, WidePhi):
                new = widen(old, new, item.type)
            changed |= new != old
            self._known[item.name] = new
        return changed

    def _descend(self, block: WideBlock) -> bool:
        changed = False
        for item in block.items:
            if item.name in self._known:
                old = self._known[item.name]
                tighter = intersect(old, self._transfer(item, block.name))
                changed |= tighter != old
                self._known[item.name] = tighter
        return changed

    def _transfer(self, item: Op | WidePhi, block: str) -> Interval:
        if isinstance(item, WidePhi):
            total = BOTTOM
            for pred, value in item.incoming:
                total = union(total, self._on_edge(value, pred, block))
            limit = self._limits.get(item.name)
            return total if limit is None else intersect(total, limit)
        interval = self._evaluate(item, block, _DEPTH)
        bound = self._bounds.get(item.name)
        return interval if bound is None else intersect(interval, bound)

    def _evaluate(self, op: Op, block: str, depth: int) -> Interval:
        if op.op == "select":
            return self._select(op, block, depth)
        operands = tuple(self._at(arg, block, depth) for arg in op.args)
        interval = evaluate(op, operands)
        return intersect(interval, (0, interval[1])) if self._is_distance(op) else interval

    def _is_distance(self, op: Op) -> bool:
        """Whether `op` is the maximum of two values less their minimum, which is not negative."""
        if op.op != "sub" or not all(isinstance(arg, Local) for arg in op.args):
            return False
        extrema = [self._definitions.get(arg.name) for arg in op.args if isinstance(arg, Local)]
        if not all(isinstance(item, Op) and item.op == "call" for item in extrema):
            return False
        largest, smallest = (item for item in extrema if isinstance(item, Op))
        pair = (largest.pred.split(".")[1], smallest.pred.split(".")[1])
        if pair == ("umax", "umin"):
            signless = all(self._base(arg)[0] >= 0 for arg in largest.args)
        else:
            signless = pair == ("smax", "smin")
        return signless and set(largest.args) == set(smallest.args)

    def _select(self, op: Op, block: str, depth: int) -> Interval:
        cond, yes, no = op.args
        decided = self._at(cond, block, depth)
        total = BOTTOM
        for truth, value in ((True, yes), (False, no)):
            if decided == (int(not truth), int(not truth)):
                continue
            facts = tuple(self._holding(cond, truth))
            total = union(total, self._apply(facts, value, self._at(value, block, depth)))
        return total

    def _on_edge(self, value: Operand, pred: str, block: str) -> Interval:
        leave = self._function.by_name[pred].exit
        if pred not in self._facts:
            return BOTTOM
        interval = self.at(value, pred)
        if leave.cond is None:
            return interval
        if self._at(leave.cond, pred, _DEPTH) == (int(block != leave.targets[0]),) * 2:
            return BOTTOM
        facts = tuple(self._holding(leave.cond, block == leave.targets[0]))
        return self._apply(facts, value, interval)

    def _at(self, operand: Operand, block: str, depth: int) -> Interval:
        if isinstance(operand, Int):
            return (operand.value, operand.value)
        if not isinstance(operand, Local):
            return full("i64")
        interval = self._base(operand)
        definition = self._definitions.get(operand.name)
        if (
            depth > 0
            and isinstance(definition, Op)
            and interval != BOTTOM
            and _is_cheap(definition)
        ):
            interval = intersect(interval, self._evaluate(definition, block, depth - 1))
        for pred, other in self._about[block].get(operand.name, ()):
            interval = refine(interval, pred, self._base(other))
        return interval

    def _base(self, operand: Operand) -> Interval:
        if isinstance(operand, Int):
            return (operand.value, operand.value)
        if not isinstance(operand, Local):
            return full("i64")
        if operand.name in self._types:
            type_ = self._types[operand.name]
            return self._bounds.get(operand.name, full(type_ if _is_int(type_) else "i64"))
        return self._known.get(operand.name, BOTTOM)

    def _apply(self, facts: tuple[Fact, ...], operand: Operand, interval: Interval) -> Interval:
        for fact in facts:
            if fact.value == operand:
                interval = refine(interval, fact.pred, self._base(fact.other))
            elif fact.other == operand:
                interval = refine(interval, _SWAPPED[fact.pred], self._base(fact.value))
        return interval

    def _add_facts(self, block: str) -> None:
        """Conditions of the branches that dominate the block, the nearest first, all together and
        by the value that they are about.
        """
        own = tuple(self._own_facts(block))
        above = self._flow.idom[block]
        self._facts[block] = own + self._facts.get(above, ())
        self._about[block] = self._about.get(above, {})
        if own:
            merged = dict(self._about[block])
            for fact in reversed(own):
                for value, pred, other in (
                    (fact.other, _SWAPPED[fact.pred], fact.value),
                    (fact.value, fact.pred, fact.other),
                ):
                    if isinstance(value, Local) and (value is fact.value or other != value):
                        merged[value.name] = ((pred, other), *merged.get(value.name, ()))
            self._about[block] = merged

    def _own_facts(self, block: str) -> Iterator[Fact]:
        """What the branch to the block says, if only one leads there."""
        preds = self._flow.predecessors[block]
        if len(preds) == 1:
            leave = self._function.by_name[preds[0]].exit
            if leave.cond is not None:
                yield from self._holding(leave.cond, block == leave.targets[0])

    def _holding(self, cond: Operand, truth: bool) -> Iterator[Fact]:
        """What is known if `cond` has the given truth."""
        definition = self._definitions.get(cond.name) if isinstance(cond, Local) else None
        if not isinstance(definition, Op):
            return
        if definition.op == "icmp":
            if not comparable(definition):
                return
            pred = definition.pred if truth else _NEGATED[definition.pred]
            yield Fact(definition.args[0], pred, definition.args[1], definition.type)
        elif definition.op == "xor" and definition.args[1] in (Int(1), Int(-1)):
            yield from self._holding(definition.args[0], not truth)
        elif _is_conjunction(definition) if truth else _is_disjunction(definition):
            for part in definition.args:
                yield from self._holding(part, truth)


def _is_conjunction(op: Op) -> bool:
    return (op.op == "and" and op.type == "i1") or (
        op.op == "select" and op.args[2] == Int(0) and op.type == "i1"
    )


def _is_disjunction(op: Op) -> bool:
    return (op.op == "or" and op.type == "i1") or (
        op.op == "select" and op.args[1] == Int(1) and op.type == "i1"
    )


def _is_cheap(op: Op) -> bool:
    """Worth evaluating again with what is known in a later block."""
    return op.op in ("add", "sub", "sext", "zext", "trunc", "shl", "select", "and", "freeze", "mul")


def _result_type(item: Op | WidePhi) -> str:
    return "i1" if isinstance(item, Op) and item.op in ("icmp", "fcmp") else item.type


@cache
def _is_int(type_: str) -> bool:
    return type_[:1] == "i" and type_[1:].isdigit()
