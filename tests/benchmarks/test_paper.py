"""The paper's tables are made of kept rows; what is there is not measured again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from benchmarks import paper
from benchmarks.paper import ROWS
from vividc.paper.frames import ALL_VIEWS, Key, Row, timed
from vividc.paper.scenes import Scenes

RATES = {
    (False, "fp32", "gpu"): 10.0,
    (False, "fp32", "tpu-unified"): 12.0,
    (False, "fp32", "auto"): 15.0,
    (True, "fp32", "auto"): 20.0,
    (True, "fp8", "auto"): 40.0,
}


class Measured:
    """Makes up what is measured, and notes the keys in order."""

    def __init__(self) -> None:
        self.keys: list[Key] = []

    def __call__(self, key: Key, scenes: Scenes, folder: str) -> Row:
        self.keys.append(key)
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


@pytest.fixture
def made_up(monkeypatch: pytest.MonkeyPatch) -> Measured:
    scenes = SimpleNamespace(
        chosen_views=lambda scene, size: [0, 8],
        photographs=lambda size: Path("there"),
        models=lambda: {
            "mic": {"tensorf": Path(), "kilonerf": Path()},
            "playbot": {"3dgs": Path()},
        },
    )
    monkeypatch.setattr(paper, "SCENES", scenes)
    return Measured()


def table(made_up: Measured, output: Path | None, *methods: str) -> list[str]:
    return list(paper.sections(methods, (200, 800), output, made_up))[-1]


def test_a_method_in_all_tables(made_up: Measured, tmp_path: Path) -> None:
    lines = table(made_up, tmp_path, "tensorf")
    row = next(line for line in lines if line.startswith("| mic | tensorf | 200x200 |"))
    cells = [cell.strip() for cell in row.strip("|").split("|")]
    assert cells[3:12] == ["36.50", "0.9900", "2", "1", "36.50", "36.40", "36.40", "36.00", "0.50"]
    assert cells[-3:] == ["120.00", "120.00", "40.00"]
    frame = next(line for line in lines if line.startswith("| tensorf | 0.05 | lookahead |"))
    assert frame.split(" | ")[-4] == "40.0"  # mJ of a whole frame: 2 for a twentieth
    contributions = next(line for line in lines if line.startswith("| tensorf | 10.00 |"))
    for text in ("| 10.00 |", "1.20x (13%)", "1.25x (16%)", "1.33x (21%)", "2.00x (50%)", "4.00x"):
        assert text in contributions
    halves = [
        line for found in paper.sections(["tensorf"], (800,), None, made_up) for line in found
    ]
    assert "| tensorf | 10.00 | 1.20x | - | - | - | - | - |" in halves  # no shares of what is known
    bars = (tmp_path / "paper-stages.svg").read_text()
    assert "network: 75%" in bars
    assert "2.00x" in (tmp_path / "paper-contributions.svg").read_text()
    whole = [line for line in lines if line.startswith("| tensorf | fp")]
    assert [line.split(" | ")[1:4] for line in whole] == [
        ["fp32", "4,000,001", "20.00"],
        ["fp8", "4,000,001", "40.00"],
    ]
    sampled = [key for key in made_up.keys if key.size == 800 and key.sample < 1]
    assert {key.sample for key in sampled} == {0.05}
    assert len({*sampled}) == len(RATES)


def test_rows_are_not_measured_again_unless_they_failed(made_up: Measured, tmp_path: Path) -> None:
    first = table(made_up, tmp_path)
    died = [key for key in made_up.keys if key.scene == "playbot" and key.precision == "fp8"]
    assert died
    assert (
        len(made_up.keys)
        == len(set(made_up.keys))
        == len((tmp_path / ROWS).read_text().splitlines())
    )
    made_up.keys.clear()
    assert table(made_up, tmp_path) == first
    assert made_up.keys == died


def test_seconds_are_those_with_compiled_kernels_at_hand() -> None:
    told: list[bool] = []
    clock = iter((0.0, 100.0, 103.0))  # what was compiled took until 100

    def render(*_: object, tell: Callable[[str], None]) -> str:
        told.append(not told)
        if told[-1]:
            tell("compiling")
        return "frame"

    nothing: Any = None
    frame, seconds = timed(nothing, nothing, nothing, render, clock.__next__)  # type: ignore[arg-type]
    assert (frame, seconds, told) == ("frame", 3.0, [True, False])


def test_modes_are_of_methods_that_know_them(made_up: Measured) -> None:
    table(made_up, None)
    modes = {
        method: {key.mode for key in made_up.keys if key.method == method and key.size == 800}
        for method in ("tensorf", "kilonerf")
    }
    assert modes == {"tensorf": {"gpu", "tpu-unified", "auto"}, "kilonerf": {"auto"}}
    one = next(key for key in made_up.keys if key.method == "kilonerf" and key.size == 800)
    assert made_up.keys.count(replace(one, lookahead=False)) == 1
