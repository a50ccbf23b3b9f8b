"""Inner loops as machine code: what one compiled function calls is put into it."""

from __future__ import annotations

import re
from typing import NamedTuple

import numba
import numpy as np
import pytest
from numba.core.codegen import CPUCodeLibrary
from numpy.typing import NDArray

from vividc.host.machine_code import compiler, inlined


class Table(NamedTuple):
    """Arrays that travel together."""

    keys: NDArray[np.int64]
    sums: NDArray[np.int64]


@inlined
def enter(table: Table, at: int, by: int) -> int:
    """Long enough not to be put into its callers for being short."""
    keys, sums = table.keys, table.sums
    if keys[at] % 3 == 0:
        return 0
    for step in range(1, 4):
        sums[(keys[at] * step) % len(sums)] += by
        for other in range(max(0, at - step), at):
            if keys[other] % 5 < step:
                sums[keys[other] % len(sums)] -= keys[at] // (step + by % 2)
            elif keys[other] > keys[at]:
                sums[(keys[other] + step) % len(sums)] += keys[other] % (at + 1)
    return int(sums[keys[at] % len(sums)] % 2)


@compiler(__file__)
def enter_all(table: Table, by: int) -> int:
    entered = 0
    for at in range(len(table.keys)):
        entered += enter(table, at, by)
        entered += enter(table, len(table.keys) - 1 - at, by + 1)
    return entered


def table_of(seed: int) -> Table:
    keys = np.random.default_rng(seed).integers(0, 1000, 200)
    return Table(keys, np.zeros(7, dtype=np.int64))


def test_machine_code_does_what_python_does() -> None:
    ours, expected = table_of(1), table_of(1)
    entered = sum(enter(expected, at, 5) + enter(expected, 199 - at, 6) for at in range(200))
    assert enter_all(ours, 5) == entered > 0
    assert np.array_equal(ours.sums, expected.sums)
    assert ours.sums.any()


def test_no_call_is_left() -> None:
    """A call would copy all arrays of the tuple."""
    enter_all(table_of(2), 1)
    enter_all.recompile()  # type: ignore[attr-defined] # code from disk has no listing
    code = "".join(enter_all.inspect_asm().values())  # type: ignore[attr-defined]
    assert re.search(r"^_ZN\S*enter_all\S*:", code, re.MULTILINE)
    assert not re.search(r"^_ZN\S*enterB\S*:", code, re.MULTILINE)


def test_only_callers_are_optimised(monkeypatch: pytest.MonkeyPatch) -> None:
    """All that is put into a caller was optimised by itself before: two fifths of the time."""
    names = []
    optimise = CPUCodeLibrary._optimize_final_module

    def noted(library: CPUCodeLibrary) -> None:
        names.append(library.name.rpartition(".")[2])
        optimise(library)

    monkeypatch.setattr(CPUCodeLibrary, "_optimize_final_module", noted)

    @inlined
    def half(x: int) -> int:
        return x // 2

    @inlined
    def quarter(x: int) -> int:
        return half(half(x))

    @numba.njit
    def eighth(x: int) -> int:
        return half(quarter(x))

    assert eighth(17) == 2
    assert "eighth" in names
    assert not {"half", "quarter"} & set(names)
