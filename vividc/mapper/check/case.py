"""What the verifier sees, a mapping with the places that make sense, and what it reports."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from collections.abc import Mapping as ReadOnly
from dataclasses import dataclass

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG, Edge, Node
from vividc.mapper.mapping import Mapping, Place


@dataclass(frozen=True, slots=True)
class Violation:
    """One broken rule.

    Attributes
    ----------
    kind
        Short name of the rule, for tests and tables: "missing", "issue", "register", ...
    message
        What is wrong, in one sentence.
    nodes
        Ids of the nodes involved.
    """

    kind: str
    message: str
    nodes: tuple[int, ...] = ()

    def __str__(self) -> str:
        return f"{self.kind}: {self.message}"


@dataclass(frozen=True)
class Case:
    """What is verified. `places` holds the nodes whose place makes sense, `latency` theirs."""

    dfg: DFG
    fabric: Fabric
    mapping: Mapping
    places: ReadOnly[int, Place]
    latency: ReadOnly[int, int]

    @property
    def ii(self) -> int:
        return self.mapping.ii

    def slot(self, time: int) -> int:
        return time % self.mapping.ii

    def ready(self, node: int) -> int:
        """First cycle in which the result of `node` can be used."""
        return self.places[node].time + self.latency[node]

    def read_time(self, edge: Edge) -> int:
        """Cycle in which the consumer reads, in the producer's iteration."""
        return self.places[edge.dst].time + self.ii * edge.distance

    def placed(self) -> Iterator[tuple[Node, Place]]:
        for node in self.dfg.placed:
            place = self.places.get(node.id)
            if place is not None:
                yield node, place

    def show(self, node: int) -> str:
        return f"node {node} ({self.dfg.by_id[node].op.value})"


def listed(items: Iterable[int]) -> str:
    """Ids in a sentence."""
    return ", ".join(str(item) for item in items)
