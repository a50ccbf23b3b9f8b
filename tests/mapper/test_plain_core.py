"""Fabrics with options that routers of plain fabrics can map to."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest
from random_graphs import random_loop

from vividc.arch import load, load_text
from vividc.errors import VividcError
from vividc.mapper import map_dfg
from vividc.mapper.check.verify import violations
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.plain_core import named_anew, plain_core


@pytest.mark.parametrize("name", ["hycube-3x3", "adres-3x3", "mesh-3x3"])
def test_mappings_to_the_core_are_legal(name: str) -> None:
    fabric = load(name)
    core = plain_core(fabric)
    assert core is not None
    assert core.is_plain
    for seed in range(5):
        dfg = random_loop(seed, 12)
        result = map_dfg(dfg, core, time_limit_s=20, workers=1)
        assert result.mapping is not None
        mapping = named_anew(MapProblem(dfg, fabric), result.mapping)
        assert mapping is not None
        assert violations(dfg, fabric, mapping) == []


def test_held_outputs_take_nothing_away() -> None:
    text = "routing: {output: hold, output_readers: neighbours, moves: true}"
    fabric = load_text(f"extends: mesh-3x3\n{text}\n")
    core = plain_core(fabric)
    assert core is not None
    dfg = random_loop(1, 12)
    result = map_dfg(dfg, core, time_limit_s=20, workers=1)
    assert result.mapping is not None
    assert violations(dfg, fabric, result.mapping) == []


@pytest.mark.parametrize(
    "text",
    [
        "routing: {hops: 0}",
        "occupancy: {imul: 2}",
        "pe: {register_file: {written_by: fu}}",
    ],
)
def test_what_takes_something_away_has_no_core(text: str) -> None:
    assert plain_core(load_text(f"extends: mesh-3x3\n{text}\n")) is None


def test_a_plain_fabric_is_its_own_core() -> None:
    fabric = load("vivid-tile")
    assert plain_core(fabric) is fabric
    assert plain_core(replace(fabric, name="other")) is not None


@pytest.mark.parametrize(
    ("base", "option", "why"),
    [
        ("mesh-3x3", "occupancy: {imul: 3}", "units are not pipelined (imul)"),
        ("openedge-3x3", "", "no words take links"),
    ],
)
def test_ims_says_why_it_refuses_an_array(base: str, option: str, why: str) -> None:
    fabric = load_text(f"extends: {base}\n{option}\n")
    with pytest.raises(VividcError, match=re.escape(why)):
        map_dfg(random_loop(1, 4), fabric, "ims")
