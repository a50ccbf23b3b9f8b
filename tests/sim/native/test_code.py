"""Machine code is compiled once, and found again by what it was compiled from."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.program.hand_kernels import dot, fabric, saxpy
from tests.sim.native.agreement import launch
from vividc.host import cache
from vividc.sim import NativeEngine
from vividc.sim.native import code

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture
def compilations(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Texts compiled from now on; the cache is empty, the process knows no code."""
    texts: list[str] = []
    compile_ = code.object_code

    def noted(text: str) -> bytes:
        texts.append(text)
        return compile_(text)

    monkeypatch.setenv(cache.VARIABLE, str(tmp_path))
    monkeypatch.setattr(code, "object_code", noted)
    monkeypatch.setattr(code, "known_code", type(code.known_code)())
    return texts


def test_equal_programs_are_compiled_once(compilations: list[str]) -> None:
    NativeEngine(saxpy(fabric()))
    NativeEngine(saxpy(fabric()))
    assert len(compilations) == 1
    NativeEngine(dot(fabric(latencies="{fma: 4}")))
    assert len(compilations) == 2


def test_code_of_another_process_is_loaded(
    compilations: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    program = saxpy(fabric())
    NativeEngine(program)
    monkeypatch.setattr(code, "known_code", type(code.known_code)())
    x, y = np.ones(8, np.float32), np.ones(8, np.float32)
    run = NativeEngine(program).run(launch(program, x, y, 8))
    assert len(compilations) == 1
    assert run.memory.view(np.float32)[:16].max() == 3


def test_a_process_that_compiles_nothing_runs_code_of_another(tmp_path: Path) -> None:
    """LLVM has to be set up for loading, too."""
    program = saxpy(fabric())
    program.save(tmp_path / "saxpy.vivid")
    script = (
        "import sys, numpy as np, vividc\n"
        "y = np.ones(8, np.float32)\n"
        "program = vividc.load(sys.argv[1])\n"
        "if len(sys.argv) > 2:\n"
        "    from vividc.sim.native import code\n"
        "    code.object_code = None\n"
        "result = vividc.simulate(program, y.copy(), y, 8, engine='native')\n"
        "print(result.stats['engine'], y.max())\n"
    )
    environment = {**os.environ, cache.VARIABLE: str(tmp_path)}
    for more in ([], ["compile nothing"]):
        command = [sys.executable, "-c", script, str(tmp_path / "saxpy.vivid"), *more]
        done = subprocess.run(
            command, env=environment, cwd=ROOT, capture_output=True, text=True, check=True
        )
        assert done.stdout == "native 3.0\n"


def test_another_machine_means_other_code(
    compilations: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    NativeEngine(saxpy(fabric()))
    monkeypatch.setattr(code, "host", lambda: "another computer")
    NativeEngine(saxpy(fabric()))
    assert len(compilations) == 2
