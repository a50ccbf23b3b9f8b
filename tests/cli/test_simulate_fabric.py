"""`vividc simulate --fabric`: a job on an accelerator, from the command line."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from vividc.cli.main import main

KERNEL = """
import numpy as np
import vividc
from numba import prange

@vividc.kernel("int32(int32[::1], int32[::1])")
def scale(x, y):
    total = np.int32(0)
    for i in prange(x.shape[0]):
        y[i] = 3 * x[i]
        total += x[i]
    return total
"""


@pytest.fixture
def program(tmp_path: Path) -> Path:
    (tmp_path / "k.py").write_text(KERNEL)
    done = CliRunner().invoke(
        main,
        ["compile", str(tmp_path / "k.py"), "--fabric", "vivid", "-o", str(tmp_path / "p.vivid")],
    )
    assert done.exit_code == 0, done.output
    x = np.arange(90000, dtype=np.int32) % 1000
    np.savez(tmp_path / "in.npz", x=x, y=np.zeros_like(x))
    return tmp_path / "p.vivid"


def simulate(program: Path, *options: str) -> tuple[int, str]:
    inputs = str(program.parent / "in.npz")
    done = CliRunner().invoke(main, ["simulate", str(program), "--inputs", inputs, *options])
    return done.exit_code, done.output


def test_a_spread_run_is_checked_and_told(program: Path) -> None:
    out = program.parent / "out.npz"
    code, text = simulate(program, "--fabric", "vivid", "--check", "--outputs", str(out))
    assert code == 0, text
    assert "agrees with numba" in text
    assert "runs of 16 tiles)" in text
    with np.load(out) as arrays:
        assert (arrays["y"] == 3 * (np.arange(90000) % 1000)).all()
        assert arrays["return"] == 90 * (1000 * 999 // 2)
    code, text = simulate(program, "--fabric", "vivid", "--json")
    told = json.loads(text)
    assert told["fabric"] == "vivid"
    assert len(told["stats"]["tiles"]) == 16
    assert told["stats"]["stalls"]["dma"] > 0


def test_a_program_runs_on_what_it_was_compiled_for(program: Path) -> None:
    code, text = simulate(program, "--json")
    assert code == 0, text
    assert json.loads(text)["fabric"] == "vivid"


def test_one_tile_does_not_hold_the_arrays(program: Path) -> None:
    """It is what a waveform is of."""
    code, text = simulate(program, "--vcd", str(program.parent / "t.vcd"))
    assert code == 2
    assert "720000 bytes" in text


def test_a_tile_is_no_accelerator(program: Path) -> None:
    code, text = simulate(program, "--fabric", "vivid-tile")
    assert code == 2
    assert "single tile" in text
