"""The main job on a real scene: blend a crop of `scenes/mic` on one simulated tile, and check every
step.

Run by `make demo`; `python -m benchmarks.demo --help` lists the options.
"""

from __future__ import annotations

import importlib.util
import time
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
from rich.console import Console

import vividc
from vividc.cli.program_report import print_regions
from vividc.render import (
    BlendLaunch,
    Crop,
    Gaussians,
    TileLists,
    assemble,
    blend_image,
    cut_launches,
    load_cameras,
    over_background,
    psnr,
    read_gaussians,
    side_by_side,
    tile_lists,
    write_png,
)

ROOT = Path(__file__).resolve().parents[1]
SCENE = ROOT / "scenes" / "mic"
RTOL, ATOL = 1e-4, 1e-5
"""The array's exp is within 2 ulp and its FMAs round once: that much may differ from numba's libm
and mul-add.
"""


@dataclass(frozen=True)
class ArrayRun:
    """What the simulated tile did with all launches of a crop."""

    outputs: list[np.ndarray]
    cycles: int
    seconds: float
    worst_difference: float
    outside_tolerance: int


def load_kernel() -> vividc.KernelFunction:
    """The blending kernel from `kernels/gs_blend.py`."""
    spec = importlib.util.spec_from_file_location("gs_blend", ROOT / "kernels" / "gs_blend.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    kernel = module.gs_blend
    assert isinstance(kernel, vividc.KernelFunction)
    return kernel


def run_on_array(
    program: vividc.Program, kernel: vividc.KernelFunction, launches: tuple[BlendLaunch, ...]
) -> ArrayRun:
    """Simulates every launch, runs numba on the same arguments, and compares."""
    outputs, cycles, seconds, worst, outside = [], 0, 0.0, 0.0, 0
    for launch in launches:
        arguments, twin = launch.arguments(), launch.arguments()
        start = time.perf_counter()
        result = vividc.simulate(program, *arguments.values())
        seconds += time.perf_counter() - start
        kernel(*twin.values())
        array, numba = np.asarray(arguments["out"]), np.asarray(twin["out"])
        worst = max(worst, float(np.abs(array - numba).max()))
        outside += int((~np.isclose(array, numba, rtol=RTOL, atol=ATOL)).sum())
        cycles += result.cycles
        outputs.append(array)
    return ArrayRun(outputs, cycles, seconds, worst, outside)


def scene_lists() -> tuple[Gaussians, TileLists]:
    """The trained Gaussians of `scenes/mic` and the sorted lists of view 0 at 200x200."""
    gaussians = read_gaussians(SCENE / "mic_3dgs_sh3.ply")
    return gaussians, tile_lists(gaussians, load_cameras(SCENE / "ref_gs.npz")[0])


@click.command()
@click.option("--fabric", default="vivid-tile", show_default=True)
@click.option("--crop", "corner", nargs=4, type=int, default=(80, 144, 32, 32), show_default=True)
@click.option("--time-limit", default=90.0, show_default=True, help="Seconds for the mapper.")
@click.option("-o", "--output", type=click.Path(path_type=Path), default=Path("demo"))
def main(fabric: str, corner: tuple[int, int, int, int], time_limit: float, output: Path) -> None:
    """Compile kernels/gs_blend.py, simulate it on a crop of scenes/mic, and compare with numba and
    numpy.
    """
    console = Console()
    kernel = load_kernel()
    console.print(f"compiling kernels/gs_blend.py for {fabric} ...")
    start = time.perf_counter()
    program = vividc.compile(kernel, fabric=fabric, time_limit_s=time_limit)
    print_regions(program)
    console.print(f"compiled in {time.perf_counter() - start:.1f} s\n")
    crop = Crop(*corner)
    gaussians, lists = scene_lists()
    reference = blend_image(lists, crop)
    launches = cut_launches(lists, crop)
    console.print(
        f"simulating {crop.pixels} pixels of scenes/mic ({len(gaussians.means)} Gaussians)"
    )
    run = run_on_array(program, kernel, launches)
    picture, expected = assemble(crop, launches, run.outputs), over_background(reference.rgbt)
    output.mkdir(parents=True, exist_ok=True)
    program.save(str(output / "gs_blend.vivid"))
    write_png(output / "array.png", picture)
    write_png(output / "reference.png", expected)
    write_png(output / "compare.png", side_by_side(expected, picture, 1e4))
    evaluated, blended = int(reference.evaluated.sum()), int(reference.blended.sum())
    console.print(f"PSNR against the float32 reference   {psnr(picture, expected):.1f} dB")
    console.print(f"cycles                               {run.cycles:,}")
    console.print(
        f"cycles per evaluated Gaussian        {run.cycles / evaluated:.2f}"
        f" ({evaluated:,} evaluated)"
    )
    console.print(
        f"cycles per blended Gaussian          {run.cycles / blended:.2f} ({blended:,} blended)"
    )
    console.print(
        f"simulated in                         {run.seconds:.1f} s"
        f" ({run.cycles / run.seconds:,.0f} cycles/s)"
    )
    console.print(f"largest difference from numba        {run.worst_difference:.2g}")
    agree = run.outside_tolerance == 0
    console.print(
        f"numba and the simulator agree        {'yes' if agree else 'NO'}"
        f" (rtol {RTOL:g}, atol {ATOL:g})"
    )
    console.print(f"pictures in                          {output}/")
    if not agree:
        raise SystemExit(5)


if __name__ == "__main__":
    main()
