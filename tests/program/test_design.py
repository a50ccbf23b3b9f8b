"""A program keeps the graph and the mapping of each region, to be looked at again."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

import vividc
from tests.launch.kernels import saxpy
from vividc.errors import BundleError
from vividc.mapper import violations
from vividc.program import Program


@pytest.fixture(scope="module")
def program() -> Program:
    return vividc.compile(saxpy)


def test_graphs_and_mappings_come_back_from_the_file(program: Program, tmp_path: Path) -> None:
    program.save(tmp_path / "a.vivid")
    again = vividc.load(tmp_path / "a.vivid")
    assert again == program
    again.save(tmp_path / "b.vivid")
    assert (tmp_path / "a.vivid").read_bytes() == (tmp_path / "b.vivid").read_bytes()
    assert any(region.kind == "loop" for region in again.regions)
    for region, row in zip(again.regions, again.table, strict=True):
        assert len(region.dfg.operations) == region.operations
        mapping, result = region.mapping, region.result
        if mapping is None or result is None:
            assert not region.dfg.placed
            continue
        assert (mapping.ii, result.lower_bound) == (row.ii, region.lower_bound)
        straight = region.kind == "straight"
        assert not list(violations(region.dfg, again.fabric, mapping, straight=straight))
        assert region.name in mapping.plot().title + region.dfg.plot().title


def test_what_a_program_of_before_has_not(program: Program) -> None:
    region = replace(program.regions[0], design="")
    with pytest.raises(BundleError, match="neither graph nor mapping") as raised:
        _ = region.dfg
    assert raised.value.hint == "compile the kernel again with this version"


@pytest.mark.parametrize(
    "damage",
    [
        "",
        "[]",
        "{",
        "{}",
        '{"graph": 3}',
        '{"graph": {"name": "x", "nodes": [{"id": 0, "op": "mul"}, {"id": 0, "op": "mul"}]}}',
        "[" * 100_000,
    ],
)
def test_a_damaged_design_is_one_error(program: Program, damage: str) -> None:
    region = replace(program.regions[0], design=damage or " ")
    with pytest.raises(BundleError):
        _ = region.dfg


def test_a_mapping_of_another_fabric_is_refused(program: Program) -> None:
    loop = next(region for region in program.regions if region.kind == "loop")
    other = vividc.arch.load("vivid-8x8").source
    with pytest.raises(BundleError, match="mapping of a region cannot be read"):
        _ = replace(loop, fabric_yaml=other).mapping
    text = json.loads(loop.design)
    text["result"]["mapping"]["places"][0]["pe"] = 999
    with pytest.raises(BundleError, match=r"not legal|cannot be read"):
        _ = replace(loop, design=json.dumps(text)).mapping
    moved = json.loads(loop.design)
    for place in moved["result"]["mapping"]["places"]:
        place["time"] = 0
    with pytest.raises(BundleError, match="is not legal"):
        _ = replace(loop, design=json.dumps(moved)).mapping
