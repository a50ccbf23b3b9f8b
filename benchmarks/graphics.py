"""The renderers and filters of `kernels/graphics/`: inputs, and each picture on the accelerator.

`python -m benchmarks.graphics -o docs/images/graphics` draws the pictures of the gallery.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final

import click
import numpy as np

import vividc
from benchmarks import EFFORT, PATIENCE
from benchmarks.npbench import largest_error
from benchmarks.workloads import Arguments, Workload
from vividc.launch import JobResult
from vividc.render import read_views, upscale_nearest, write_png

TITLE: Final = "Renderers and filters in ordinary numba"
NOTES: Final = """\
The kernels of `kernels/graphics/`, each a whole picture ([gallery](../docs/gallery.md)), compiled
for `vivid` without a flag and launched once, transfers and configuration included. Those whose
loop over the rows is a `prange` run on the sixteen tiles, the others on one.

- loop ops, II: of the loop with most operations, which may take several pixels side by side.
- ops a pixel: what the FUs of all tiles issued, over the pixels.
- difference: the largest from numba's, over the greatest number of the array; integers are equal.
- compile s: seconds of user CPU.
""".splitlines()
HEADER: Final = (
    "| kernel | picture | tiles | loop ops | II | status | ops a pixel | cycles | cycles a pixel "
    "| difference | compile s |\n|---|---|---|---|---|---|---|---|---|---|---|"
)
_PHOTO: Final = Path(__file__).resolve().parents[1] / "scenes" / "mic" / "ref_gs.npz"
_CROP: Final = 192
"""Pixels of a side of the photograph, which sizes of pictures divide."""
_SHOWN: Final = 192
"""Pixels of a side of the PNGs."""
_STUD: Final = 0.8
_GAP: Final = 4
Image = np.ndarray


def _light(*direction: float) -> Image:
    """A direction of length 1."""
    given = np.array(direction)
    return (given / np.linalg.norm(given)).astype(np.float32)


@cache
def _photo(size: int) -> Image:
    """[size, size] float32 luminance of a picture of scenes/mic, means of squares of pixels."""
    picture = read_views(_PHOTO)[0].truth()[:_CROP, :_CROP] @ np.array([0.299, 0.587, 0.114])
    square = _CROP // size
    return picture.reshape(size, square, size, square).mean((1, 3)).astype(np.float32)


def _grainy(size: int) -> Image:
    """The photograph with noise."""
    noise = np.random.default_rng(3).normal(0, 0.06, (size, size))
    return np.clip(_photo(size) + noise, 0, 1).astype(np.float32)


def _ball(size: int) -> Image:
    """[size, size] brightness of a ball in front of a wall."""
    y, x = (np.mgrid[:size, :size] + 0.5) * 2.5 / size - 1.25
    z = np.sqrt(np.maximum(1 - x * x - y * y, 0))
    lit = np.tensordot(_light(-0.5, -0.6, 0.7), np.stack([x, y, z]), 1)
    wall = 0.35 + 0.25 * (1.25 - y)
    return np.where(z > 0, 0.08 + 0.9 * np.maximum(lit, 0), wall).astype(np.float32)


def _terrain(size: int) -> Image:
    """[size, size] heights, about -1 to 1: waves in all directions, long ones higher."""
    rng = np.random.default_rng(11)
    y, x = np.mgrid[:size, :size] / size
    heights = np.zeros((size, size))
    for octave in range(1, 8):
        for _ in range(6):
            angle, phase = rng.uniform(0, 2 * np.pi, 2)
            along = x * np.cos(angle) + y * np.sin(angle)
            heights += np.sin(2 * np.pi * 0.75 * octave * along + phase) / octave**1.7
    return (heights / np.abs(heights).max()).astype(np.float32)


def _studs(size: int) -> Image:
    """[size, size, 3] normals of a plate with four by four round studs."""
    y, x = (np.mgrid[:size, :size] + 0.5) * 4 / size
    u, v = x % 1 * 2 - 1, y % 1 * 2 - 1
    inside = np.hypot(u, v) < _STUD
    normals = np.stack([np.where(inside, u, 0), np.where(inside, v, 0), np.ones_like(u)], -1)
    normals[..., 2] = np.sqrt(1 - normals[..., 0] ** 2 - normals[..., 1] ** 2)
    return normals.astype(np.float32)


def _torus(size: int) -> Arguments:
    """Vertices on the picture and their depths, colours, and triangles of a tilted ring."""
    around, across = 28, 14
    a, b = (grid.ravel() for grid in np.mgrid[:around, :across] * 2 * np.pi)
    a, b = a / around, b / across
    ring = 1 + 0.42 * np.cos(b)
    points = np.stack([ring * np.cos(a), ring * np.sin(a), 0.42 * np.sin(b)])
    normals = np.stack([np.cos(b) * np.cos(a), np.cos(b) * np.sin(a), np.sin(b)])
    tilt, turn = 0.95, 0.5
    tilted = np.array(
        [[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]]
    )
    turned = np.array(
        [[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]]
    )
    x, y, z = turned @ tilted @ points
    depth = z + 4
    vertices = np.stack([size * (0.5 + 1.15 * x / depth), size * (0.5 + 1.15 * y / depth), depth])
    bright = np.maximum(_light(-0.5, -0.8, -0.9) @ (turned @ tilted @ normals), 0)
    base = 0.5 + 0.5 * np.cos(np.stack([a, a + 2.1, a + 4.2]))
    colours = base * (0.3 + 0.75 * bright) + 0.3 * bright**8
    i, j = (grid.ravel() for grid in np.mgrid[:around, :across])
    corner = [((i + di) % around) * across + (j + dj) % across for di in (0, 1) for dj in (0, 1)]
    first = np.stack([corner[0], corner[1], corner[2]], 1)
    second = np.stack([corner[1], corner[3], corner[2]], 1)
    faces = np.concatenate([first, second]).astype(np.int32)
    return vertices.T.astype(np.float32).copy(), colours.T.astype(np.float32).copy(), faces


def _blank(*shape: int) -> Image:
    return np.zeros(shape, np.float32)


SPHERES: Final = np.array(
    [
        [-1.35, 0.75, 0.6, 0.75, 0.95, 0.30, 0.22, 0.30],
        [0.35, 1.0, 1.9, 1.0, 0.95, 0.93, 0.88, 0.75],
        [1.25, 0.5, 0.1, 0.5, 0.98, 0.72, 0.15, 0.20],
        [-0.3, 0.32, -0.9, 0.32, 0.20, 0.50, 0.85, 0.25],
        [0.45, 0.22, -1.2, 0.22, 0.40, 0.75, 0.35, 0.20],
    ],
    np.float32,
)
SUNSET: Final = np.array(
    [
        *([5, 7, 40], [25, 60, 140], [120, 190, 235], [250, 240, 200]),
        *([255, 180, 60], [200, 80, 40], [110, 25, 60], [35, 8, 50]),
    ],
    np.float32,
) / np.float32(255)
TINTS: Final = np.array(
    [
        *([40, 80, 140], [70, 130, 170], [200, 190, 140], [110, 150, 80]),
        *([90, 120, 70], [140, 120, 90], [170, 160, 150], [240, 240, 245]),
    ],
    np.float32,
) / np.float32(255)
_LEVELS: Final = 9


def _permutation() -> Image:
    table = np.random.default_rng(5).permutation(256).astype(np.int32)
    return np.concatenate([table, table])


def _spheres(n: int) -> Arguments:
    return SPHERES, _light(-0.6, 0.8, -0.55), np.int32(4), _blank(n, n, 3)


def _shaded(n: int) -> Arguments:
    """With what numba's rays hit."""
    hits = _blank(n, n, 4)
    BY_NAME["march_scene"].workload().kernel()(hits)
    return hits, _light(-0.5, 0.75, -0.6), _blank(n, n, 3)


