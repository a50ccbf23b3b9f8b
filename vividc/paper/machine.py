"""Exhibits that need no frame: area, systolic modes, exp in narrow formats, and reconfiguration."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

import vividc
from vividc import arch
from vividc.arch.cost.tables import DEFAULT_TABLE, load_costs
from vividc.gemm import FABRICS, LayerShape, Precision, predict
from vividc.launch import Job
from vividc.paper import bars, published
from vividc.paper.exhibit import Exhibit, Line, Table, judged
from vividc.paper.scenes import GAUSSIANS, MIC, Scenes
from vividc.program import Program, RegionReport
from vividc.render import Gaussians, blend_on_array, psnr, read_scene
from vividc.render.array.device.programs import kernel_folder, kernel_module
from vividc.sim.cost import area

_SAMPLES: Final = 65_536
_NETWORKS: Final = {
    "KiloNeRF 59-32-3": ((59, 32), (32, 3)),
    "Instant-NGP 32-64-64-3": ((32, 64), (64, 64), (64, 3)),
    "TensoRF 150-128-128-3": ((150, 128), (128, 128), (128, 3)),
}
_FORMATS: Final[tuple[Precision, ...]] = ("f32", "e4m3")
_LANES: Final[dict[Precision, int]] = {"f32": 1, "e4m3": 4}
_SWEPT: Final = (32, 48, 64, 80, 96, 128, 160)
"""Widths K of colour networks K-K-K-3."""
_EXPS: Final = ("fp32", "fp16", "fp8")
_THREADS, _MAPPING_S, _PATIENCE = 4, 60.0, 10.0


def figure_6(_scenes: Scenes) -> Exhibit:
    """Figure 6: area and its parts."""
    machine = arch.load_accelerator("vivid")
    report = area(machine.fabric, load_costs(DEFAULT_TABLE), tiles=len(machine.tiles))
    mm2 = report["parts_mm2"]
    published_parts = sum(mm2[part] for part in published.AREA_SHARES)
    why = "the published area has room for fewer contexts than our configuration memories hold"
    lines = [
        judged("area of the published parts", published_parts, published.AREA_MM2, "mm2", why),
        judged("area with all contexts", report["total_mm2"], published.AREA_MM2, "mm2", why),
    ]
    lines += [
        judged(f"area: {part}", mm2[part] / published_parts, theirs, "of the published parts", why)
        for part, theirs in published.AREA_SHARES.items()
    ]
    parts = [(name, f"{value:.2f}") for name, value in mm2.items()]
    return Exhibit(
        "fig6",
        "Figure 6: area",
        lines,
        tables=[Table("Area at 45 nm, mm2", ("part", "mm2"), parts)],
        assumptions=[
            "The cost tables are calibrated to the published total, so its parts agree by "
            "construction; figures that were synthesised or published apart, and what is assumed, "
            "are told apart by `vividc area vivid`.",
            "Power is that of a program: Figure 7(a, b) has each method's.",
        ],
    )


def equations(_scenes: Scenes) -> Exhibit:
    """Equations 4 and 5: a full reload of the configuration memories."""
    machine = arch.load_accelerator("vivid")
    program = vividc.compile(_reload, fabric="vivid-tile", loops=vividc.LoopOptions(auto=False))
    job = Job(machine)
    job.configure(range(len(machine.tiles)), program)
    contexts = len(program.words)
    ours = job.simulate().cycles * 10 / contexts
    why = "the stream writes an entry a cycle, and constant tables besides"
    return Exhibit(
        "eq45",
        "Equations 4 and 5: reconfiguration",
        [
            judged(
                "cycles of a full reload of 10 contexts",
                ours,
                published.RELOAD_CYCLES,
                "cycles",
                why,
            )
        ],
        assumptions=[f"Measured on a program of {contexts} contexts, and scaled to ten."],
    )


@vividc.kernel("void(float32[::1], float32[::1], int32)")
def _reload(x, y, n):  # type: ignore[no-untyped-def]
    for i in range(n):
        y[i] += np.float32(2.0) * x[i]


def figure_8a(_scenes: Scenes) -> Exhibit:
    """Figure 8(a): a colour network on one array of 16x16 and on four of 8x8."""
    found = {
        (name, fmt): _both(_layers(shapes, fmt))
        for name, shapes in _NETWORKS.items()
        for fmt in _FORMATS
    }
    swept = {
        (str(width), fmt): _both(_layers(((width, width), (width, width), (width, 3)), fmt))
        for fmt in _FORMATS
        for width in _SWEPT
    }
    theirs = {
        "speed-up": published.MODES_SPEED_UP,
        "use, unified": published.UNIFIED_USE,
        "use, partitioned": published.PARTITIONED_USE,
    }
    why = (
        "theirs lies between networks 64 and 96 wide in E4M3 (second table); which network it is "
        "of, and in which format, is not published"
    )
    ours = dict(zip(theirs, found["Instant-NGP 32-64-64-3", "e4m3"], strict=True))
    near = min(swept.values(), key=lambda one: abs(one[0] - published.MODES_SPEED_UP))
    header = ("format", "speed-up", "unified: use", "partitioned: use")
    return Exhibit(
        "fig8a",
        "Figure 8(a): unified and partitioned arrays",
        [
            *(judged(f"Instant-NGP: {what}", ours[what], theirs[what], "", why) for what in theirs),
            judged("the nearest width", near[0], published.MODES_SPEED_UP, "x", why),
        ],
        tables=[
            Table(f"Colour networks, {_SAMPLES:,} samples", ("network", *header), _shown(found)),
            Table("Colour networks K-K-K-3", ("K", *header), _shown(swept)),
        ],
        pictures={
            "modes": bars.paired(
                "Four arrays of 8x8 over one of 16x16", [(n, ours[n], theirs[n]) for n in theirs]
            )
        },
        assumptions=[
            "The exact closed form, which equals simulation wherever both were run (docs/gemm.md).",
            "The format moves the speed-up of Instant-NGP's network: 1.08 in FP32, 1.97 in E4M3.",
        ],
    )


def _layers(shapes: Sequence[tuple[int, int]], fmt: Precision) -> list[LayerShape]:
    return [LayerShape(depth, cols, precision=fmt) for depth, cols in shapes]


def _both(layers: list[LayerShape]) -> tuple[float, float, float]:
    """Speed-up of four arrays over one, and the share of all lanes that one and four use."""
    one, four = (predict(_SAMPLES, layers, mode) for mode in FABRICS)
    lanes = _LANES[layers[0].precision]
    return one.cycles / four.cycles, one.utilization / lanes, four.utilization / lanes


def _shown(
    found: Mapping[tuple[str, Precision], tuple[float, float, float]],
) -> list[Sequence[str]]:
    return [
        (*names, f"{speed_up:.2f}x", f"{unified:.1%}", f"{partitioned:.1%}")
        for names, (speed_up, unified, partitioned) in found.items()
    ]


def figure_8b(scenes: Scenes) -> Exhibit:
    """Figure 8(b): exp of the blending kernel in FP16 and FP8."""
    _, model = read_scene(scenes.models()[MIC][GAUSSIANS])
    assert isinstance(model, Gaussians)
    camera, _ = scenes.view(MIC, GAUSSIANS, 0, 200, model)
    kernel = kernel_module(kernel_folder() / "precision.py").gs_blend_columns
    cycles, rows, pictures = {}, [], {}
    for name in _EXPS:
        with vividc.patient(_PATIENCE):
            program = vividc.compile(
                kernel,
                fabric="vivid-tile",
                loops=vividc.LoopOptions(threads=_THREADS),
                precision={"exp": name},
                time_limit_s=_MAPPING_S,
                effort="thorough",
            )
        picture = blend_on_array(program, model, camera, "vivid")
        cycles[name], pictures[name] = picture.cycles, np.clip(picture.image, 0, 1)
        hot = _hot(program)
        loss = psnr(pictures[name], pictures["fp32"])
        same = "-" if name == "fp32" else f"{loss:.1f}"
        rows.append((name, str(hot.operations), str(hot.ii), f"{picture.cycles:,}", same))
    why = (
        "exp is a third of the loop's operations here (56 of 171), all else stays FP32: a kernel "
        "without exp would gain 1.44 at most"
    )
    lines: list[Line] = [
        judged(f"blending, exp in {name}", cycles["fp32"] / cycles[name], theirs, "x", why)
        for name, theirs in published.EXP_SPEED_UP.items()
    ]
    return Exhibit(
        "fig8b",
        "Figure 8(b): exp in FP16 and FP8",
        lines,
        tables=[
            Table(
                "Blending `mic` at 200x200 on sixteen tiles",
                ("exp", "operations", "II", "cycles", "dB to FP32"),
                rows,
            )
        ],
        pictures={
            "exp": bars.paired(
                "Speed-up over exp in FP32",
                [
                    (name, cycles["fp32"] / cycles[name], theirs)
                    for name, theirs in published.EXP_SPEED_UP.items()
                ],
            )
        },
        assumptions=["Theirs is of the scene Truck; ours of `mic`."],
    )


def _hot(program: Program) -> RegionReport:
    """The loop with most operations."""
    loops = [region for region in program.regions if region.kind == "loop"]
    return max(loops, key=lambda region: region.operations)
