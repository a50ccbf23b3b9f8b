"""3D Gaussian Splatting rendered whole by the array: cycles by stage, and what lookahead saves.

Projection, colour, sorting, lists and pixels are all computed by configuration words on the sixteen
tiles, with the transfers timed; the host makes launch graphs and reads counts.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Iterator, Sequence
from itertools import takewhile
from pathlib import Path

import numpy as np

from vividc.errors import SourceLoc
from vividc.render import (
    Camera,
    Gaussians,
    orbit_camera,
    psnr,
    read_scene,
    read_views,
    render_reference,
    scaled_camera,
)
from vividc.render.array import ArrayFrame, Device, open_device
from vividc.render.array.splats.blend import Culling, blend_program
from vividc.render.array.splats.frame import render_splats

TITLE = "3D Gaussian Splatting rendered by the array"
NOTES = (
    "Whole frames on the 16 tiles of `vivid`: every splat, list entry and pixel is computed by",
    "kernels of `kernels/render/splat_*.py`. Cycles of a stage are those of its jobs one after the",
    "other, with configuration and DMA; lists is the share of sorting and binning. Without culling",
    "exp is taken of every pair of a pixel and an entry of its list (`--lookahead off`); Lookahead",
    "Culling II (on) compares exponents with a threshold before exp, of blocks of 4x4 pixels",
    "at once and then of pixels. The pictures are the same to the last bit. Seconds are of the",
    "simulation on all cores, without compiling; memory is the peak so far.",
)
HEADER = (
    "| scene | size | culling | splats | list entries | cycles | frames/s | projection | colour "
    "| sorting | binning | blend | lists | pairs | exponents | exps | PSNR to float32 dB | s "
    "| peak MB |\n"
    "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
)
CULLINGS: tuple[Culling, ...] = ("none", "blocks", "pixels")
STAGES = ("projection", "colour", "sorting", "binning", "blend")
EXP_OPERATIONS = 14
"""Of the array, as in docs/math.md."""
_ROOT = Path(__file__).resolve().parents[1]
_MIC = _ROOT / "scenes" / "mic"
_SHARED = _ROOT.parent / "shared" / "scenes"
_SIZES = (100, 200, 400, 800)
_BEST: tuple[Culling, ...] = ("pixels",)
_COPIES = 32
"""Of the Gaussians of `mic`: half a million."""
_APART = 0.01
"""Standard deviation of copies' places, in units of the world."""
_ORBIT = (30.0, 20.0, "-y", 800, 800)


def rows(accelerator: str) -> Iterator[str]:
    """Yield the lines of the table, as they are measured."""
    device = open_device(accelerator)
    _, mic = read_scene(_MIC / "mic_3dgs_sh3.ply")
    view = read_views(_MIC / "ref_gs.npz")[0].camera
    for size in _SIZES:
        yield from _rows_of("mic, view 0", mic, scaled_camera(view, size, size), device)
    many = scaled_camera(view, _SIZES[-1], _SIZES[-1])
    yield from _rows_of(f"mic {_COPIES} times, view 0", crowded(mic, _COPIES), many, device, _BEST)
    for file in sorted((_SHARED / "playbot").glob("*.npz")):
        _, scene = read_scene(file)
        yield from _rows_of(file.stem, scene, orbit_camera(scene, *_ORBIT), device)
    if not _SHARED.is_dir():
        yield f"\nNo other scenes: `../{_SHARED.relative_to(_ROOT.parent)}` is not there."
    yield from _loops(device)


def crowded(scene: Gaussians, copies: int) -> Gaussians:
    """Copies of a scene's Gaussians near each other, together as much volume as before."""
    rng = np.random.default_rng(0)
    means = np.concatenate([scene.means] * copies)
    others = (
        scene.scales * np.float32(copies ** (-1 / 3)),
        scene.rotations,
        scene.opacity,
        scene.sh,
    )
    moved = means + rng.normal(0, _APART, means.shape).astype(np.float32)
    return Gaussians(moved, *(np.concatenate([column] * copies) for column in others))


def _rows_of(
    name: str,
    scene: object,
    camera: Camera,
    device: Device,
    cullings: Sequence[Culling] = CULLINGS,
) -> Iterator[str]:
    """Yield a row for each kind of culling."""
    if not isinstance(scene, Gaussians):
        yield f"| {name} | no Gaussians |"
        return
    reference = render_reference(scene, camera).image
    for culling in cullings:
        render_splats(_few(scene), camera, device=device, culling=culling)  # compiles the kernels
        began = time.perf_counter()
        frame = render_splats(scene, camera, device=device, culling=culling)
        seconds = time.perf_counter() - began
        peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        cells = (
            *(name, f"{camera.width}x{camera.height}", culling),
            *(f"{frame.counts['splats']:,}", f"{frame.counts['list_entries']:,}"),
            *(f"{frame.cycles:,}", f"{frame.frames_a_second:,.1f}"),
            *(f"{_cycles(frame, stage):,}" for stage in STAGES),
            f"{(_cycles(frame, 'sorting') + _cycles(frame, 'binning')) / frame.cycles:.0%}",
            *(f"{frame.counts[name]:,}" for name in ("evaluated", "exponents", "exponentials")),
            *(f"{psnr(frame.image, reference):.1f}", f"{seconds:.1f}", f"{peak_mb:,.0f}"),
        )
        yield f"| {' | '.join(cells)} |"


def _few(scene: Gaussians) -> Gaussians:
    columns = (scene.means, scene.scales, scene.rotations, scene.opacity, scene.sh)
    return Gaussians(*(column[:64] for column in columns))


def _cycles(frame: ArrayFrame, stage: str) -> int:
    return sum(found.cycles for found in frame.stages if found.name == stage)


def _loops(device: Device) -> Iterator[str]:
    """Yield the loops of the blending kernels, and how much of those that take exp is exp."""
    yield "\n| kernel | line | operations | II | exp's share of operations |"
    yield "|---|---|---|---|---|"
    for culling in CULLINGS:
        program = blend_program(device, culling)
        for region in program.regions:
            if region.kind == "loop" and region.loc is not None:
                exp = _takes_exp(region.loc)
                share = f"{EXP_OPERATIONS / region.operations:.0%}" if exp else "-"
                cells = (program.name, region.loc.line, region.operations, region.ii, share)
                yield f"| {' | '.join(str(cell) for cell in cells)} |"


def _takes_exp(loc: SourceLoc) -> bool:
    """Return whether exp is called between a loop's line and the end of its function."""
    lines = Path(loc.file).read_text(encoding="utf-8").splitlines()[loc.line :]
    body = takewhile(lambda line: line.startswith(" ") or not line, lines)
    return any("math.exp" in line for line in body)