def _noise(n: int) -> Arguments:
    return _permutation(), np.float32(n / 3), np.int32(5), _blank(n, n)


def _mandelbrot(n: int) -> Arguments:
    place = (np.float32(-0.7), np.float32(0.0), np.float32(2.9))
    return *place, np.int32(48), SUNSET, np.float32(16), _blank(n, n, 3)


def _bilateral(n: int) -> Arguments:
    return _grainy(n), np.int32(3), np.float32(2), np.float32(0.15), _blank(n, n)


def _fitted(n: int) -> Arguments:
    return _grainy(n), _grainy(n), np.int32(2), np.float32(0.01), _blank(n, n, 2)


def _applied(n: int) -> Arguments:
    """With the lines that numba fits."""
    arguments = _fitted(n)
    BY_NAME["fit_lines"].workload().kernel()(*arguments)
    return _grainy(n), _last(arguments), np.int32(2), _blank(n, n)


def _dithered(n: int) -> Arguments:
    return (np.rint(_ball(n) * 255).astype(np.int16),)


def _contours(n: int) -> Arguments:
    return _terrain(n), np.float32(0.1), _blank(n * n // 2, 4)


def _lines(n: int) -> Arguments:
    """Contours of a terrain of half the size at several levels."""
    kernel = BY_NAME["marching_squares"].workload().kernel()
    field, _, segments = _contours(n // 2)
    pieces = []
    for level in np.linspace(-0.8, 0.8, _LEVELS, dtype=np.float32):
        pieces.append(segments[: kernel(field, level, segments)].copy())
    lines = np.concatenate(pieces)
    canvas = np.full((n, n), 255, np.uint8)
    return lines, np.int32(len(lines)), np.float32(2), np.uint8(40), canvas


def _relief(n: int) -> Arguments:
    return _terrain(n), np.float32(n / 5), TINTS, _light(-1, -1, 1.1), _blank(n, n, 3)


def _plate(n: int) -> Arguments:
    red = np.array([0.75, 0.12, 0.10], np.float32)
    return _studs(n), _light(-0.5, -0.6, 0.9), red, np.float32(24), _blank(n, n, 3)


def _coarse(n: int) -> Image:
    """The photograph in large pixels."""
    return upscale_nearest(_photo(n // 3), 3)


def _resampled(n: int) -> Arguments:
    return _photo(n // 3), _blank(n, n)


def _last(arguments: Arguments) -> Image:
    """The picture that most kernels leave in their last array."""
    image = arguments[-1]
    assert isinstance(image, np.ndarray)
    return image


@dataclass(frozen=True, slots=True)
class Picture:
    """A kernel that makes a square picture.

    Attributes
    ----------
    name, file
        The kernel and its file in `kernels/graphics/`.
    make
        Arguments for pictures of so many pixels a side, the same at every call, in new arrays.
    shown
        The picture of the arguments after a run, [n, n] or [n, n, 3], 0 to 1; None: another kernel
        goes on with what this one leaves.
    before
        What is shown on its left, if anything.
    size, small
        Pixels of a side of the whole picture, and of the one of the fast tests.
    tolerance
        How far floats of the whole picture may be from numba's, as a share of the greatest. The
        array contracts products and sums, which numba does not.
    """

    name: str
    file: str
    make: Callable[[int], Arguments]
    shown: Callable[[Arguments], Image] | None = _last
    before: Callable[[int], Image] | None = None
    size: int = 96
    small: int = 8
    tolerance: float = 1e-5

    def workload(self, size: int | None = None) -> Workload:
        """Of the whole picture, if no size is given."""
        pixels = self.size if size is None else size
        return Workload(self.name, lambda _: self.make(pixels), f"graphics/{self.file}")

    def panel(self, arguments: Arguments) -> Image:
        """What the gallery shows of the arguments after a run: float32 [height, width, 3]."""
        assert self.shown is not None
        panels = [_enlarged(self.shown(arguments))]
        if self.before is not None:
            gap = np.ones((_SHOWN, _GAP, 3), np.float32)
            panels = [_enlarged(self.before(self.size)), gap, *panels]
        return np.concatenate(panels, axis=1)


def _enlarged(image: Image) -> Image:
    colours = image if image.ndim == len("yxc") else np.repeat(image[..., None], 3, axis=2)
    factor = _SHOWN // len(image)
    return upscale_nearest(np.clip(colours, 0, 1).astype(np.float32), factor)


MIRRORED: Final = 1e-3
"""Each round mirror magnifies a difference of its ray."""
ITERATED: Final = 5e-3
"""Each iteration about doubles a difference."""

PICTURES: Final = (
    Picture("trace_spheres", "tracing", _spheres, tolerance=MIRRORED),
    Picture("march_scene", "tracing", lambda n: (_blank(n, n, 4),), None, tolerance=1e-4),
    Picture("shade_scene", "tracing", _shaded, tolerance=1e-4),
    Picture("fractal_noise", "procedural", _noise, lambda a: 0.5 + 0.6 * _last(a)),
    Picture("mandelbrot_smooth", "procedural", _mandelbrot, tolerance=ITERATED),
    Picture("rasterize", "raster", lambda n: (*_torus(n), _blank(n, n), _blank(n, n, 3))),
    Picture("shade_relief", "raster", _relief),
    Picture("shade_normals", "raster", _plate),
    Picture("marching_squares", "raster", _contours, None, size=48),
    Picture("draw_segments", "raster", _lines, lambda a: _last(a) / 255, small=16),
    Picture("bilateral", "filters", _bilateral, before=_grainy, size=64),
    Picture("fit_lines", "filters", _fitted, None, size=64, tolerance=1e-4),
    Picture("apply_lines", "filters", _applied, before=_grainy, size=64),
    Picture("floyd_steinberg", "filters", _dithered, lambda a: _last(a) / 255, _ball),
    Picture("bicubic", "filters", _resampled, before=_coarse, small=12),
)
BY_NAME: Final = {picture.name: picture for picture in PICTURES}
WORKLOADS: Final = tuple(picture.workload() for picture in PICTURES)


def rows(accelerator: str) -> Iterator[str]:
    """Yield the lines of the table, as they are measured."""
    for picture in PICTURES:
        yield _row(picture, accelerator)


def _row(picture: Picture, accelerator: str) -> str:
    workload = picture.workload()
    start = os.times().user
    program = vividc.compile(workload.kernel(), fabric=accelerator, effort=EFFORT)
    took = os.times().user - start
    mine, theirs = workload.fresh(), workload.fresh()
    result = launched(program, mine, accelerator)
    value = workload.kernel()(*theirs)
    pixels = picture.size**2
    loops = [region for region in program.regions if region.kind == "loop"]
    hot = max(loops, key=lambda region: region.operations)
    cells = (
        *(picture.name, f"{picture.size}x{picture.size}", len(result.stats["tiles"])),
        *(hot.operations, hot.ii, hot.status),
        f"{sum(result.stats['operations'].values()) / pixels:,.0f}",
        *(f"{result.cycles:,}", f"{result.cycles / pixels:,.1f}"),
        *(f"{largest_error([*mine, result.value], [*theirs, value]):.1g}", f"{took:.1f}"),
    )
    return f"| {' | '.join(map(str, cells))} |"


def launched(program: vividc.Program, arguments: Arguments, accelerator: str) -> JobResult:
    """One launch on all tiles."""
    result = vividc.simulate(program, *arguments, fabric=accelerator)
    assert isinstance(result, JobResult)
    return result


def drawn(picture: Picture, program: vividc.Program, accelerator: str = "vivid") -> Image:
    """The picture of the gallery, from a launch."""
    arguments = picture.workload().fresh()
    launched(program, arguments, accelerator)
    return picture.panel(arguments)


@click.command()
@click.argument("names", nargs=-1, type=click.Choice([p.name for p in PICTURES if p.shown]))
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False), required=True)
def main(names: tuple[str, ...], output: Path) -> None:
    """Draw the pictures NAMES, or all, to PNG files in the folder OUTPUT."""
    output.mkdir(parents=True, exist_ok=True)
    for picture in PICTURES:
        if picture.shown and picture.name in (names or BY_NAME):
            with vividc.patient(PATIENCE):
                program = vividc.compile(picture.workload().kernel(), fabric="vivid", effort=EFFORT)
            write_png(output / f"{picture.name}.png", drawn(picture, program))
            click.echo(output / f"{picture.name}.png")


if __name__ == "__main__":
    main()
