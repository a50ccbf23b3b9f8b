"""Between which cycles operations may start: the frame of an iteration, and mappings inside it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.mapper.graphs import GraphBuilder, chain
from tests.mapper.random_graphs import random_loop
from vividc import arch
from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG
from vividc.machine.opcodes import Opcode
from vividc.mapper.bounds.bounds import all_bounds, mii
from vividc.mapper.check.verify import violations
from vividc.mapper.deadline import Deadline
from vividc.mapper.engines.negotiate import (
    Effort,
    least_span,
    loose_frame,
    negotiate,
    tight_frame,
)
from vividc.mapper.mapping import Mapping
from vividc.mapper.problem import MapProblem

QUICK = Effort(moves=2000, rounds=20, repairs=60, trials=2)


def problem_of(dfg: DFG) -> MapProblem:
    fabric = arch.load("vivid-tile")
    assert isinstance(fabric, Fabric)
    return MapProblem(dfg, fabric)


def span(problem: MapProblem, mapping: Mapping) -> int:
    latency = {node.id: problem.fabric.latency(node) for node in problem.dfg.placed}
    return max(place.time + latency[node] for node, place in mapping.places.items())


def test_each_node_leaves_room_for_what_follows() -> None:
    problem = problem_of(chain(4))
    order = [node.id for node in problem.dfg.placed]
    assert least_span(problem, 1) == 4
    frame = tight_frame(problem, 1, 6)
    assert frame is not None
    assert [frame.begin[node] for node in order] == [0, 1, 2, 3]
    assert [frame.last[node] for node in order] == [2, 3, 4, 5]


def test_a_frame_is_not_shorter_than_the_longest_path() -> None:
    problem = problem_of(chain(4))
    assert tight_frame(problem, 1, 4) is not None
    assert tight_frame(problem, 1, 3) is None


def test_a_frame_is_not_longer_than_all_stages() -> None:
    problem = problem_of(chain(9))
    few = replace(problem.fabric.controller, max_stages=3)
    assert tight_frame(problem, 1, 9) is not None
    short = replace(problem, fabric=replace(problem.fabric, controller=few))
    assert tight_frame(short, 1, 9) is None
    frame = tight_frame(short, 4, 20)
    assert frame is not None
    assert max(frame.last.values()) == 11


def test_a_recurrence_does_not_count_twice() -> None:
    g = GraphBuilder("sum")
    total = g.op(Opcode.FADD, g.source(Opcode.IV))
    g.carry(total, total, 1, g.const(0))
    problem = problem_of(g.build())
    assert least_span(problem, 4) == 4
    frame = tight_frame(problem, 4, 5)
    assert frame is not None
    assert frame.last == {total: 1}


@pytest.mark.parametrize("seed", range(3))
def test_mappings_stay_in_their_frame(seed: int) -> None:
    problem = problem_of(random_loop(seed, 16, (8, 2, 0)))
    ii = mii(all_bounds(problem)) + 1
    loose = loose_frame(problem, ii)
    assert loose is not None
    assert max(loose.last.values()) >= max(loose.begin.values())
    shorter = least_span(problem, ii) + 3
    made = negotiate(
        problem, ii, 1, Deadline.after(60), QUICK, frame=tight_frame(problem, ii, shorter)
    ).mapping
    assert made is not None
    assert violations(problem.dfg, problem.fabric, made) == []
    assert span(problem, made) <= shorter
