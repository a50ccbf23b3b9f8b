"""What words need of output registers where those are the only way from PE to PE: a relaxation.

A *cell* is an output register in a slot. A word takes the cell in which it is ready, one for each
move, and one for each further cycle in which an output register holds it. The times of the schedule
say how many it needs at least, wherever its readers lie:

*Reads.* Who reads a word in a slot does so beside a cell that holds it, or on a PE at which it has
entered the register file, as a result: its own, or one that moved it. A PE issues one operation a
slot, so a slot has at most one such reader on each PE at which the word was a result, and as many
more beside each of its cells as other PEs read an output register.

*Lives.* A register holds a word for II cycles, then the next iteration's word wants the place, and
the word must be a result again.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ortools.sat.python.cp_model import CpModel, IntVar, LinearExpr

from vividc.arch.fabric import Fabric
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.dependences import Dependence, dependences


def outputs_are_the_only_way(fabric: Fabric) -> bool:
    """Whether words leave a PE through its output register only, and enter register files as
    results only.
    """
    files = all(pe.written_by_fu or not pe.registers for pe in fabric.pes)
    return fabric.routing.open_outputs and not fabric.routing.hops and files


def cells_suffice(
    model: CpModel,
    task: MapProblem,
    ii: int,
    start: Mapping[int, IntVar],
    in_slot: Mapping[int, Sequence[Sequence[IntVar]]],
) -> None:
    """Add the relaxation to a model of times.

    Parameters
    ----------
    start
        Time of each placed node.
    in_slot
        For each placed node and slot, literals of which one says that the node starts there.
    """
    if outputs_are_the_only_way(task.fabric):
        _Cells(model, task, ii, start, in_slot).add()


@dataclass(frozen=True)
class _Cells:
    model: CpModel
    task: MapProblem
    ii: int
    start: Mapping[int, IntVar]
    in_slot: Mapping[int, Sequence[Sequence[IntVar]]]

    def add(self) -> None:
        """One word after another, then the cells that all take together."""
        readers: dict[int, list[Dependence]] = {}
        for edge in dependences(self.task.dfg, self.task.fabric):
            if edge.routed:
                readers.setdefault(edge.src, []).append(edge)
        taken: list[list[LinearExpr]] = [[] for _ in range(self.ii)]
        for node in self.task.dfg.operations:
            word = _Word(self, node.id)
            if node.id in readers:
                word.is_read(readers[node.id])
            for slot, terms in enumerate(taken):
                terms.append(word.cells(slot))
        for terms in taken:
            self.model.add(LinearExpr.sum(terms) <= len(self.task.fabric.pes))

    def starts_in(self, node: int, slot: int) -> LinearExpr:
        """1 if the node starts in the slot, else 0."""
        return _total(self.in_slot[node][slot % self.ii])


class _Word:
    """What one word takes; `moves` and `holds` by slot."""

    def __init__(self, cells: _Cells, node: int) -> None:
        self.all, self.node = cells, node
        self.latency = cells.task.fabric.latency(cells.task.dfg.by_id[node])
        self.moves: list[IntVar] = []
        self.holds: list[IntVar] = []

    def is_read(self, edges: Sequence[Dependence]) -> None:
        """Let it move and stay, and give every reader its place."""
        model, routing, ii = self.all.model, self.all.task.fabric.routing, self.all.ii
        most = len(self.all.task.fabric.pes)
        slots = range(ii)
        moved, held = most * routing.moves, most * routing.holds
        self.moves = [model.new_int_var(0, moved, f"moves[{self.node},{s}]") for s in slots]
        self.holds = [model.new_int_var(0, held, f"holds[{self.node},{s}]") for s in slots]
        for slot in slots:
            model.add(self.holds[slot] <= self.cells(slot - 1))
        self._lives(edges)
        self._reads(edges)

    def cells(self, slot: int) -> LinearExpr:
        """Output registers that hold it in the slot."""
        return self._made(slot) + self._later(slot) if self.moves else self._made(slot)

    def _made(self, slot: int) -> LinearExpr:
        return self.all.starts_in(self.node, slot - self.latency)

    def _later(self, slot: int) -> LinearExpr:
        return self.moves[(slot - 1) % self.all.ii] + self.holds[slot % self.all.ii]

    def _results(self) -> LinearExpr:
        """Times that it is a result, moves counted."""
        return _total(self.moves) + 1

    def _lives(self, edges: Sequence[Dependence]) -> None:
        """II cycles for each time that it is a result, one more for each that it is held on."""
        fabric, start = self.all.task.fabric, self.all.start
        if any(pe.rotating for pe in fabric.pes):
            return
        most = self.all.ii if any(pe.registers for pe in fabric.pes) else 1
        lasts = self._results() * most + _total(self.holds)
        for edge in edges:
            life = start[edge.dst] + self.all.ii * edge.distance - start[edge.src] - edge.latency
            self.all.model.add(lasts >= life + 1)

    def _reads(self, edges: Sequence[Dependence]) -> None:
        """In each slot: all reads, and those that do not come in the very cycle of the result."""
        model, ii, fabric = self.all.model, self.all.ii, self.all.task.fabric
        nodes = self.all.task.dfg.by_id
        beside = max(Counter(pe for seen in fabric.outputs_seen_by for pe in seen).values())
        others = {e.dst for e in edges if e.dst != self.node and nodes[e.dst].uses_fu}
        later = {reader: self._reads_later(reader, edges) for reader in sorted(others)}
        for slot in range(ii):
            own = self._results() - self.all.starts_in(self.node, slot) - self.moves[slot]
            reads = [self.all.starts_in(reader, slot) for reader in sorted(others)]
            model.add(LinearExpr.sum(reads) <= own + self.cells(slot) * (beside - 1))
            waits: list[IntVar] = []
            for reader, literal in later.items():
                both = model.new_bool_var(f"waits[{self.node},{reader},{slot}]")
                model.add(both >= self.all.starts_in(reader, slot) + literal - 1)
                waits.append(both)
            model.add(LinearExpr.sum(waits) <= own + self._later(slot) * (beside - 1))

    def _reads_later(self, reader: int, edges: Sequence[Dependence]) -> IntVar:
        """A literal that is 1 if the reader reads it in another cycle than that of the result."""
        start, literal = self.all.start, self.all.model.new_bool_var(f"later[{self.node},{reader}]")
        for edge in edges:
            if edge.dst == reader:
                read = start[reader] + self.all.ii * edge.distance
                made = start[self.node] + edge.latency
                self.all.model.add(read == made).only_enforce_if(~literal)
        return literal


def _total(variables: Sequence[IntVar]) -> LinearExpr:
    """Their sum; there is one at least."""
    return LinearExpr.weighted_sum(list(variables), [1] * len(variables))
