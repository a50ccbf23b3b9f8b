"""The paper's tables are made of kept rows; what is there is not measured again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from benchmarks import measured_frames, paper
from benchmarks.measured_frames import ALL_VIEWS, ROWS, Key, Row

RATES = {
    (False, "fp32", "gpu"): 10.0,
    (False, "fp32", "tpu-unified"): 12.0,
    (False, "fp32", "auto"): 15.0,
    (True, "fp32", "auto"): 20.0,
    (True, "fp8", "auto"): 40.0,
}


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[Key]:
    """The keys that were measured, in order; what is measured is made up."""
    keys: list[Key] = []

    def made_up(key: Key, folder: str) -> Row:
        keys.append(key)
        if key.view == ALL_VIEWS:
            return Row(key, "done", psnr_truth=36.5, ssim_truth=0.99)
        if key.scene != "mic" and key.precision == "fp8":
            return Row(key, "died")
        narrow = key.precision == "fp8"
        return Row(
            key,
            "done",
            frames_per_second=RATES[key.lookahead, key.precision, key.mode],
            stages={"network": 3e6, "marching": 1e6, "rest": 1.0},
            avoided={"colour_path": 0.25 if key.lookahead else 0.0},
            psnr_reference=40.0 if narrow else 120.0,
            psnr_truth=36.0 if narrow else 36.4,
            host_psnr_truth=36.5,
            energy_mj=2.0,
            seconds=1.0,
            peak_mb=100,
            load=0.5,
        )

    monkeypatch.setattr(measured_frames, "in_child", made_up)
    monkeypatch.setattr(paper, "chosen_views", lambda scene, size: [0, 8])
    monkeypatch.setattr(paper, "photographs", lambda size: Path("there"))
    scenes = {"mic": {"tensorf": Path(), "kilonerf": Path()}, "playbot": {"3dgs": Path()}}
    monkeypatch.setattr(paper, "scenes", lambda: scenes)
    return keys


def table(output: Path | None, *methods: str) -> list[str]:
    return list(paper.sections(methods, (200, 800), output))[-1]


def test_a_method_in_all_tables(asked: list[Key], tmp_path: Path) -> None:
    lines = table(tmp_path, "tensorf")
    row = next(line for line in lines if line.startswith("| mic | tensorf | 200x200 |"))
    cells = [cell.strip() for cell in row.strip("|").split("|")]
    assert cells[3:12] == ["36.50", "0.9900", "2", "1", "36.50", "36.40", "36.40", "36.00", "0.50"]
    assert cells[-3:] == ["120.00", "120.00", "40.00"]
    frame = next(line for line in lines if line.startswith("| tensorf | 0.05 | lookahead |"))
    assert frame.split(" | ")[-4] == "40.0"  # mJ of a whole frame: 2 for a twentieth
    contributions = next(line for line in lines if line.startswith("| tensorf | 10.00 |"))
    for text in ("| 10.00 |", "1.20x (13%)", "1.25x (16%)", "1.33x (21%)", "2.00x (50%)", "4.00x"):
        assert text in contributions
    halves = [line for found in paper.sections(["tensorf"], (800,), None) for line in found]
    assert "| tensorf | 10.00 | 1.20x | - | - | - | - | - |" in halves  # no shares of what is known
    bars = (tmp_path / "paper-stages.svg").read_text()
    assert "network: 75%" in bars
    assert "2.00x" in (tmp_path / "paper-contributions.svg").read_text()
    whole = [line for line in lines if line.startswith("| tensorf | fp")]
    assert [line.split(" | ")[1:4] for line in whole] == [
        ["fp32", "4,000,001", "20.00"],
        ["fp8", "4,000,001", "40.00"],
    ]
    sampled = [key for key in asked if key.size == 800 and key.sample < 1]
    assert {key.sample for key in sampled} == {0.05}
    assert len({*sampled}) == len(RATES)


def test_rows_are_not_measured_again_unless_they_failed(asked: list[Key], tmp_path: Path) -> None:
    first = table(tmp_path)
    died = [key for key in asked if key.scene == "playbot" and key.precision == "fp8"]
    assert died
    assert len(asked) == len(set(asked)) == len((tmp_path / ROWS).read_text().splitlines())
    asked.clear()
    assert table(tmp_path) == first
    assert asked == died


def test_seconds_are_those_with_compiled_kernels_at_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[bool] = []
    clock = iter((0.0, 100.0, 103.0))  # what was compiled took until 100

    def render(*_: object, tell: Callable[[str], None]) -> str:
        told.append(not told)
        if told[-1]:
            tell("compiling")
        return "frame"

    monkeypatch.setattr(measured_frames, "render_array", render)
    monkeypatch.setattr(measured_frames, "time", SimpleNamespace(perf_counter=clock.__next__))
    frame, seconds = measured_frames.timed(None, None, None)  # type: ignore[arg-type]
    assert (frame, seconds, told) == ("frame", 3.0, [True, False])


def test_modes_are_of_methods_that_know_them(asked: list[Key]) -> None:
    table(None)
    modes = {
        method: {key.mode for key in asked if key.method == method and key.size == 800}
        for method in ("tensorf", "kilonerf")
    }
    assert modes == {"tensorf": {"gpu", "tpu-unified", "auto"}, "kilonerf": {"auto"}}
    one = next(key for key in asked if key.method == "kilonerf" and key.size == 800)
    assert asked.count(replace(one, lookahead=False)) == 1
