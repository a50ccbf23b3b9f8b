"""What each stage of a frame waits for: `mic` at 800x800 with culling and FP8, on `vivid`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Final

from benchmarks.paper import SCENES
from vividc.launch import JobStats
from vividc.paper.scenes import GAUSSIANS, METHODS, MIC
from vividc.render import psnr, read_scene, render_reference
from vividc.render.array import ArrayFrame, ArrayOptions, Stage, render_array
from vividc.render.arrays import Float32Array

TITLE: Final = "Frames stage by stage"
NOTES: Final = """\
`mic` at 800x800, lookahead culling, FP8, DRAM of 32 bytes a cycle, 16 tiles at 1 GHz. Of the
ray-marched methods a twentieth of the blocks of pixels is simulated, chosen by their work; cycles
are of whole frames.

- DRAM, NoC: cycles in which they are busy, over the stage's.
- FUs: issue slots used, over those of all tiles.
- waits: cycles of all tiles, over all that they have: for transfers, for programs, for banks (of
  their own accesses and of DMA's), and after their last run. What is left is neither: iterations
  that are longer than their operations need, as IIs are whole, loops fill and drain, and chains of
  operations are waited for.
- binds: what is used most, DRAM, the NoC or FUs: no stage is faster than with that at 100 %. Of
  stages below half of it, also what tiles wait for most, or "own code" where that is what is left.

The last table leaves out samples of little weight (`--weight-min`, docs/rendering.md, which says
what that costs against photographs).
""".splitlines()
HEADER: Final = (
    "| method | stage | M cycles | share | jobs | runs | DRAM | NoC | FUs | transfers | programs "
    "| banks | idle | binds |\n"
    "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
)
_THRESHOLDS: Final = (0.0, 3e-3, 1e-2)
"""The first one is the frame's of the table above."""
_SIDE, _SAMPLE = 800, 0.05
_HALF: Final = 0.5
_LEAST: Final = 0.005
"""Share of a stage that has a line of its own."""


def rows(*_: object) -> Iterator[str]:
    """Yield the lines of the tables, method by method."""
    fewer: list[str] = []
    for method in METHODS:
        _, scene = read_scene(SCENES.models()[MIC][method])
        camera, _ = SCENES.view(MIC, method, 0, _SIDE, scene)
        reference = render_reference(scene, camera).image
        sample, thresholds = (1.0, ()) if method == GAUSSIANS else (_SAMPLE, _THRESHOLDS)
        frame = render_array(scene, camera, ArrayOptions(sample=sample, precision="fp8"))
        yield from _rows(method, frame, _near(frame, reference))
        for weight_min in thresholds:
            if weight_min:
                options = ArrayOptions(sample=sample, precision="fp8", weight_min=weight_min)
                frame = render_array(scene, camera, options)
            samples = frame.counts["colour_samples"] / frame.sampled
            fewer.append(
                f"| {method} | {weight_min:g} | {samples / 1e6:.2f} | {frame.frames_a_second:.1f} "
                f"| {_near(frame, reference):.1f} |"
            )
    yield ""
    yield "| method | `--weight-min` | M colour samples | frames/s | dB to float32 |"
    yield "|---|---|---|---|---|"
    yield from fewer


def _near(frame: ArrayFrame, reference: Float32Array) -> float:
    """Decibel of the simulated pixels, to the float32 picture that leaves out nothing."""
    seen = slice(None) if frame.simulated is None else frame.simulated
    return psnr(frame.image[seen], reference[seen])


def _rows(method: str, frame: ArrayFrame, near: float) -> Iterator[str]:
    whole = {stage.name: stage.cycles / _share(stage, frame) for stage in frame.stages}
    total = sum(whole.values())
    yield (
        f"| **{method}** | {frame.frames_a_second:.1f} frames/s, {near:.1f} dB to float32 "
        f"| {total / 1e6:.1f} |" + " |" * 11
    )
    for stage in frame.stages:
        share = whole[stage.name] / total
        if share >= _LEAST:
            shown = (
                f"{whole[stage.name] / 1e6:.2f}",
                f"{share:.1%}",
                stage.jobs,
                f"{stage.runs:,}",
            )
            used, waits = _of_jobs(stage.stats)
            parts = (f"{part:.0%}" for part in (*used.values(), *waits.values()))
            yield (
                f"| | {stage.name} | {' | '.join(map(str, (*shown, *parts)))} "
                f"| {binds(used, waits)} |"
            )


def _share(stage: Stage, frame: ArrayFrame) -> float:
    return 1.0 if stage.whole else frame.sampled


def _of_jobs(stats: list[JobStats]) -> tuple[dict[str, float], dict[str, float]]:
    """How busy things are, and what tiles wait for, as shares."""
    cycles = sum(one["cycles"] for one in stats)
    whole = sum(one["cycles"] * len(one["tiles"]) for one in stats)
    busy, waits, used = Counter[str](), Counter[str](), Counter[str]()
    for one in stats:
        busy.update(one["busy"])
        waits.update(one["stalls"])
        used.update(one["cycles_by_use"])
    slots = sum(one["utilization"] * one["cycles"] * len(one["tiles"]) for one in stats)
    banks = waits["bank"] + waits["scratchpad"]
    return (
        {"DRAM": busy["dram"] / cycles, "NoC": busy["noc"] / cycles, "FUs": slots / whole},
        {
            "transfers": waits["dma"] / whole,
            "programs": waits["configuration"] / whole,
            "banks": banks / whole,
            "idle": used["idle"] / whole,
        },
    )


def binds(used: Mapping[str, float], waits: Mapping[str, float]) -> str:
    """What is used most, and, where that is below half, what keeps tiles from more: what they wait
    for most, or their own code, if that is more of their time. All are shares.
    """
    most = max(used, key=lambda name: used[name])
    if used[most] >= _HALF:
        return most
    own = 1.0 - used["FUs"] - sum(waits.values())
    others = {**waits, "own code": own}
    return f"{most}, {max(others, key=lambda name: others[name])}"
