"""Which values an integer can have: intervals over SSA, refined by the branches that lead to a
block.

Widening and narrowing as by Cousot and Cousot (1977). Values of type iN are signed, except i1 (0 or
1).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

from vividc.frontend.ranges.interval import (
    BOTTOM,
    Interval,
    comparable,
    compare,
    evaluate,
    full,
    intersect,
    is_integer,
    refine,
    union,
    widen,
)
from vividc.frontend.ranges.trips import counter_bounds, joined_bounds
from vividc.host import time_limit
from vividc.ssa.flow import Flow, flow_of
from vividc.ssa.ir import (
    Function,
    Instr,
    Int,
    Key,
    Kind,
    Named,
    Phi,
    Value,
    definition_of,
    result_type,
)

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

    value: Value
    pred: str
    other: Value
    type: Kind


_About = dict[Key, tuple[tuple[str, Value], ...]]
"""By key: (predicate, other operand) of each comparison that holds of the value."""


class Ranges:
    """Intervals of all integer values of a function.

    Parameters
    ----------
    function
        A function without unreachable blocks, memory resolved.
    bounds
        Intervals of parameters and of instructions that are tighter than their type.
    """

    def __init__(self, function: Function, bounds: dict[Key, Interval]) -> None:
        self._function = function
        self._flow = flow_of(function)
        self._types = dict(function.inputs)
        self._bounds = bounds
        self._integers = {
            name: tuple(filter(_is_integer, function.by_name[name].items))
            for name in self._flow.order
        }
        self._cheap: dict[Key, Instr] = {
            op.id: op for block in function.blocks for op in block.instrs if _is_cheap(op)
        }
        self._known: dict[Key, Interval] = {}
        self._given: dict[int, Interval] = {}
        self._stale: set[int] = set()
        self._readers: defaultdict[Key, set[int]] = defaultdict(set)
        self._reader = -1
        self._limits: dict[int, Interval] = {}
        self._facts: dict[str, tuple[Fact, ...]] = {}
        self._about: dict[str, _About] = {}
        for name in self._flow.order:  # a block comes after those that dominate it
            self._add_facts(name)
        self._solve()
        self._limits = counter_bounds(function, self._flow, self.at)
        if any(self._known[name] != limit for name, limit in self._limits.items()):
            self._solve()
        self._join_webs()

    def _join_webs(self) -> None:
        """Solve once more where phis that take each other's values have less than they seem to."""
        tighter = False
        for name, bound in joined_bounds(self._function, self._flow, self.at).items():
            least = intersect(bound, self._known[name])
            if least not in (BOTTOM, self._known[name]):
                tighter = True
                self._limits[name] = intersect(least, self._limits.get(name, least))
        if tighter:
            self._solve()

    def at(self, operand: Value, block: str) -> Interval:
        """Values that `operand` can have while `block` runs."""
        return self._at(operand, block, _DEPTH)

    def compare_at(self, op: Instr, block: str) -> bool | None:
        """Whether the comparison is always true, always false, or neither."""
        if op.op != "icmp" or not comparable(op):
            return None
        return compare(op.pred, self.at(op.operands[0], block), self.at(op.operands[1], block))

    def facts(self, block: str) -> tuple[Fact, ...]:
        """Comparisons that hold wherever `block` runs: those of branches on every way to it."""
        return self._facts[block]

    @property
    def flow(self) -> Flow:
        """Dominators and loops of the function."""
        return self._flow

    def is_nonzero(self, operand: Value, block: str) -> bool:
        """Whether `operand` is known not to be 0 while `block` runs."""
        low, high = self.at(operand, block)
        if low > 0 or high < 0:
            return True
        same = self._unextended(operand)
        return any(
            fact.pred == "ne" and fact.other == Int(0) and self._unextended(fact.value) == same
            for fact in self._facts[block]
        )

    def _unextended(self, operand: Value) -> Value:
        """What was sign- or zero-extended to the operand."""
        while True:
            definition = definition_of(self._function, operand)
            if not isinstance(definition, Instr) or definition.op not in ("sext", "zext"):
                break
            operand = definition.operands[0]
        return operand

    def _solve(self) -> None:
        self._known = {}
        self._stale = {item.id for items in self._integers.values() for item in items}
        rounds = 0
        changed = True
        while changed:
            rounds += 1
            changed = any([self._ascend(block, rounds > _WIDEN_AFTER) for block in self._integers])
        for _ in range(_NARROWINGS):
            if not any([self._descend(block) for block in self._integers]):
                break

    def _ascend(self, block: str, widening: bool) -> bool:
        changed = False
        time_limit.step("ranges of values were found")
        for item in self._integers[block]:
            if item.id not in self._stale:
                continue
            old = self._known.get(item.id, BOTTOM)
            new = union(old, self._transfer(item, block))
            if widening and isinstance(item, Phi):
                new = widen(old, new, item.type)
            changed |= self._learn(item.id, new)
        return changed

    def _descend(self, block: str) -> bool:
        changed = False
        for item in self._integers[block]:
            tighter = intersect(self._known[item.id], self._transfer(item, block))
            changed |= self._learn(item.id, tighter)
        return changed

    def _learn(self, ident: int, interval: Interval) -> bool:
        """Whether a value's interval changes; what was computed from it is then stale."""
        changed = self._known.get(ident, BOTTOM) != interval
        if changed:
            self._stale |= self._readers[ident]
        self._known[ident] = interval
        return changed

    def _transfer(self, item: Instr | Phi, block: str) -> Interval:
        """What an item gives, computed anew if an interval that it was computed from changed."""
        if item.id in self._stale:
            self._stale.remove(item.id)
            self._reader = item.id
            given = self._computed(item, block)
            if self._given.get(item.id) != given:
                self._stale |= self._readers[item.id]
            self._given[item.id] = given
        return self._given[item.id]

    def _computed(self, item: Instr | Phi, block: str) -> Interval:
        if isinstance(item, Phi):
            total = BOTTOM
            for pred, value in item.incoming:
                total = union(total, self._on_edge(value, pred, block))
            limit = self._limits.get(item.id)
            return total if limit is None else intersect(total, limit)
        interval = self._evaluate(item, block, _DEPTH)
        bound = self._bounds.get(item.id)
        return interval if bound is None else intersect(interval, bound)

    def _evaluate(self, op: Instr, block: str, depth: int) -> Interval:
        if op.op == "select":
            return self._select(op, block, depth)
        operands = tuple(self._at(arg, block, depth) for arg in op.operands)
        interval = evaluate(op, operands)
        return intersect(interval, (0, interval[1])) if self._is_distance(op) else interval

    def _is_distance(self, op: Instr) -> bool:
        """Whether `op` is the maximum of two values less their minimum, which is not negative."""
        if op.op != "sub":
            return False
        extrema = [definition_of(self._function, arg) for arg in op.operands]
        if not all(isinstance(item, Instr) and item.op == "call" for item in extrema):
            return False
        largest, smallest = (item for item in extrema if isinstance(item, Instr))
        pair = (largest.pred.split(".")[1], smallest.pred.split(".")[1])
        if pair == ("umax", "umin"):
            signless = all(self._base(arg)[0] >= 0 for arg in largest.operands)
        else:
            signless = pair == ("smax", "smin")
        return signless and set(largest.operands) == set(smallest.operands)

    def _select(self, op: Instr, block: str, depth: int) -> Interval:
        cond, yes, no = op.operands
        decided = self._at(cond, block, depth)
        total = BOTTOM
        for truth, value in ((True, yes), (False, no)):
            if decided == (int(not truth), int(not truth)):
                continue
            facts = tuple(self._holding(cond, truth))
            total = union(total, self._apply(facts, value, self._at(value, block, depth)))
        return total

    def _on_edge(self, value: Value, pred: str, block: str) -> Interval:
        leave = self._function.by_name[pred].branch
        if pred not in self._facts:
            return BOTTOM
        interval = self.at(value, pred)
        if leave.cond is None:
            return interval
        if self._at(leave.cond, pred, _DEPTH) == (int(block != leave.successors[0]),) * 2:
            return BOTTOM
        facts = tuple(self._holding(leave.cond, block == leave.successors[0]))
        return self._apply(facts, value, interval)

    def _at(self, operand: Value, block: str, depth: int) -> Interval:
        if isinstance(operand, Int):
            return (operand.value, operand.value)
        if not isinstance(operand, Named):
            return full("i64")
        interval = self._base(operand)
        key, about = operand.key, self._about[block]
        made = self._cheap.get(key) if depth > 0 and interval != BOTTOM else None
        if made is not None and not self._is_settled(made, about, interval):
            interval = intersect(interval, self._evaluate(made, block, depth - 1))
        for pred, other in about.get(key, ()):
            interval = refine(interval, pred, self._base(other))
        return interval

    def _is_settled(self, made: Instr, about: _About, interval: Interval) -> bool:
        """Whether what `made` gives, with all that is known here, is the interval that it has."""
        if self._given.get(made.id) != interval or made.id in self._stale:
            return False
        return self._about[self._function.block_of[made.id]] is about

    def _base(self, operand: Value) -> Interval:
        if isinstance(operand, Int):
            return (operand.value, operand.value)
        if not isinstance(operand, Named):
            return full("i64")
        if operand.key in self._types:
            type_ = self._types[operand.key]
            return self._bounds.get(operand.key, full(type_ if is_integer(type_) else "i64"))
        self._readers[operand.key].add(self._reader)
        return self._known.get(operand.key, BOTTOM)

    def _apply(self, facts: tuple[Fact, ...], operand: Value, interval: Interval) -> Interval:
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
                    if isinstance(value, Named) and (value is fact.value or other != value):
                        merged[value.key] = ((pred, other), *merged.get(value.key, ()))
            self._about[block] = merged

    def _own_facts(self, block: str) -> Iterator[Fact]:
        """What the branch to the block says, if only one leads there."""
        preds = self._flow.predecessors[block]
        if len(preds) == 1:
            leave = self._function.by_name[preds[0]].branch
            if leave.cond is not None:
                yield from self._holding(leave.cond, block == leave.successors[0])

    def _holding(self, cond: Value, truth: bool) -> Iterator[Fact]:
        """What is known if `cond` has the given truth."""
        definition = definition_of(self._function, cond)
        if not isinstance(definition, Instr):
            return
        if definition.op == "icmp":
            if not comparable(definition):
                return
            pred = definition.pred if truth else _NEGATED[definition.pred]
            yield Fact(definition.operands[0], pred, definition.operands[1], definition.type)
        elif definition.op == "xor" and definition.operands[1] in (Int(1), Int(-1)):
            yield from self._holding(definition.operands[0], not truth)
        elif _is_conjunction(definition) if truth else _is_disjunction(definition):
            for part in definition.operands:
                yield from self._holding(part, truth)


def _is_integer(item: Phi | Instr) -> bool:
    return is_integer(result_type(item)) and (isinstance(item, Phi) or item.has_result)


def _is_conjunction(op: Instr) -> bool:
    return (op.op == "and" and op.type == "i1") or (
        op.op == "select" and op.operands[2] == Int(0) and op.type == "i1"
    )


def _is_disjunction(op: Instr) -> bool:
    return (op.op == "or" and op.type == "i1") or (
        op.op == "select" and op.operands[1] == Int(1) and op.type == "i1"
    )


def _is_cheap(op: Instr) -> bool:
    """Worth evaluating again with what is known in a later block."""
    return op.op in ("add", "sub", "sext", "zext", "trunc", "shl", "select", "and", "freeze", "mul")
