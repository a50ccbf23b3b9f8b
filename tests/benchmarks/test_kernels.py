"""The tables of kernels on one tile: rows, and what is said below them."""

from __future__ import annotations

import pytest

from benchmarks import kernels
from benchmarks.workloads import WORKLOADS


def test_a_table_has_a_row_a_kernel_and_says_what_they_come_to(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    chosen = tuple(one for one in WORKLOADS if one.name in {"saxpy", "dot"})
    monkeypatch.setitem(kernels.TABLES, "kernels", ("Kernels", chosen))
    header, _, *rows, empty, seconds, predicted, gain = kernels.lines("kernels", "vivid-tile", 60.0)
    names = [name.strip() for name in header.split("|")]
    assert all(row.count("|") == header.count("|") for row in rows)
    cells = {
        row.split("|")[1].strip(): dict(zip(names, row.split("|"), strict=True)) for row in rows
    }
    assert list(cells) == ["saxpy", "dot"]
    assert cells["dot"]["II"].strip() == "4"
    assert cells["dot"]["predicted"].strip() == "1.00"
    assert float(cells["saxpy"]["gain"]) > 1.5
    assert empty == ""
    assert seconds.startswith("- compile s: median ")
    assert predicted.endswith("0 of 2")
    assert gain.startswith("- gain: geometric mean 1.")
