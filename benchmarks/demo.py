"""The main job on a real scene: blend a crop of `scenes/mic` on one simulated tile, and check every
step.

Run by `make demo`, which writes the folder `demo/`; `python -m benchmarks.demo --help` lists the
options.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

import vividc
from benchmarks.workloads import WORKLOADS
from vividc.cli.reports.program import print_regions
from vividc.compiler.driver import lower
from vividc.dfg.expand.expand import expand_math
from vividc.dfg.ir import DFG, Edge, Node
from vividc.machine.opcodes import Opcode
from vividc.render import (
    Blended,
    BlendLaunch,
    Crop,
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
    stalls: int
    seconds: float
    worst_difference: float
    outside_tolerance: int


def run_on_array(
    program: vividc.Program, kernel: vividc.KernelFunction, launches: tuple[BlendLaunch, ...]
) -> ArrayRun:
    """Simulates every launch, runs numba on the same arguments, and compares."""
    outputs: list[np.ndarray] = []
    cycles, stalls, seconds, worst, outside = 0, 0, 0.0, 0.0, 0
    for launch in track(launches, "simulating", console=Console(stderr=True), transient=True):
        arguments, twin = launch.arguments(), launch.arguments()
        start = time.perf_counter()
        result = vividc.simulate(program, *arguments.values())
        seconds += time.perf_counter() - start
        kernel(*twin.values())
        array, numba = np.asarray(arguments["out"]), np.asarray(twin["out"])
        worst = max(worst, float(np.abs(array - numba).max()))
        outside += int((~np.isclose(array, numba, rtol=RTOL, atol=ATOL)).sum())
        cycles += result.cycles
        stalls += result.stats["stalls"]["bank_conflict"]
        outputs.append(array)
    return ArrayRun(outputs, cycles, stalls, seconds, worst, outside)


def exp_share(kernel: vividc.KernelFunction) -> tuple[int, int, int, int]:
    """(operations of one expanded exp, operations of the hot loop, and the same for FLOPs)."""
    nodes = (
        Node(0, Opcode.LIVE_IN, name="x"),
        Node(1, Opcode.EXP),
        Node(2, Opcode.LIVE_OUT, name="%y"),
    )
    exp = expand_math(DFG("exp", nodes, (Edge(0, 1, 0), Edge(1, 2, 0))))
    loop = next(region for region in lower(kernel).regions if region.kind == "loop")
    return len(exp.operations), len(loop.dfg.operations), flops(exp), flops(loop.dfg)


def flops(dfg: DFG) -> int:
    """Floating-point additions and multiplications of one iteration; an FMA is two."""
    weights = {Opcode.FMA: 2, Opcode.FADD: 1, Opcode.FSUB: 1, Opcode.FMUL: 1}
    return sum(weights.get(node.op, 0) for node in dfg.nodes)


def report(kernel: vividc.KernelFunction, run: ArrayRun, blended: Blended, quality: float) -> Table:
    """What a person wants to know of the run."""
    evaluated, added = int(blended.evaluated.sum()), int(blended.blended.sum())
    exp_ops, ops, exp_flops, all_flops = exp_share(kernel)
    table = Table(show_header=False, title="scenes/mic, blended on one tile", title_justify="left")
    rows = (
        ("PSNR against the float32 reference", f"{quality:.1f} dB"),
        ("cycles", f"{run.cycles:,}"),
        ("stall cycles (banks)", f"{run.stalls:,}"),
        ("Gaussians evaluated", f"{evaluated:,}: {run.cycles / evaluated:.2f} cycles each"),
        ("Gaussians blended", f"{added:,}: {run.cycles / added:.1f} cycles each"),
        ("exp in the hot loop", f"{exp_ops} of {ops} operations, {exp_flops} of {all_flops} FLOPs"),
        ("simulated in", f"{run.seconds:.1f} s, {run.cycles / run.seconds:,.0f} cycles/s"),
        ("largest difference from numba", f"{run.worst_difference:.2g}"),
        (
            "numba and the simulator agree",
            f"{'yes' if run.outside_tolerance == 0 else 'NO'} (rtol {RTOL:g}, atol {ATOL:g})",
        ),
    )
    for row in rows:
        table.add_row(*row)
    return table


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
    kernel = next(w for w in WORKLOADS if w.name == "gs_blend").kernel()
    console.print(f"compiling kernels/gs_blend.py for {fabric} ...")
    start = time.perf_counter()
    program = vividc.compile(kernel, fabric=fabric, time_limit_s=time_limit)
    print_regions(program)
    console.print(f"compiled in {time.perf_counter() - start:.1f} s\n")
    crop = Crop(*corner)
    lists = tile_lists(
        read_gaussians(SCENE / "mic_3dgs_sh3.ply"), load_cameras(SCENE / "ref_gs.npz")[0]
    )
    blended, launches = blend_image(lists, crop), cut_launches(lists, crop)
    console.print(f"simulating {crop.pixels} pixels in {len(launches)} launches ...")
    run = run_on_array(program, kernel, launches)
    picture, expected = assemble(crop, launches, run.outputs), over_background(blended.rgbt)
    output.mkdir(parents=True, exist_ok=True)
    program.save(output / "gs_blend.vivid")
    write_png(output / "array.png", picture)
    write_png(output / "reference.png", expected)
    write_png(output / "compare.png", side_by_side(expected, picture, 1e6))
    console.print(report(kernel, run, blended, psnr(picture, expected)))
    console.print(f"written: {output}/compare.png, array.png, reference.png, gs_blend.vivid")
    if run.outside_tolerance:
        raise SystemExit(5)


if __name__ == "__main__":
    main()
