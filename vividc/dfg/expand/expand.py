"""Expansion of elementary functions into the operations of the array."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Final

import networkx as nx

from vividc.dfg.expand import (
    arc,
    bits,
    divide,
    exp,
    hyperbolic,
    integer,
    log,
    power,
    remainder,
    roots,
    rounding,
    trigonometric,
)
from vividc.dfg.expand.builder import Builder, Expansion
from vividc.dfg.expand.exp import exponential_in
from vividc.dfg.expand.magnitudes import argument_magnitudes
from vividc.dfg.ir import DFG, Node
from vividc.dfg.order import evaluation_order
from vividc.dfg.passes.rewrite import Rewrite, Value, to_fixpoint
from vividc.machine.opcodes import PRED, LatencyClass, Opcode
from vividc.ssa.formats.precision import Precision, formats_of


def expand_math(dfg: DFG) -> DFG:
    """Replace each elementary function by operations of the array, none of them a table.

    The expansions (`exponential`, `divide`, `square_root`, ...) state their accuracy. The result
    has no operation of `ELEMENTARY`.
    """
    return _expanded(dfg, EXPANSIONS)


def expansion_pass(policy: Precision) -> Callable[[DFG], DFG]:
    """`expand_math` under a precision policy."""
    if not policy:
        return expand_math
    chosen = {opcode: exponential_in(opcode, fmt) for opcode, fmt in formats_of(policy).items()}

    def expand_math_in_formats(dfg: DFG) -> DFG:
        return _expanded(dfg, EXPANSIONS | chosen)

    return expand_math_in_formats


def _expanded(dfg: DFG, expansions: Mapping[Opcode, Expansion]) -> DFG:
    if not any(node.op in expansions for node in dfg.nodes):
        return dfg
    # Before: an expanded remainder or sine no longer shows its range.
    parts = waiting_parts(dfg)
    facts = _Facts(
        argument_magnitudes(dfg),
        frozenset[int]().union(*parts),
        late_divisors(dfg, parts),
        _divided_by_roots(dfg),
    )
    return to_fixpoint(dfg, lambda rewrite, node: _expand(rewrite, node, facts, expansions))


def _divided_by_roots(dfg: DFG) -> frozenset[int]:
    """Quotients by what is always a root, and of the same iteration."""
    masked = {edge.dst for edge in dfg.edges if edge.port == PRED}
    roots = {node.id for node in dfg.nodes if node.op is Opcode.SQRT} - masked
    by = (edge for edge in dfg.edges if edge.src in roots and edge.is_data and not edge.distance)
    divided = {node.id for node in dfg.nodes if node.op is Opcode.FDIV}
    return frozenset(edge.dst for edge in by if edge.port == 1) & divided


def waiting_parts(dfg: DFG) -> list[frozenset[int]]:
    """Nodes whose cycles count: those of each recurrence, or all of straight code."""
    carried = any(edge.distance for edge in dfg.edges)
    if not carried and not any(node.op is Opcode.IV for node in dfg.nodes):
        return [frozenset(dfg.by_id)]
    graph = nx.DiGraph((edge.src, edge.dst) for edge in dfg.edges)
    around = (part for part in nx.strongly_connected_components(graph) if len(part) > 1)
    loops = {edge.src for edge in dfg.edges if edge.src == edge.dst}
    return [*map(frozenset, around), *(frozenset({loop}) for loop in loops)]


def late_divisors(dfg: DFG, parts: list[frozenset[int]]) -> frozenset[int]:
    """Quotients in these parts that wait for their divisors rather than for their dividends. What
    is outside its part does not hold a quotient up.
    """
    late: set[int] = set()
    for part in parts:
        ready: dict[int, int] = {}
        for node_id in (one for one in evaluation_order(dfg) if one in part):
            node = dfg.by_id[node_id]
            inputs = [e for e in dfg.in_edges[node_id] if e.is_data and e.src in part]
            at = {edge.port: 0 if edge.distance else ready[edge.src] for edge in inputs}
            cost = _CYCLES.get(node.latency_class, 0 if node.is_source else 1)
            ready[node_id] = max(at.values(), default=0) + cost
            if node.op is Opcode.FDIV and at.get(0, -_NEAR) < at.get(1, -_NEAR) + _NEAR:
                late.add(node_id)
    return frozenset(late)


_NEAR: Final = 8
"""A divisor that is there at most so many cycles before its dividend is the one to wait for. By
what `divide` takes from either these are up to 6, or 18; but a dividend that takes longer often
begins with what a loop before ends with, which is there later than the divisor is (durbin).
"""

_CYCLES: Final = {
    LatencyClass.FADD: 4,
    LatencyClass.FMUL: 4,
    LatencyClass.FMA: 4,
    LatencyClass.IMUL: 2,
    LatencyClass.CONVERT: 2,
    LatencyClass.LOAD: 2,
    LatencyClass.GENERIC: 40,
}
"""About what operations take on `vivid-tile`, elementary functions among them, if not one."""


@dataclass(frozen=True)
class _Facts:
    """Of the nodes of a graph before it is expanded."""

    magnitudes: Mapping[int, float]
    latency_bound: frozenset[int]
    late_divisors: frozenset[int]
    normal_divisors: frozenset[int]


EXPANSIONS: Final[dict[Opcode, Expansion]] = {
    opcode: expand
    for module in (
        exp,
        divide,
        roots,
        rounding,
        integer,
        bits,
        trigonometric,
        arc,
        power,
        remainder,
        hyperbolic,
        log,
    )
    for opcode, expand in module.EXPANSIONS.items()
}


def _expand(
    rewrite: Rewrite,
    node: Node,
    facts: _Facts,
    expansions: Mapping[Opcode, Expansion],
) -> bool:
    expand = expansions.get(node.op)
    if expand is None:
        return False
    operands = rewrite.operands(node)
    builder = Builder(
        rewrite,
        node,
        facts.magnitudes.get(node.id, math.inf),
        latency_binds=node.id in facts.latency_bound,
        divisor_is_last=node.id in facts.late_divisors,
        has_normal_divisor=node.id in facts.normal_divisors,
    )
    value = expand(builder, *operands)
    pred = rewrite.edge(node.id, PRED)
    if pred is not None:
        guard = Value(pred.src, pred.distance, pred.init)
        value = Builder(rewrite, node).op(Opcode.SELECT, guard, value, operands[-1])
    if node.control is not None:  # a quotient may be a trip count
        rewrite.set_node(replace(rewrite.nodes[value.src], control=node.control))
    rewrite.forward(node.id, value)
    rewrite.remove_node(node.id)
    return True
