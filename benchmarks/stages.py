"""What each stage of a frame waits for: `mic` at 800x800 with culling and FP8, on `vivid`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Final

import numpy as np

from benchmarks.paper import SCENES
from vividc.launch import JobStats
from vividc.paper.scenes import GAUSSIANS, METHODS, MIC
from vividc.render import psnr, read_scene, render_reference
from vividc.render.array import ArrayFrame, ArrayOptions, Stage, render_array

TITLE: Final = "Frames stage by stage"
NOTES: Final = """\
`mic` at 800x800, lookahead culling, FP8, DRAM of 32 bytes a cycle, 16 tiles at 1 GHz. Of the
ray-marched methods a twentieth of the blocks of pixels is simulated, chosen by their work; cycles
are of whole frames.

- DRAM, NoC: cycles in which they are busy, over the stage's.
- FUs: issue slots used, over those of all tiles.
- waits: cycles of all tiles, over all that they have: for transfers, for programs, for banks (of
  their own accesses and of DMA's), and after their last run.
""".splitlines()
HEADER: Final = (
    "| method | stage | M cycles | share | jobs | runs | DRAM | NoC | FUs | transfers | programs "
    "| banks | idle |\n"
    "|---|---|---|---|---|---|---|---|---|---|---|---|---|"
)
_SIDE, _SAMPLE = 800, 0.05
_LEAST: Final = 0.005
"""Share of a stage that has a line of its own."""


def rows(*_: object) -> Iterator[str]:
    """Yield the lines of the table, method by method."""
    for method in METHODS:
        sample = 1.0 if method == GAUSSIANS else _SAMPLE
        _, scene = read_scene(SCENES.models()[MIC][method])
        camera, _ = SCENES.view(MIC, method, 0, _SIDE, scene)
        options = ArrayOptions(sample=sample, precision="fp8")
        frame = render_array(scene, camera, options)
        seen = slice(None) if frame.simulated is None else frame.simulated
        near = psnr(frame.image[seen], render_reference(scene, camera).image[seen])
        yield from _rows(method, frame, near)


def _rows(method: str, frame: ArrayFrame, near: float) -> Iterator[str]:
    whole = {stage.name: stage.cycles / _share(stage, frame) for stage in frame.stages}
    total = sum(whole.values())
    yield (
        f"| **{method}** | {frame.frames_a_second:.1f} frames/s, {near:.1f} dB to float32 "
        f"| {total / 1e6:.1f} |" + " |" * 10
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
            yield f"| | {stage.name} | {' | '.join(map(str, (*shown, *_bound(stage.stats))))} |"


def _share(stage: Stage, frame: ArrayFrame) -> float:
    return 1.0 if stage.whole else frame.sampled


def _bound(stats: list[JobStats]) -> list[str]:
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
    shares = (
        *(busy["dram"] / cycles, busy["noc"] / cycles, slots / whole, waits["dma"] / whole),
        *(waits["configuration"] / whole, banks / whole, used["idle"] / whole),
    )
    return [f"{share:.0%}" for share in np.array(shares)]
