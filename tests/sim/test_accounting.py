"""Cycles, operations and bytes of regions, counted by hand and against their sums."""

from __future__ import annotations

import numpy as np
import pytest

import vividc
from tests.sim.view import small_kernels
from vividc.program import RegionRow
from vividc.sim.accounting import by_kind, bytes_by_level, cycles_by_use
from vividc.sim.engine import Activity, RegionRun


def row(kind: str, ii: int, span: int) -> RegionRow:
    return RegionRow(
        kind=kind,
        context=0,
        ii=ii,
        span=span,
        stages=-(-span // ii),
        counted=True,
        has_exit=False,
        next=None,
        branch=None,
    )


@pytest.mark.parametrize(
    ("kind", "ii", "span", "runs", "stalls", "expected"),
    [
        # One run of 10 iterations: 9 * 2 + 7 = 25 cycles, 20 of them steady.
        ("loop", 2, 7, [10], 0, (20, 5, 0)),
        # Three runs of 10, 1 and 0 iterations: 25 + 7 + 0 cycles, 22 steady; 4 stalls beside.
        ("loop", 2, 7, [10, 1, 0], 4, (22, 10, 0)),
        ("straight", 5, 5, [1, 1], 1, (0, 0, 10)),
    ],
)
def test_cycles_by_use(kind, ii, span, runs, stalls, expected):
    cycles = sum((k - 1) * ii + span for k in runs if k) + stalls
    region = RegionRun(len(runs), sum(runs), cycles, stalls, {})
    found = cycles_by_use(row(kind, ii, span), region)
    assert tuple(found.values()) == (*expected, stalls)
    assert sum(found.values()) == cycles


def test_kinds_of_operations():
    issued = {"fma": 3, "fadd": 1, "fsub": 2, "add": 4, "fneg": 1, "mov": 5, "load": 6, "fmin": 7}
    assert by_kind(issued) == {
        "compare": {"f32": 7},
        "fadd": {"f32": 3},
        "fma": {"f32": 3},
        "int": {"f32": 1, "i32": 4, "word": 5},
        "load": {"word": 6},
    }


def test_bytes_are_whole_words():
    moved = bytes_by_level(Activity(link_words=3, scratchpad_reads=2, constant_writes=1))
    assert moved["links"] == 12
    assert moved["scratchpad_read"] == 8
    assert moved["constants_written"] == 4
    assert moved["registers_read"] == 0


def test_regions_add_up_to_the_run():
    program = vividc.compile(small_kernels.strided, time_limit_s=30)
    x, y = np.arange(256, dtype=np.int32), np.zeros(12, np.int32)
    stats = vividc.simulate(program, x, y, 8, 16, 12).stats
    assert sum(stats["cycles_by_use"].values()) == stats["cycles"]
    assert stats["cycles_by_use"]["bank_stall"] == stats["stalls"]["bank_conflict"]
    assert stats["cycles_by_use"]["switch"] == stats["switch_cycles"]
    for name, count in stats["activity"].items():
        assert count == sum(region["activity"][name] for region in stats["regions"])
    for region in stats["regions"]:
        assert sum(region["cycles_by_use"].values()) == region["cycles"]
        kinds = region["operations_by_class"].values()
        assert sum(sum(kind.values()) for kind in kinds) == sum(region["operations"].values())
    loop = max(stats["regions"], key=lambda region: region["cycles"])
    # Two loads and a store in each of 12 iterations, nothing elsewhere.
    assert loop["activity"]["scratchpad_reads"] == 24
    assert loop["bytes"]["scratchpad_written"] == 48
    assert stats["bytes"]["scratchpad_read"] == 96
