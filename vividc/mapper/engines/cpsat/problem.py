"""One II's mapping problem, fully prepared: candidates, time windows, and where each word could be
and when.

Two timelines share every type and constraint here. On the *open* timeline a time counts cycles from
the start of the iteration, and a solution is a mapping. On the *cyclic* one it is a slot, time
modulo II: words lose their age, so a solution is no mapping yet, but a mapping always folds to a
solution. The cyclic problem is therefore a relaxation that needs no limit on schedule length or
lifetime, and its infeasibility refutes the II.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import Node
from vividc.machine.opcodes import Opcode
from vividc.mapper.bounds.bounds import usable_pes
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.dependences import (
    Dependence,
    dependences,
    earliest_starts,
    longest_tails,
)
from vividc.mapper.resources.distances import cycles_for, hop_distances, hops_a_cycle

NodeAt = tuple[int, int, int]
"""(node, PE, time): also a word by its producer, a PE and a time."""
LinkAt = tuple[int, int, int]
"""(producer of the word, link, time)."""


@dataclass(frozen=True, slots=True)
class Window:
    """First and last start time of a node, both allowed."""

    first: int
    last: int

    @property
    def times(self) -> range:
        """All start times."""
        return range(self.first, self.last + 1)


@dataclass(frozen=True)
class Prepared:
    """What the constraint families read.

    Attributes
    ----------
    windows
        Start times of each placed node. On the cyclic timeline 0 .. ii - 1.
    last_stage
        Cyclic only: start = slot + ii * stage with stage in 0 .. last_stage.
    """

    task: MapProblem
    ii: int
    windows: Mapping[int, Window]
    cyclic: bool = False
    last_stage: int = 0

    def wrap(self, time: int) -> int:
        """The time as this timeline counts it."""
        return time % self.ii if self.cyclic else time

    @property
    def fabric(self) -> Fabric:
        """The fabric mapped to."""
        return self.task.fabric

    @cached_property
    def nodes(self) -> tuple[Node, ...]:
        """Placed nodes."""
        return self.task.dfg.placed

    @cached_property
    def candidates(self) -> dict[int, tuple[int, ...]]:
        """PEs that each placed node may lie on."""
        return {node.id: usable_pes(self.task, node) for node in self.nodes}

    @cached_property
    def latency(self) -> dict[int, int]:
        """Latency of each placed node."""
        return {node.id: self.fabric.latency(node) for node in self.nodes}

    @cached_property
    def dependences(self) -> tuple[Dependence, ...]:
        """All edges between placed nodes."""
        return dependences(self.task.dfg, self.fabric)

    @cached_property
    def reads(self) -> dict[int, tuple[Dependence, ...]]:
        """Routed edges by producer; the keys are the words that exist."""
        by_word: dict[int, list[Dependence]] = {}
        for edge in self.dependences:
            if edge.routed:
                by_word.setdefault(edge.src, []).append(edge)
        return {word: tuple(edges) for word, edges in by_word.items()}

    @cached_property
    def starts(self) -> tuple[NodeAt, ...]:
        """Every (node, PE, time) at which the node could issue."""
        return tuple(
            (node.id, pe, time)
            for node in self.nodes
            for pe in self.candidates[node.id]
            for time in self.windows[node.id].times
        )

    @cached_property
    def on_links(self) -> tuple[LinkAt, ...]:
        """Every (word, link, time) at which the word could be readable at the end of the link."""
        return tuple(
            (word, link.id, time)
            for word in self.reads
            for link in self.fabric.links
            if self.fabric.routing.hops
            for time in self._on_link(word, link.src, link.dst)
        )

    @cached_property
    def in_registers(self) -> tuple[NodeAt, ...]:
        """Every (word, PE, time) at which a register of the PE could hold the word."""
        return tuple(
            (word, pe.id, time)
            for word in self.reads
            for pe in self.fabric.pes
            if pe.registers and pe.read_ports and pe.write_ports
            for time in self._between(word, pe.id, 0)
        )

    @cached_property
    def in_outputs(self) -> tuple[NodeAt, ...]:
        """Every (word, PE, time) at which the output register of the PE could hold the word; none
        where a word is there for one cycle and its own PE only, which its start says already.
        """
        routing = self.fabric.routing
        if not routing.open_outputs:
            return ()
        return tuple(
            (word, pe.id, time)
            for word in self.reads
            for pe in self.fabric.pes
            if routing.moves or pe.id in self.candidates[word]
            for time in self._between(word, pe.id, int(routing.shared))
        )

    @cached_property
    def moves(self) -> tuple[NodeAt, ...]:
        """Every (word, PE, time) at which the FU of the PE could move the word."""
        if not self.fabric.routing.moves:
            return ()
        return tuple((word, pe, self.wrap(time - 1)) for word, pe, time in self.in_outputs)

    @property
    def least_size(self) -> int:
        """Number of starts, without naming them: `size` takes long for the largest problems."""
        windows = self.windows
        return sum(len(windows[node].times) * len(pes) for node, pes in self.candidates.items())

    @property
    def size(self) -> int:
        """Number of Boolean variables the model will have, nearly."""
        layers = self.fabric.routing.hops if self.fabric.routing.hops > 1 else 0
        outputs = len(self.in_outputs) + len(self.moves)
        links = len(self.on_links) * (1 + layers)
        return len(self.starts) + links + 3 * len(self.in_registers) + outputs

    def _on_link(self, word: int, came_from: int, at: int) -> range:
        """Times at which the word can be at the end of a link; in the cycle before it may have
        passed others before and after this one.
        """
        if self.cyclic:
            return range(self.ii)
        a_cycle = self._hops_a_cycle
        first = self._ready[word] + cycles_for(self._way_to[word][came_from] + 1, a_cycle) - 1
        return range(first, self._last_at(word, at, a_cycle - 1) + 1)

    def _between(self, word: int, pe: int, ahead: int) -> range:
        """Times at which the word can be in a register of the PE; PEs up to `ahead` links away
        read it there.
        """
        if self.cyclic:
            return range(self.ii)
        first = self._ready[word] + cycles_for(self._way_to[word][pe], self._hops_a_cycle)
        return range(first, self._last_at(word, pe, ahead) + 1)

    def _last_at(self, word: int, pe: int, ahead: int) -> int:
        """Latest time at which the word at the PE can still reach a consumer in time."""
        return max(
            self.windows[edge.dst].last
            + self.ii * edge.distance
            - cycles_for(self._way_on[edge.dst][pe] - ahead, self._hops_a_cycle)
            for edge in self.reads[word]
        )

    @cached_property
    def _hops_a_cycle(self) -> int:
        return hops_a_cycle(self.fabric)

    @cached_property
    def _hops(self) -> tuple[tuple[int, ...], ...]:
        return hop_distances(self.fabric)

    @cached_property
    def _ready(self) -> dict[int, int]:
        """Earliest time at which each word is ready."""
        return {word: self.windows[word].first + self.latency[word] for word in self.reads}

    @cached_property
    def _way_to(self) -> dict[int, tuple[int, ...]]:
        """Links from the nearest PE on which each word can be made to each PE."""
        return {
            word: tuple(
                min(self._hops[origin][pe.id] for origin in self.candidates[word])
                for pe in self.fabric.pes
            )
            for word in self.reads
        }

    @cached_property
    def _way_on(self) -> dict[int, tuple[int, ...]]:
        """Links from each PE to the nearest on which each reader can lie."""
        readers = dict.fromkeys(edge.dst for edges in self.reads.values() for edge in edges)
        return {
            reader: tuple(
                min(self._hops[pe.id][target] for target in self.candidates[reader])
                for pe in self.fabric.pes
            )
            for reader in readers
        }


def fixed(task: MapProblem, ii: int, start: Mapping[int, int], slack: int = 0) -> Prepared:
    """Problem with every start within `slack` cycles of a schedule."""
    limit = ii * task.fabric.controller.max_stages - 1
    windows = {
        node: Window(max(time - slack, 0), min(time + slack, limit)) for node, time in start.items()
    }
    return Prepared(task, ii, windows)


def windowed(task: MapProblem, ii: int, slack: int) -> Prepared:
    """Problem with windows from ASAP to ALAP for a schedule `slack` cycles longer than the longest
    path.

    Raises ValueError if `ii` is below the RecMII or the longest path does not fit `max_stages`.
    """
    nodes = tuple(node.id for node in task.dfg.placed)
    edges = dependences(task.dfg, task.fabric)
    first = earliest_starts(nodes, edges, ii)
    if first is None:
        raise ValueError(f"II {ii} is below the RecMII")
    tails = longest_tails(nodes, edges, ii)
    longest = max((first[node] + tails[node] for node in nodes), default=0)
    limit = ii * task.fabric.controller.max_stages - 1
    if longest > limit:
        raise ValueError(f"the longest path does not fit the stages at II {ii}")
    length = min(longest + slack, limit)
    windows = {node: Window(first[node], length - tails[node]) for node in nodes}
    return Prepared(task, ii, windows)


def folded(task: MapProblem, ii: int) -> Prepared:
    """The cyclic problem: a relaxation of every schedule length."""
    windows = {node.id: Window(0, ii - 1) for node in task.dfg.placed}
    return Prepared(task, ii, windows, cyclic=True, last_stage=last_useful_stage(task, ii))


def last_useful_stage(task: MapProblem, ii: int) -> int:
    """Largest stage that the relaxation needs.

    With slots fixed, stages obey difference constraints stage[dst] >= stage[src] + k with k <=
    ceil((separation + ii - 1) / ii); the least solution is a longest simple path, so no stage
    exceeds the sum over nodes of the largest positive k out of each. `max_stages` limits it as
    well.
    """
    steps: dict[int, int] = {}
    for edge in dependences(task.dfg, task.fabric):
        step = -(-(edge.weight(ii) + ii - 1) // ii)
        steps[edge.src] = max(steps.get(edge.src, 0), step)
    return min(sum(steps.values()), task.fabric.controller.max_stages - 1)


def complete_slack(task: MapProblem, ii: int) -> int:
    """Slack from which on `windowed` loses no mapping, so that its infeasibility refutes the II.

    `max_stages` gives one limit. Routes give another. Each cycle of a word's way takes one (link,
    register or output register, slot) unit that no other word may use, so the ways of all words
    together last at most U = ii * (links + registers + PEs) cycles. Two nodes of a component
    connected by routed edges are joined by a simple path, on which each producer occurs at most
    twice: their starts differ by at most 2 U + sum(ii * distance) + 2 * sum(latency). Components
    joined by ORDER and CONTROL edges only (or not at all) may be moved by multiples of II: in the
    least solution each stands within II - 1 of 0 or of such a constraint, which adds separation +
    ii * (distance + 1) per such edge and II per component. The sum is an upper bound on the
    schedule's length.
    """
    fabric = task.fabric
    outputs = len(fabric.pes) if fabric.routing.open_outputs else 0
    units = ii * (len(fabric.links) + sum(pe.registers for pe in fabric.pes) + outputs)
    edges = dependences(task.dfg, fabric)
    length = 2 * units + 2 * sum(fabric.latency(node) for node in task.dfg.placed)
    length += sum(ii * edge.distance for edge in edges)
    length += sum(edge.separation + ii for edge in edges if not edge.routed)
    length += ii * len(task.dfg.placed)
    return min(length, ii * fabric.controller.max_stages)


def is_live_out(node: Node) -> bool:
    """Delivered to a constant store instead of an FU."""
    return node.op is Opcode.LIVE_OUT
