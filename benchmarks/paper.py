"""The paper's Table 2, Figure 1(b) and Figure 7(c) in our own measure, from frames of the four
methods that the array renders (`vividc.paper.frames`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Final

from benchmarks.quality import SHARED
from vividc.host.files import write_whole
from vividc.host.plot import to_svg
from vividc.paper import bars
from vividc.paper.exhibit import decibel, shown, tenths
from vividc.paper.frames import ALL_VIEWS, Key, Measure, Row, mean_of, measured
from vividc.paper.rendered import STEPS, WITH_MODES
from vividc.paper.scenes import CHECKOUT, GAUSSIANS, METHODS, MIC, Scenes

ROWS: Final = "paper.jsonl"
SCENES: Final = Scenes((CHECKOUT, SHARED))
TITLE: Final = "The paper's figures of the four methods, in our own measure"
SIZES: Final = (200, 400, 800)
NOTES: Final = (
    f"Each frame has a process of its own; rows are kept in `{ROWS}` and not measured again:",
    "delete them after a change of the renderers. `vivid`, 16 tiles at 1 GHz; every stage on the",
    "array. Whole float32 frames of ray-marched methods are of an earlier day than the others of",
    "800x800.",
    "",
    "PSNR is the mean over the views, of the clipped pictures against photographs, as they are",
    "against float32 on the host. The array renders three of the held-out photographs' views (25",
    "of 200x200, 8 of 400x400), evenly spread; `views` are those measured so far, `sample` is the",
    "share of the blocks of pixels that is simulated, chosen by their work and the same in each",
    "row (rows of before 2026-11-24: evenly spread, with up to 4 % more samples). PSNR",
    "is of those pixels, for the host's picture in the same row, too; SSIM of whole pictures.",
    "Sizes without a row have not been measured yet. The Gaussians of playbot have no",
    "photographs: three cameras around them. Sizes above 400 are scaled cameras without",
    "photographs.",
    "",
    "Frames a second, cycles and energy are of whole frames: of a stage that is sampled each block",
    "counts as the average, and at 800x800 what jobs take to begin and end is counted once a",
    "batch. `host s` are those of the simulated share, with compiled kernels at hand. In",
    "partitioned mode a network runs in whichever mode takes fewest cycles, in unified",
    "mode in that one or in GPU-like mode; 3DGS and KiloNeRF know GPU-like mode alone.",
)
_TABLE_2: Final = {"array": "partitioned mode", "lookahead": "lookahead", "FP8": "FP8"}
"""The columns of Table 2, and the steps that they are."""
_TABLE_2_LARGEST: Final = 400
_WHOLE: Final = ("lookahead", "FP8")
"""Steps of which a frame is simulated whole."""
_SAMPLES: Final = ((200, 1.0), (400, 0.2), (8192, 0.05))
"""Share of the blocks of the ray-marched methods, up to a side."""
_SHOWN: Final = 0.01
"""Least share of a stage that is named."""


def sections(
    methods: Sequence[str],
    sizes: Sequence[int],
    output: Path | None,
    measure: Measure | None = None,
) -> Iterator[list[str]]:
    """Measure and yield the tables' lines again after each row: what is finished so far.

    Parameters
    ----------
    methods, sizes
        Which, or all; the last size is that of the figures.
    output
        Folder of the rows and pictures; None: nothing is kept or drawn.
    measure
        In place of a process that renders.
    """
    methods, sizes = methods or METHODS, sizes or SIZES
    size = sizes[-1]
    wanted = (
        *_quality_keys(methods, sizes),
        *_figure_keys(methods, size),
        *_whole_keys(methods, size),
    )
    kept = None if output is None else output / ROWS
    for rows in measured(list(dict.fromkeys(wanted)), SCENES, kept, measure=measure):
        yield [
            *_table_2(list(_quality_keys(methods, sizes)), rows),
            "",
            *_figures(methods, size, rows, output),
            "",
            *_whole_frames(methods, size, rows),
        ]


def _key(scene: str, method: str, size: int, view: int, step: str) -> Key:
    lookahead, precision, mode = STEPS[step]
    sample = 1.0
    if method != GAUSSIANS:
        sample = next(share for most, share in _SAMPLES if size <= most)
    return Key(
        *(scene, method, size, view),
        sample=sample,
        lookahead=lookahead,
        precision=precision,
        mode=mode if method in WITH_MODES else "auto",
    )


def _quality_keys(methods: Sequence[str], sizes: Sequence[int]) -> Iterator[Key]:
    for scene, models in SCENES.models().items():
        for size in (size for size in sizes if size <= _TABLE_2_LARGEST):
            for method in (method for method in methods if method in models):
                if scene == MIC and SCENES.photographs(size) is not None:
                    yield Key(scene, method, size, ALL_VIEWS, engine="reference")
                for view in SCENES.chosen_views(scene, size):
                    for step in _TABLE_2.values():
                        yield _key(scene, method, size, view, step)


def _figure_keys(methods: Sequence[str], size: int) -> Iterator[Key]:
    for method in methods:
        for step in STEPS:
            yield _key(MIC, method, size, SCENES.chosen_views(MIC, size)[0], step)


def _whole_keys(methods: Sequence[str], size: int) -> Iterator[Key]:
    for method in methods:
        for step in _WHOLE:
            sampled = _key(MIC, method, size, SCENES.chosen_views(MIC, size)[0], step)
            yield replace(sampled, sample=1.0)


def _table_2(keys: Sequence[Key], rows: Mapping[Key, Row]) -> Iterator[str]:
    """Yield Table 2: one line a scene, method and size."""
    yield "## Table 2: quality"
    yield ""
    yield (
        "| scene | method | size | float32, all photographs: dB | SSIM | views | sample "
        "| float32 there: dB | array: dB | + lookahead | + FP8 | FP8 loses dB | SSIM of array "
        "| + FP8 | array against float32: dB | + lookahead | + FP8 |"
    )
    yield "|---" * 17 + "|"
    for scene, method, size in dict.fromkeys((key.scene, key.method, key.size) for key in keys):
        whole = rows.get(Key(scene, method, size, ALL_VIEWS, engine="reference"))
        views = [
            view
            for view in SCENES.chosen_views(scene, size)
            if any(_key(scene, method, size, view, step) in rows for step in _TABLE_2.values())
        ]
        by_step = {
            name: [rows.get(_key(scene, method, size, view, step)) for view in views]
            for name, step in _TABLE_2.items()
        }
        array, fp8 = by_step["array"], by_step["FP8"]
        truths = [mean_of(found, "psnr_truth") for found in by_step.values()]
        cells = (
            *(scene, method, f"{size}x{size}"),
            *(
                decibel(mean_of([whole], "psnr_truth")),
                shown(mean_of([whole], "ssim_truth"), ".4f"),
            ),
            *(len(views), f"{_key(scene, method, size, 0, 'FP8').sample:g}"),
            *(decibel(mean_of(array, "host_psnr_truth")), *map(decibel, truths)),
            decibel(_difference(mean_of(array, "host_psnr_truth"), truths[-1])),
            *(shown(mean_of(found, "ssim_truth"), ".4f") for found in (array, fp8)),
            *(decibel(mean_of(found, "psnr_reference")) for found in by_step.values()),
        )
        yield f"| {' | '.join(map(str, cells))} |"


def _figures(
    methods: Sequence[str], size: int, rows: Mapping[Key, Row], output: Path | None
) -> Iterator[str]:
    view = SCENES.chosen_views(MIC, size)[0]
    steps = {
        method: {step: rows.get(_key(MIC, method, size, view, step)) for step in STEPS}
        for method in methods
    }
    yield f"## Figure 1(b): frames a second and cycles by stage, {size}x{size}"
    yield ""
    yield "Shares of the cycles of a frame, of the stages above 1 %."
    yield ""
    yield (
        "| method | sample | step | frames/s | stages | colour path avoided | exps avoided "
        "| exp's share of blending's operations | mJ a frame | host s | peak MB | load |"
    )
    yield "|---" * 12 + "|"
    for method, found in steps.items():
        for step, row in found.items():
            if row is not None and (step == "GPU-like mode" or row is not _before(found, step)):
                yield _frame_line(method, step, row)
    yield ""
    yield from _contributions(size, steps)
    if output is not None:
        drawn = {
            "stages": bars.stages(
                _stage_bars(steps), "Cycles of a frame by stage, float32 with lookahead"
            ),
            "contributions": bars.contributions(
                _bars_of_steps(steps),
                "What gives the speed-up over float32 in GPU-like mode without culling",
            ),
        }
        for name, picture in drawn.items():
            write_whole(output / f"paper-{name}.svg", to_svg(picture).encode())


def _whole_frames(methods: Sequence[str], size: int, rows: Mapping[Key, Row]) -> Iterator[str]:
    """Yield what it takes to simulate every pixel."""
    yield f"## Whole frames: every pixel simulated, {size}x{size}"
    yield ""
    yield "With lookahead. Seconds and memory are those of the host."
    yield ""
    yield (
        "| method | format | cycles | frames/s | dB to float32 | SSIM | mJ | host s | peak MB "
        "| load |"
    )
    yield "|---" * 10 + "|"
    for key in _whole_keys(methods, size):
        row = rows.get(key)
        if row is not None and row.is_done:
            cells = (
                *(key.method, key.precision, f"{sum(row.stages.values()):,.0f}"),
                *(decibel(row.frames_per_second), decibel(row.psnr_reference)),
                *(shown(row.ssim_reference, ".4f"), f"{row.energy_mj:.1f}"),
                *(row.seconds, f"{row.peak_mb:,.0f}", row.load),
            )
            yield f"| {' | '.join(map(str, cells))} |"


def _before(found: Mapping[str, Row | None], step: str) -> Row | None:
    names = list(found)
    return found[names[names.index(step) - 1]]


def _frame_line(method: str, step: str, row: Row) -> str:
    if not row.is_done:
        return f"| {method} | {row.key.sample:g} | {step} | {row.status} |" + " |" * 8
    total = sum(row.stages.values())
    shares = sorted(((n / total, name) for name, n in row.stages.items()), reverse=True)
    exp = row.exp_share if row.key.precision == "fp32" else None
    energy = None if row.energy_mj is None else row.energy_mj / row.key.sample
    cells = (
        *(method, f"{row.key.sample:g}", step, tenths(row.frames_per_second)),
        ", ".join(f"{name} {share:.0%}" for share, name in shares if share >= _SHOWN),
        *(shown(row.avoided.get(name), ".1%") for name in ("colour_path", "exponentials")),
        *(shown(exp, ".1%"), tenths(energy)),
        *(row.seconds, f"{row.peak_mb:,.0f}", row.load),
    )
    return f"| {' | '.join(map(str, cells))} |"


def _contributions(size: int, steps: Mapping[str, Mapping[str, Row | None]]) -> Iterator[str]:
    """Yield Figure 7(c): the factor that each step gives, and its share of the whole speed-up."""
    yield f"## Figure 7(c): what gives the speed-up, {size}x{size}"
    yield ""
    yield "Each step is added to those on its left; the factor is of frames a second, and in"
    yield "brackets, when all are measured, its logarithm's share of all those that are faster."
    yield ""
    names = list(STEPS)
    yield f"| method | {names[0]}: frames/s | {' | '.join(names[1:])} | together | frames/s |"
    yield "|---" * (len(names) + 3) + "|"
    for method, found in steps.items():
        rates = _rates(found)
        factors = _factors(rates)
        whole = _factors((rates[0], rates[-1]))
        cells = (
            *(method, decibel(rates[0])),
            *(_factor(factor, factors) for factor in factors),
            *("-" if one is None else f"{one:.2f}x" for one in whole),
            decibel(rates[-1]),
        )
        yield f"| {' | '.join(map(str, cells))} |"


def _rates(found: Mapping[str, Row | None]) -> list[float | None]:
    return [None if row is None else row.frames_per_second for row in found.values()]


def _factors(rates: Sequence[float | None]) -> list[float | None]:
    """Return each rate over the one before; None where either is not known."""
    return [
        None if before is None or after is None else after / before
        for before, after in pairwise(rates)
    ]


def _factor(factor: float | None, factors: Sequence[float | None]) -> str:
    if factor is None:
        return "-"
    gains = [math.log(one) for one in factors if one is not None and one > 1]
    is_known = None not in factors
    share = f" ({math.log(factor) / sum(gains):.0%})" if factor > 1 and is_known else ""
    return f"{factor:.2f}x{share}"


def _stage_bars(steps: Mapping[str, Mapping[str, Row | None]]) -> dict[str, dict[str, float]]:
    """Return the cycles of each stage, with lookahead and float32, by method."""
    rows = {method: found["lookahead"] for method, found in steps.items()}
    return {method: row.stages for method, row in rows.items() if row is not None and row.stages}


def _bars_of_steps(steps: Mapping[str, Mapping[str, Row | None]]) -> dict[str, dict[str, float]]:
    """Return the factor of each step, by method, of those of which all are known."""
    found = {}
    for method, rows in steps.items():
        factors = [factor for factor in _factors(_rates(rows)) if factor is not None]
        if len(factors) == len(rows) - 1:
            found[method] = dict(zip(list(STEPS)[1:], factors, strict=True))
    return found


def _difference(before: float | None, after: float | None) -> float | None:
    return None if before is None or after is None else before - after
