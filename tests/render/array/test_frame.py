"""Cycles of a whole frame, predicted from some of its blocks."""

from __future__ import annotations

import numpy as np
import pytest

from tests.render.array.jobs import job_stats
from vividc.launch import JobStats
from vividc.render.array import ArrayFrame, Stage

IMAGE = np.ones((8, 8, 3), np.float32)


def stage(name: str, *jobs: int, whole: bool = False, once: bool = False) -> Stage:
    """A stage of jobs on two tiles: of each, 40 cycles of the tiles are waits for a program, and
    20 behind the last run.
    """
    stats = [job_stats(cycles, tiles=2, configuration=40, idle=20) for cycles in jobs]
    return Stage(name, "gpu", sum(jobs), len(jobs), 2 * len(jobs), stats, 0.0, whole, once)


def frame(*stages: Stage, sampled: float, batches: float) -> ArrayFrame:
    return ArrayFrame(IMAGE, stages, {}, 1.0, sampled, batches)


def test_what_jobs_take_to_begin_and_end_does_not_grow_with_the_blocks() -> None:
    one = frame(
        *(stage("network", 130, 230), stage("depths", 130, once=True)),
        *(stage("sorting", 500, whole=True), Stage("moves", cycles=10, stats=[_moves()])),
        sampled=0.1,
        batches=4.0,
    )
    assert one.predicted == pytest.approx(
        {
            "network": (100 + 200) / 0.1 + 4 * (30 + 30),
            "depths": 100 / 0.1 + 30,
            "sorting": 500,
            "moves": 100,
        }
    )
    assert one.frames_a_second == pytest.approx(1e9 / sum(one.predicted.values()))


def test_nothing_is_predicted_of_a_whole_frame() -> None:
    whole = frame(stage("network", 130, 230), sampled=1.0, batches=1.0)
    assert whole.predicted == {"network": 360}
    assert frame(sampled=0.5, batches=2.0).frames_a_second == 0.0


def _moves() -> JobStats:
    return job_stats(10, tiles=0, dram=10)
