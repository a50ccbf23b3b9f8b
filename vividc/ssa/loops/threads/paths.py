"""When a thread runs a block: path predicates of a level, for one thread.

As in `if_convert`: a node that always follows its dominator needs no condition of its own, and
branches out of the loop count as not taken (Park and Schlansker 1991).
"""

from __future__ import annotations

from dataclasses import dataclass, field

from vividc.ssa.analysis.levels import Edge, Level
from vividc.ssa.ir import Const, Phi, Undefined, Value
from vividc.ssa.loops.threads.chain import Chain


@dataclass
class Paths:
    """Path predicates of the nodes of a level; None stands for always.

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

    def of(self, node: str, root: str | None = None) -> Value | None:
        """When a node runs, given that its dominator `root` (the level's header) does."""
        root = self.level.loop.header if root is None else root
        if node == root:
            return None
        dominator = self.level.dominator[node]
        if self.level.always_follows(node, dominator):
            return self.of(dominator, root)
        total: Value | None = None
        into = [edge for edge in self.level.edges if self.level.node(edge[1]) == node]
        for number, edge in enumerate(into):
            found = self.edge(edge, root)
            total = found if number == 0 else self.chain.either(total, found)
        return total

    def edge(self, edge: Edge, root: str | None = None) -> Value | None:
        """When control goes along an edge between nodes, given that `root` runs."""
        node = self.level.node(edge[0])
        base = self.of(node, root)
        ways = sum(self.level.node(source) == node for source, _ in self.level.edges)
        if ways < 2:  # noqa: PLR2004 - one way on
            return base
        return self.chain.both(base, self._taken(edge))

    def leaving(self, edge: Edge) -> Value:
        """When control leaves the loop along an edge, if it has not done so before."""
        taken = self._taken(edge)
        found = self.chain.both(self.of(self.level.node(edge[0])), taken)
        return Const(1) if found is None else found

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
        result, root = default, self.level.dominator[block]
        for value, sources in groups.items():
            if value == default:
                continue
            when: Value | None = None
            for number, source in enumerate(sources):
                found = self.edge((source, block), root)
                when = found if number == 0 else self.chain.either(when, found)
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
