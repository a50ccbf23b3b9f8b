"""What each stage of a frame waits for: `mic` at 800x800 with culling and FP8, on `vivid`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from benchmarks.paper import SCENES
from benchmarks.quality import WEIGHTS
from vividc.launch import JobStats
from vividc.paper.scenes import METHODS, MIC
from vividc.render import psnr, read_scene, render_reference
from vividc.render.array import ArrayFrame, ArrayOptions, render_array
from vividc.render.arrays import Float32Array

TITLE: Final = "Frames stage by stage"
NOTES: Final = """\
`mic` at 800x800, lookahead culling, FP8, DRAM of 32 bytes a cycle, 16 tiles at 1 GHz. Every pixel
is simulated.

- DRAM, NoC: cycles in which they are busy, over the stage's.
- FUs: issue slots used, over those of all tiles.
- waits: cycles of all tiles, over all that they have: for transfers, for programs, for banks (of
  their own accesses and of DMA's), and after their last run. What is left is neither: iterations
  that are longer than their operations need, as IIs are whole, loops fill and drain, and chains of
  operations are waited for.
- binds: what is used most, DRAM, the NoC or FUs: no stage is faster than with that at 100 %. Of
  stages below half of it, also what tiles wait for most, or "own code" where that is what is left.

The second table leaves out samples of little weight (`--weight-min`); `quality.md` has what that
loses against photographs. The third has cycles that `--sample 0.05` predicts, over those of the
whole frame: stages of at least a hundredth of it, from the one that is predicted too short to the
one too long; and by how much a frame would be shorter at most if all stages ran side by side: what
is busy longest then, DRAM, the NoC, or tiles, for as long as they now run programs.
""".splitlines()
HEADER: Final = (
    "| method | stage | M cycles | share | jobs | runs | DRAM | NoC | FUs | transfers | programs "
    "| banks | idle | binds |\n"
    "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
)
_SIDE = 800
_HALF: Final = 0.5
_LEAST: Final = 0.005
"""Share of a stage that has a line of its own."""
_PREDICTED: Final = 0.01
"""The same, if it is predicted."""
_WAITS: Final = ("dma", "configuration", "dependency")
"""Stalls in which a tile has nothing to run."""
_SHARE: Final = 0.05
"""Of the blocks of pixels, from which frames are predicted."""


def rows(*_: object) -> Iterator[str]:
    """Yield the lines of the tables, method by method."""
    fewer: list[str] = []
    predicted: list[str] = []
    for method in METHODS:
        _, scene = read_scene(SCENES.models()[MIC][method])
        camera, _ = SCENES.view(MIC, method, 0, _SIDE, scene)
        reference = render_reference(scene, camera).image
        frame = render_array(scene, camera, ArrayOptions(precision="fp8"))
        yield from _rows(method, frame, _near(frame, reference))
        few = render_array(scene, camera, ArrayOptions(precision="fp8", sample=_SHARE))
        predicted.append(_prediction(method, frame, few))
        if method not in WEIGHTS:
            continue
        for weight_min in (0.0, *WEIGHTS[method]):
            if weight_min:
                options = ArrayOptions(precision="fp8", weight_min=weight_min)
                frame = render_array(scene, camera, options)
            fewer.append(
                f"| {method} | {weight_min:g} | {frame.counts['colour_samples'] / 1e6:.2f} "
                f"| {frame.frames_a_second:.1f} | {_near(frame, reference):.1f} |"
            )
    yield ""
    yield "| method | `--weight-min` | M colour samples | frames/s | dB to float32 |"
    yield "|---|---|---|---|---|"
    yield from fewer
    yield ""
    yield "| method | frames/s | predicted | stages: predicted over simulated | side by side |"
    yield "|---|---|---|---|---|"
    yield from predicted


def _prediction(method: str, frame: ArrayFrame, few: ArrayFrame) -> str:
    """A frame, what a part of its blocks predicts of it, and what it would take side by side."""
    made = {stage.name: stage.cycles for stage in frame.stages}
    over = {
        name: few.predicted[name] / cycles
        for name, cycles in made.items()
        if cycles >= _PREDICTED * frame.cycles
    }
    names = sorted(over, key=lambda name: over[name])
    ends = [f"{over[name]:.2f} ({name})" for name in (names[0], names[-1])]
    overlap = side_by_side([stats for stage in frame.stages for stats in stage.stats])
    return (
        f"| {method} | {frame.frames_a_second:.1f} | {few.frames_a_second:.1f} "
        f"| {' to '.join(ends)} | {overlap:.2f}x |"
    )


def side_by_side(stats: Sequence[JobStats]) -> float:
    """How much shorter jobs would be together, if nothing in them waited but for what is busy all
    of the time.
    """
    busy = Counter[str]()
    for one in stats:
        busy.update(one["busy"])
        waits = sum(one["stalls"][name] for name in _WAITS if name in one["stalls"])
        idle = one["cycles_by_use"].get("idle", 0)
        tiles = len(one["tiles"])
        busy["tiles"] += one["cycles"] - (waits + idle) / tiles if tiles else 0
    return sum(one["cycles"] for one in stats) / max(busy.values())


def _near(frame: ArrayFrame, reference: Float32Array) -> float:
    """Decibel to the float32 picture that leaves out nothing."""
    return psnr(frame.image, reference)


def _rows(method: str, frame: ArrayFrame, near: float) -> Iterator[str]:
    whole = {stage.name: stage.cycles for stage in frame.stages}
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
