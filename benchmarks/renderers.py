"""The table of renderers: frames of each method that the array computes whole, by stage."""

from __future__ import annotations

import resource
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.quality import MODELS, SHARED
from vividc import arch
from vividc.cli.frame_report import avoided, frame_body
from vividc.render import (
    Scene,
    SceneError,
    View,
    psnr,
    read_scene,
    read_views,
    render_reference,
    scaled_camera,
)
from vividc.render.array import ArrayFrame, ArrayOptions, render_array
from vividc.render.arrays import Float32Array

TITLE = "Frames of the four methods, every stage on the array"
NOTES = (
    "`mic`, view 0 of the held-out photographs (without them: of the reference renders), every",
    "pixel simulated. Cycles are of all jobs one after the other, with transfers and",
    "configuration; frames a second at the fabric's clock. Stages: share of the cycles, of those",
    "above 1 %. Avoided: of the colour path by Lookahead Culling I, of exps by II; `off`: without.",
    "`same`: the picture is that of `off` to the last bit. Seconds are the host's, with compiled",
    "kernels at hand; memory: the peak so far.",
)
HEADER = (
    "| method | size | lookahead | cycles | frames/s | stages | avoided | PSNR to float32 dB "
    "| PSNR to the photograph dB | float32's | same | mJ | s | peak MB |\n"
    "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
)
_MIC = Path(__file__).resolve().parents[1] / "scenes" / "mic"
_SIZES = (200, 400, 800)
_SIZES_WITHOUT = (200,)
"""Sizes at which frames are rendered without lookahead, too."""
_PJ_IN_MJ = 1e9
_LEAST_SHARE = 0.01


def rows(accelerator: str, sizes: tuple[int, ...] = _SIZES) -> Iterator[str]:
    """Yield the lines of the table, as they are measured."""
    for model, renders in MODELS.items():
        method, scene = read_scene(_MIC / model)
        for size in sizes:
            view = _view(renders, size)
            try:
                yield from _rows(method, scene, view, size, accelerator)
            except SceneError as error:
                yield f"| {method} | {size}x{size} | {error.reason} |"


def _view(renders: str, size: int) -> View:
    photographs = SHARED / "mic" / f"mic_{size}.npz"
    return read_views(photographs if photographs.is_file() else _MIC / renders)[0]


def _rows(method: str, scene: Scene, view: View, size: int, accelerator: str) -> Iterator[str]:
    camera = scaled_camera(view.camera, size, size)
    reference = render_reference(scene, camera).image
    truth = view.truth() if view.camera.width == size else None
    off = None
    for lookahead in (False, True) if size in _SIZES_WITHOUT else (True,):
        start = time.perf_counter()
        frame = render_array(scene, camera, ArrayOptions(accelerator, lookahead=lookahead))
        seconds = time.perf_counter() - start
        yield _row(method, frame, lookahead, reference, truth, off, seconds, accelerator)
        off = frame.image


def _row(
    method: str,
    frame: ArrayFrame,
    lookahead: bool,
    reference: Float32Array,
    truth: Float32Array | None,
    off: Float32Array | None,
    seconds: float,
    accelerator: str,
) -> str:
    machine = arch.load_accelerator(accelerator)
    energy = frame_body(frame, machine, reference)["energy_pj"]
    assert isinstance(energy, dict)
    spared = ", ".join(f"{share:.1%}" for share in avoided(frame.counts).values())
    peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    cells = (
        *(method, f"{reference.shape[1]}x{reference.shape[0]}", "on" if lookahead else "off"),
        *(f"{frame.cycles:,}", f"{frame.frames_a_second:.2f}", _stages(frame), spared),
        f"{psnr(frame.image, reference):.1f}",
        *(_against(image, truth) for image in (frame.image, reference)),
        "-" if off is None else "yes" if np.array_equal(off, frame.image) else "NO",
        f"{sum(energy.values()) / _PJ_IN_MJ:.2f}",
        *(f"{seconds:.0f}", f"{peak_mb:,.0f}"),
    )
    return f"| {' | '.join(cells)} |"


def _against(image: Float32Array, truth: Float32Array | None) -> str:
    return "-" if truth is None else f"{psnr(np.clip(image, 0, 1), np.clip(truth, 0, 1)):.2f}"


def _stages(frame: ArrayFrame) -> str:
    shares = Counter({stage.name: stage.cycles / frame.cycles for stage in frame.stages})
    return ", ".join(
        f"{name} {share:.0%}" for name, share in shares.most_common() if share >= _LEAST_SHARE
    )
