"""What the machine forbids stops the run with the source line, PE, region and cycle."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from tests.program.hand_kernels import FILE, O, choose, fabric, find, saxpy
from vividc import simulate
from vividc.errors import SimulationError, SourceLoc
from vividc.program import Entry, Operand, Program, Sel, Select, pack, word_layout


def patched(program: Program, context: int, pe: int, change: Callable[[Entry], Entry]) -> Program:
    """The program with one configuration entry changed."""
    words = program.words.copy()
    entry = change(program.entries[context][pe])
    words[context, pe] = pack(word_layout(program.fabric), entry)
    return replace(program, words=words)


def arrays(n: int) -> tuple[np.ndarray, np.ndarray]:
    return np.ones(n, np.float32), np.ones(n, np.float32)


def test_reading_nothing_names_line_pe_region_and_cycle() -> None:
    def read_output(entry: Entry) -> Entry:
        issue = entry.issue
        assert issue is not None
        a, _, c = issue.operands
        wrong = Operand(Select(Sel.OUT))
        return replace(entry, issue=replace(issue, operands=(a, wrong, c)))

    program = saxpy(fabric())
    (fma,) = (row for row in program.debug if row.op == O.FMA.value)
    with pytest.raises(SimulationError) as caught:
        simulate(patched(program, 2, 1, read_output), *arrays(4), 4)
    assert caught.value.loc == fma.loc
    assert "PE 1 (fma), region loop, cycle 4" in caught.value.reason
    assert isinstance(fma.loc, SourceLoc)
    assert fma.loc.file == FILE


def test_link_that_is_no_longer_driven_carries_nothing() -> None:
    def silence(entry: Entry) -> Entry:
        return replace(entry, links=tuple(Select(Sel.NONE) for _ in entry.links))

    with pytest.raises(SimulationError, match="reads nothing: PE 1"):
        simulate(patched(saxpy(fabric()), 2, 0, silence), *arrays(4), 4)


def test_two_completions_in_one_cycle() -> None:
    program = choose(fabric(latencies="{select: 2}"))

    def two_cycles(entry: Entry) -> Entry:
        issue = entry.issue
        assert issue is not None
        operand = issue.operands[0]
        return replace(entry, issue=replace(issue, op=O.SELECT, operands=(operand,) * 3))

    def one_cycle(entry: Entry) -> Entry:
        issue = program.entries[0][0].issue
        return replace(entry, issue=issue)

    broken = patched(patched(program, 1, 0, one_cycle), 0, 0, two_cycles)
    with pytest.raises(SimulationError, match="two operations complete in one cycle: PE 0"):
        simulate(broken, 3)


@pytest.mark.parametrize(("offset", "what"), [(2, "misaligned"), (-4, "out-of-bounds")])
def test_bad_address(offset: int, what: str) -> None:
    def shift_address(entry: Entry) -> Entry:
        issue = entry.issue
        assert issue is not None
        return replace(entry, issue=replace(issue, offset=offset))

    program = saxpy(fabric())
    with pytest.raises(SimulationError, match=f"{what} access at byte {offset} of") as caught:
        simulate(patched(program, 2, 0, shift_address), *arrays(4), 4)
    assert "(load x)" in caught.value.reason


def test_bad_store_address_even_in_the_last_iteration() -> None:
    x = np.zeros(4096, np.float32)
    y = np.zeros(4096, np.float32)
    simulate(saxpy(fabric()), x, y, 4096)
    with pytest.raises(SimulationError, match="out-of-bounds"):
        simulate(saxpy(fabric()), x, y, 4097)


def test_cycle_limit() -> None:
    x, y = np.zeros(4000, np.int32), np.zeros(4000, np.int32)
    with pytest.raises(SimulationError, match="in region search after 100 cycles"):
        simulate(find(fabric()), x, y, 7, cycle_limit=100)
    assert np.array_equal(y, np.zeros(4000))
    simulate(saxpy(fabric()), *arrays(8), 8, cycle_limit=14)
    with pytest.raises(SimulationError, match="cycle_limit"):
        simulate(saxpy(fabric()), *arrays(8), 8, cycle_limit=13)


def test_regions_without_cycles_cannot_follow_each_other_for_ever() -> None:
    program = saxpy(fabric(controller="{switch_cycles: 0}"))
    loop = replace(program.table[1], next=1)
    endless = replace(program, table=(program.table[0], loop))
    with pytest.raises(SimulationError, match="after 1000 cycles"):
        simulate(endless, *arrays(4), 0, cycle_limit=1000)


def test_missing_return_value() -> None:
    program = choose(fabric())
    table = tuple(replace(row, next=None, branch=None) for row in program.table)
    with pytest.raises(SimulationError, match="without writing its return value"):
        simulate(replace(program, table=table), 99)


def test_progress_is_told() -> None:
    told: list[int] = []
    fast = fabric(scratchpad="{size_bytes: 262144, banks: 8}")
    n = 16_000
    x, y = np.zeros(n, np.float32), np.zeros(n, np.float32)
    result = simulate(saxpy(fast), x, y, n, progress=told.append)
    assert told == sorted(told)
    assert told
    assert told[-1] <= result.cycles
