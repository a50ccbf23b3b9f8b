"""Batches shared out among processes: the same picture and cost, whoever rendered which."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from vividc.render import read_scene, read_views, scaled_camera
from vividc.render.array import ArrayOptions, Ledger, render_array
from vividc.render.array.device.frame import Stage
from vividc.render.array.march import batches, crew
from vividc.render.array.march.crew import Batch, Work, processes_for, share_out
from vividc.render.array.march.depths import Blocks
from vividc.render.array.march.marching import steps_of

MIC = Path(__file__).parents[3] / "scenes" / "mic"
BATCHES = [
    Blocks(
        np.full((1 + number % 3, 2), number, np.int32), np.zeros((1 + number % 3, 2), np.float32)
    )
    for number in range(8)
]

posix = pytest.mark.skipif(os.name != "posix", reason="helpers are started on POSIX only")


def here(blocks: Blocks) -> Batch:
    ledger = Ledger()
    ledger.count(here=len(blocks))
    return np.full((len(blocks), 64, 4), blocks.corners[0, 0], np.float32), ledger


def shared(behaviour: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> tuple[Any, ...]:
    """What comes of the batches, and the progress told. This process waits with its second batch
    until the helper has taken one, unless the helper is late.
    """
    taken = tmp_path / "taken"
    monkeypatch.setenv("ECHO_HELPER_TAKEN", str(taken))
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    monkeypatch.setattr(crew, "HELPER", "echo_helper")
    monkeypatch.setattr(crew, "processes_for", lambda _: 2)
    told: list[int] = []

    def after_the_helper(blocks: Blocks) -> Batch:
        while blocks is not BATCHES[0] and behaviour != "late" and not taken.exists():
            time.sleep(0.01)
        return here(blocks)

    work = cast("Work", behaviour)  # the helper that stands in takes a word
    return share_out(work, BATCHES, after_the_helper, told.append), told


def total(results: list[Batch], name: str) -> int:
    return sum(ledger.counts.get(name, 0) for _, ledger in results)


@posix
@pytest.mark.parametrize("behaviour", ["works", "fails", "dies", "late"])
def test_all_batches_are_rendered_in_order(
    behaviour: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    results, told = shared(behaviour, monkeypatch, tmp_path)
    for (pixels, _), blocks in zip(results, BATCHES, strict=True):
        expected = np.full((len(blocks), 64, 4), blocks.corners[0, 0])
        np.testing.assert_array_equal(pixels, expected)
    rows = sum(map(len, BATCHES))
    assert total(results, "here") + total(results, "by_helper") == rows
    assert told == sorted(told)
    assert told[-1] == len(BATCHES)
    if behaviour != "works":
        assert total(results, "here") == rows


@posix
def test_a_helper_takes_part(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    results, _ = shared("works", monkeypatch, tmp_path)
    assert total(results, "by_helper")


def test_without_work_there_are_no_helpers() -> None:
    results = share_out(None, BATCHES, here, lambda _: None)
    assert total(results, "here") == sum(map(len, BATCHES))


def test_an_error_of_this_process_is_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(blocks: Blocks) -> Batch:
        raise ValueError("of a batch")

    with pytest.raises(ValueError, match="of a batch"):
        share_out(None, BATCHES, broken, lambda _: None)


def test_few_batches_are_not_worth_a_helper(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    assert [processes_for(count) for count in (0, 1, 3, 4, 100)] == [1, 1, 1, 2, 2]
    monkeypatch.setattr(os, "cpu_count", lambda: 64)
    assert processes_for(100) == 4


@pytest.mark.parametrize("count", [0, 1, 40, 600, 1100, 2830])
@pytest.mark.parametrize("depths", ["alike", "growing", "none", "everywhere"])
def test_batches_have_as_many_steps_each(count: int, depths: str) -> None:
    far = {
        "alike": np.full(count, 2.0),
        "growing": 1 + 3 * np.arange(count) / max(count, 1),
        "none": np.full(count, 1.0),
        "everywhere": np.full(count, 3e38),
    }[depths]
    corners = np.stack((np.arange(count), np.zeros(count)), axis=1).astype(np.int32)
    blocks = Blocks(corners, np.stack((np.ones(count), far), axis=1).astype(np.float32))
    march = read_scene(MIC / "mic_kilonerf.npz")[1].march
    cut = batches.batches_of(march, blocks)
    assert sum(map(len, cut)) == count
    assert all(len(part) for part in cut)
    if cut:
        np.testing.assert_array_equal(np.concatenate([part.corners for part in cut]), corners)
    assert len(cut) == {0: 0, 1: 1, 40: 1, 600: 2, 1100: 3, 2830: 7}[count]
    if len(cut) > 1:
        first, *others = (steps_of(march, part).sum() for part in cut)
        assert first < 0.6 * max(others)
        assert max(others) < 1.1 * min(others)


@posix
@pytest.mark.slow
def test_two_processes_render_the_same_frame_as_one(monkeypatch: pytest.MonkeyPatch) -> None:
    _, scene = read_scene(MIC / "mic_kilonerf.npz")
    camera = scaled_camera(read_views(MIC / "ref_kilo.npz")[0].camera, 64, 64)
    monkeypatch.setattr(batches, "BLOCKS_AT_ONCE", 8)
    frames = []
    for processes in (1, 2):
        monkeypatch.setattr(crew, "processes_for", lambda _, count=processes: count)
        frames.append(render_array(scene, camera, ArrayOptions()))
    one, two = frames
    np.testing.assert_array_equal(one.image, two.image)
    assert one.counts == two.counts
    assert [cost(stage) for stage in one.stages] == [cost(stage) for stage in two.stages]


def cost(stage: Stage) -> tuple[object, ...]:
    """What a stage took, but for the engine: "auto" changes over by what a process ran before."""
    stats = [{name: one[name] for name in one if name != "engine"} for one in stage.stats]
    return stage.name, stage.mode, stage.cycles, stage.jobs, stage.runs, stats
