"""If-conversion: the acyclic body of a region becomes one graph with predicates and selects.

Branches out of the loop count as not taken (`PathPredicates`); the tile controller undoes what an
exiting iteration must not do (`unless_exit`), and effects before a later exit carry a predicate.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import networkx as nx

from vividc.dfg.builder import GraphBuilder, Operand
from vividc.machine.opcodes import Opcode
from vividc.ssa.analysis.acyclic import Acyclic, Edge, PathPredicates
from vividc.ssa.ir import Block, Function, Phi, Undefined, Value


@dataclass(frozen=True)
class Body:
    """The blocks of a region as a DAG from `entry`; `latch` is the last one, `exits` lead out of
    the loop.
    """

    function: Function
    names: frozenset[str]
    entry: str
    latch: str
    exits: tuple[tuple[str, str], ...] = ()

    @cached_property
    def by_name(self) -> dict[str, Block]:
        """The blocks."""
        return {block.name: block for block in self.function.blocks if block.name in self.names}

    @cached_property
    def flow(self) -> Acyclic:
        """Control flow inside the body without the back edge."""
        graph: nx.DiGraph[str] = nx.DiGraph()
        graph.add_nodes_from(name for name in self.by_name)
        for name, block in self.by_name.items():
            for target in block.branch.successors:
                if target in self.names and target != self.entry:
                    graph.add_edge(name, target)
        return Acyclic(graph, self.entry)

    def are_exclusive(self, one: str, other: str) -> bool:
        """Whether no iteration runs both blocks."""
        return not self.flow.reaches(one, other) and not self.flow.reaches(other, one)


@dataclass
class Predicates(PathPredicates[Operand]):
    """Emits path predicates of a body's blocks."""

    body: Body
    builder: GraphBuilder
    condition: dict[str, Operand]
    _memo: dict[tuple[str, str], Operand | None] = field(default_factory=dict)
    _inverted: dict[Operand, Operand] = field(default_factory=dict)

    @property
    def flow(self) -> Acyclic:
        """The body's blocks."""
        return self.body.flow

    def node(self, block: str) -> str:
        """Each block is a node."""
        return block

    def into(self, node: str) -> list[Edge]:
        """The edges that lead to a block."""
        return [(source, node) for source in self.flow.graph.predecessors(node)]

    def of(self, node: str, root: str | None = None) -> Operand | None:
        """When a block runs, emitted once."""
        root = self.body.entry if root is None else root
        if (node, root) not in self._memo:
            self._memo[node, root] = super().of(node, root)
        return self._memo[node, root]

    def taken(self, edge: Edge) -> Operand | None:
        """When control goes along an edge, given that its first block runs."""
        is_only = self.flow.graph.out_degree(edge[0]) == 1
        return None if is_only else self._taken(*edge)

    def leaving(self, source: str, target: str) -> Operand:
        """When control leaves the loop from `source` to `target`."""
        taken = self._taken(source, target)
        when = self.both(self.of(source), taken)
        return taken if when is None else when

    def both(self, left: Operand | None, right: Operand | None) -> Operand | None:
        """Conjunction."""
        if left is None or right is None:
            return right if left is None else left
        return left if left == right else self.builder.add(Opcode.AND, [left, right])

    def either(self, left: Operand | None, right: Operand | None) -> Operand | None:
        """Disjunction."""
        if left is None or right is None:
            return None
        return left if left == right else self.builder.add(Opcode.OR, [left, right])

    def inverted(self, operand: Operand) -> Operand:
        """Negation, emitted once."""
        if operand not in self._inverted:
            self._inverted[operand] = self.builder.invert(operand)
        return self._inverted[operand]

    def _taken(self, source: str, target: str) -> Operand:
        branch = self.body.by_name[source].branch
        condition = self.condition[source]
        return condition if branch.target == target else self.inverted(condition)


def merge_phi(
    predicates: Predicates, block: str, phi: Phi, values: dict[Value, Operand]
) -> Operand:
    """The selects that stand for a phi inside a body.

    Inputs with the same value share one select; the default is a loop-carried value if there is one
    (so that the select can become a predicated operation), else the most frequent value. An
    undefined input takes any value, so none of its own.
    """
    body = predicates.body
    inputs = [item for item in phi.incoming if item[0] in body.names]
    defined = [item for item in inputs if not isinstance(item[1], Undefined)]
    groups: dict[Operand, list[str]] = {}
    for source, value in defined or inputs:
        groups.setdefault(values[value], []).append(source)
    default = max(groups, key=lambda operand: (operand.is_phi, len(groups[operand])))
    result = default
    root = body.flow.dominator[block]
    for operand, sources in groups.items():
        if operand == default:
            continue
        when = predicates.any_of([(source, block) for source in sources], root)
        if when is None:
            return operand
        result = predicates.builder.add(Opcode.SELECT, [when, operand, result], phi.loc)
    return result
