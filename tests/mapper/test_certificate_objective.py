"""What was minimised: the checker's value of a mapping, the mapper's, and what they must be."""

from __future__ import annotations

import pytest
from brute_routing import minimum_ii
from option_fabrics import FABRICS
from random_graphs import random_loop
from tiny_fabrics import tiny_fabric

from vividc.arch.fabric import Fabric, Routing
from vividc.dfg.ir import DFG, Edge, Node
from vividc.machine.opcodes import Opcode
from vividc.mapper import (
    Mapping,
    MapProblem,
    MapResult,
    Objective,
    Place,
    Step,
    Subject,
    check_certificate,
    violations,
)
from vividc.mapper.engines.cpsat.minima import measure

_NAMES = ("hops", "registers", "length")


def said(dfg: DFG, fabric: Fabric, mapping: Mapping, objective: Objective) -> list[str]:
    result = MapResult("feasible", mapping.ii, 1, (), mapping, "test", 0.0, objective=objective)
    found = check_certificate(result, Subject(dfg, fabric))
    return [str(finding) for finding in found if objective.name in finding.what]


@pytest.mark.parametrize("name", FABRICS)
def test_checker_and_mapper_agree_on_every_kind_of_fabric(name: str) -> None:
    fabric, seen = FABRICS[name], 0
    for seed in range(10):
        dfg = random_loop(seed, 3, (6, 2, 1) if seed % 2 else (2, 3, 2))
        least = minimum_ii(dfg, fabric)
        for objective in _NAMES if least is not None else ():
            assert least is not None
            value = measure(MapProblem(dfg, fabric), least[1], objective)
            for claimed, verdict in ((value, "confirmed"), (value + 1, "wrong")):
                words = said(dfg, fabric, least[1], Objective(objective, claimed, None, None, 99))
                assert words[0].startswith(verdict)
            seen += 1
    assert seen > 0


def test_a_word_that_an_fu_passes_to_itself_is_moved() -> None:
    """Where output registers do not hold, and once wherever the result of the move goes."""
    nodes = tuple(Node(number, Opcode.MOV) for number in range(3))
    dfg = DFG("wait", nodes, (Edge(0, 1, 0), Edge(0, 2, 0)))
    fabric = tiny_fabric(1, 1, routing=Routing(moves=True), written_by_fu=True)
    places = {0: Place(0, 0), 1: Place(0, 3), 2: Place(0, 4)}
    first, second = Step("out", 0, 0, 1), Step("out", 0, 0, 2)
    held = tuple(Step("reg", 0, 0, time) for time in (3, 4))
    routes = {0: (first, second, Step("out", 0, 0, 3)), 1: (first, second, *held)}
    mapping = Mapping(5, places, routes)
    assert violations(dfg, fabric, mapping) == []
    assert measure(MapProblem(dfg, fabric), mapping, "hops") == 2
    assert said(dfg, fabric, mapping, Objective("hops", 2, None, None, 9)) == [
        "confirmed: the mapping has hops 2"
    ]
