"""Programs for known sizes: launches of others are refused, on a tile and on an accelerator."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numba import prange

import vividc
from vividc.errors import ArgumentError
from vividc.launch import At, Job
from vividc.program import Program


@vividc.kernel("void(int32[:, ::1], int32[::1], int16, int64)")
def scaled(a, y, k, m):
    for i in prange(a.shape[0]):
        y[i] = a[i, k] * np.int32(m >> 33)


SIZES = {"a": (6, 3), "y": 6, "k": -1, "m": 3 << 33}


def arguments(rows: int = 6, columns: int = 3) -> list[object]:
    a = np.arange(rows * columns, dtype=np.int32).reshape(rows, columns)
    return [a, np.zeros(rows, np.int32), np.int16(-1), np.int64(3 << 33)]


@pytest.fixture(scope="module", params=["vivid-tile", "vivid"])
def program(request: pytest.FixtureRequest) -> Program:
    return vividc.compile(scaled, request.param, like=SIZES)


@pytest.mark.parametrize("fabric", [None, "vivid"])
def test_launches_of_its_sizes_run(program: Program, fabric: str | None) -> None:
    args = arguments()
    vividc.simulate(program, *args, fabric=fabric)
    assert np.array_equal(args[1], args[0][:, -1] * 3)


@pytest.mark.parametrize("fabric", [None, "vivid"])
@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({0: np.zeros((6, 4), np.int32)}, "a 6x3 only, and got a 6x4"),
        ({0: np.zeros((3, 6), np.int32)}, "a 6x3 only, and got a 3x6"),
        ({1: np.zeros(7, np.int32)}, "y 6 only, and got y 7"),
        ({2: np.int16(2)}, "k = -1 only, and got k = 2"),
        ({3: np.int64(3)}, "m = 25769803776 only, and got m = 3"),
        ({3: np.int64((3 << 33) + 1)}, "m = 25769803776 only, and got m = 25769803777"),
        (
            {0: np.zeros((7, 3), np.int32), 1: np.zeros(7, np.int32), 2: np.int16(0)},
            "a 6x3, y 6, k = -1 only, and got a 7x3, y 7, k = 0",
        ),
    ],
)
def test_launches_of_others_are_refused(
    program: Program, fabric: str | None, change: dict[int, object], told: str
) -> None:
    args = [change.get(number, value) for number, value in enumerate(arguments())]
    with pytest.raises(ArgumentError, match=f"scaled was compiled for {told}") as caught:
        vividc.simulate(program, *args, fabric=fabric)
    assert caught.value.exit_code == 2
    assert "--sizes" in str(caught.value.hint)


def test_a_step_of_a_job_is_checked_too(program: Program) -> None:
    job = Job("vivid")
    scalars = {"k": -1, "m": 3 << 33}
    with pytest.raises(ArgumentError, match="a 6x3 only, and got a 5x3"):
        job.run(0, program, a=At(0, (5, 3)), y=At(512, (6,)), **scalars)
    a, y = arguments()[:2]
    here = job.move_in(0, a, 0)
    run = job.run(0, program, a=At(0, (6, 3)), y=At(512, (6,)), after=[here], **scalars)
    job.move_out(0, 512, y, after=[run])
    job.simulate()
    assert np.array_equal(y, a[:, -1] * 3)


def test_the_file_keeps_them(program: Program, tmp_path: Path) -> None:
    path = tmp_path / "scaled.vivid"
    program.save(path)
    again = vividc.load(path)
    assert again == program
    assert again.sizes == {"a": (6, 3), "y": (6,), "k": -1, "m": 3 << 33}
    args = arguments(5)
    with pytest.raises(ArgumentError, match="and got a 5x3, y 5"):
        vividc.simulate(again, *args)
    assert vividc.compile(scaled, program.fabric.name) != program
