"""Operations on numbers of 16 and 8 bits go to FUs that are made of slices."""

from __future__ import annotations

import pytest

from tests.sim.test_lanes import kernel_of
from vividc.arch import load_text
from vividc.dfg.ir import DFG, Edge, Node
from vividc.errors import MappingFailed
from vividc.machine.opcodes import Opcode
from vividc.mapper import map_dfg, verify
from vividc.mapper.engines.list_schedule import list_schedule
from vividc.mapper.problem import MapProblem

ONE = (
    "extends: vivid-tile\npe: {sliced: false}\n"
    "overrides: [{at: {rows: 2, cols: 2}, sliced: true}]\n"
)


def lanes_loop() -> DFG:
    kernel = kernel_of([Opcode.FMA_F16X2, Opcode.DOT_E4M3X4])
    return next(region.dfg for region in kernel.regions if region.kind == "loop")


def test_the_bound_counts_the_sliced_fus() -> None:
    dfg, fabric = lanes_loop(), load_text(ONE, "one.yaml")
    result = map_dfg(dfg, fabric, time_limit_s=60)
    assert (result.status, result.ii) == ("optimal", 2)
    assert result.mapping is not None
    assert verify(dfg, fabric, result.mapping) == []
    places = result.mapping.places
    assert {places[node.id].pe for node in dfg.nodes if node.info.sliced} == {10}


def test_without_slices_there_is_no_mapping() -> None:
    fabric = load_text("extends: vivid-tile\npe: {sliced: false}\n")
    result = map_dfg(lanes_loop(), fabric, time_limit_s=60)
    assert result.status == "infeasible"
    assert "needs slices for 16 or 8 bits" in result.bounds[0].reason


def test_the_verifier_knows_slices() -> None:
    dfg, fabric = lanes_loop(), load_text(ONE, "one.yaml")
    mapping = map_dfg(dfg, fabric, time_limit_s=60).mapping
    assert mapping is not None
    plain = load_text("extends: vivid-tile\npe: {sliced: false}\n")
    reasons = [str(violation) for violation in verify(dfg, plain, mapping)]
    assert len(reasons) == 2
    assert all("PE 10, whose FU has no slices for 16 or 8 bits" in reason for reason in reasons)


def test_straight_code_is_refused_with_the_reason() -> None:
    nodes = (Node(0, Opcode.LIVE_IN, name="a"), Node(1, Opcode.FPTRUNC_E5M2))
    dfg = DFG("straight", nodes, (Edge(0, 1, 0),))
    fabric = load_text("extends: mesh-1x2\npe: {sliced: false}\n")
    with pytest.raises(MappingFailed, match=r"executes convert on 16 or 8 bits \(`sliced`\)"):
        list_schedule(MapProblem(dfg, fabric))
