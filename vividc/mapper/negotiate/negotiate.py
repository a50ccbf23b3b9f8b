"""From a modulo schedule to a mapping: anneal places, negotiate routes, name registers."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping as ReadOnly
from dataclasses import dataclass
from typing import Final

from vividc.errors import InternalError
from vividc.mapper.deadline import Deadline
from vividc.mapper.mapping import Mapping, Step
from vividc.mapper.negotiate.anneal import Annealer
from vividc.mapper.negotiate.route import Negotiator
from vividc.mapper.problem import MapProblem
from vividc.mapper.registers import Stay, allocate
from vividc.mapper.verify import violations

_MOVES_PER_NODE: Final = 1200
_ROUNDS: Final = 35
_TRIALS: Final = 5
_NAMING_ROUNDS: Final = 12


@dataclass(frozen=True, slots=True)
class Effort:
    """How hard one try is: annealing moves a node, rounds of negotiation, and how often places are
    changed where no routes were found.
    """

    moves: int = _MOVES_PER_NODE
    rounds: int = _ROUNDS
    trials: int = _TRIALS


def negotiate(
    task: MapProblem,
    ii: int,
    start: ReadOnly[int, int],
    seed: int,
    deadline: Deadline,
    effort: Effort | None = None,
) -> Mapping | None:
    """A mapping at `ii` near the schedule `start` (cycle of each placed node), or None.

    Finding none refutes nothing. Deterministic for a seed while the deadline is not reached.
    """
    effort = effort or Effort()
    latest = max(start.values(), default=0) + ii
    latest = min(latest, ii * task.fabric.controller.max_stages - 1)
    annealer = Annealer(task, ii, start, latest, seed)
    moves = effort.moves * len(start)
    for trial in range(effort.trials):
        if not annealer.run(moves if trial == 0 else moves // 3, deadline, warm=trial > 0):
            return None
        router = Negotiator(task, ii, annealer.places)
        mapping = _routed(router, effort.rounds, deadline)
        if mapping is not None:
            return _checked(mapping, task)
        if deadline.passed:
            return None
        annealer.loosen(router.pairs_without_way())
    return None


def _routed(router: Negotiator, rounds: int, deadline: Deadline) -> Mapping | None:
    for _ in range(_NAMING_ROUNDS):
        if not router.run(rounds, deadline):
            return None
        if not router.cut_long_stays():
            continue
        registers, crowded = _name_registers(router)
        if not crowded:
            return Mapping(router.ii, dict(router.places), _routes(router, registers))
        if not all(router.market.shrink_file(pe) for pe in crowded):
            return None
    return None


def _checked(mapping: Mapping, task: MapProblem) -> Mapping:
    found = violations(task.dfg, task.fabric, mapping, allowed=task.allowed, resident=task.resident)
    if found:
        raise InternalError(f"negotiated mapping of {task.dfg.name}: {found[0].message}")
    return mapping


_Held = dict[tuple[int, int, int], int]
"""Register of (producer, PE, cycle)."""


def _name_registers(router: Negotiator) -> tuple[_Held, list[int]]:
    """Registers of all stays, and the PEs whose words do not fit theirs."""
    stays: dict[int, list[Stay]] = defaultdict(list)
    for pe, stay in router.stays():
        stays[pe].append(stay)
    registers: _Held = {}
    crowded: list[int] = []
    for pe, here in stays.items():
        chosen = allocate(here, router.ii, router.fabric.pes[pe].registers)
        if chosen is None:
            crowded.append(pe)
            continue
        for stay, register in zip(here, chosen, strict=True):
            for time in range(stay.first, stay.last + 1):
                registers[stay.word, pe, time] = register
    return registers, crowded


def _routes(router: Negotiator, registers: _Held) -> dict[int, tuple[Step, ...]]:
    routes: dict[int, tuple[Step, ...]] = {}
    for index, edge in router.task.dfg.routed_edges():
        steps = []
        for time, location in router.ways[index]:
            pe = router.at[location]
            if location < router.links:
                steps.append(Step("link", pe, location, time))
            else:
                steps.append(Step("reg", pe, registers[edge.src, pe, time], time))
        routes[index] = tuple(steps)
    return routes
