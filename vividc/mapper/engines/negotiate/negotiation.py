"""One attempt at an II: anneal places and times, negotiate routes, name registers."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping as ReadOnly
from collections.abc import Sequence

import numpy as np

from vividc.mapper.deadline import Deadline
from vividc.mapper.engines.negotiate import tuning
from vividc.mapper.engines.negotiate.anneal import State, anneal, new_heat
from vividc.mapper.engines.negotiate.arrays import Task, build_task
from vividc.mapper.engines.negotiate.frame import Frame
from vividc.mapper.engines.negotiate.lockstep import Steps
from vividc.mapper.engines.negotiate.motion import new_motion
from vividc.mapper.engines.negotiate.places import broken, lie_all, new_places
from vividc.mapper.engines.negotiate.repair import new_undo, repair
from vividc.mapper.engines.negotiate.traffic import (
    DIRECT,
    FREELY,
    OVER,
    PRESSURE,
    claim,
    new_graph,
    new_scratch,
    new_traffic,
    raise_prices,
    reprice_all,
)
from vividc.mapper.engines.negotiate.tuning import Effort
from vividc.mapper.engines.negotiate.ways import Router, route_as_shown, route_round
from vividc.mapper.engines.negotiate.words import hide_all, new_words, show_all
from vividc.mapper.mapping import Mapping, Place, Step
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.arrays import Ints, Ints2, ints
from vividc.mapper.resources.moved_words import allocate_with_moves
from vividc.mapper.resources.mrrg import MRRG, NONE, Spot, build_mrrg
from vividc.mapper.resources.registers import Lifetime, allocate


class Negotiation:
    """The arrays of one II and what the compiled functions do with them.

    `quits`: see `Effort`; `is_far`: the last trial was given up far from a mapping.
    """

    def __init__(
        self,
        problem: MapProblem,
        ii: int,
        frame: Frame,
        seed: int,
    ) -> None:
        self.problem, self.ii = problem, ii
        self.mrrg: MRRG = build_mrrg(problem.fabric)
        self.task: Task
        self.task, self.ids = build_task(problem, ii, frame, self.mrrg)
        self.density = max(len(self.task.edges.src) / len(self.ids) / tuning.TYPICAL_EDGES, 1.0)
        self.places = new_places(self.task, seed)
        self.words = new_words(self.task)
        self.cooling = tuning.SHOWN if self.task.array.moves else tuning.FREELY
        self.warm, self.quits, self.is_far = frame.origin is not None, False, False
        if frame.origin is None:
            self._put(frame.begin)
        else:
            self._put_as(frame.origin, frame.last)
        latest = max(frame.last.values(), default=0)
        self.cycles = latest + int(self.task.edges.ahead.max(initial=0)) + 1
        sinks = int(np.diff(self.task.edges.sink_begin).max(initial=0))
        self.room = self.cycles + min(self.cycles, 4 * ii) + 8 * sinks

    @property
    def fits(self) -> bool:
        """Whether the work space is of a sensible size."""
        cells = max(self.cycles * self.mrrg.locations, self.room * len(self.ids))
        return cells <= tuning.MOST_CELLS

    def _put(self, start: ReadOnly[int, int]) -> None:
        nodes = self.task.nodes
        first, choices = nodes.pe_begin[:-1], np.diff(nodes.pe_begin)
        pes = nodes.pe_items[first + np.arange(len(self.ids)) % choices]
        lie_all(self.task, self.places, pes, ints(start[name] for name in self.ids))

    def _put_as(self, origin: Mapping, last: ReadOnly[int, int]) -> None:
        """Have nodes be where they are in a mapping, or as late as the frame lets them."""
        places = [origin.places[name] for name in self.ids]
        times = [min(place.time, last[name]) for place, name in zip(places, self.ids, strict=True)]
        lie_all(self.task, self.places, ints(place.pe for place in places), ints(times))

    def run(self, effort: Effort, deadline: Deadline) -> Steps[Mapping | None]:
        """Try until a mapping is found or all trials have failed."""
        times = effort.shown if self.task.array.moves else 1
        self.quits = effort.quits
        for _ in range(effort.trials):
            moves, self.is_far = effort.moves * len(self.ids) * times, False
            if (yield from self._anneal(moves, deadline)):
                mapping = yield from self._routed(effort, deadline)
                if mapping is not None:
                    return mapping
            if deadline.passed:
                return None
        return None

    def _anneal(self, moves: int, deadline: Deadline) -> Steps[bool]:
        """Anneal from where nodes are, and again less hot where little is left broken; True when
        nothing is in the end but what moves of words break.
        """
        task, places, words = self.task, self.places, self.words
        show_all(task, places, words)
        first = self.cooling.warm if self.warm else 1.0
        little = tuning.LITTLE_IN_HASTE if self.quits else tuning.LITTLE
        for part in (first, *self.cooling.again):
            yield from self._cool(part, int(moves * part**0.5), deadline)
            if not 0 < broken(task, places) <= little:
                break
        hide_all(task, places, words)
        return broken(task, places) == 0

    def _cool(self, part: float, moves: int, deadline: Deadline) -> Steps[None]:
        """Anneal once, from a part of the heat. Where moves are claimed, what crowds nothing any
        more is only quenched, so that words wait less: registers are not claimed.
        """
        state = State(self.places, self.words, new_motion(self.task, self.words))
        heat, end = new_heat(part * self.cooling.hot, self.cooling.cold, moves), moves
        done, quenched = 0, not self.task.array.moves
        while done < end and not deadline.passed:
            moves_now = min(tuning.SLICE, end - done)
            anneal(self.task, state, heat, moves_now)
            done += tuning.SLICE
            move_s = tuning.SHOWN_MOVE_S if self.task.array.moves else tuning.MOVE_S
            yield self.density * moves_now * move_s
            if self.quits and not self.task.array.moves and self._is_frozen(float(heat.value[0])):
                break
            if not quenched and broken(self.task, self.places) == 0:
                quenched, end = True, min(end, done + int(tuning.QUENCH * moves))
                hot = min(float(heat.value[0]), tuning.QUENCH_HOT)
                heat = new_heat(hot, tuning.QUENCH_COLD, end - done)

    def _is_frozen(self, heat: float) -> bool:
        """Whether what is broken at this heat stays so, and notes if it is much."""
        left = broken(self.task, self.places)
        part = (left - tuning.LEAST_FAR) / len(self.ids)
        self.is_far = any(heat <= hot and part >= least for hot, least in tuning.FAR)
        return self.is_far or any(heat <= hot and left >= least for hot, least in tuning.FROZEN)

    def _routed(self, effort: Effort, deadline: Deadline) -> Steps[Mapping | None]:
        """Route and name registers; where a file's words fit but have no allocation, again with
        one register less there.
        """
        self.traffic = new_traffic(self.mrrg, self.task, self.room)
        scratch = new_scratch(self.mrrg, self.cycles)
        graph = new_graph(self.mrrg, self.problem.fabric)
        self.router = Router(graph, self.task, self.places, self.traffic, scratch)
        for turn in range(tuning.NAMING_ROUNDS):
            moves = effort.repairs * len(self.ids)
            if turn == 0 and self._as_shown():
                free = yield from self._repaired(moves, tuning.SHOWN_REPAIR_HEATS, deadline)
            else:
                free = yield from self._negotiate(effort, deadline, fresh=turn == 0)
                free = free or (not self.is_far and (yield from self._repair(moves, deadline)))
            if not free:
                return None
            registers, crowded = self._name_registers()
            yield tuning.CUT_S * self.files_cut
            if not crowded:
                return self._mapping(registers)
            if not all(self._shrink(pe) for pe in crowded):
                return None
        return None

    def _as_shown(self) -> bool:
        """Route words as the annealer claimed moves for them; False if some cannot be routed so."""
        if not self.task.array.moves:
            return False
        return bool(route_as_shown(self.router, self.words) == 0)

    def _negotiate(self, effort: Effort, deadline: Deadline, *, fresh: bool) -> Steps[bool]:
        """Rounds of rip-up and re-route; True when nothing is crowded."""
        traffic = self.traffic
        most = max(tuning.LEAST_CROWDED, tuning.CROWDED * len(self.ids))
        for turn in range(effort.rounds):
            lost = route_round(self.router, fresh and turn == 0)
            if lost or deadline.passed:
                return False
            if traffic.totals[OVER] == 0:
                return True
            if self.quits and turn >= tuning.CROWDED_ROUND and traffic.totals[OVER] > most:
                self.is_far = True
                return False
            raise_prices(traffic, self.ii, tuning.HISTORY, tuning.GROWTH, tuning.MOST_PRESSURE)
            yield self.density * tuning.ROUTED_S * len(self.ids)
        return False

    def _repair(self, moves: int, deadline: Deadline) -> Steps[bool]:
        """Move nodes with their routes, in turns from those that are there and from new ones if
        they crowd little, else from new ones; True when nothing is crowded.
        """
        if not self.task.array.outputs and 0 < self.traffic.totals[OVER] <= tuning.FEW:
            return (yield from self._repair_in_turns(moves, deadline))
        heats = tuning.REPAIR_HEATS
        if self.task.array.outputs:
            heats = tuning.OUTPUT_REPAIR_HEATS
            nodes = max(tuning.OUTPUT_NODES, len(self.ids))
            moves *= max(1, tuning.OUTPUT_REPAIRS * tuning.OUTPUT_NODES // nodes)
        return (yield from self._repaired_anew(moves, heats, deadline))

    def _repair_in_turns(self, moves: int, deadline: Deadline) -> Steps[bool]:
        """Repair the same negotiated places in two ways, each with its share of the moves."""
        began = [part.copy() for part in self._state()]
        share = int(tuning.FEW_SHARE * moves)
        if (yield from self._repaired(moves, tuning.NEARLY_FREE_HEATS, deadline, most=share)):
            return True
        if deadline.passed:
            return False
        for part, before in zip(self._state(), began, strict=True):
            part[...] = before
        return (yield from self._repaired_anew(share, tuning.REPAIR_HEATS, deadline, trades=True))

    def _state(self) -> tuple[Ints | Ints2, ...]:
        """What moves change of where nodes are; what is drawn next goes on."""
        return tuple(part for part in self.places if part is not self.places.random)

    def _repaired_anew(
        self,
        moves: int,
        heats: tuple[float, float],
        deadline: Deadline,
        *,
        trades: bool = False,
    ) -> Steps[bool]:
        """Route everything anew, then move nodes with their routes."""
        traffic = self.traffic
        traffic.history[:] = 1.0
        traffic.totals[PRESSURE] = tuning.REPAIR_PRESSURE
        reprice_all(traffic, self.ii)
        if route_round(self.router, True):
            return False
        return (yield from self._repaired(moves, heats, deadline, trades=trades))

    def _repaired(
        self,
        moves: int,
        heats: tuple[float, float],
        deadline: Deadline,
        *,
        trades: bool = False,
        most: int | None = None,
    ) -> Steps[bool]:
        """Move nodes with their routes, so as to be cold after `moves` of them, of which it makes
        `most`; True when nothing is crowded.
        """
        undo = new_undo(self.task, self.traffic)
        heat, end = new_heat(*heats, moves), moves if most is None else most
        if self.quits:
            end = min(end, tuning.SLICES_IN_HASTE * tuning.REPAIR_SLICE)
        for done in range(0, end, tuning.REPAIR_SLICE):
            crowding = int(self.traffic.totals[OVER])
            if deadline.passed or crowding == 0 or self._is_hopeless(crowding, done / moves):
                break
            moves_now = min(tuning.REPAIR_SLICE, moves - done)
            repair(self.router, undo, heat, moves_now, trades)
            repair_s = tuning.OUTPUT_REPAIR_S if self.task.array.outputs else tuning.REPAIR_S
            yield self.density * moves_now * repair_s
        return bool(self.traffic.totals[OVER] == 0)

    def _is_hopeless(self, crowding: int, share: float) -> bool:
        """Whether this much crowding is hopeless after this share of the moves."""
        least = min(part for start, part in tuning.HOPELESS if start <= share)
        return crowding > max(tuning.FEW, least * len(self.ids))

    def _shrink(self, pe: int) -> bool:
        """Take one register from a file; False if it has none left."""
        for number, resource in enumerate(self.mrrg.resources):
            if resource.kind == "registers" and resource.index == pe:
                slots = slice(number * self.ii, (number + 1) * self.ii)
                if self.traffic.capacity[slots.start] <= 1:
                    return False
                self.traffic.capacity[slots] -= 1
        reprice_all(self.traffic, self.ii)
        return True

    # --- from arrays to a mapping ---

    def _cells(self, producer: int) -> list[tuple[int, int, int]]:
        """(location, cycle of the producer's iteration, location before) of one word, sorted."""
        count = self.traffic.size[producer, 0]
        ready = self._ready(producer)
        rows = self.traffic.cell[producer, :count].tolist()
        return sorted((location, ready + cycle, before) for cycle, location, before in rows)

    def _ready(self, producer: int) -> int:
        return int(self.places.time[producer] + self.task.nodes.latency[producer])

    def _cuts(self, producer: int) -> set[tuple[int, int]]:
        """(register file, cycle) from which on a word that stays there is in another register."""
        count, ready = self.traffic.size[producer, 2], self._ready(producer)
        rows = self.traffic.cut[producer, :count].tolist()
        return {(location, ready + cycle) for cycle, location in rows}

    def _lifetimes(self, producer: int) -> list[tuple[int, Lifetime]]:
        """(PE, lifetime) of a word in each register that it is in."""
        cuts = self._cuts(producer)
        spans: list[tuple[int, Lifetime]] = []
        for location, cycle, before in self._cells(producer):
            if self.mrrg.spots[location].kind != "reg":
                continue
            pe = int(self.mrrg.owner[location])
            if before == location and (location, cycle) not in cuts:
                spans[-1] = (pe, Lifetime(producer, spans[-1][1].first, cycle))
            else:
                spans.append((pe, Lifetime(producer, cycle, cycle)))
        return spans

    def _name_registers(self) -> tuple[_Held, list[int]]:
        """Registers of all lifetimes, and the PEs whose words do not fit theirs."""
        lifetimes: dict[int, list[Lifetime]] = defaultdict(list)
        for producer in range(len(self.ids)):
            for pe, lifetime in self._lifetimes(producer):
                lifetimes[pe].append(lifetime)
        registers: _Held = {}
        crowded: list[int] = []
        self.files_cut = 0
        for pe, here in lifetimes.items():
            named = self._allocated(pe, here)
            if named is None:
                crowded.append(pe)
                continue
            for lifetime, register in zip(*named, strict=True):
                for cycle in range(lifetime.first, lifetime.last + 1):
                    registers[lifetime.word, pe, cycle] = register
        return registers, crowded

    def _allocated(
        self, pe: int, lifetimes: Sequence[Lifetime]
    ) -> tuple[Sequence[Lifetime], tuple[int, ...]] | None:
        """Lifetimes on a PE and the register of each; where there is no allocation, words change
        registers in cycles whose ports are free.
        """
        registers = self.problem.fabric.pes[pe].registers
        chosen = allocate(lifetimes, self.ii, registers)
        if chosen is not None:
            return lifetimes, chosen
        file = self.mrrg.spots.index(Spot("reg", pe))
        if self.router.graph.renew[file] != FREELY:
            return None
        self.files_cut += 1
        found = allocate_with_moves(lifetimes, self.ii, registers, self._spare_ports(file))
        if found is not None:
            begun = {(whole.word, whole.first) for whole in lifetimes}
            for part in found[0]:
                if (part.word, part.first) not in begun:
                    self._cut_at(file, part.word, part.first)
        return found

    def _spare_ports(self, file: int) -> list[int]:
        """By slot, the words that ports could move within a file."""
        graph, traffic, ii = self.router.graph, self.traffic, self.ii
        ports = [graph.leaving[file], graph.entering[file]]
        free = [(traffic.capacity - traffic.use)[port * ii : (port + 1) * ii] for port in ports]
        return [int(spare) for spare in np.minimum(*free)]

    def _cut_at(self, file: int, word: int, cycle: int) -> None:
        """Have a word be in another register from a cycle of its iteration on."""
        traffic, graph = self.traffic, self.router.graph
        row = traffic.size[word, 2]
        traffic.cut[word, row] = cycle - self._ready(word), file
        traffic.size[word, 2] += 1
        for port in (graph.leaving[file], graph.entering[file]):
            claim(traffic, self.ii, word, port, cycle - 1)

    def _mapping(self, registers: _Held) -> Mapping:
        places = {
            name: Place(int(self.places.pe[node]), int(self.places.time[node]))
            for node, name in enumerate(self.ids)
        }
        routed = np.flatnonzero(self.task.edges.routed).tolist()
        routes = {
            index: self._route(edge, registers)
            for (index, _), edge in zip(self.problem.dfg.routed_edges(), routed, strict=True)
        }
        return Mapping(self.ii, places, routes)

    def _route(self, edge: int, registers: _Held) -> tuple[Step, ...]:
        """Steps from the result to the read, found backwards through the tree."""
        edges = self.task.edges
        location = int(self.traffic.end[edge])
        if location == DIRECT:
            return ()
        producer = int(edges.src[edge])
        before = {(at, cycle): origin for at, cycle, origin in self._cells(producer)}
        for at, cycle in self._cuts(producer):
            if (self.router.graph.renew[at], cycle) in before:  # shown there, for another read
                before[at, cycle] = int(self.router.graph.renew[at])
        cycle = int(self.places.time[edges.dst[edge]] + edges.ahead[edge])
        steps = []
        while location >= 0:
            pe, spot = int(self.mrrg.owner[location]), self.mrrg.spots[location]
            index = spot.index if spot.kind == "link" else 0
            if spot.kind == "reg":
                index = registers[producer, pe, cycle]
            steps.append(Step(spot.kind, pe, index, cycle))
            location, cycle = self._driver(before, location, cycle)
        return tuple(reversed(steps))

    def _driver(
        self, before: ReadOnly[tuple[int, int], int], location: int, cycle: int
    ) -> tuple[int, int]:
        """The step before; a result that goes to registers through an output register has none
        there.
        """
        origin = before[location, cycle]
        if not self.mrrg.aside[location] or origin in (location, NONE):
            return origin, cycle - 1
        if self.mrrg.spots[location].kind == "link":
            return origin, cycle
        return before[origin, cycle], cycle - 1


_Held = dict[tuple[int, int, int], int]
"""Register of (producer, PE, cycle)."""
