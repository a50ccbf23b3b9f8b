"""A mapping that is interrupted or runs out of time leaves no worker behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
from random_graphs import random_loop

from tests.marks import with_slow
from vividc.arch import load
from vividc.dfg.ir import DFG
from vividc.mapper import MapInterrupted, map_dfg
from vividc.mapper.check.verify import verify

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
    side = 2 if sys.argv[1] == "sat-kms" else 3  # it maps to three by three in no time
    told = []

    def tell(line):
        if "joint" in line or "mobility" in line or "iterative" in line or "annealing" in line:
            if not told:
                print("solving", flush=True)
            told.append(line)

    try:
        map_dfg(
            blending(), grid(side, side, contexts=64), sys.argv[1], time_limit_s=float(sys.argv[2]),
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


@pytest.mark.parametrize("mapper", with_slow(["auto", "cpsat", "sat-kms"], {"sat-kms"}))
def test_no_thread_is_left_after_an_interrupt(mapper: str) -> None:
    assert _run(mapper, 60.0, interrupt=True) == ["solving", "interrupted", "0"]


@pytest.mark.parametrize("mapper", with_slow(["auto", "cpsat", "sat-kms"], {"sat-kms"}))
def test_no_thread_is_left_after_the_time_limit(mapper: str) -> None:
    lines = _run(mapper, 1.5, interrupt=False)
    assert lines[-2:] == ["done", "0"]


def _stop_at(what: str, fabric: str, dfg: DFG, mapper: str = "auto", **more) -> MapInterrupted:
    """Interrupt at the first line of progress that ends so."""

    def tell(line: str) -> None:
        if line.endswith(what):
            raise KeyboardInterrupt

    with pytest.raises(MapInterrupted) as stop:
        map_dfg(dfg, load(fabric), mapper, workers=1, progress=tell, **more)
    return stop.value


@pytest.mark.parametrize(
    ("mapper", "nodes"),
    [
        ("auto", 12),
        ("auto", 60),
        ("cpsat", 12),
        ("cpsat", 60),
        ("decoupled", 12),
        pytest.param("decoupled", 60, marks=pytest.mark.slow),
    ],
)
def test_an_interrupt_keeps_the_best(mapper: str, nodes: int) -> None:
    dfg = random_loop(21, nodes, (8, 2, 1))
    result = _stop_at("mapped", "mesh-3x3", dfg, mapper).result
    assert result.mapping is not None
    assert verify(dfg, load("mesh-3x3"), result.mapping) == []
    assert result.status == ("optimal" if result.ii == result.lower_bound else "feasible")
    assert "II" in result.explain()
    assert result.mapping.plot()


def test_an_interrupt_while_something_is_minimised_keeps_the_mapping() -> None:
    dfg = random_loop(1, 8)
    stop = _stop_at("minimising hops", "mesh-3x3", dfg, objective="hops")
    assert stop.result.mapping is not None
    assert stop.result.objective is None


def test_an_interrupt_before_there_is_a_mapping_is_one() -> None:
    def tell(line: str) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as stop:
        map_dfg(random_loop(21, 60, (8, 2, 1)), load("mesh-3x3"), workers=1, progress=tell)
    assert not isinstance(stop.value, MapInterrupted)
