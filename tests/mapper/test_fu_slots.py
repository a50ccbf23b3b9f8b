"""Issue slots that a mapping takes: the picture's header and the command's `use` are these."""

from __future__ import annotations

from dataclasses import replace

import pytest
from fabrics import grid
from graphs import chain

from vividc.arch import load
from vividc.mapper import Mapping, MapResult, Place, Step, utilization
from vividc.mapper.mapping import Subject
from vividc.mapper.report.draw.scene import scene_of
from vividc.mapper.resources.fu_slots import fu_slots


def test_operations_take_a_slot_each_and_live_outs_none() -> None:
    dfg, fabric = chain(3), grid(2, 2)
    places = {node.id: Place(0, time) for time, node in enumerate(dfg.placed)}
    mapping = Mapping(4, places, {})
    assert fu_slots(dfg, fabric, mapping) == len(dfg.operations)
    assert utilization(dfg, fabric, mapping) == len(dfg.operations) / 16


def test_moves_of_words_by_fus_take_slots() -> None:
    fabric, dfg = load("openedge-2x2"), chain(2)
    index, _ = next(dfg.routed_edges())
    first, second = (node.id for node in dfg.placed[:2])
    steps = (Step("out", 0, 0, 1), Step("out", 1, 0, 2), Step("out", 1, 0, 3))
    mapping = Mapping(4, {first: Place(0, 0), second: Place(1, 3)}, {index: steps})
    assert utilization(dfg, fabric, mapping) == pytest.approx(3 / 16)
    result = MapResult("feasible", 4, 1, (), mapping, "auto", 0.0, subject=Subject(dfg, fabric))
    assert "the FU of PE 1 is taken in 2 of 4 slots" in result.explain()


def test_an_fu_that_is_kept_busy_takes_slots() -> None:
    dfg = chain(1)
    node = dfg.placed[0]
    slow = replace(grid(2, 2), occupancies={node.latency_class: 3})
    mapping = Mapping(4, {node.id: Place(0, 3)}, {})
    assert utilization(dfg, slow, mapping) == pytest.approx(3 / 16)
    assert scene_of(dfg, slow, mapping).usage().startswith("3 of 16 FU slots")
