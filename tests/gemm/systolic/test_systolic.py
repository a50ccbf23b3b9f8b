"""Systolic mappings are legal on every shape, and their bounds are as stated."""

from __future__ import annotations

import pytest

from vividc import arch
from vividc.arch.fabric import Fabric
from vividc.dfg.check import check
from vividc.gemm.systolic import (
    Form,
    Precision,
    SystolicArray,
    SystolicError,
    SystolicSchedule,
    chosen_ii,
    gemm_region,
    least_ii,
    plan,
)
from vividc.mapper import violations

SMALL = """
extends: vivid-8x8
rows: {rows}
cols: {cols}
latencies: {{fma: {fma}, load: {load}}}
"""


def small(rows: int, cols: int, fma: int = 4, load: int = 2) -> Fabric:
    text = SMALL.format(rows=rows + 2, cols=cols + 1, fma=fma, load=load)
    return arch.load_text(text, "small.yaml")


@pytest.mark.parametrize("relu", [False, True])
@pytest.mark.parametrize("depth", [1, 2, 3, 4, 5, 8, 13, 16, 21])
@pytest.mark.parametrize(("rows", "cols"), [(1, 1), (2, 3), (4, 4)])
def test_every_depth_gives_a_legal_mapping(rows: int, cols: int, depth: int, relu: bool) -> None:
    array = SystolicArray.of(small(rows, cols))
    region = gemm_region(array, Form(depth, relu))
    assert not list(check(region.dfg))
    assert violations(region.dfg, array.fabric, region.mapping) == []


@pytest.mark.parametrize("relu", [False, True])
@pytest.mark.parametrize("depth", [1, 2, 5, 8, 13, 16])
@pytest.mark.parametrize(("rows", "cols"), [(1, 1), (2, 3), (4, 4)])
def test_sums_that_start_from_a_matrix_give_a_legal_mapping(
    rows: int, cols: int, depth: int, relu: bool
) -> None:
    array = SystolicArray.of(small(rows, cols))
    region = gemm_region(array, Form(depth, relu, added=True))
    assert not list(check(region.dfg))
    assert violations(region.dfg, array.fabric, region.mapping) == []
    assert region.mapping.ii == chosen_ii(array, Form(depth, relu, added=True), 500)


@pytest.mark.parametrize("relu", [False, True])
@pytest.mark.parametrize("depth", [1, 2, 5, 8, 9, 13])
@pytest.mark.parametrize("results", ["f16", "e4m3", "e5m2"])
def test_packed_results_give_a_legal_mapping(results: Precision, depth: int, relu: bool) -> None:
    for rows, cols in ((2, 4), (5, 8)):
        array = SystolicArray.of(small(rows, cols))
        region = gemm_region(array, Form(depth, relu, "e4m3", results))
        assert not list(check(region.dfg))
        assert violations(region.dfg, array.fabric, region.mapping) == []
        assert region.mapping.ii == chosen_ii(array, Form(depth, relu, "e4m3", results), 500)


def test_drains_that_cannot_pack_are_refused() -> None:
    with pytest.raises(SystolicError, match="6 columns are not a multiple of 4"):
        plan(SystolicArray.of(small(2, 6)), Form(4, results="e4m3"))
    slow = SMALL.replace("{{fma", "{{convert: 3, fma").format(rows=4, cols=5, fma=4, load=2)
    with pytest.raises(SystolicError, match="cannot store f16: the latency of convert is 3"):
        plan(SystolicArray.of(arch.load_text(slow, "slow.yaml")), Form(4, results="f16"))
    blunt = SMALL.format(rows=4, cols=5, fma=4, load=2)
    blunt += "overrides:\n  - at: {rows: 1}\n    sliced: false\n"
    with pytest.raises(SystolicError, match=r"at its edge has no pack\.f16x2"):
        plan(SystolicArray.of(arch.load_text(blunt, "blunt.yaml")), Form(4, results="f16"))


@pytest.mark.parametrize(("fma", "load"), [(1, 1), (2, 1), (3, 3), (5, 2), (6, 4)])
def test_other_latencies_give_legal_mappings(fma: int, load: int) -> None:
    array = SystolicArray.of(small(3, 2, fma, load))
    for depth in (1, 6, 9):
        region = gemm_region(array, Form(depth, relu=True))
        assert violations(region.dfg, array.fabric, region.mapping) == []


def test_a_block_takes_a_cycle_more_than_its_inner_dimension() -> None:
    array = SystolicArray.of(arch.load("vivid-16x16"))
    for depth in (35, 64, 128, 150):
        assert least_ii(array, Form(depth, relu=True)) == depth + 1
    assert least_ii(array, Form(32, relu=True)) == 34  # 32 of a drain's slots are taken


def test_a_cycle_a_block_is_not_bought_with_a_long_way_to_the_first_one() -> None:
    array = SystolicArray.of(arch.load("vivid-16x16"))
    assert [chosen_ii(array, Form(depth), 500) for depth in (16, 38, 64, 150)] == [19, 39, 66, 152]
    assert chosen_ii(array, Form(64), 65) == 65
    spans = [SystolicSchedule(array, Form(64), ii).span for ii in (65, 66)]
    assert spans[0] > spans[1] + 48


def test_the_drains_of_a_word_share_its_work() -> None:
    array = SystolicArray.of(arch.load("vivid-8x8"))
    for depth, ii in ((1, 9), (8, 11), (9, 13), (12, 15), (15, 17), (16, 18)):
        assert least_ii(array, Form(depth, True, "e4m3", "e4m3")) == ii
    assert least_ii(array, Form(8)) == 11
    assert least_ii(array, Form(8, True)) == 11


@pytest.mark.parametrize("results", ["f32", "f16", "e4m3"])
@pytest.mark.parametrize("depth", [8, 9, 16, 38])
def test_places_that_other_pes_load_give_legal_mappings(results: Precision, depth: int) -> None:
    array = SystolicArray.of(arch.load("vivid-8x8"))
    region = gemm_region(array, Form(depth, results == "e4m3", "e4m3", results))
    assert violations(region.dfg, array.fabric, region.mapping) == []


def test_a_fabric_without_edges_is_refused() -> None:
    with pytest.raises(SystolicError, match="vivid-tile is not a systolic array"):
        SystolicArray.of(arch.load("vivid-tile"))


def test_an_inner_dimension_beyond_the_contexts_is_refused() -> None:
    array = SystolicArray.of(arch.load("vivid-8x8"))
    plan(array, Form(509))
    with pytest.raises(SystolicError, match="takes 511 contexts"):
        plan(array, Form(510))
