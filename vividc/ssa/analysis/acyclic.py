"""Control flow without cycles: the order of its nodes, what dominates them, and when each runs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Generic, TypeVar

import networkx as nx

_SINK = ""
_Word = TypeVar("_Word")

Edge = tuple[str, str]
"""From a block to a block."""


@dataclass(frozen=True)
class Acyclic:
    """Nodes that control passes from `entry` on, each at most once."""

    graph: nx.DiGraph[str]
    entry: str

    @cached_property
    def order(self) -> tuple[str, ...]:
        """The nodes in topological order."""
        position = {name: index for index, name in enumerate(self.graph.nodes)}
        return tuple(nx.lexicographical_topological_sort(self.graph, key=position.__getitem__))

    @cached_property
    def dominator(self) -> dict[str, str]:
        """Immediate dominator of each node but the entry."""
        return dict(nx.immediate_dominators(self.graph, self.entry))

    @cached_property
    def _post_dominators(self) -> dict[str, str]:
        graph = self.graph.reverse(copy=True)
        graph.add_edges_from(
            (_SINK, name) for name in self.graph if not self.graph.out_degree(name)
        )
        return dict(nx.immediate_dominators(graph, _SINK))

    @cached_property
    def _reached(self) -> dict[str, set[str]]:
        reached: dict[str, set[str]] = {}
        for name in reversed(self.order):
            reached[name] = {name}.union(*(reached[after] for after in self.graph[name]))
        return reached

    def always_follows(self, node: str, after: str) -> bool:
        """Whether `node` runs whenever `after` does, exits aside."""
        walk = after
        while walk not in (node, _SINK):
            walk = self._post_dominators[walk]
        return walk == node

    def reaches(self, source: str, target: str) -> bool:
        """Whether control may come from `source` to `target`."""
        return target in self._reached[source]


class PathPredicates(ABC, Generic[_Word]):
    """When nodes run; None stands for always.

    As by Park and Schlansker (1991), simplified by dominance: a node that post-dominates its
    immediate dominator needs no condition of its own. Branches out of the loop count as not taken.
    """

    @property
    @abstractmethod
    def flow(self) -> Acyclic:
        """The nodes."""

    @abstractmethod
    def node(self, block: str) -> str:
        """The node that a block belongs to."""

    @abstractmethod
    def into(self, node: str) -> Sequence[Edge]:
        """The edges that lead to a node."""

    @abstractmethod
    def taken(self, edge: Edge) -> _Word | None:
        """When control goes along an edge, given that the node where it begins runs."""

    @abstractmethod
    def both(self, left: _Word | None, right: _Word | None) -> _Word | None:
        """Conjunction."""

    @abstractmethod
    def either(self, left: _Word | None, right: _Word | None) -> _Word | None:
        """Disjunction."""

    def of(self, node: str, root: str | None = None) -> _Word | None:
        """When a node runs, given that its dominator `root` (default: the entry) does."""
        root = self.flow.entry if root is None else root
        if node == root:
            return None
        dominator = self.flow.dominator[node]
        if self.flow.always_follows(node, dominator):
            return self.of(dominator, root)
        return self.any_of(self.into(node), root)

    def any_of(self, edges: Iterable[Edge], root: str) -> _Word | None:
        """When control goes along one of the edges, given that `root` runs."""
        total: _Word | None = None
        for number, edge in enumerate(edges):
            base = self.of(self.node(edge[0]), root)
            goes = self.both(base, self.taken(edge))
            total = goes if number == 0 else self.either(total, goes)
        return total
