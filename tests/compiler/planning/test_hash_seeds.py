"""The same kernel is given the same loops in every process, whatever order sets have in it, and on
however many cores.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

KERNEL = """
import vividc

@vividc.kernel("void(float32[:, ::1], float32[::1], float32[::1], float32[::1], float32[::1])")
def both(a, x, y, z, w):
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            y[i] += a[i, j] * x[j]
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            w[i] += a[j, i] * z[j]

@vividc.kernel("void(int32[::1], int32[::1], int32)")
def with_exits(x, out, t):
    a = b = s = 0
    for i in range(len(x)):
        a = x[i] * 3
        if a > t:
            break
        b = a + s * 5
        if b > 2 * t:
            break
        s = s + b
    out[0] = a
    out[1] = b
    out[2] = s
"""
PROCESS = """
import os, sys
if sys.argv[3] == "on one core":
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
sys.path.insert(0, sys.argv[1])
from nests import both, with_exits
from vividc import arch
from vividc.compiler.planning.choose import choose
from vividc.compiler.planning.estimate import Estimator
from vividc.compiler.planning.options import LoopOptions
from vividc.dfg.pipeline import PassOptions
from vividc.ssa.text import to_text

estimator = Estimator(arch.load("vivid-tile"), PassOptions(reassociate=True))
unrolled = LoopOptions(auto=False, unroll={int(sys.argv[2]): 2})
for kernel, options in ((both, LoopOptions()), (with_exits, unrolled)):
    for stage in choose(kernel.lower(), estimator, options).stages:
        print(to_text(stage.state.function))
"""


def stages(folder: Path, seed: str, cores: str = "") -> str:
    """The functions of the plan that a process with this seed makes."""
    line = KERNEL[: KERNEL.index("for i in range(len(x))")].count("\n") + 1
    script = [sys.executable, "-c", PROCESS, str(folder), str(line), cores]
    env = {**os.environ, "PYTHONHASHSEED": seed}
    done = subprocess.run(script, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_plans_do_not_depend_on_the_seed_of_hashes(tmp_path: Path) -> None:
    (tmp_path / "nests.py").write_text(KERNEL)
    assert len({stages(tmp_path, seed) for seed in ("0", "1", "3")}) == 1


@pytest.mark.skipif(sys.platform != "linux", reason="cores are given to processes on Linux")
def test_plans_do_not_depend_on_how_many_cores_there_are(tmp_path: Path) -> None:
    (tmp_path / "nests.py").write_text(KERNEL)
    assert stages(tmp_path, "0") == stages(tmp_path, "0", "on one core")
