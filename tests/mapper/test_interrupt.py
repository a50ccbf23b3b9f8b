"""A mapping that is interrupted or runs out of time leaves no worker behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = textwrap.dedent(
    """
    import os, sys, time
    sys.path.insert(0, "tests/mapper")
    from fabrics import grid
    from graphs import blending
    from vividc.mapper import map_dfg

    def threads():
        return len(os.listdir("/proc/self/task"))

    map_dfg(blending(), grid(1, 1, links=False), "cpsat", time_limit_s=1, workers=2)
    before = threads()
    told = []

    def tell(line):
        if "joint" in line or "mobility" in line or "iterative" in line or "annealing" in line:
            if not told:
                print("solving", flush=True)
            told.append(line)

    try:
        map_dfg(
            blending(), grid(3, 3, contexts=64), sys.argv[1], time_limit_s=float(sys.argv[2]),
            workers=2, progress=tell,
        )
        print("done")
    except KeyboardInterrupt:
        print("interrupted")
    end = time.monotonic() + 10
    while threads() > before and time.monotonic() < end:
        time.sleep(0.01)  # the system counts a thread for a moment after it was joined
    print(threads() - before)
    """
)


def _run(mapper: str, time_limit_s: float, *, interrupt: bool) -> list[str]:
    with subprocess.Popen(
        [sys.executable, "-c", PROGRAM, mapper, str(time_limit_s)],
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        lines = [process.stdout.readline().strip()]
        if interrupt:
            process.send_signal(signal.SIGINT)
        lines += process.stdout.read().split()
    assert not Path(f"/proc/{process.pid}").exists()
    return lines


@pytest.mark.parametrize("mapper", ["cpsat", "sat-kms"])
def test_no_thread_is_left_after_an_interrupt(mapper: str) -> None:
    assert _run(mapper, 60.0, interrupt=True) == ["solving", "interrupted", "0"]


@pytest.mark.parametrize("mapper", ["cpsat", "sat-kms"])
def test_no_thread_is_left_after_the_time_limit(mapper: str) -> None:
    lines = _run(mapper, 1.5, interrupt=False)
    assert lines[-2:] == ["done", "0"]
