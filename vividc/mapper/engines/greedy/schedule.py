"""One greedy pass over a straight region: each node in turn is placed and its operands are routed,
where and when the array allows it soonest.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from vividc.host import time_limit
from vividc.mapper.bounds.straight import Heights, end_after_start
from vividc.mapper.engines.greedy.board import FULL, NONE, PARKED, STEPS, new_board
from vividc.mapper.engines.greedy.order import (
    DONE,
    GOING,
    LONG,
    NO_ROOM,
    STUCK,
    Turn,
    place_some,
)
from vividc.mapper.engines.greedy.placing import PATIENCE, Options, Pass, Rules, has_room
from vividc.mapper.engines.greedy.search import new_search
from vividc.mapper.engines.greedy.task import Task, build_task
from vividc.mapper.engines.greedy.words import Ways, cycles_to_park
from vividc.mapper.engines.refusals import Stuck
from vividc.mapper.mapping import Mapping, Place, Step
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.arrays import Ints, ints
from vividc.mapper.resources.banks import Meets
from vividc.mapper.resources.distances import FAR

_BATCH: Final = 200
"""Placements that are tried before the clock is looked at again: some 5 ms."""
_SPOTS: Final = 64
_FEW: Final = 64
"""So many spots of words a node, and of as many more nodes: room at first. What is not used is not
touched, either.
"""


@dataclass(frozen=True, slots=True)
class Policy:
    """How one trial decides. Above `pressure` parked words per register, readers go first, of these
    if `deep` those of the newest words: chains beside each other come one after the other. A store
    with less than `spared` entries left is avoided by a cycle for each that is missing. An access
    is `apart` cycles late rather than that it meets another one in a bank.
    """

    urgency: dict[int, int]
    pressure: float
    deep: bool
    affinity: int
    constants: int
    spared: int
    apart: int


class Region:
    """A straight region, to be scheduled by passes.

    Attributes
    ----------
    task, nodes
        Its arrays, and its nodes by their numbers there.
    most
        Cycles by which a node may make a schedule longer, until its word waits in a register.
    cycles, spots
        Room of passes, for the schedule and for spots of words: it grows where it does not do.
    """

    def __init__(self, problem: MapProblem, heights: Heights, meets: Meets) -> None:
        self.problem, self.heights = problem, heights
        self.task, self.nodes = build_task(problem, heights, meets)
        self.routed = [index for index, _ in problem.dfg.routed_edges()]
        grid, nodes = self.task.grid, self.task.nodes
        apart = int(self.task.edges.before[:, 1].max(initial=0))
        longest = int((nodes.ends + nodes.busy + nodes.latency).max(initial=0))
        self.most = 2 * grid.diameter + 3 * PATIENCE + apart + longest + cycles_to_park(grid)
        least = max(max(heights.of.values(), default=1), len(self.nodes) // grid.pes)
        least = max(least, 0 if problem.drain is None else problem.drain.cycles)
        self.cycles = least + least // 4 + 2 * self.most
        self.spots = _SPOTS * (_FEW + len(self.nodes))

    def grow(self, *, spots: bool) -> None:
        """Make more room for spots of words, or for cycles."""
        if spots:
            self.spots *= 2
        else:
            self.cycles *= 2


class Schedule:
    """One greedy pass over a region: `job` and `turn` are how far it has come."""

    def __init__(self, region: Region, policy: Policy) -> None:
        self.region, self.policy = region, policy
        task, urgency = region.task, policy.urgency
        self.registers = task.grid.places - task.grid.links
        of = region.heights.of
        rules = Rules(
            policy.pressure * self.registers,
            int(policy.deep),
            policy.affinity,
            policy.constants,
            policy.spared,
            policy.apart,
            ints(-of[node.id] - urgency.get(node.id, 0) for node in region.nodes),
        )
        self.job, self.turn = _new_pass(region, rules), _new_turn(task)

    @property
    def waits(self) -> float:
        """Cycles in which accesses are expected to wait for each other."""
        return float(self.turn.late[0])

    def run(self, below: float = math.inf) -> int | None:
        """Place every node; the cycles of the region, or None, once it is sure to take as many as
        `below`, with those in which accesses wait.

        Raises
        ------
        Stuck
            A node has no place.
        """
        region, stands = self.region, GOING
        while stands in (GOING, NO_ROOM):
            time_limit.step("straight regions were scheduled")
            if stands == NO_ROOM:
                region.grow(spots=bool(self.job.board.counts[FULL]))
                self.job, self.turn = _new_pass(region, self.job.rules), _new_turn(region.task)
            stands = place_some(self.job, self.turn, _BATCH, float(below), region.most)
        if stands == LONG:
            return None
        if stands != DONE:
            node = region.nodes[stands - STUCK]
            raise Stuck(node, self._why_stuck(stands - STUCK))
        for node, pe in zip(region.nodes, self._by_node(self.job.board.begin.pe), strict=True):
            if pe == NONE:
                raise Stuck(node, "its dependences form a cycle")
        return max(1, int(self.job.horizon[0]))

    def starts(self) -> dict[int, int]:
        """The cycle in which each node begins, by id, once all have a place."""
        starts = self._by_node(self.job.board.begin.start)
        return {node.id: start for node, start in zip(self.region.nodes, starts, strict=True)}

    def mapping(self) -> Mapping:
        """What was found, once all nodes have a place."""
        board, nodes = self.job.board, self.region.nodes
        pes, starts = self._by_node(board.begin.pe), self._by_node(board.begin.start)
        places = zip(nodes, pes, starts, strict=True)
        steps, edges = self._steps(), len(self.region.routed)
        first = board.cells[board.begin.route : board.begin.route + edges].tolist()
        length = board.cells[board.begin.length : board.begin.length + edges].tolist()
        rows = zip(self.region.routed, first, length, strict=True)
        return Mapping(
            self._length(starts),
            {node.id: Place(pe, start) for node, pe, start in places},
            {edge: tuple(steps[begin : begin + count]) for edge, begin, count in rows},
        )

    def _length(self, starts: Sequence[int]) -> int:
        """Cycles of the region, without those that a loop behind it has to wait."""
        problem = self.region.problem
        pairs = zip(self.region.nodes, starts, strict=True)
        ends = (start + end_after_start(problem.fabric, node) for node, start in pairs)
        return max(1, 0 if problem.drain is None else problem.drain.cycles, *ends)

    def _by_node(self, table: int) -> list[int]:
        found: list[int] = self.job.board.cells[table : table + len(self.region.nodes)].tolist()
        return found

    def _steps(self) -> list[Step]:
        """Of all routes, one after the other."""
        board, grid = self.job.board, self.region.task.grid
        time, place = np.divmod(
            board.steps[: board.cells[board.begin.numbers + STEPS]], grid.places
        )
        is_link = place < grid.links
        pe = grid.end[place]
        index = np.where(is_link, place, place - grid.first[pe])
        kinds: list[Literal["link", "reg"]] = ["link" if one else "reg" for one in is_link]
        return list(map(Step, kinds, pe.tolist(), index.tolist(), time.tolist()))

    # --- refusals ---

    def _why_stuck(self, number: int) -> str:
        task, node = self.region.task, self.region.nodes[number]
        candidates = self.region.problem.candidates(node)
        if not any(has_room(task, self.job.board, number, pe) for pe in candidates):
            return "no constant store of a PE that could take it has room for its constants"
        if all(self.job.options.earliest[pe] >= FAR for pe in candidates):
            return "no links lead from its operands to a PE that could take it"
        board = self.job.board
        if board.cells[board.begin.numbers + PARKED] >= self.registers:
            return f"all {self.registers} registers hold words that are still needed"
        begin = task.nodes.source_begin
        words = int(begin[number + 1] - begin[number])
        if all(words > self._words_at_once(pe) for pe in candidates):
            return f"it reads {words} words at once, more than links and read ports of a PE bring"
        return "no cycle has links and register ports free for its operands and its result"

    def _words_at_once(self, pe: int) -> int:
        grid = self.region.task.grid
        return int(grid.into_begin[pe + 1] - grid.into_begin[pe] + grid.read_ports[pe])


def _new_pass(region: Region, rules: Rules) -> Pass:
    task, problem = region.task, region.problem
    drain = problem.drain
    pes = task.grid.pes
    most = int(np.diff(task.nodes.read_begin).max(initial=0))
    by_pe = [_zeros(pes) for _ in Options._fields[1:]]
    options = Options(_zeros(most), *by_pe)
    loops = [one for one in (drain, problem.fill) if one is not None]
    return Pass(
        task,
        rules,
        new_board(task, region.cycles, region.spots, loops),
        new_search(task.grid, region.cycles),
        Ways(np.zeros((cycles_to_park(task.grid) + 1, pes), dtype=np.int64)),
        options,
        ints((0 if drain is None else drain.cycles,)),
        _zeros(1),
    )


def _new_turn(task: Task) -> Turn:
    nodes = len(task.nodes.kind)
    ready = np.flatnonzero(task.nodes.waits == 0)
    every = _zeros(nodes)
    every[: len(ready)] = ready
    count = ints((len(ready), 0))
    return Turn(every, task.nodes.waits.copy(), _zeros(nodes), count, np.zeros(1))


def _zeros(length: int) -> Ints:
    return np.zeros(length, dtype=np.int64)
