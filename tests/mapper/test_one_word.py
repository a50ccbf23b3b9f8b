"""One word that is read on any PEs at any times: what the router finds is legal."""

from __future__ import annotations

import random
from dataclasses import replace
from itertools import product

import pytest

from vividc import arch
from vividc.arch.fabric import Fabric, Routing
from vividc.dfg.ir import DFG, Edge, Node
from vividc.machine.opcodes import Opcode
from vividc.mapper.check.verify import violations
from vividc.mapper.deadline import Deadline
from vividc.mapper.engines.negotiate import Effort
from vividc.mapper.engines.negotiate.frame import Frame
from vividc.mapper.engines.negotiate.lockstep import first_result
from vividc.mapper.engines.negotiate.negotiation import Negotiation
from vividc.mapper.engines.negotiate.places import enter
from vividc.mapper.mapping import Mapping
from vividc.mapper.problem import MapProblem

MOST_STAGES = 4
TWO_DRIVERS = {"openedge-3x3": (2971, 6056), "openedge-2x5": (2407, 4603, 8239, 8987)}
"""Seeds with which a word that changed registers came to an output register from there, and from
another PE.
"""
ROUTES_ONLY = Effort(moves=0, rounds=10, repairs=0, trials=1, shown=1)


def star(readers: int) -> DFG:
    """Node 0 makes a word that all others read."""
    nodes = tuple(Node(number, Opcode.GENERIC, name="op") for number in range(readers + 1))
    return DFG("star", nodes, tuple(Edge(0, reader, 0) for reader in range(1, readers + 1)))


def routed(seed: int, fabric: Fabric) -> tuple[MapProblem, Mapping | None]:
    """A star with its nodes in different slots; a word may live for some IIs."""
    rng = random.Random(seed)
    ii, dfg = rng.randrange(2, 7), star(rng.randrange(2, 9))
    slots = [(pe, slot) for pe in range(len(fabric.pes)) for slot in range(ii)]
    places = rng.sample(slots, len(dfg.nodes))
    first = places[0][1]
    times = {
        number: slot + ii * (rng.randrange(MOST_STAGES) + (slot <= first))
        for number, (_, slot) in enumerate(places)
    }
    times[0] = first
    problem = MapProblem(dfg, fabric)
    frame = Frame(times, dict.fromkeys(times, max(times.values())))
    attempt = Negotiation(problem, ii, frame, seed)
    nodes, array = attempt.task.nodes, attempt.task.array
    for number, (pe, _) in enumerate(places):
        enter(nodes, array, attempt.places, number, -1)
        attempt.places.pe[number] = pe
    for number in range(len(places)):
        enter(nodes, array, attempt.places, number, 1)
    return problem, first_result([attempt.run(ROUTES_ONLY, Deadline.after(600.0))])


@pytest.mark.parametrize("name", ["openedge-3x3", "openedge-2x5", "mesh-3x3", "hycube-3x3"])
def test_what_is_routed_is_legal(name: str) -> None:
    fabric = arch.load(name)
    assert isinstance(fabric, Fabric)
    mapped = 0
    for seed in (*range(300), *TWO_DRIVERS.get(name, ())):
        problem, mapping = routed(seed, fabric)
        if mapping is not None:
            mapped += 1
            assert not violations(problem.dfg, fabric, mapping), seed
    assert mapped > 30


@pytest.mark.parametrize(("hops", "holds"), [*product((0, 1, 2), (False, True))])
def test_whatever_routing_an_array_has(hops: int, holds: bool) -> None:
    mapped = 0
    for name, shared, moves in product(("openedge-3x3", "mesh-3x3"), (False, True), (False, True)):
        array = arch.load(name)
        assert isinstance(array, Fabric)
        fabric = replace(array, routing=Routing(hops, holds=holds, shared=shared, moves=moves))
        for seed in range(60):
            problem, mapping = routed(seed, fabric)
            if mapping is not None:
                mapped += 1
                assert not violations(problem.dfg, fabric, mapping), (fabric.routing, seed)
    assert mapped > 10
