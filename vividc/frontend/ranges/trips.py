"""Bounds of counters: a value that grows by a bounded amount in each iteration of a loop of bounded
length.

Widening loses these, and without them no `found += 1` would fit in a word.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import networkx as nx

from vividc.frontend.ranges.interval import (
    BOTTOM,
    Interval,
    contains,
    full,
    is_integer,
    union,
    width,
)
from vividc.ssa.analysis.induction import induction_of
from vividc.ssa.flow import Flow
from vividc.ssa.ir import Branch, Function, Instr, Phi, Ref, Value, definition_of

_WORD = 32
Range = Callable[[Value, str], Interval]
_UPWARD = {"slt": 0, "ult": 0, "sle": 1, "ule": 1}
_DOWNWARD = {"sgt": 0, "sge": 1}
_SWAPPED = {"slt": "sgt", "sle": "sge", "sgt": "slt", "sge": "sle", "ugt": "ult", "uge": "ule"}
_NEGATED = {"slt": "sge", "sle": "sgt", "sgt": "sle", "sge": "slt", "ult": "uge", "ule": "ugt"}
_NEGATED |= {"ugt": "ule", "uge": "ult"}


def counter_bounds(function: Function, flow: Flow, range_at: Range) -> dict[int, Interval]:
    """Intervals of the phis of loop headers, from trip counts.

    Parameters
    ----------
    range_at
        Sound intervals of operands in blocks.
    """
    analysis = _Counters(function, flow, range_at)
    bounds: dict[int, Interval] = {}
    for header in flow.loops:
        for phi in function.by_name[header].phis:
            bound = analysis.bound(phi, header)
            if bound is not None:
                bounds[phi.id] = bound
    return bounds


@dataclass(frozen=True, slots=True)
class _Edges:
    """Values of a header's phi: from before the loop, and from its only latch."""

    entries: tuple[tuple[str, Value], ...]
    latch: str
    again: Value


