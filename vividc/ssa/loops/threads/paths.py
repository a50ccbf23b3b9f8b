"""When a thread runs a block: path predicates of a level, for one thread."""

from __future__ import annotations

from dataclasses import dataclass, field

from vividc.ssa.analysis.acyclic import Acyclic, Edge, PathPredicates
from vividc.ssa.analysis.levels import Level
from vividc.ssa.ir import Phi, Undefined, Value
from vividc.ssa.loops.threads.chain import Chain


@dataclass
class Paths(PathPredicates[Value]):
    """Path predicates of the nodes of a level.

    Attributes
    ----------
    conditions
        By block: its branch's predicate in this thread.
    left_by
        By edge out of an inner loop: whether the thread left the loop there.
    """

    level: Level
    chain: Chain
    conditions: dict[str, Value] = field(default_factory=dict)
    left_by: dict[Edge, Value] = field(default_factory=dict)

    @property
    def flow(self) -> Acyclic:
        """The level's nodes."""
        return self.level.flow

    def node(self, block: str) -> str:
        """The node that a block belongs to."""
        return self.level.node(block)

    def into(self, node: str) -> list[Edge]:
        """The edges that lead to a node."""
        return [edge for edge in self.level.edges if self.node(edge[1]) == node]

    def taken(self, edge: Edge) -> Value | None:
        """When control goes along an edge, given that its first node runs."""
        node = self.node(edge[0])
        ways = sum(self.node(source) == node for source, _ in self.level.edges)
        return self._taken(edge) if ways > 1 else None

    def both(self, left: Value | None, right: Value | None) -> Value | None:
        """Conjunction."""
        return self.chain.both(left, right)

    def either(self, left: Value | None, right: Value | None) -> Value | None:
        """Disjunction."""
        return self.chain.either(left, right)

    def leaving(self, edge: Edge) -> Value:
        """When control leaves the loop along an edge, if it has not done so before."""
        taken = self._taken(edge)
        leaves = self.chain.both(self.of(self.level.node(edge[0])), taken)
        assert leaves is not None  # a node of a loop also leads back to its header
        return leaves

    def merged(
        self, block: str, phi: Phi, values: dict[str, Value], carried: frozenset[Value]
    ) -> Value:
        """The choices that stand for a phi of a block other than the header.

        Parameters
        ----------
        values
            The thread's value of each input, by source.
        carried
            Values of the iteration before: the best to fall back on.
        """
        defined = {s: v for s, v in values.items() if not isinstance(v, Undefined)} or values
        groups: dict[Value, list[str]] = {}
        for source, value in defined.items():
            groups.setdefault(value, []).append(source)
        default = max(groups, key=lambda value: (value in carried, len(groups[value])))
        result, root = default, self.flow.dominator[block]
        for value, sources in groups.items():
            if value == default:
                continue
            when = self.any_of([(source, block) for source in sources], root)
            result = self.chain.select(when, value, result, phi.type)
        return result

    def _taken(self, edge: Edge) -> Value | None:
        source, target = edge
        if self.level.node(source) in self.level.children:
            return self.left_by.get(edge)  # None: there is no other way out
        branch = self.level.blocks[source].branch
        if branch.cond is None:
            return None
        condition = self.conditions[source]
        return condition if branch.target == target else self.chain.inverted(condition)
