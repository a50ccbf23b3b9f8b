"""Which accesses met in memory when a kernel was interpreted, and are kept in order by no path."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache

from vividc.dfg.interpret.interpreter import Watch
from vividc.dfg.ir import DFG, Node
from vividc.dfg.regions import Kernel
from vividc.machine.opcodes import Opcode


@dataclass
class Trace(Watch):
    """Watches a kernel that is interpreted, one run of a region after the other."""

    kernel: Kernel
    iteration: int = 0
    problems: set[str] = field(default_factory=set)
    _now: list[tuple[Node, int]] = field(default_factory=list)
    _last: dict[int, dict[int, int]] = field(default_factory=dict)
    """Of each byte: the last iteration in which each node touched it."""

    def __post_init__(self) -> None:
        self._graph = {id(n): r.dfg for r in self.kernel.regions for n in r.dfg.nodes}
        self._paths = {id(r.dfg): cache(_Paths(r.dfg).lengths) for r in self.kernel.regions}

    def enter(self) -> None:
        """A region begins."""
        self.iteration = 0
        self._last.clear()
        self._now.clear()

    def access(self, node: Node, byte: int) -> None:
        """A node touches bytes from `byte` on."""
        self._now.append((node, byte))

    def leave(self, *, exited: bool) -> None:
        """An iteration ends; one that exits did not mean what it read ahead."""
        for node, byte in self._now:
            if not (exited and node.unless_exit):
                self._touch(node, byte)
        self._now.clear()
        self.iteration += 1

    def _touch(self, node: Node, byte: int) -> None:
        dfg = self._graph[id(node)]
        for place in range(byte, byte + node.width):
            before = self._last.setdefault(place, {})
            for other, iteration in before.items():
                self._meet(dfg, dfg.by_id[other], node, self.iteration - iteration)
            before[node.id] = self.iteration

    def demand_order(self) -> None:
        """Fails if accesses met that are not kept in order."""
        assert not self.problems, f"met in memory, and not ordered: {self.problems}"

    def _meet(self, dfg: DFG, first: Node, second: Node, later: int) -> None:
        if Opcode.STORE not in (first.op, second.op) or (first is second and not later):
            return
        least = self._paths[id(dfg)]
        kept = least(first.id).get(second.id, later + 1) <= later
        if not kept and (later or least(second.id).get(first.id, 1)):
            self.problems.add(
                f"{dfg.name}: {first.op.value} {first.id} and {later} iterations later "
                f"{second.op.value} {second.id} at {first.loc}, {second.loc}"
            )


class _Paths:
    def __init__(self, dfg: DFG) -> None:
        self._dfg = dfg

    def lengths(self, source: int) -> dict[int, int]:
        """The least distance of a path from `source` to each node, of an edge or more."""
        least: dict[int, int] = {}
        work = [(source, 0)]
        while work:
            node, distance = work.pop()
            for edge in self._dfg.out_edges.get(node, ()):
                total = distance + edge.distance
                if total < least.get(edge.dst, total + 1):
                    least[edge.dst] = total
                    work.append((edge.dst, total))
        return least
