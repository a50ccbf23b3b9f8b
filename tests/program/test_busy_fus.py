"""FUs that an operation keeps for several cycles: no word issues while they are busy."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import vividc
from vividc.arch import load_text
from vividc.machine.opcodes import OPCODES
from vividc.program import Program, RegionRow

_BUSY = "extends: vivid-tile\noccupancy: {fmul: 4, fadd: 3, imul: 2, int: 2, load: 5}\n"


@vividc.kernel("float32(float32[::1], float32[::1], int32)")
def polynomial(x, y, n):
    total = np.float32(0.0)
    for i in range(n):
        v = x[i]
        total += (v * v + v) * v
        y[i] = total * v
    return total * total


@vividc.kernel("int32(int32[::1], int32)")
def search(x, n):
    for i in range(n):
        if x[i] * x[i] - 3 * x[i] > 900:
            return i
    return -1


@cache
def _program(name: str) -> Program:
    kernel = {"polynomial": polynomial, "search": search}[name]
    return vividc.compile(
        kernel, fabric=load_text(_BUSY), time_limit_s=60, loops=vividc.LoopOptions(auto=False)
    )


@pytest.mark.parametrize("name", ["polynomial", "search"])
def test_an_fu_issues_nothing_while_it_is_busy(name: str) -> None:
    program = _program(name)
    for row in program.table:
        for pe in range(len(program.fabric.pes)):
            busy = _busy_slots(program, row, pe)
            assert len(set(busy)) == len(busy), (row, pe)


@pytest.mark.parametrize("name", ["polynomial", "search"])
def test_the_utilization_counts_busy_fus(name: str) -> None:
    program = _program(name)
    for row, report in zip(program.table, program.regions, strict=True):
        pes = range(len(program.fabric.pes))
        busy = sum(len(_busy_slots(program, row, pe)) for pe in pes)
        assert report.utilization == pytest.approx(busy / (row.ii * len(pes)))


def _busy_slots(program: Program, row: RegionRow, pe: int) -> list[int]:
    """Slots in which the PE's FU issues or is busy; a straight region must end with it idle."""
    slots = []
    for slot in range(row.ii):
        issue = program.entries[row.context + slot][pe].issue
        if issue is None:
            continue
        cycles = program.fabric.occupancies.get(OPCODES[issue.op].latency_class, 1)
        assert row.kind == "loop" or slot + cycles <= row.ii
        assert row.kind == "straight" or issue.stage * row.ii + slot + cycles <= row.span
        slots += [(slot + cycle) % row.ii for cycle in range(cycles)]
    return slots


def test_results_are_those_of_numba() -> None:
    x = np.linspace(-2, 2, 17).astype(np.float32)
    expected, found = np.zeros(17, np.float32), np.zeros(17, np.float32)
    value = polynomial(x, expected, 17)
    result = vividc.simulate(_program("polynomial"), x, found, 17)
    # FMA contraction: one rounding less a multiplication and addition
    np.testing.assert_allclose(found, expected, rtol=1e-5)
    np.testing.assert_allclose(result.value, value, rtol=1e-5)
    numbers = np.arange(50, dtype=np.int32)
    result = vividc.simulate(_program("search"), numbers, 50)
    assert result.value == search(numbers, 50) == 32


def test_busy_fus_cost_cycles() -> None:
    loop = next(region for region in _program("polynomial").regions if region.kind == "loop")
    assert loop.ii >= 5
    assert loop.status == "optimal"
