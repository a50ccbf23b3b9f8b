"""Which accesses met in memory when a kernel was interpreted, and are kept in order by no path; and
whether they went where their address forms say.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache

from vividc.dfg.interpret.interpreter import Watch
from vividc.dfg.ir import CHANGES, DFG, Node
from vividc.dfg.regions import Kernel
from vividc.machine.opcodes import Opcode
from vividc.ssa.analysis.polynomial import ITERATION


@dataclass
class Trace(Watch):
    """Watches a kernel that is interpreted, one run of a region after the other."""

    kernel: Kernel
    iteration: int = 0
    problems: set[str] = field(default_factory=set)
    misplaced: set[str] = field(default_factory=set)
    _now: list[tuple[Node, int]] = field(default_factory=list)
    _last: dict[int, dict[int, int]] = field(default_factory=dict)
    """Of each byte: the last iteration in which each node touched it."""
    _rests: dict[frozenset[object], int] = field(default_factory=dict)
    """What sums of unknown words are, of a run of the region."""

    def __post_init__(self) -> None:
        self._graph = {id(n): r.dfg for r in self.kernel.regions for n in r.dfg.nodes}
        self._paths = {id(r.dfg): cache(_Paths(r.dfg).lengths) for r in self.kernel.regions}

    def enter(self) -> None:
        """A region begins."""
        self.iteration = 0
        self._last.clear()
        self._rests.clear()
        self._now.clear()

    def access(self, node: Node, byte: int) -> None:
        """A node touches bytes from `byte` on."""
        self._now.append((node, byte))

    def leave(self, *, exited: bool) -> None:
        """An iteration ends; one that exits did not mean what it read ahead."""
        for node, byte in self._now:
            if not (exited and node.unless_exit):
                self._touch(node, byte)
                self._place(node, byte)
        self._now.clear()
        self.iteration += 1

    def _touch(self, node: Node, byte: int) -> None:
        dfg = self._graph[id(node)]
        for place in range(byte, byte + node.width):
            before = self._last.setdefault(place, {})
            for other, iteration in before.items():
                self._meet(dfg, dfg.by_id[other], node, self.iteration - iteration)
            before[node.id] = self.iteration

    def _place(self, node: Node, byte: int) -> None:
        """Where two addresses differ by a number, by their forms, they must."""
        steps = {(): 1, (ITERATION.key,): self.iteration}
        terms = dict(node.address or ())
        known = sum(terms.pop(words, 0) * times for words, times in steps.items())
        words = {word for words in terms for word in words}
        if ITERATION.key in words or any(word.startswith(CHANGES) for word in words):
            terms[f"iteration {self.iteration}",] = 1
        rest = (byte - known) % (1 << 32)
        if self._rests.setdefault(frozenset(terms.items()), rest) != rest:
            self.misplaced.add(f"{node.op.value} {node.id} at {node.loc}: {node.address}")

    def demand_order(self) -> None:
        """Fails if accesses met that are not kept in order, or went where they should not."""
        assert not self.misplaced, f"not where their forms say: {self.misplaced}"
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
