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
from vividc.dfg.passes.rewrite import Rewrite, Value, to_fixpoint
from vividc.machine.opcodes import PRED, Opcode
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
    facts = _Facts(argument_magnitudes(dfg), latency_bound(dfg))
    return to_fixpoint(dfg, lambda rewrite, node: _expand(rewrite, node, facts, expansions))


def latency_bound(dfg: DFG) -> frozenset[int]:
    """Nodes whose cycles count: those on a recurrence, and all of straight code."""
    graph = nx.DiGraph((edge.src, edge.dst) for edge in dfg.edges)
    graph.add_nodes_from(dfg.by_id)
    carried = any(edge.distance for edge in dfg.edges)
    if not carried and not any(node.op is Opcode.IV for node in dfg.nodes):
        return frozenset(dfg.by_id)
    around = (part for part in nx.strongly_connected_components(graph) if len(part) > 1)
    loops = {edge.src for edge in dfg.edges if edge.src == edge.dst}
    return frozenset(loops.union(*around))


@dataclass(frozen=True)
class _Facts:
    """Of the nodes of a graph before it is expanded."""

    magnitudes: Mapping[int, float]
    latency_bound: frozenset[int]


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
