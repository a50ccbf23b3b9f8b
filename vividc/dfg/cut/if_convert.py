"""If-conversion: the acyclic body of a region becomes one graph with predicates and selects.

Path predicates follow Park and Schlansker (1991), simplified by dominance: a block that post-
dominates its immediate dominator needs no condition of its own. Branches out of the loop count as
not taken; the tile controller undoes what an exiting iteration must not do (`unless_exit`), and
effects before a later exit carry a predicate.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import networkx as nx

from vividc.dfg.builder import GraphBuilder, Operand
from vividc.machine.opcodes import Opcode
from vividc.ssa.ir import Block, Function, Phi, Undefined, Value

_SINK = ""


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
    def dag(self) -> nx.DiGraph[str]:
        """Control flow inside the body without the back edge."""
        graph: nx.DiGraph[str] = nx.DiGraph()
        graph.add_nodes_from(name for name in self.by_name)
        for name, block in self.by_name.items():
            for target in block.branch.successors:
                if target in self.names and target != self.entry:
                    graph.add_edge(name, target)
        return graph

    @cached_property
    def order(self) -> tuple[str, ...]:
        """The blocks in topological order."""
        position = {name: index for index, name in enumerate(self.by_name)}
        return tuple(nx.lexicographical_topological_sort(self.dag, key=position.__getitem__))

    @cached_property
    def immediate_dominator(self) -> dict[str, str]:
        """Immediate dominator of each block but the entry."""
        return dict(nx.immediate_dominators(self.dag, self.entry))

    @cached_property
    def _post_dominators(self) -> dict[str, str]:
        graph = self.dag.reverse(copy=True)
        graph.add_edges_from(
            (_SINK, name) for name in self.dag.nodes if self.dag.out_degree(name) == 0
        )
        return dict(nx.immediate_dominators(graph, _SINK))

    def always_follows(self, name: str, after: str) -> bool:
        """Whether `name` runs whenever `after` does, exits aside."""
        walk = after
        while walk not in (name, _SINK):
            walk = self._post_dominators[walk]
        return walk == name

    def are_exclusive(self, one: str, other: str) -> bool:
        """Whether no iteration runs both blocks."""
        return not self.reaches(one, other) and not self.reaches(other, one)

    def reaches(self, source: str, target: str) -> bool:
        """Whether control may go from `source` to `target` within an iteration."""
        return source == target or nx.has_path(self.dag, source, target)


@dataclass
class Predicates:
    """Emits path predicates of a body's blocks; None stands for `always`."""

    body: Body
    builder: GraphBuilder
    condition: dict[str, Operand]
    _memo: dict[tuple[str, str], Operand | None] = field(default_factory=dict)
    _inverted: dict[Operand, Operand] = field(default_factory=dict)

    def of(self, name: str, relative_to: str | None = None) -> Operand | None:
        """When block `name` runs, given that its dominator `relative_to` (default: entry) runs."""
        root = self.body.entry if relative_to is None else relative_to
        if name == root:
            return None
        if (name, root) not in self._memo:
            self._memo[name, root] = self._compute(name, root)
        return self._memo[name, root]

    def edge(self, source: str, target: str, root: str) -> Operand | None:
        """When control goes from `source` to `target`, given that `root` runs."""
        base = self.of(source, root)
        inside = list(self.body.dag.successors(source))
        if len(inside) < 2:  # noqa: PLR2004 - one way on
            return base
        return self.both(base, self._taken(source, target))

    def leaving(self, source: str, target: str) -> Operand:
        """When control leaves the loop from `source` to `target`."""
        taken = self._taken(source, target)
        found = self.both(self.of(source), taken)
        return taken if found is None else found

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

    def _compute(self, name: str, root: str) -> Operand | None:
        dominator = self.body.immediate_dominator[name]
        if self.body.always_follows(name, dominator):
            return self.of(dominator, root)
        total: Operand | None = None
        for number, source in enumerate(self.body.dag.predecessors(name)):
            edge = self.edge(source, name, root)
            total = edge if number == 0 else self.either(total, edge)
        return total


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
    root = body.immediate_dominator[block]
    for operand, sources in groups.items():
        if operand == default:
            continue
        when: Operand | None = None
        for number, source in enumerate(sources):
            edge = predicates.edge(source, block, root)
            when = edge if number == 0 else predicates.either(when, edge)
        if when is None:
            return operand
        result = predicates.builder.add(Opcode.SELECT, [when, operand, result], phi.loc)
    return result
