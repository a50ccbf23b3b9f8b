"""Whole frames blended by the accelerator: cycles, what bounds them, seconds and memory.

Projection, lists and sorting are the host's; every pixel is blended by configuration words on the
sixteen tiles, with the transfers timed.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Iterator
from pathlib import Path

import vividc
from benchmarks import EFFORT
from benchmarks.workloads import WORKLOADS
from vividc.render import (
    Camera,
    Gaussians,
    Scene,
    blend_on_array,
    orbit_camera,
    psnr,
    read_scene,
    read_views,
    render_reference,
    scaled_camera,
)

TITLE = "Frames of 3D Gaussian Splatting on the accelerator"
NOTES = (
    "`kernels/gs_blend.py`, blocks of at most 8x8 pixels over the 16 tiles of `vivid`. Cycles are",
    "of the whole job: configuration, DMA, blending; shares are of all tiles' cycles. Seconds",
    "are the host's projection and lists, the simulation by the native engine on all cores, and",
    "the timing; tile-cycles are those in which a tile ran words. Memory: the peak so far.",
)
HEADER = (
    "| scene | size | launches | cycles | ms at the clock | tiles run | bank stalls | wait for DMA "
    "| idle at the end | PSNR to float32 dB | s | tile-cycles/s | peak MB |\n"
    "|---|---|---|---|---|---|---|---|---|---|---|---|---|"
)
_ROOT = Path(__file__).resolve().parents[1]
_MIC = _ROOT / "scenes" / "mic"
_SHARED = _ROOT.parent / "shared" / "scenes"
_SIZES = (200, 400, 800)
_ORBIT = (30.0, 20.0, "-y", 800, 800)
_MAPPING_S = 30.0


def rows(accelerator: str) -> Iterator[str]:
    """Yield the lines of the table, as they are measured."""
    kernel = next(w for w in WORKLOADS if w.name == "gs_blend").kernel()
    program = vividc.compile(kernel, fabric=accelerator, time_limit_s=_MAPPING_S, effort=EFFORT)
    _, mic = read_scene(_MIC / "mic_3dgs_sh3.ply")
    view = read_views(_MIC / "ref_gs.npz")[0].camera
    for size in _SIZES:
        yield _row("mic, view 0", mic, scaled_camera(view, size, size), program, accelerator)
    for file in sorted((_SHARED / "playbot").glob("*.npz")):
        _, scene = read_scene(file)
        camera = orbit_camera(scene, *_ORBIT)
        yield _row(file.stem, scene, camera, program, accelerator)
    if not _SHARED.is_dir():
        yield f"\nNo other scenes: `../{_SHARED.relative_to(_ROOT.parent)}` is not there."


def _row(name: str, scene: Scene, camera: Camera, program: vividc.Program, accelerator: str) -> str:
    if not isinstance(scene, Gaussians):
        return f"| {name} | no Gaussians |"
    began = time.perf_counter()
    picture = blend_on_array(program, scene, camera, accelerator)
    seconds = time.perf_counter() - began
    stats = picture.stats
    slots = len(stats["tiles"]) * picture.cycles
    running = sum(stats["cycles_by_use"].values()) - stats["cycles_by_use"]["idle"]
    peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    cells = (
        *(name, f"{camera.width}x{camera.height}", f"{picture.launches:,}"),
        *(f"{picture.cycles:,}", f"{picture.milliseconds:.2f}"),
        f"{running / slots:.0%}",
        f"{stats['stalls']['bank'] / slots:.0%}",
        f"{stats['stalls']['dma'] / slots:.0%}",
        f"{stats['cycles_by_use']['idle'] / slots:.0%}",
        f"{psnr(picture.image, render_reference(scene, camera).image):.1f}",
        *(f"{seconds:.1f}", f"{stats['tile_cycles'] / seconds:,.0f}", f"{peak_mb:,.0f}"),
    )
    return f"| {' | '.join(cells)} |"