class _Counters:
    def __init__(self, function: Function, flow: Flow, range_at: Range) -> None:
        self._function = function
        self._block_of = function.block_of
        self._flow = flow
        self._range_at = range_at
        self._growths: dict[tuple[int, int], Interval | None] = {}
        self._trips = {header: self._trip_bound(header) for header in flow.loops}

    def bound(self, phi: Phi, header: str) -> Interval | None:
        """Interval of a header's phi; None if the loop or the growth is not bounded."""
        if not is_integer(phi.type):
            return None
        edges = self._edges(phi, header)
        growth = self._growth_in_loop(phi, header)
        if edges is None or growth is None:
            return None
        start = BOTTOM
        for pred, value in edges.entries:
            start = union(start, self._range_at(value, pred))
        total = (start[0] + growth[0], start[1] + growth[1])
        return total if start != BOTTOM and contains(full(phi.type), total) else None

    def _edges(self, phi: Phi, header: str) -> _Edges | None:
        body = self._flow.loops[header]
        entries = tuple(item for item in phi.incoming if item[0] not in body)
        again = [item for item in phi.incoming if item[0] in body]
        return _Edges(entries, again[0][0], again[0][1]) if len(again) == 1 else None

    def _growth_in_loop(self, phi: Phi, header: str) -> Interval | None:
        """By how much the phi can differ from its first value."""
        trips = self._trips[header]
        edges = self._edges(phi, header)
        if trips is None or edges is None:
            return None
        step = self._growth(edges.again, phi.id)
        if step is None:
            return None
        return (min(0, step[0] * trips), max(0, step[1] * trips))

    def _growth(self, value: Value, base: int) -> Interval | None:
        """`value - base` in one iteration; None if it is not base plus something bounded."""
        if not isinstance(value, Ref):
            return None
        key = (value.id, base)
        if key not in self._growths:
            self._growths[key] = self._growth_of(value, base)
        return self._growths[key]

    def _growth_of(self, value: Ref, base: int) -> Interval | None:
        if value == Ref(base):
            return (0, 0)
        definition = definition_of(self._function, value)
        if isinstance(definition, Phi):
            return self._growth_of_phi(definition, base)
        return None if definition is None else self._growth_of_op(definition, base)

    def _growth_of_op(self, definition: Instr, base: int) -> Interval | None:
        if definition.op == "add":
            left, right = definition.operands
            return self._sum(definition, left, right, base) or self._sum(
                definition, right, left, base
            )
        if definition.op == "sub":
            return self._sum(
                definition, definition.operands[0], definition.operands[1], base, sign=-1
            )
        if definition.op == "select":
            return self._join([self._growth(arg, base) for arg in definition.operands[1:]])
        return None

    def _sum(
        self, op: Instr, relative: Value, addend: Value, base: int, sign: int = 1
    ) -> Interval | None:
        growth = self._growth(relative, base)
        if growth is None:
            return None
        low, high = self._range_at(addend, self._block_of[op.id])
        if sign < 0:
            low, high = -high, -low
        return (growth[0] + low, growth[1] + high) if low <= high else None

    def _growth_of_phi(self, phi: Phi, base: int) -> Interval | None:
        block = self._block_of[phi.id]
        if block not in self._flow.loops:
            return self._join([self._growth(value, base) for _, value in phi.incoming])
        if phi.id == base or self._flow.dominates(block, self._block_of[base]):
            return None  # a phi of the same or an outer loop
        edges = self._edges(phi, block)
        inner = self._growth_in_loop(phi, block)
        if edges is None or inner is None:
            return None
        start = self._join([self._growth(value, base) for _, value in edges.entries])
        return None if start is None else (start[0] + inner[0], start[1] + inner[1])

    @staticmethod
    def _join(parts: list[Interval | None]) -> Interval | None:
        total = BOTTOM
        for part in parts:
            if part is None:
                return None
            total = union(total, part)
        return total

    def _trip_bound(self, header: str) -> int | None:
        """How often the loop can return to its header, from its exit tests."""
        body = self._flow.loops[header]
        latches = [name for name in self._flow.predecessors[header] if name in body]
        if len(latches) != 1:
            return None
        bounds = [
            self._bound_of_exit(header, name)
            for name in self._flow.dominators(latches[0])
            if name in body
        ]
        return min((bound for bound in bounds if bound is not None), default=None)

    def _bound_of_exit(self, header: str, name: str) -> int | None:
        """Loop goes on while `iv pred limit`, where iv is a phi of the header with a constant step,
        or its next.
        """
        leave = self._function.by_name[name].branch
        body = self._flow.loops[header]
        if leave.cond is None or all(target in body for target in leave.successors):
            return None
        test = definition_of(self._function, leave.cond)
        if not isinstance(test, Instr) or test.op != "icmp" or not is_integer(test.type):
            return None
        left, right = test.operands
        for induction, limit in ((left, right), (right, left)):
            pred = _staying(test.pred, leave, body, swap=induction is right)
            bound = None if pred is None else self._bound(header, name, induction, pred, limit)
            if bound is not None and width(test.type) >= _WORD:
                return bound
        return None

    def _bound(
        self, header: str, name: str, induction: Value, pred: str, limit: Value
    ) -> int | None:
        found = self._induction(header, induction)
        if found is None:
            return None
        phi, step = found
        edges = self._edges(phi, header)
        assert edges is not None
        starts = BOTTOM
        for before, value in edges.entries:
            starts = union(starts, self._range_at(value, before))
        low, high = self._range_at(limit, name)
        if BOTTOM in (starts, (low, high)) or not self._cannot_wrap(phi, step, (low, high)):
            return None
        if step > 0 and pred in _UPWARD and (pred[0] == "s" or low >= 0):
            return max(0, -((starts[0] - high - _UPWARD[pred]) // step))
        if step < 0 and pred in _DOWNWARD:
            return max(0, -((low - starts[1] - _DOWNWARD[pred]) // -step))
        return None

    @staticmethod
    def _cannot_wrap(phi: Phi, step: int, limit: Interval) -> bool:
        """The first value past the limit is still a value of the type."""
        return contains(full(phi.type), (limit[0] - abs(step), limit[1] + abs(step)))

    def _induction(self, header: str, operand: Value) -> tuple[Phi, int] | None:
        """The header's phi and its step, if `operand` is that phi or the phi plus its step."""
        phis: dict[Value, Phi] = {Ref(phi.id): phi for phi in self._function.by_name[header].phis}
        definition = definition_of(self._function, operand)
        if isinstance(definition, Instr) and definition.op == "add":
            phi = phis.get(definition.operands[0])
        else:
            phi = phis.get(operand)
        edges = self._edges(phi, header) if phi is not None else None
        if phi is None or edges is None:
            return None
        induction = induction_of(self._function, self._flow.loops[header], phi)
        if induction is None or not induction.step or operand not in (Ref(phi.id), edges.again):
            return None
        return phi, induction.step


def _staying(pred: str, leave: Branch, body: frozenset[str], *, swap: bool) -> str | None:
    """The predicate that holds when the loop goes on, with the induction on the left."""
    held: str | None = pred
    if swap:
        held = _SWAPPED.get(pred) or next((k for k, v in _SWAPPED.items() if v == pred), None)
    if held is not None and leave.successors[0] not in body:
        held = _NEGATED.get(held)
    return held


def joined_bounds(function: Function, flow: Flow, range_at: Range) -> dict[int, Interval]:
    """Intervals of phis that only take each other's values and some from outside, as a length does
    that an iteration may add to and that a branch tests: all that come from outside. Widening loses
    these, too.

    Parameters
    ----------
    range_at
        Sound intervals of operands in blocks.
    """
    bounds: dict[int, Interval] = {}
    for web in _webs(function, flow):
        ids = {phi.id for phi in web}
        total = BOTTOM
        for phi in web:
            for pred, value in phi.incoming:
                if not (isinstance(value, Ref) and value.id in ids):
                    total = union(total, range_at(value, pred))
        if total != BOTTOM:
            bounds |= dict.fromkeys(ids, total)
    return bounds


def _webs(function: Function, flow: Flow) -> list[list[Phi]]:
    """The integer phis that take each other's values, of those with more than one, around a loop's
    header.
    """
    graph: nx.Graph[int] = nx.Graph()
    phis = {
        phi.id: phi
        for name in flow.order
        for phi in function.by_name[name].phis
        if is_integer(phi.type)
    }
    for phi in phis.values():
        values = (value for _, value in phi.incoming)
        taken = [v.id for v in values if isinstance(v, Ref) and v.id in phis]
        graph.add_edges_from((phi.id, one) for one in taken)
    heads = {phi.id for name in flow.loops for phi in function.by_name[name].phis}
    webs = (web for web in nx.connected_components(graph) if len(web) > 1 and heads & web)
    return [[phis[id_] for id_ in sorted(web)] for web in webs]
