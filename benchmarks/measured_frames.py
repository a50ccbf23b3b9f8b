"""Frames of the renderers, one measured in a process of its own and kept in a file of rows: what
`benchmarks/paper.py` makes its tables and pictures of.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import resource
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import asdict, dataclass, field
from pathlib import Path
from statistics import mean
from typing import Final, Literal

import numpy as np

from benchmarks.quality import MODELS, SHARED, compare
from vividc import arch
from vividc.cli.reports.frame import avoided, frame_body
from vividc.errors import VividcError
from vividc.render import (
    Camera,
    Scene,
    View,
    orbit_camera,
    psnr,
    read_scene,
    read_views,
    render_reference,
    scaled_camera,
    ssim,
)
from vividc.render.array import (
    ArrayFrame,
    ArrayOptions,
    NetworkMode,
    RenderPrecision,
    render_array,
)
from vividc.render.arrays import Float32Array

ROWS: Final = "paper.jsonl"
MIC: Final = "mic"
GAUSSIANS: Final = "3dgs"
METHODS: Final = (GAUSSIANS, "kilonerf", "instant-ngp", "tensorf")
"""In the order of `MODELS`."""
ALL_VIEWS: Final = -1
_SCENES: Final = Path(__file__).resolve().parents[1] / "scenes" / MIC
_SIZES: Final = (100, 200, 400)
"""Sides of the photographs that there are; other sizes are compared with the reference alone."""
_VIEWS: Final = 3
"""Held-out photographs whose views the array renders, evenly spread."""
_AZIMUTHS: Final = (30.0, 150.0, 270.0)
_PJ_IN_MJ: Final = 1e9


@dataclass(frozen=True)
class Key:
    """What is measured: a picture of a scene, and by what.

    `view` is the number of the photograph, or of the camera around a scene without any;
    `ALL_VIEWS`: the mean over all photographs, of the reference. `sample` is the share of the
    blocks of pixels.
    """

    scene: str
    method: str
    size: int
    view: int
    engine: Literal["reference", "array"] = "array"
    sample: float = 1.0
    lookahead: bool = True
    precision: RenderPrecision = "fp32"
    mode: NetworkMode = "auto"


@dataclass(frozen=True)
class Row:
    """A measured frame; PSNR in dB, SSIM of whole pictures only, None: there is nothing to compare.

    Attributes
    ----------
    status
        "done", or why there is no picture.
    frames_per_second, stages
        Of the whole frame: a stage of which some blocks were simulated counts as if all cost the
        same.
    psnr_reference, ssim_reference
        Against float32 on the host.
    psnr_truth, ssim_truth, host_psnr_truth
        Against the photograph, and the float32 reference's on the same pixels.
    exp_share
        Operations of exp, of those issued in blending.
    energy_mj
        Of the blocks that were simulated.
    seconds, peak_mb, load
        Of the host: simulation with compiled kernels at hand, memory (of all its processes), and
        how busy the machine was at the start.
    """

    key: Key
    status: str
    frames_per_second: float | None = None
    stages: dict[str, float] = field(default_factory=dict)
    avoided: dict[str, float] = field(default_factory=dict)
    psnr_reference: float | None = None
    ssim_reference: float | None = None
    psnr_truth: float | None = None
    ssim_truth: float | None = None
    host_psnr_truth: float | None = None
    exp_share: float | None = None
    energy_mj: float | None = None
    seconds: float | None = None
    peak_mb: float | None = None
    load: float | None = None

    @property
    def is_done(self) -> bool:
        """Whether there are figures."""
        return self.status == "done"


EXP_OPERATIONS: Final = {"fp32": 14, "fp16": 12, "fp8": 5}
"""Of the array for one exp, as in docs/math.md and docs/precision.md."""


def photographs(size: int) -> Path | None:
    """Return where the held-out photographs of a size are, if they are."""
    path = SHARED / MIC / f"mic_{size}.npz"
    return path if size in _SIZES and path.is_file() else None


def scenes() -> dict[str, dict[str, Path]]:
    """Return the file of each scene by method."""
    files = (_SCENES / name for name in MODELS)
    found = {MIC: dict(zip(METHODS, files, strict=True))}
    for path in sorted((SHARED / "playbot").glob("*.npz")):
        found[path.stem] = {GAUSSIANS: path}
    return found


def chosen_views(scene: str, size: int) -> list[int]:
    """Return the views that the array renders: some of the photographs, or around the scene."""
    path = photographs(size)
    if scene != MIC:
        return list(range(len(_AZIMUTHS)))
    if path is None:
        return [0]
    count = len(read_views(path))
    return [count * number // _VIEWS for number in range(_VIEWS)]


def measured(keys: Sequence[Key], output: Path | None) -> Iterator[dict[Key, Row]]:
    """Measure what is not in `output`'s file of rows yet; yield all rows after each, and at last.

    Rows without figures are measured again.
    """
    kept = None if output is None else output / ROWS
    rows = {key: row for key, row in _read(kept).items() if row.is_done}
    with tempfile.TemporaryDirectory() as folder:
        for key in keys:
            if key in rows:
                continue
            rows[key] = in_child(key, folder)
            print(rows[key], file=sys.stderr)
            if kept is not None:
                with kept.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(asdict(rows[key])) + "\n")
            yield rows
    yield rows


def _read(kept: Path | None) -> dict[Key, Row]:
    if kept is None or not kept.exists():
        return {}
    found = (json.loads(line) for line in kept.read_text(encoding="utf-8").splitlines())
    rows = [Row(key=Key(**row.pop("key")), **row) for row in found]
    return {row.key: row for row in rows}


def in_child(key: Key, folder: str) -> Row:
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=spawn) as pool:
        try:
            return pool.submit(measure, key, folder).result()
        except BrokenProcessPool:
            return Row(key, "died")


def measure(key: Key, folder: str) -> Row:
    """Measure a frame; reference pictures are kept in `folder` for the next one."""
    load = round(os.getloadavg()[0], 1)
    _, scene = read_scene(scenes()[key.scene][key.method])
    if key.view == ALL_VIEWS:
        return _all_views(key, scene)
    camera, truth = _view(key, scene)
    options = ArrayOptions(
        sample=key.sample, lookahead=key.lookahead, precision=key.precision, mode=key.mode
    )
    try:
        frame, seconds = timed(scene, camera, options)
    except VividcError as error:
        return Row(key, error.reason, load=load)
    peak = _peak_kb()  # before the reference takes memory
    reference = _reference(key, scene, camera, Path(folder))
    body = frame_body(frame, arch.load_accelerator(options.fabric), reference)
    energy = body["energy_pj"]
    assert isinstance(energy, dict)
    return Row(
        key,
        "done",
        frames_per_second=frame.frames_a_second,
        stages=_whole_stages(frame),
        avoided=avoided(frame.counts),
        **_quality(frame, reference, truth),
        exp_share=_exp_share(frame, key.precision),
        energy_mj=sum(energy.values()) / _PJ_IN_MJ,
        seconds=round(seconds, 1),
        peak_mb=round(peak / 1024),
        load=load,
    )


def _peak_kb() -> int:
    """Most memory of this process and, if it had one, of its largest helper."""
    who = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return sum(resource.getrusage(one).ru_maxrss for one in who)


def _all_views(key: Key, scene: Scene) -> Row:
    path = photographs(key.size)
    views: Sequence[View] = () if path is None else read_views(path)
    found = list(compare(scene, views))
    if not found:
        return Row(key, "no photographs of this size")
    return Row(
        key,
        "done",
        psnr_truth=mean(one.psnr_db for one in found),
        ssim_truth=mean(one.ssim for one in found),
        seconds=round(sum(one.picture.seconds for one in found), 1),
    )


def _view(key: Key, scene: Scene) -> tuple[Camera, Float32Array | None]:
    """Return the camera, and the photograph if there is one of that size."""
    if key.scene != MIC:
        return orbit_camera(scene, _AZIMUTHS[key.view], 20.0, "-y", key.size, key.size), None
    path = photographs(key.size)
    if path is not None:
        view = read_views(path)[key.view]
        return view.camera, view.truth()
    renders = MODELS[scenes()[MIC][key.method].name]
    return scaled_camera(read_views(_SCENES / renders)[key.view].camera, key.size, key.size), None


def _reference(key: Key, scene: Scene, camera: Camera, folder: Path) -> Float32Array:
    path = folder / f"{key.scene}-{key.method}-{key.size}-{key.view}.npy"
    if not path.exists():
        np.save(path, render_reference(scene, camera).image)
    image: Float32Array = np.load(path)
    return image


def timed(scene: Scene, camera: Camera, options: ArrayOptions) -> tuple[ArrayFrame, float]:
    """Return a frame and the seconds it took: it is rendered again if kernels were compiled."""
    compiled: list[str] = []

    def tell(line: str) -> None:
        compiled.append(line)
        print(line, file=sys.stderr)

    start = time.perf_counter()
    frame = render_array(scene, camera, options, tell=tell)
    if compiled:
        start = time.perf_counter()
        frame = render_array(scene, camera, options, tell=tell)
    return frame, time.perf_counter() - start


def _whole_stages(frame: ArrayFrame) -> dict[str, float]:
    """Return the cycles of each stage of the whole frame."""
    shares = ((stage, 1.0 if stage.whole else frame.sampled) for stage in frame.stages)
    return {stage.name: round(stage.cycles / share, 1) for stage, share in shares}


def _quality(
    frame: ArrayFrame, reference: Float32Array, truth: Float32Array | None
) -> dict[str, float | None]:
    """Return how near a frame is to the reference and to the photograph, where it was simulated."""
    seen = slice(None) if frame.simulated is None else frame.simulated
    image, host = np.clip(frame.image, 0, 1), np.clip(reference, 0, 1)
    real = None if truth is None else np.clip(truth, 0, 1)
    whole = frame.simulated is None
    return {
        "psnr_reference": psnr(frame.image[seen], reference[seen]),
        "ssim_reference": ssim(image, host) if whole else None,
        "psnr_truth": None if real is None else psnr(image[seen], real[seen]),
        "ssim_truth": ssim(image, real) if whole and real is not None else None,
        "host_psnr_truth": None if real is None else psnr(host[seen], real[seen]),
    }


def _exp_share(frame: ArrayFrame, precision: RenderPrecision) -> float | None:
    """Return which share of the operations of 3DGS's blending compute exp."""
    exps = frame.counts.get("exponentials")
    issued = sum(
        sum(stats["operations"].values())
        for stage in frame.stages
        for stats in stage.stats
        if stage.name == "blend"
    )
    return EXP_OPERATIONS[precision] * exps / issued if exps is not None and issued else None
