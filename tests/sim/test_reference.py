"""The reference engine against numpy, and against cycle counts by hand from docs/machine.md."""

from __future__ import annotations

import numpy as np
import pytest

from tests.program.hand_kernels import choose, dot, fabric, find, pairs, positive, saxpy
from vividc import simulate
from vividc.errors import SimulationError

TRIP_AND_SWITCH = 3  # the straight region that sets the trip count, and the switch after it


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 100])
def test_counted_loop_at_ii_1(n: int) -> None:
    x = np.linspace(-3, 7, n, dtype=np.float32)
    y = np.linspace(1, 2, n, dtype=np.float32)
    expected = np.float32(2) * x + y
    result = simulate(saxpy(fabric()), x, y, n)
    assert np.array_equal(y, expected)
    assert result.cycles == TRIP_AND_SWITCH + (n - 1) + 4
    assert result.value is None
    loop = result.stats["regions"][1]
    assert loop["iterations"] == n
    assert loop["operations"] == {"fma": n, "load": 2 * n, "store": n}
    assert result.stats["activity"]["scratchpad_reads"] == 2 * n
    assert result.stats["activity"]["scratchpad_writes"] == n
    assert result.stats["activity"]["link_words"] == 4 * n
    assert result.stats["stalls"] == {"bank_conflict": 0}


@pytest.mark.parametrize("n", [0, -1, -(2**31)])
def test_loop_without_iterations_takes_no_cycle(n: int) -> None:
    x, y = np.ones(4, np.float32), np.ones(4, np.float32)
    result = simulate(saxpy(fabric()), x, y, n)
    assert result.cycles == TRIP_AND_SWITCH
    assert np.array_equal(y, np.ones(4))


@pytest.mark.parametrize("n", [0, 1, 2, 9])
def test_recurrence_and_variables_between_regions(n: int) -> None:
    x = np.arange(1, n + 1, dtype=np.float32)
    y = np.full(n, 0.5, np.float32)
    result = simulate(dot(fabric(latencies="{fma: 4}")), x, y, n)
    assert result.value == float(0.5 * n * (n + 1) / 2)
    loop = (n - 1) * 4 + 6 if n else 0
    assert result.cycles == 2 + 1 + loop + 1 + 2
    assert result.stats["switch_cycles"] == 2


@pytest.mark.parametrize("at", [0, 1, 2, 7, 15])
def test_exit_kills_later_iterations(at: int) -> None:
    x = np.arange(100, 116, dtype=np.int32)
    y = np.zeros(16, np.int32)
    result = simulate(find(fabric()), x, y, key=100 + at)
    assert result.value == at
    assert y[:at].tolist() == x[:at].tolist()
    assert not y[at:].any(), "unless_exit stops the exiting iteration's store"
    assert result.cycles == at + 4
    loop = result.stats["regions"][0]
    assert loop["iterations"] == at + 1
    assert loop["operations"]["load"] == at + 3, "iterations at+1 and at+2 load speculatively"
    assert loop["operations"]["icmp.eq"] == at + 2


def test_counted_loop_with_exit_ends_by_either() -> None:
    x = np.arange(8, dtype=np.int32)
    y = np.zeros(8, np.int32)
    program = find(fabric(), counted=True)
    assert simulate(program, x, y, 99, 5).cycles == TRIP_AND_SWITCH + 4 + 4
    assert y.tolist() == [0, 1, 2, 3, 4, 0, 0, 0]
    assert simulate(program, x, y, 2, 5).value == 2
    last = simulate(program, x, y, 4, 5)
    assert (last.value, last.cycles) == (4, TRIP_AND_SWITCH + 4 + 4)
    assert last.stats["regions"][1]["operations"]["load"] == 5, "the trip count bounds speculation"


def test_speculative_load_beyond_the_scratchpad_gives_0() -> None:
    small = fabric(scratchpad="{size_bytes: 128, banks: 4}")
    x = np.arange(100, 128, dtype=np.int32)
    y = np.zeros(4, np.int32)
    program = find(small)
    assert simulate(program, x, y, 103).value == 3
    end_first = np.arange(32, dtype=np.int32)
    with pytest.raises(SimulationError, match="out-of-bounds"):
        simulate(program, end_first, np.zeros(0, np.int32), 1000)


def test_predicated_store() -> None:
    x = np.array([3, -1, 0, 2, -5], np.int32)
    y = np.full(5, 9, np.int32)
    result = simulate(positive(fabric()), x, y, 5)
    assert y.tolist() == [3, 9, 9, 2, 9]
    assert result.stats["activity"]["scratchpad_writes"] == 2
    assert result.cycles == TRIP_AND_SWITCH + 4 + 3


@pytest.mark.parametrize(("distance", "stalls"), [(8, 1), (1, 0), (16, 1)])
def test_bank_conflicts_stall_the_tile(distance: int, stalls: int) -> None:
    n = 10
    x = np.arange(n + distance, dtype=np.int32)
    y = np.zeros(n, np.int32)
    result = simulate(pairs(fabric(), distance), x, y, n)
    assert y.tolist() == (x[:n] + x[distance:]).tolist()
    stalled = result.stats["stalls"]["bank_conflict"]
    assert result.cycles == TRIP_AND_SWITCH + (n - 1) + 4 + stalled
    # the store of iteration i - 3 goes to y[i - 3]: y starts at the next multiple of 8, plus 1
    y_bank, banks = 1, 8
    expected = 0
    for cycle in range(n + 3):
        touched = []
        if cycle < n:
            touched += [cycle % banks, (cycle + distance) % banks]
        if cycle >= 3:
            touched.append((cycle - 3 + y_bank) % banks)
        expected += max((touched.count(bank) for bank in touched), default=1) - 1
    assert stalled == expected
    assert stalls == 0 or stalled >= n


@pytest.mark.parametrize(("n", "value"), [(3, 1), (10, 2), (-4, 1)])
def test_branch(n: int, value: int) -> None:
    result = simulate(choose(fabric()), n)
    assert (result.value, result.cycles) == (value, 2 + 1 + 2)
