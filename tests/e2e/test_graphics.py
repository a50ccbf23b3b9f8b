"""Renderers and filters written in ordinary numba: on all tiles, against numba and the gallery."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import vividc
from benchmarks.graphics import BY_NAME, PICTURES, Picture, launched
from benchmarks.npbench import largest_error
from vividc.launch import JobResult
from vividc.render.image import to_uint8

GALLERY = Path(__file__).resolve().parents[2] / "docs" / "images" / "graphics"
SMALL_TOLERANCE = 1e-5
"""Of small pictures: eight rows have no place where a difference grows."""
SERIAL = {"floyd_steinberg", "marching_squares", "draw_segments"}
"""Kernels without `prange`: each pixel or line waits for those before."""


def run(picture: Picture, program: vividc.Program, size: int, tolerance: float) -> JobResult:
    """A launch whose arguments are afterwards numba's."""
    workload = picture.workload(size)
    mine, theirs = workload.fresh(), workload.fresh()
    result = launched(program, mine, "vivid")
    value = workload.kernel()(*theirs)
    assert largest_error([*mine, result.value], [*theirs, value]) <= tolerance
    return result


HARD = {
    "bicubic",
    "bilateral",
    "fit_lines",
    "mandelbrot_smooth",
    "march_scene",
    "rasterize",
    "shade_scene",
    "trace_spheres",
}
"""Kernels whose straight code takes more than two seconds to map."""


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] if name in HARD else []) for name in BY_NAME],
)
def test_a_small_picture_is_numbas_with_loops_as_written(name: str) -> None:
    picture = BY_NAME[name]
    as_written = vividc.LoopOptions(auto=False)
    program = vividc.compile(
        picture.workload().kernel(), fabric="vivid", effort="fast", loops=as_written
    )
    result = run(picture, program, picture.small, SMALL_TOLERANCE)
    assert (len(result.stats["tiles"]) == 1) == (name in SERIAL)


@pytest.mark.slow
@pytest.mark.parametrize("name", BY_NAME)
def test_a_whole_picture_is_numbas_and_the_gallerys(name: str) -> None:
    picture = BY_NAME[name]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        program = vividc.compile(picture.workload().kernel(), fabric="vivid")
    result = run(picture, program, picture.size, picture.tolerance)
    assert (len(result.stats["tiles"]) == 1) == (name in SERIAL)
    if picture.shown is None:
        return
    arguments = picture.workload().fresh()
    launched(program, arguments, "vivid")
    with Image.open(GALLERY / f"{name}.png") as image:
        kept = np.asarray(image).astype(int)
    assert np.abs(to_uint8(picture.panel(arguments)).astype(int) - kept).max() <= 1


def test_every_picture_is_in_the_gallery_and_no_other() -> None:
    shown = {picture.name for picture in PICTURES if picture.shown is not None}
    assert {path.stem for path in GALLERY.glob("*.png")} == shown
    page = (GALLERY.parents[1] / "gallery.md").read_text(encoding="utf-8")
    assert all(f"](images/graphics/{name}.png)" in page for name in shown)


def test_every_file_has_only_kernels_of_the_table() -> None:
    for file in {picture.file for picture in PICTURES}:
        names = {picture.name for picture in PICTURES if picture.file == file}
        scope = BY_NAME[min(names)].workload().kernel().py_func.__globals__
        assert {n for n, v in scope.items() if isinstance(v, vividc.KernelFunction)} == names
