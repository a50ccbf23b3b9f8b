"""Formats on the command line: the policy, float16 arrays, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from vividc.cli import main

SOURCE = """\
import math

import numpy as np
import vividc
from vividc import lang


@vividc.kernel("void(float32[::1], float32[::1])")
def glow(x, y):
    for i in range(len(x)):
        y[i] = math.exp(x[i])


@vividc.kernel("void(float16[::1], uint8[::1])")
def squares(x, codes):
    for i in range(len(x)):
        x[i] = x[i] * x[i]
        codes[i] = lang.bits_of(lang.fp8(x[i]))
"""


def run(*args: object) -> Result:
    return CliRunner().invoke(main, [*map(str, args)])


@pytest.fixture
def kernels(tmp_path: Path) -> Path:
    file = tmp_path / "k.py"
    file.write_text(SOURCE)
    return file


def test_a_policy_gives_numbers_of_the_format(kernels: Path) -> None:
    folder = kernels.parent
    command = ("compile", f"{kernels}:glow", "--precision", "exp=e5m2", "-o", folder / "k.vivid")
    assert run(*command).exit_code == 0
    x = np.linspace(-3, 3, 50).astype(np.float32)
    np.savez(folder / "in.npz", x=x, y=np.zeros_like(x))
    simulate = ("simulate", folder / "k.vivid", "--inputs", folder / "in.npz")
    assert run(*simulate, "--outputs", folder / "out.npz").exit_code == 0
    got = np.load(folder / "out.npz")["y"]
    assert np.all(got.view(np.uint32) & 0x1FFFFF == 0)  # two bits of mantissa
    assert np.allclose(got, np.exp(x), rtol=0.13)
    assert run(*simulate, "--check").exit_code == 5


def test_arrays_of_float16_pass_the_check(kernels: Path) -> None:
    folder = kernels.parent
    assert run("compile", f"{kernels}:squares", "-o", folder / "s.vivid").exit_code == 0
    x = np.linspace(-300, 300, 40).astype(np.float16)
    np.savez(folder / "in.npz", x=x, codes=np.zeros(40, np.uint8))
    done = run("simulate", folder / "s.vivid", "--inputs", folder / "in.npz", "--check")
    assert done.exit_code == 0, done.stderr


@pytest.mark.parametrize(
    ("policy", "says"),
    [
        ("exp=fp4", "fp32, fp16, fp8, e5m2"),
        ("erf=fp8", "exp, exp2"),
        ("exp", "FUNCTION=FORMAT"),
    ],
)
def test_what_no_policy_can_be_is_told(kernels: Path, policy: str, says: str) -> None:
    done = run("compile", f"{kernels}:glow", "--precision", policy)
    assert done.exit_code == 2
    assert says in done.stderr


def test_two_formats_of_one_function_are_refused(kernels: Path) -> None:
    done = run("compile", f"{kernels}:glow", "--precision", "exp=fp8", "--precision", "exp=fp16")
    assert done.exit_code == 2
    assert "exp is given twice" in done.stderr
