"""When blocks of a loop's body run, as conjunctions of its branches' tests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

from vividc.ssa.analysis.acyclic import Acyclic, Edge, PathPredicates
from vividc.ssa.analysis.levels import Level
from vividc.ssa.edit import read_values
from vividc.ssa.ir import Const, Function, Ref, Value

Conjunction = frozenset[tuple[Value, bool]]
"""Tests and whether they hold, all at once."""

CONTRARY: Final = (Const(0), True)
"""Is in the conjunction of a block that runs where one or another one holds, which is none."""


@dataclass(frozen=True)
class Conjunctions(PathPredicates[Conjunction]):
    """Of the nodes of a level."""

    level: Level

    @property
    def flow(self) -> Acyclic:
        """The nodes."""
        return self.level.flow

    def node(self, block: str) -> str:
        """The node that a block belongs to."""
        return self.level.node(block)

    def into(self, node: str) -> Sequence[Edge]:
        """The edges that lead to a node."""
        return [edge for edge in self.level.edges if self.node(edge[1]) == node]

    def taken(self, edge: Edge) -> Conjunction | None:
        """The test of a branch inside the loop; exits of inner loops are taken in any case."""
        source, target = edge
        branch = self.level.blocks[source].branch
        leaves = not set(branch.successors) <= self.level.loop.blocks
        if self.node(source) in self.level.children or leaves or len(set(branch.successors)) == 1:
            return None
        assert branch.cond is not None
        return frozenset({(branch.cond, target == branch.successors[0])})

    def both(self, left: Conjunction | None, right: Conjunction | None) -> Conjunction | None:
        """All tests of two."""
        if left is None or right is None:
            return left or right
        return left | right

    def either(self, left: Conjunction | None, right: Conjunction | None) -> Conjunction | None:
        """`CONTRARY`, unless two are one."""
        return left if left == right else frozenset({CONTRARY})


def only_tested(function: Function) -> set[int]:
    """Ids of what nothing but branches reads."""
    read: set[Value] = set()
    for block in function.blocks:
        read.update(read_values(replace(block, branch=replace(block.branch, cond=None))))
    tests = {block.branch.cond for block in function.blocks} - read
    return {value.id for value in tests if isinstance(value, Ref)}
