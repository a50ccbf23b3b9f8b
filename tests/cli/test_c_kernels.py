"""C functions on the command line: compile, simulate, check."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from vividc.cli import main

KERNELS = Path(__file__).resolve().parents[2] / "kernels" / "c"


def run(*args: object) -> Result:
    return CliRunner().invoke(main, [*map(str, args)])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("c")
    shutil.copy(KERNELS / "signals.ll", folder / "k.ll")
    result = run("compile", f"{folder / 'k.ll'}:fir", "-o", folder / "fir.vivid")
    assert result.exit_code == 0, result.stderr
    x, h = np.arange(20, dtype=np.int32), np.arange(8, dtype=np.int32)
    np.savez(folder / "in.npz", x=x, h=h, y=np.zeros(13, np.int32), n=20)
    return folder


def test_check_agrees_with_the_same_file_on_the_host(folder: Path) -> None:
    result = run("simulate", folder / "fir.vivid", "--inputs", folder / "in.npz", "--check")
    assert result.exit_code == 0, result.stderr
    assert "check: agrees with LLVM on this computer" in result.stdout


def test_check_reports_a_mismatch(folder: Path, tmp_path: Path) -> None:
    text = (folder / "k.ll").read_text()
    changed = tmp_path / "other.ll"
    changed.write_text(text.replace("mul nsw i32", "add nsw i32"))
    assert changed.read_text() != text
    spec = ("--kernel", f"{changed}:fir")
    program, inputs = folder / "fir.vivid", folder / "in.npz"
    result = run("simulate", program, "--inputs", inputs, "--check", *spec, "--json")
    assert result.exit_code == 5
    assert json.loads(result.stdout)["check"]["passed"] is False


def test_wrong_arguments_name_the_parameters(folder: Path, tmp_path: Path) -> None:
    np.savez(tmp_path / "in.npz", arg0=np.zeros(3, np.int32))
    result = run("simulate", folder / "fir.vivid", "--inputs", tmp_path / "in.npz")
    assert result.exit_code == 2
    assert "expected: x: int32[...], h: int32[...], y: int32[...], n: int32" in result.stderr


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("k.ll", "has several functions: fir, biquad, jacobi2d, prefix_sum"),
        ("k.ll:none", "has no function `none`"),
        ("gone.ll:fir", "cannot be read"),
    ],
)
def test_wrong_files_and_functions(folder: Path, spec: str, message: str) -> None:
    result = run("compile", folder / spec)
    assert result.exit_code == 2
    assert message in result.stderr
    assert "Traceback" not in result.stderr
