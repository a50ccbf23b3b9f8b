"""Without any one constraint family the solver makes mappings to which the verifier objects."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import pytest
from brute_force import minimum_ii
from ortools.sat.python.cp_model import FEASIBLE, OPTIMAL, CpSolver
from random_graphs import random_loop
from test_drop_one_options import OPTION_FAMILIES
from tiny_fabrics import tiny_fabric

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG, Control, Edge, Node
from vividc.machine.opcodes import BASE, LatencyClass, Opcode
from vividc.mapper.check.verify import violations
from vividc.mapper.deadline import Deadline
from vividc.mapper.engines.cpsat import (
    CONSTRAINT_FAMILIES,
    JointModel,
    Prepared,
    Search,
    build,
    place_and_route,
    windowed,
)
from vividc.mapper.mapping import Mapping, Place, Step
from vividc.mapper.problem import MapProblem

# Its docstring says so: on the open timeline the routes imply it.
_REDUNDANT = {"routed_edges_are_ordered"}
_OBJECTION = {
    "each_node_starts_once": "missing",
    "one_issue_per_fu_and_slot": "issue",
    "one_completion_per_fu_and_slot": "completion",
    "links_are_driven": "route",
    "registers_are_written": "route",
    "registers_keep_words": "route",
    "registers_last_one_ii": "register",
    "reads_find_the_word": "route",
    "operands_arrive": "route",
    "one_word_per_link_and_slot": "link",
    "words_fit_registers": "register",
    "reads_fit_ports": "read_ports",
    "writes_fit_ports": "write_ports",
    "constants_fit_store": "constants",
    "one_live_out_per_pe_and_slot": "live_out",
    "live_outs_spare_words_still_read": "live_in",
    "one_control_result_per_slot": "control",
    "accesses_fit_banks": "banks",
    "edges_without_a_word_are_ordered": "dependence",
}
_SLACK = 3
_LATENCIES = {LatencyClass.IMUL: 3, LatencyClass.LOAD: 2}
_FABRICS = (
    tiny_fabric(1, 2, constants=3, latencies=_LATENCIES, max_stages=3, contexts=4),
    tiny_fabric(2, 2, registers=1, latencies=_LATENCIES, max_stages=3, contexts=4),
    tiny_fabric(1, 1, registers=2, latencies=_LATENCIES, max_stages=4, contexts=6),
    tiny_fabric(1, 2, registers=3, write_ports=2, latencies=_LATENCIES, max_stages=4, contexts=6),
)


def test_each_family_is_known_here() -> None:
    known = {*_OBJECTION, *_REDUNDANT, *OPTION_FAMILIES}
    assert {family.__name__ for family in CONSTRAINT_FAMILIES} == known


@pytest.mark.parametrize("family", _OBJECTION)
def test_the_verifier_misses_each_family(family: str) -> None:
    assert any(
        violation.kind == _OBJECTION[family]
        for problem in _problems()
        for mapping in _solution(problem, {family})
        for violation in violations(problem.task.dfg, problem.fabric, mapping)
    )


def test_with_all_families_it_is_content() -> None:
    solved = 0
    for problem in _problems():
        outcome = place_and_route(problem, Search(Deadline.after(60.0), workers=1))
        if outcome.value is not None:
            solved += 1
            assert violations(problem.task.dfg, problem.fabric, outcome.value) == []
    assert solved >= 10


@cache
def _problems() -> tuple[Prepared, ...]:
    """At the least II, and at one less, where every mapping is a wrong one."""
    cases: list[tuple[DFG, Fabric]] = list(_by_hand())
    cases += [(random_loop(seed, 3 + seed % 3), _FABRICS[seed % 4]) for seed in range(28)]
    found = []
    for dfg, fabric in cases:
        least = minimum_ii(dfg, fabric)
        if least is None:
            continue
        for ii in (least[0] - 1, least[0]):
            prepared = _prepared(MapProblem(dfg, fabric), ii)
            if prepared is not None:
                found.append(prepared)
    return tuple(found)


def _prepared(task: MapProblem, ii: int) -> Prepared | None:
    try:
        return windowed(task, ii, _SLACK) if ii > 0 else None
    except ValueError:  # below the RecMII
        return None


def _by_hand() -> Iterator[tuple[DFG, Fabric]]:
    value = Node(0, Opcode.MOV)
    outs = (Node(1, Opcode.LIVE_OUT, name="%x"), Node(2, Opcode.LIVE_OUT, name="%y"))
    yield DFG("outs", (value, *outs), (Edge(0, 1, 0), Edge(0, 2, 0))), _FABRICS[2]
    controls = (
        Node(0, Opcode.MOV, control=Control.BRANCH),
        Node(1, Opcode.MOV, control=Control.TRIP),
    )
    yield DFG("controls", controls, ()), _FABRICS[0]
    loads = tuple(Node(index, Opcode.LOAD, name="a") for index in (1, 2, 3))
    address = (Node(0, Opcode.CONST, const=0), Node(4, Opcode.LIVE_IN, name="&a"))
    feeds = [edge for n in (1, 2, 3) for edge in (Edge(0, n, 0), Edge(4, n, BASE))]
    yield DFG("accesses", (*address, *loads), tuple(feeds)), tiny_fabric(2, 2)
    fork = (value, *(Node(index, Opcode.MOV) for index in (1, 2, 3)))
    late = (Edge(0, 1, 0), Edge(1, 2, 0), Edge(2, 3, 0), Edge(0, 3, 1))
    yield DFG("late", fork, late), _FABRICS[3]
    rewrites = (
        Node(0, Opcode.LIVE_IN, name="%x"),
        Node(1, Opcode.LIVE_IN, name="%y"),
        Node(2, Opcode.ADD),
        Node(3, Opcode.LIVE_OUT, name="%x"),
        Node(4, Opcode.LIVE_OUT, name="%y"),
    )
    edges = (Edge(0, 2, 0), Edge(1, 2, 1), Edge(2, 3, 0), Edge(2, 4, 0))
    yield DFG("rewrites", rewrites, edges), _FABRICS[0]


def _solution(problem: Prepared, dropped: set[str]) -> Iterator[Mapping]:
    """The solver's answer, read without trusting it."""
    joint = build(problem, dropped)
    solver = CpSolver()
    solver.parameters.num_workers = 1
    if solver.solve(joint.model) in {OPTIMAL, FEASIBLE}:
        yield _Reader(problem, joint, solver).mapping()


