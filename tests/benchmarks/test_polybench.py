"""The page of PolyBench: rows are kept, steps are told apart, results are compared with numba."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import vividc
from benchmarks.kernels import predicted
from benchmarks.polybench import table
from benchmarks.polybench.measure import RTOL, Row, largest_error, measured
from benchmarks.polybench.suite import CASES, IMAGES, MINI, POLYBENCH, SMALL
from vividc import arch
from vividc.errors import KernelError

SCRATCHPAD = arch.load("vivid-tile").scratchpad.size_bytes


def row(step: str, kernel: str, cycles: int) -> Row:
    return Row(step, kernel, SMALL, operations=1600, floor=50, error=0.0, cycles=cycles)


def test_the_suite_is_whole_and_fits_a_tile() -> None:
    assert (len(POLYBENCH), len(IMAGES)) == (30, 4)
    for case in CASES.values():
        for size in (MINI, SMALL):
            arrays = [a for a in case.fresh(size) if isinstance(a, np.ndarray)]
            assert sum(array.nbytes for array in arrays) <= SCRATCHPAD


def test_a_row_says_how_the_kernel_ran() -> None:
    made = measured("baseline", "jacobi-1d", MINI)
    assert made.is_right
    assert made.operations == 4 * 2 * 14 * 3
    assert made.cycles is not None
    assert made.floor is not None
    assert made.cycles > made.floor
    assert made.stalls is not None
    assert made.predicted == made.cycles - made.stalls


def test_a_prediction_counts_runs_iterations_and_switches() -> None:
    case = CASES["durbin"]
    program = vividc.compile(case.kernel)
    result = vividc.simulate(program, *case.fresh(MINI))
    assert predicted(program, result.stats) == pytest.approx(result.cycles, rel=0.1)


def test_a_refusal_is_a_row(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise KernelError("its arrays need more than the scratchpad")

    monkeypatch.setattr(vividc, "compile", refuse)
    made = measured("baseline", "gemm", MINI)
    assert made.cycles is None
    assert "scratchpad" in made.refused
    assert "refused" in table.line(made)


def test_an_error_is_a_share_of_the_greatest_number() -> None:
    one, other = np.array([100.0, 0.0], np.float32), np.array([100.0, 0.1], np.float32)
    assert largest_error((1, one), (1, other)) == pytest.approx(1e-3)
    assert largest_error((one,), (np.array([100.0, np.nan], np.float32),)) == np.inf
    whole = np.array([1, 2], np.int32)
    assert largest_error((whole,), (whole + 1,)) == np.inf
    assert largest_error((whole,), (whole.copy(),)) == 0.0 <= RTOL


def test_a_new_step_measures_anew_and_shows_the_progress(tmp_path: Path) -> None:
    kept = table.Kept(tmp_path)
    assert kept.begin("") == table.BASELINE
    kept.add(row(table.BASELINE, "gemm", 1600))
    kept.add(row(table.BASELINE, "lu", 400))
    assert kept.begin("tiling") == "tiling"
    kept.add(row("tiling", "gemm", 400))
    again = table.Kept(tmp_path)
    assert again.begin("") == "tiling"  # goes on
    assert again.has("tiling", "gemm", SMALL, known=False)
    assert not again.has("tiling", "lu", SMALL, known=False)
    lines = list(table.page(again))
    (tiling,) = (line for line in lines if line.startswith("| tiling |"))
    (baseline,) = (line for line in lines if line.startswith("| baseline |"))
    assert [cell.strip() for cell in baseline.split("|")][3:9] == [
        "2", "2 of 2", "8.0", "16.0", "8.0", "16.0",
    ]  # fmt: skip
    assert [cell.strip() for cell in tiling.split("|")][3:7] == ["1", "2 of 2", "4.0", "4.0"]


def test_rows_for_known_sizes_are_in_no_other_figure(tmp_path: Path) -> None:
    kept = table.Kept(tmp_path)
    kept.begin("")
    kept.add(row(table.BASELINE, "gemm", 1600))
    before = list(table.page(kept))
    kept.add(replace(row(table.BASELINE, "gemm", 400), known=True))
    kept.add(replace(row(table.BASELINE, "lu", 400), known=True))
    assert not kept.has(table.BASELINE, "lu", SMALL, known=False)
    after = list(table.page(table.Kept(tmp_path)))
    start = after.index("## Known sizes")
    end = start + len(after) - len(before)
    assert after[:start] + after[end:] == before
    gemm, lu = (line for line in after[start:end] if line.startswith(("| gemm", "| lu")))
    assert "| 400 | 1,600 | 4.0 | 16.0 |" in gemm
    assert "| 400 | - | 4.0 | - |" in lu
    assert "operations / 16 4.0, any: 16.0." in " ".join(after[start:end])


def test_rows_with_sums_in_another_order_are_in_no_other_figure(tmp_path: Path) -> None:
    kept = table.Kept(tmp_path)
    kept.begin("")
    kept.add(row(table.BASELINE, "gemm", 1600))
    before = list(table.page(kept))
    kept.add(replace(row(table.BASELINE, "gemm", 400), reassociate=True))
    assert not kept.has(table.BASELINE, "gemm", SMALL, known=True)
    assert kept.has(table.BASELINE, "gemm", SMALL, known=False, reassociate=True)
    after = list(table.page(table.Kept(tmp_path)))
    start = after.index("## Float sums in another order")
    end = start + len(after) - len(before)
    assert after[:start] + after[end:] == before
    assert "operations / 16 4.0, any: 16.0." in " ".join(after[start:end])


def test_a_kernel_is_measured_for_its_sizes_only(tmp_path: Path) -> None:
    wanted = table.Wanted(only=("durbin",), sizes=(MINI,), known=True)
    *_, page = table.sections(wanted, tmp_path)
    assert "## Known sizes" in page
    assert f"## {MINI}" not in page
    [made] = table.Kept(tmp_path).rows
    assert made.known
    assert made.is_right
    lines = (tmp_path / table.ROWS).read_text().splitlines()
    assert [json.loads(line).get("kernel") for line in lines] == [None, "durbin"]
    *_, again = table.sections(wanted, tmp_path)
    assert page == again
    assert (tmp_path / table.ROWS).read_text().splitlines() == lines


@pytest.mark.slow
def test_rows_are_kept_when_they_are_made(tmp_path: Path) -> None:
    wanted = table.Wanted(only=("trisolv",), sizes=(MINI,))
    *_, page = table.sections(wanted, tmp_path)
    lines = (tmp_path / table.ROWS).read_text().splitlines()
    assert [json.loads(line).get("kernel") for line in lines] == [None, "trisolv"]
    *_, again = table.sections(wanted, tmp_path)
    assert page == again
    assert (tmp_path / table.ROWS).read_text().splitlines() == lines
