"""Rendered frames: each measured in a process of its own and kept as a row, so that what was
interrupted goes on where it stopped.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from statistics import mean
from typing import Any, Final, Literal

import numpy as np
from pydantic import TypeAdapter

from vividc import arch
from vividc.arch import Accelerator
from vividc.arch.cost.tables import DEFAULT_TABLE, load_costs
from vividc.errors import VividcError
from vividc.host.inputs import GRAPH_BYTES, read_bytes
from vividc.launch.cost import work_of_job
from vividc.paper.scenes import Scenes, compare
from vividc.render import Camera, Scene, psnr, read_scene, read_views, render_reference, ssim
from vividc.render.array import (
    ArrayFrame,
    ArrayOptions,
    NetworkMode,
    RenderPrecision,
    Stage,
    render_array,
)
from vividc.render.arrays import Float32Array
from vividc.sim.cost import energy

ALL_VIEWS: Final = -1
_PJ_IN_MJ: Final = 1e9
_EXP_OPERATIONS: Final = {"fp32": 14, "fp16": 12, "fp8": 5}
"""Of the array for one exp, as in docs/math.md and docs/precision.md."""


@dataclass(frozen=True)
class Key:
    """What is measured: a picture of a scene, and by what.

    `view` is the number of the photograph, or of the camera around a scene without any;
    `ALL_VIEWS`: the mean over all photographs, of the reference. `sample` is the share of the
    blocks of pixels; `fabric` an accelerator's name, or its YAML
    (and before it, with `---` between them, its tile's); `weight_min` as in `ArrayOptions`.
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
    fabric: str = "vivid"
    weight_min: float = 0.0


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


_ROW: Final = TypeAdapter(Row)
Measure = Callable[[Key, Scenes, str], Row]
Rows = Mapping[Key, Row]


def measured(
    keys: Sequence[Key],
    scenes: Scenes,
    kept: Path | None,
    made_by: str = "",
    measure: Measure | None = None,
) -> Iterator[dict[Key, Row]]:
    """Measure what is not kept yet; yield all rows after each, and at last.

    Rows without figures are measured again.

    Parameters
    ----------
    kept
        JSON lines, one a row; None: nothing is kept.
    made_by
        Of which code: rows of other code do not count.
    measure
        In place of a process that renders.
    """
    rows = {key: row for key, row in _read(kept, made_by).items() if row.is_done}
    with tempfile.TemporaryDirectory() as folder:
        for key in keys:
            if key in rows:
                continue
            rows[key] = (measure or in_child)(key, scenes, folder)
            if kept is not None:
                _append(kept, {"made_by": made_by, **asdict(rows[key])})
            yield rows
    yield rows


def _read(kept: Path | None, made_by: str) -> dict[Key, Row]:
    """Return the kept rows; what is none, as a line that an interrupt cut short, is left out."""
    if kept is None or not kept.exists():
        return {}
    rows = {}
    text = read_bytes(kept, GRAPH_BYTES, hint="remove it: its frames are measured again")
    for line in text.splitlines():
        try:
            found: dict[str, Any] = json.loads(line)
            if found.pop("made_by", "") == made_by:
                row = _ROW.validate_python(found)
                rows[row.key] = row
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
            continue
    return rows


def _append(kept: Path, row: dict[str, object]) -> None:
    """Add a line; one before it that an interrupt cut short is ended."""
    with kept.open("a+b") as file:
        if file.tell():
            file.seek(-1, os.SEEK_END)
            file.write(b"" if file.read(1) == b"\n" else b"\n")
        file.write(json.dumps(row).encode() + b"\n")


def mean_of(rows: Sequence[Row | None], name: str) -> float | None:
    """Return the mean of a figure over views; None where it is missing for one of them."""
    values = [None if row is None else getattr(row, name) for row in rows]
    known = [value for value in values if value is not None]
    return mean(known) if known and len(known) == len(values) else None


def in_child(key: Key, scenes: Scenes, folder: str) -> Row:
    """Measure a frame in a process of its own, whose end costs this one nothing."""
    asked = {
        "key": asdict(key),
        "scenes": [str(path) for path in scenes.folders],
        "folder": folder,
    }
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    made = subprocess.run(
        [sys.executable, "-P", "-m", "vividc.paper.child"],
        input=json.dumps(asked).encode(),
        stdout=subprocess.PIPE,
        env=environment,
        check=False,
    )
    if made.returncode:
        return Row(key, "the process that rendered it died")
    return _ROW.validate_json(made.stdout)


def measure_frame(key: Key, scenes: Scenes, folder: str) -> Row:
    """Measure a frame; reference pictures are kept in `folder` for the next one."""
    load = round(os.getloadavg()[0], 1)
    _, scene = read_scene(scenes.models()[key.scene][key.method])
    if key.view == ALL_VIEWS:
        return _all_views(key, scenes, scene)
    camera, truth = scenes.view(key.scene, key.method, key.view, key.size, scene)
    options = ArrayOptions(
        fabric=_fabric_file(key.fabric, Path(folder)),
        sample=key.sample,
        lookahead=key.lookahead,
        precision=key.precision,
        mode=key.mode,
        weight_min=key.weight_min,
    )
    try:
        frame, seconds = timed(scene, camera, options)
    except VividcError as error:
        return Row(key, error.reason, load=load)
    machine = arch.load_accelerator(options.fabric)
    peak = _peak_kb()  # before the reference takes memory
    reference = _reference(key, scene, camera, Path(folder))
    return Row(
        key,
        "done",
        frames_per_second=frame.frames_a_second,
        stages=_whole_stages(frame),
        avoided=avoided(frame.counts),
        **_quality(frame, reference, truth),
        exp_share=_exp_share(frame, key.precision),
        energy_mj=sum(sum(stage_energy(s, machine).values()) for s in frame.stages) / _PJ_IN_MJ,
        seconds=round(seconds, 1),
        peak_mb=round(peak / 1024),
        load=load,
    )


def stage_energy(stage: Stage, machine: Accelerator) -> dict[str, float]:
    """Return the picojoules of a stage's jobs by component."""
    table = load_costs(DEFAULT_TABLE)
    parts: Counter[str] = Counter()
    for stats in stage.stats:
        work = work_of_job(stats, len(machine.tiles))
        parts.update(energy(work, machine.fabric, table)["parts_pj"])
    return dict(parts)


def avoided(counts: Mapping[str, int]) -> dict[str, float]:
    """Return which share of the colour path (I) or of the exps (II) was not computed."""
    pairs = {
        "colour_path": ("colour_samples", "density_samples"),
        "exponentials": ("exponentials", "evaluated"),
    }
    return {
        name: 1 - counts[done] / counts[all_of_them]
        for name, (done, all_of_them) in pairs.items()
        if counts.get(all_of_them)
    }


def timed(
    scene: Scene,
    camera: Camera,
    options: ArrayOptions,
    render: Callable[..., ArrayFrame] = render_array,
    clock: Callable[[], float] = time.perf_counter,
) -> tuple[ArrayFrame, float]:
    """Return a frame and the seconds it took: it is rendered again if kernels were compiled."""
    compiled: list[str] = []
    start = clock()
    frame = render(scene, camera, options, tell=compiled.append)
    if compiled:
        start = clock()
        frame = render(scene, camera, options, tell=compiled.append)
    return frame, clock() - start


def _fabric_file(fabric: str, folder: Path) -> str:
    """Return an accelerator's name, or the file that its YAML is written to, and its tile's, if
    that stands before it, to `tile.yaml`.
    """
    if "\n" not in fabric:
        return fabric
    *tiles, text = fabric.split("---\n")
    for tile in tiles:
        (folder / "tile.yaml").write_text(tile, encoding="utf-8")
    path = folder / "fabric.yaml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def _peak_kb() -> int:
    """Most memory of this process and, if it had one, of its largest helper."""
    who = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return sum(resource.getrusage(one).ru_maxrss for one in who)


def _all_views(key: Key, scenes: Scenes, scene: Scene) -> Row:
    path = scenes.photographs(key.size)
    found = list(compare(scene, () if path is None else read_views(path)))
    if not found:
        return Row(key, "no photographs of this size")
    return Row(
        key,
        "done",
        psnr_truth=mean(one.psnr_db for one in found),
        ssim_truth=mean(one.ssim for one in found),
        seconds=round(sum(one.picture.seconds for one in found), 1),
    )


def _reference(key: Key, scene: Scene, camera: Camera, folder: Path) -> Float32Array:
    path = folder / f"{key.scene}-{key.method}-{key.size}-{key.view}.npy"
    if not path.exists():
        np.save(path, render_reference(scene, camera).image)
    image: Float32Array = np.load(path)
    return image


def _whole_stages(frame: ArrayFrame) -> dict[str, float]:
    """Return the cycles of each stage of the whole frame."""
    return {name: round(cycles, 1) for name, cycles in frame.predicted.items()}


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
    return _EXP_OPERATIONS[precision] * exps / issued if exps is not None and issued else None