class _Reader:
    """Reads times, places and routes off a solution; where a route does not lead back it stops."""

    def __init__(self, problem: Prepared, joint: JointModel, solver: CpSolver) -> None:
        self.problem = problem
        true = solver.boolean_value
        variables = joint.variables
        self.start = {n: (p, t) for (n, p, t), x in variables.start.items() if true(x)}
        self.link = {key for key, x in variables.link.items() if true(x)}
        self.held = {key for key, x in variables.held.items() if true(x)}
        self.written = {key for key, x in variables.written.items() if true(x)}

    def mapping(self) -> Mapping:
        places = {node: Place(pe, time) for node, (pe, time) in sorted(self.start.items())}
        ways = {}
        for index, edge in self.problem.task.dfg.routed_edges():
            if edge.src not in places or edge.dst not in places:
                continue
            reader = places[edge.dst]
            time = reader.time + self.problem.ii * edge.distance
            ways[index] = (edge.src, self._way_back(edge.src, reader.pe, time))
        used = {(w, pe, at) for w, way in ways.values() for pe, link, at in way if link is None}
        register = self._registers(used)
        routes = {
            index: tuple(
                Step("link", pe, link, at)
                if link is not None
                else Step("reg", pe, register[word, pe, at], at)
                for pe, link, at in reversed(way)
            )
            for index, (word, way) in ways.items()
        }
        return Mapping(self.problem.ii, places, routes)

    def _way_back(self, word: int, pe: int, time: int) -> list[tuple[int, int | None, int]]:
        origin, issued = self.start[word]
        ready = issued + self.problem.latency[word]
        way: list[tuple[int, int | None, int]] = []
        if (pe, time) == (origin, ready):
            return way
        while time >= ready:
            link = self._link_into(word, pe, time)
            if link is not None:
                way.append((pe, link, time))
                pe = self.problem.fabric.links[link].src
            else:
                way.append((pe, None, time))
                if (word, pe, time) not in self.held:
                    return way
            if (pe, time) == (origin, ready):
                return way
            time -= 1
        return way

    def _link_into(self, word: int, pe: int, time: int) -> int | None:
        for link in self.problem.fabric.links_to[pe]:
            if (word, link.id, time) in self.link:
                return link.id
        return None

    def _registers(self, used: set[tuple[int, int, int]]) -> dict[tuple[int, int, int], int]:
        """First fit by write time; a lifetime that fits nowhere shares register 0."""
        chosen: dict[tuple[int, int, int], int] = {}
        busy: set[tuple[int, int, int]] = set()
        for word, pe, first in sorted(used, key=lambda key: (key[1], key[2], key[0])):
            if (word, pe, first) in chosen:
                continue
            last = first
            while (word, pe, last + 1) in used - self.written:
                last += 1
            slots = [time % self.problem.ii for time in range(first, last + 1)]
            size = self.problem.fabric.pes[pe].registers
            free = [r for r in range(size) if not any((pe, r, slot) in busy for slot in slots)]
            register = (free or [0])[0]
            busy.update((pe, register, slot) for slot in slots)
            chosen.update({(word, pe, time): register for time in range(first, last + 1)})
        return chosen
