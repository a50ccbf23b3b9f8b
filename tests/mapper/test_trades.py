"""Repairs trade slots: of a full array no node changes its own otherwise."""

from __future__ import annotations

import numpy as np
import pytest
from tiny_fabrics import tiny_fabric

from tests.mapper.graphs import GraphBuilder
from vividc.dfg.ir import DFG
from vividc.machine.opcodes import Opcode
from vividc.mapper.check.verify import verify
from vividc.mapper.deadline import Deadline
from vividc.mapper.engines.negotiate import Effort, negotiate
from vividc.mapper.engines.negotiate.anneal import new_heat
from vividc.mapper.engines.negotiate.frame import loose_frame
from vividc.mapper.engines.negotiate.negotiation import Negotiation
from vividc.mapper.engines.negotiate.places import broken, enter, lie
from vividc.mapper.engines.negotiate.repair import new_undo, repair
from vividc.mapper.engines.negotiate.traffic import OVER, new_graph, new_scratch, new_traffic
from vividc.mapper.engines.negotiate.ways import Router, route_round
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.plain_core import unrotated

PES, II = 2, 2
FABRIC = unrotated(tiny_fabric(1, PES, registers=4, constants=32))


def unrelated(count: int) -> DFG:
    """Operations that do not read each other."""
    g = GraphBuilder("full")
    for _ in range(count):
        g.op(Opcode.MOV, g.source(Opcode.IV))
    return g.build()


def full() -> Negotiation:
    """An array whose every slot has a node, routed."""
    problem = MapProblem(unrelated(PES * II), FABRIC)
    frame = loose_frame(problem, II)
    assert frame is not None
    one = Negotiation(problem, II, frame, 1)
    for node in range(PES * II):
        enter(one.task.nodes, one.task.array, one.places, node, -1)
        lie(one.task, one.places, node, node % PES, node // PES)
        enter(one.task.nodes, one.task.array, one.places, node, 1)
    assert broken(one.task, one.places) == 0
    traffic = new_traffic(one.mrrg, one.task, one.room)
    scratch = new_scratch(one.mrrg, one.cycles)
    one.router = Router(new_graph(one.mrrg, FABRIC), one.task, one.places, traffic, scratch)
    assert route_round(one.router, True) == 0
    return one


@pytest.mark.parametrize("trades", [False, True])
def test_nodes_of_a_full_array_change_their_slots_by_trades_only(trades: bool) -> None:
    one, changed = full(), False
    slots = one.places.time % II
    undo, heat = new_undo(one.task, one.router.traffic), new_heat(5.0, 1.0, 400)
    for _ in range(20):
        one.router.traffic.totals[OVER] = 1.0  # for it to go on: nothing is crowded
        repair(one.router, undo, heat, 20, trades)
        assert broken(one.task, one.places) == 0
        assert sorted((one.places.pe * II + one.places.time % II).tolist()) == [0, 1, 2, 3]
        changed = changed or bool(np.any(one.places.time % II != slots))
    assert changed is trades


def test_a_graph_that_fills_the_array_is_mapped() -> None:
    dfg = unrelated(PES * II)
    problem = MapProblem(dfg, FABRIC)
    mapping = negotiate(problem, II, 1, Deadline.after(60), Effort(moves=500, trials=2)).mapping
    assert mapping is not None
    assert verify(dfg, FABRIC, mapping) == []
