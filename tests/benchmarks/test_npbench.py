"""Programs of a folder that is laid out as NPBench: what runs, and why the rest does not."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks.npbench import RTOL, Row, largest_error, measured, programs, spread

NUMBA = "import numba as nb\nimport numpy as np\n\n\n@nb.jit(nopython=True)\n"


def suite(folder: Path, program: str) -> Path:
    """A folder with one program, `sums`, whose arguments are x and n."""
    home = folder / "npbench" / "sums"
    home.mkdir(parents=True)
    (home / "sums_numba_n.py").write_text(NUMBA + program)
    (home / "sums.py").write_text(
        "import numpy as np\ndef initialize(N): return np.arange(N) / 2\n"
    )
    described = {
        "module_name": "sums",
        "func_name": "sums",
        "parameters": {"S": {"N": 4000, "TSTEPS": 50}},
        "init": {"func_name": "initialize", "input_args": ["N"], "output_args": ["x"]},
        "input_args": ["x", "TSTEPS"],
    }
    (folder / "bench_info").mkdir()
    (folder / "bench_info" / "sums.json").write_text(json.dumps({"benchmark": described}))
    return folder


def test_a_program_that_runs(tmp_path: Path) -> None:
    folder = suite(tmp_path, "def sums(x, n):\n    x[0] = n\n    return x * np.float32(2)\n")
    assert list(programs(folder)) == ["sums"]
    row = measured(folder, "sums")
    assert row.error == 0
    assert row.cycles
    assert row.operations is not None
    assert 14 <= row.operations <= 16
    assert row.line.startswith("| sums | yes | yes | ")


def test_a_program_that_is_refused_says_why(tmp_path: Path) -> None:
    row = measured(suite(tmp_path, "def sums(x, n):\n    return [x]\n"), "sums")
    assert row.cycles is None
    assert "list" in row.refused


DOUBLED = "def sums(x, n):\n    y = np.empty_like(x)\n    for i in nb.prange(len(x)):\n"


@pytest.mark.parametrize(("body", "why"), [("2 * x[i]", ""), ("2 * x[i] + y[i - 1]", "read")])
def test_a_program_with_prange_is_spread_or_says_why_not(
    tmp_path: Path, body: str, why: str
) -> None:
    folder = suite(tmp_path, DOUBLED + "        y[i] = 2 * x[i]\n    return y\n")
    (file,) = programs(folder).values()
    looped = DOUBLED + f"        y[i] = {body} if i else 1\n    return y\n"
    file.with_name("sums_numba_npr.py").write_text(NUMBA + looped)
    assert list(programs(folder, "npr")) == ["sums"]
    row = spread(folder, "sums")
    assert row.cycles
    assert row.on_tile
    assert row.tiles
    assert row.tiles > 1 or why
    assert why in row.refused
    assert bool(row.refused) == bool(why)
    assert row.line.startswith("| sums | yes | yes | ")


def test_a_wrong_result_is_marked() -> None:
    assert "**no**" in Row("sums", error=1.0, cycles=3, operations=1, compile_s=0.1).line
    x = np.arange(3, dtype=np.float32)
    assert largest_error([x, (x, 1)], [x, (x, 1)]) == 0
    assert largest_error([x + 1], [x]) > RTOL
    assert largest_error([x, (x,)], [x, (x, 1)]) == np.inf
    assert largest_error([x.astype(np.int32)], [x]) == np.inf
