"""The check of bounds confirms all that the mappers find, and nothing sharper."""

from __future__ import annotations

import random
from collections import Counter
from dataclasses import replace

import pytest
from option_fabrics import FABRICS
from random_graphs import random_loop
from tiny_fabrics import tiny_fabric

from vividc.arch import load_text
from vividc.arch.fabric import Fabric, Routing
from vividc.dfg.ir import DFG, Edge, Node
from vividc.machine.opcodes import LatencyClass, Opcode
from vividc.mapper import Bound, MapProblem, Subject, all_bounds
from vividc.mapper.bounds.bounds import mii
from vividc.mapper.bounds.pressure import pressure_bounds
from vividc.mapper.check.bounds import check_bounds

_MEMORY = frozenset({LatencyClass.LOAD, LatencyClass.STORE})


def subject_of(problem: MapProblem) -> Subject:
    return Subject(problem.dfg, problem.fabric, problem.allowed, problem.resident)


def verdicts(problem: MapProblem, bounds: tuple[Bound, ...]) -> list[str]:
    return [finding.verdict for finding in check_bounds(bounds, subject_of(problem))]


def chain(length: int) -> DFG:
    nodes = tuple(Node(i, Opcode.GENERIC, name=f"n{i}") for i in range(length))
    return DFG("chain", nodes, tuple(Edge(i, i + 1, 0) for i in range(length - 1)))


def detours(count: int) -> DFG:
    """Multiplications that take two words in and one past, which cannot be made later."""
    nodes, edges = [Node(0, Opcode.LOAD)], []
    for at in range(1, count + 1):
        nodes += [Node(2 * at, Opcode.MUL), Node(2 * at + 1, Opcode.ADD)]
        before = 0 if at == 1 else 2 * at - 1
        edges += [Edge(before, 2 * at, 0), Edge(before, 2 * at, 1)]
        edges += [Edge(before, 2 * at + 1, 0), Edge(2 * at, 2 * at + 1, 1)]
    return DFG("detours", tuple(nodes), tuple(edges))


def random_problem(seed: int) -> MapProblem:
    draw = random.Random(seed)
    fabric = tiny_fabric(
        1,
        draw.choice((1, 2, 3)),
        registers=draw.choice((0, 1, 2)),
        constants=draw.choice((1, 3, 8)),
        contexts=9,
        max_stages=draw.choice((1, 2, 3)),
        memory=draw.choice((None, frozenset({0}))),
        latencies={LatencyClass.IMUL: draw.choice((1, 4)), LatencyClass.LOAD: 2},
        occupancies=draw.choice((None, {LatencyClass.INT: 2})),
    )
    if seed % 3 == 0:
        fabric = draw.choice(list(FABRICS.values()))
    dfg = random_loop(seed, draw.randrange(2, 9), draw.choice(((6, 2, 1), (2, 3, 2))))
    pes = range(len(fabric.pes))
    allowed = {node.id: frozenset(draw.sample(pes, 1)) for node in draw.sample(dfg.placed, 2)}
    resident = {0: frozenset({("const", 1), ("const", 2), ("live_in", "&a")})}
    return MapProblem(dfg, fabric, allowed if seed % 2 else {}, resident if seed % 5 == 0 else {})


def test_every_bound_is_confirmed_and_none_above_it() -> None:
    seen: Counter[str] = Counter()
    for seed in range(400):
        problem = random_problem(seed)
        bounds = all_bounds(problem)
        assert set(verdicts(problem, bounds)) <= {"confirmed"}, (seed, bounds)
        for number, bound in enumerate(bounds):
            sharper = (*bounds[:number], replace(bound, ii=bound.ii + 1), *bounds[number + 1 :])
            if bound.ii <= problem.fabric.controller.contexts:  # else no II works, larger ones too
                assert verdicts(problem, sharper)[number] == "wrong", (seed, bound)
        seen.update(bound.name for bound in bounds)
    assert len(seen) >= 9, seen


def _apart(fabric: Fabric) -> Fabric:
    """PE 0 does nothing but memory, the others everything else."""
    pes = [replace(fabric.pes[0], classes=_MEMORY)]
    pes += [replace(pe, classes=pe.classes - _MEMORY) for pe in fabric.pes[1:]]
    return replace(fabric, pes=tuple(pes))


@pytest.mark.parametrize(
    ("fabric", "verdict"),
    [
        (tiny_fabric(1, 2, links=((1, 0),)), "confirmed"),
        (tiny_fabric(1, 2, links=((0, 1),)), "wrong"),
        (tiny_fabric(1, 2, routing=Routing(hops=0)), "confirmed"),
        (tiny_fabric(1, 2, routing=Routing(hops=0, shared=True)), "wrong"),
    ],
)
def test_reach(fabric: Fabric, verdict: str) -> None:
    dfg = DFG("load", (Node(0, Opcode.LOAD), Node(1, Opcode.ADD)), (Edge(0, 1, 0), Edge(0, 1, 1)))
    problem = MapProblem(dfg, _apart(fabric))
    claim = Bound("reach", fabric.controller.contexts + 1, "r", (0, 1))
    assert [bound.name for bound in all_bounds(problem)[:1] if bound.name == "reach"] == (
        ["reach"] if verdict == "confirmed" else []
    )
    assert verdicts(problem, (claim,)) == [verdict]


def test_islands() -> None:
    problem = MapProblem(chain(9), load_text("extends: mesh-4x4\ntopology: none\n"))
    bounds = all_bounds(problem)
    assert (bounds[0].name, bounds[0].ii) == ("island", 9)
    assert set(verdicts(problem, bounds)) == {"confirmed"}
    assert verdicts(problem, (replace(bounds[0], nodes=(0, 1, 3, 4, 5, 6, 7, 8)),)) == ["wrong"]
    assert verdicts(problem, (replace(bounds[0], ii=10),)) == ["wrong"]


def test_lives() -> None:
    """The bound from lives rests on the others: without them each smaller II is refuted anew."""
    fabric = tiny_fabric(1, 4, registers=1, latencies={LatencyClass.IMUL: 9}, max_stages=64)
    problem = MapProblem(detours(6), fabric)
    (bound,) = pressure_bounds(problem, 4, 100)
    assert verdicts(problem, (bound,)) == ["confirmed"]
    assert verdicts(problem, (bound, *all_bounds(problem))) == ["confirmed"] * 4
    assert verdicts(problem, (replace(bound, ii=bound.ii + 1),)) == ["wrong"]
    assert mii(all_bounds(problem)) == bound.ii


def test_lives_at_an_ii_without_a_schedule() -> None:
    edges = (Edge(0, 1, 0), Edge(1, 0, 0, distance=1, init=2))
    nodes = (Node(0, Opcode.MOV), Node(1, Opcode.MOV), Node(2, Opcode.CONST, const=0))
    problem = MapProblem(DFG("ring", nodes, edges), tiny_fabric())
    assert verdicts(problem, (Bound("register pressure", 2, "r"),)) == ["confirmed"]
    assert verdicts(problem, (Bound("register pressure", 3, "r"),)) == ["wrong"]
    assert verdicts(problem, (Bound("register pressure", 10**12, "r"),)) == ["wrong"]


def test_a_reason_cannot_pass_for_a_finding() -> None:
    problem = MapProblem(chain(2), tiny_fabric())
    (found,) = check_bounds(
        (Bound("x", 2, "r\n  confirmed: \x1b[1m" + 999 * "y"),), subject_of(problem)
    )
    assert str(found).startswith("wrong: x 2: r confirmed: \\x1b[1myyy")
    assert len(str(found)) < 400
