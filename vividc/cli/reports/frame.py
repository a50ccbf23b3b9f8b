"""What `vividc render --engine array` prints: stages, frames per second, energy, work avoided."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

import click
import numpy as np

from vividc.arch import Accelerator
from vividc.cli.reports.report import percent, print_table
from vividc.paper.frames import avoided, stage_energy
from vividc.render import psnr, ssim
from vividc.render.array.device.frame import ArrayFrame, Stage
from vividc.render.arrays import Float32Array

_MIN_SSIM_PX = 11
_PJ_IN_UJ = 1e6


def frame_body(
    frame: ArrayFrame, machine: Accelerator, reference: Float32Array
) -> dict[str, object]:
    """Return the figures of a frame, as `--json` prints them.

    Pictures are compared where blocks were simulated.
    """
    seen = slice(None) if frame.simulated is None else frame.simulated
    whole = frame.simulated is None and min(reference.shape[:2]) >= _MIN_SSIM_PX
    predicted = frame.predicted
    stages = [_stage_body(stage, machine, predicted[stage.name]) for stage in frame.stages]
    parts: Counter[str] = Counter()
    for stage in stages:
        parts.update(stage["energy_pj"])
    return {
        "fabric": machine.name,
        "sampled": frame.sampled,
        "psnr_reference_db": psnr(frame.image[seen], reference[seen]),
        "ssim_reference": ssim(frame.image, reference) if whole else None,
        "cycles": frame.cycles,
        "frames_per_second": frame.frames_a_second,
        "clock_ghz": frame.clock_ghz,
        "stopped_by_clock": list(frame.late),
        "counts": frame.counts,
        "avoided": avoided(frame.counts),
        "energy_pj": dict(parts),
        "stages": stages,
    }


def _stage_body(stage: Stage, machine: Accelerator, predicted: float) -> dict[str, Any]:
    """Return the figures of a stage; energy is of its jobs, by component."""
    return {
        "name": stage.name,
        "mode": stage.mode,
        "cycles": stage.cycles,
        "predicted_cycles": round(predicted),
        "jobs": stage.jobs,
        "runs": stage.runs,
        "dram_bytes": sum(
            stats["bytes"]["dram_read"] + stats["bytes"]["dram_written"] for stats in stage.stats
        ),
        "energy_pj": stage_energy(stage, machine),
        "seconds": round(stage.seconds, 3),
    }


def print_frame(body: Mapping[str, Any]) -> None:
    """Print the table of stages, and what the frame took as a whole."""
    total = max(body["cycles"], 1)
    rows = [
        (
            *(stage["name"], stage["mode"], f"{stage['cycles']:,}"),
            *(percent(stage["cycles"] / total), stage["jobs"], f"{stage['runs']:,}"),
            f"{stage['dram_bytes']:,}",
            f"{sum(stage['energy_pj'].values()) / _PJ_IN_UJ:,.2f}",
            f"{stage['seconds']:.1f}",
        )
        for stage in body["stages"]
    ]
    columns = ("stage", "mode", "cycles", "share", "jobs", "runs", "DRAM bytes", "uJ", "host s")
    print_table(f"stages on {body['fabric']}", columns, rows, numeric=columns[2:])
    if body["sampled"] < 1:
        click.echo(
            f"simulated: {100 * body['sampled']:.1f} % of the blocks of pixels; the others are "
            "white, cycles and energy are of what was simulated, frames a second are predicted"
        )
    click.echo(
        f"cycles: {body['cycles']:,}; {body['frames_per_second']:.2f} frames a second at "
        f"{body['clock_ghz']:g} GHz"
    )
    for text in body["stopped_by_clock"]:
        click.echo(f"cycles may be others on an idle machine: {text}")
    parts = body["energy_pj"]
    whole = sum(parts.values())
    shares = ", ".join(f"{name} {percent(pj / whole)}" for name, pj in parts.items()) or "-"
    click.echo(f"energy: {whole / _PJ_IN_UJ:,.1f} uJ ({shares})")
    for name, share in body["avoided"].items():
        click.echo(f"avoided of {name.replace('_', ' ')}: {100 * share:.1f} %")
    click.echo(f"PSNR against the float32 reference: {_decibel(body['psnr_reference_db'])}")
    if body["ssim_reference"] is not None:
        click.echo(f"SSIM against the float32 reference: {body['ssim_reference']:.4f}")


def _decibel(value: float) -> str:
    return f"{value:.2f} dB" if np.isfinite(value) else "the same to the last bit"
