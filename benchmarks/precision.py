"""What narrower formats buy: FMAs in lanes, exp by itself, and the blending of a frame."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

import vividc
from benchmarks import EFFORT
from benchmarks.workloads import Workload
from vividc.formats import to_floats
from vividc.program.tables import RegionReport
from vividc.render import View, blend_on_array, psnr, read_scene, read_views
from vividc.ssa.formats.precision import FORMAT_NAMES

TITLE = "Precision: FP16 and FP8 against FP32"
NOTES = (
    "Every figure is of a mapped and simulated program of `kernels/precision.py`, four threads a",
    "tile. FP8 is E4M3. A frame is the whole job, as in `frames.md`. Why the blending gains less",
    "than the paper's: its four exps are a third of the loop's operations (56 of 171); all else",
    "stays FP32. exp takes 12 operations in FP16, two of them conversions, 5 in FP8, 14 in FP32.",
    "With exp as one operation the loop would have 119, and no II below 8. An II above its bound",
    "is what the solver found in a minute.",
)
_ROOT = Path(__file__).resolve().parents[1]
_MIC = _ROOT / "scenes" / "mic"
_PHOTOGRAPHS = _ROOT.parent / "shared" / "scenes" / "mic" / "mic_200.npz"
_FORMATS = ("fp32", "fp16", "fp8", "e5m2")
_THREADS = 4
_MAPPING_S = 60.0
_PAPER = {"fp32": "1", "fp16": "1.27", "fp8": "1.56"}


def rows(fabric: str = "vivid-tile") -> Iterator[str]:
    """Yield the lines of the tables, as they are measured."""
    yield from _fma_rows("vivid-tile-unit")
    yield ""
    yield from _exp_rows(fabric)
    yield ""
    yield from _blend_rows(fabric)


def _fma_rows(fabric: str) -> Iterator[str]:
    """Chains of FMAs: the loop's numbers a cycle."""
    yield f"### Chains of FMAs on {fabric}"
    yield ""
    yield "| format | operations | II | bound | numbers a cycle | over FP32 | cycles |"
    yield "|---|---|---|---|---|---|---|"
    x = np.linspace(-1, 1, 80, dtype=np.float32)
    base = 0.0
    for name in _FORMATS:
        kernel = _kernel(f"fma_{name}")
        program = vividc.compile(
            kernel,
            fabric=fabric,
            effort=EFFORT,
            loops=vividc.LoopOptions(threads=_THREADS),
            time_limit_s=_MAPPING_S,
        )
        loop = _hot(program)
        rate = 16 * _THREADS / loop.ii
        base = base or rate
        cycles = vividc.simulate(program, x, np.zeros(64, np.float32), 1000).cycles
        yield (
            f"| {name} | {loop.operations} | {loop.ii} | {loop.lower_bound} | {rate:.0f} "
            f"| {rate / base:.2f} | {cycles:,} |"
        )


def _exp_rows(fabric: str) -> Iterator[str]:
    """exp of every number of the format, but for those where it overflows."""
    yield f"### exp of every number of a format on {fabric}"
    yield ""
    yield "| format | operations | II | largest error, ulp | largest relative error | mean |"
    yield "|---|---|---|---|---|---|"
    kernel = _kernel("exponentials")
    for name in _FORMATS:
        program = vividc.compile(
            kernel,
            fabric=fabric,
            effort=EFFORT,
            loops=vividc.LoopOptions(threads=_THREADS),
            precision={"exp": name},
            time_limit_s=_MAPPING_S,
        )
        x = _arguments(name)
        got = np.concatenate([_run(program, part) for part in np.array_split(x, 32)])
        loop = _hot(program)
        ulp, most, mean = _errors(name, x, got)
        yield f"| {name} | {loop.operations} | {loop.ii} | {ulp:.2f} | {most:.2g} | {mean:.2g} |"


def _run(program: vividc.Program, x: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    out = np.zeros_like(x)
    vividc.simulate(program, np.ascontiguousarray(x), out)
    return out


def _arguments(name: str) -> npt.NDArray[np.float32]:
    """Every finite number of the format (of float16 for FP32) of which exp is a normal number."""
    fmt = FORMAT_NAMES[name] or FORMAT_NAMES["fp16"]
    assert fmt is not None
    numbers = to_floats(fmt, np.arange(1 << fmt.bits, dtype=fmt.dtype))
    numbers = numbers[np.isfinite(numbers)]
    low, high = math.log(fmt.min_normal), math.log(fmt.max_finite)
    return numbers[(numbers >= low) & (numbers <= high)]


def _errors(
    name: str, x: npt.NDArray[np.float32], got: npt.NDArray[np.float32]
) -> tuple[float, float, float]:
    fmt = FORMAT_NAMES[name]
    exact = np.exp(x.astype(np.float64))
    error = np.abs(got - exact)
    ulp = np.exp2(np.floor(np.log2(exact)) - (23 if fmt is None else fmt.mantissa_bits))
    relative = error / exact
    return float((error / ulp).max()), float(relative.max()), float(relative.mean())


def _blend_rows(fabric: str) -> Iterator[str]:
    """Figure 8(b) of the paper on the scene mic."""
    view, against = _view()
    camera, truth = view.camera, view.truth()
    assert truth is not None
    size = f"{camera.width}x{camera.height}"
    yield f"### exp in the blending of mic, {size}, on 16 tiles of {fabric}, against {against}"
    yield ""
    yield (
        "| exp | operations | II | bound | cycles | speed-up | paper | PSNR dB | loss dB "
        "| PSNR to FP32 dB |"
    )
    yield "|---|---|---|---|---|---|---|---|---|---|"
    _, mic = read_scene(_MIC / "mic_3dgs_sh3.ply")
    kernel = _kernel("gs_blend_columns")
    first: tuple[int, float, npt.NDArray[np.float32]] | None = None
    for name in _FORMATS:
        program = vividc.compile(
            kernel,
            fabric=fabric,
            effort=EFFORT,
            loops=vividc.LoopOptions(threads=_THREADS),
            precision={"exp": name},
            time_limit_s=_MAPPING_S,
        )
        picture = blend_on_array(program, mic, camera, "vivid")
        shown = np.clip(picture.image, 0, 1)
        quality = psnr(shown, np.clip(truth, 0, 1))
        first = first or (picture.cycles, quality, shown)
        loop = _hot(program)
        yield (
            f"| {name} | {loop.operations} | {loop.ii} | {loop.lower_bound} "
            f"| {picture.cycles:,} | {first[0] / picture.cycles:.2f} | {_PAPER.get(name, '-')} "
            f"| {quality:.2f} | {first[1] - quality:.2f} | {psnr(shown, first[2]):.1f} |"
        )


def _view() -> tuple[View, str]:
    """A photograph if there is one beside the checkout, else the render of the model."""
    if _PHOTOGRAPHS.is_file():
        return read_views(_PHOTOGRAPHS)[0], "a photograph"
    return read_views(_MIC / "ref_gs.npz")[0], "a render in float64"


def _kernel(name: str) -> vividc.KernelFunction | vividc.LLKernel:
    return Workload(name, lambda _: (), "precision").kernel()


def _hot(program: vividc.Program) -> RegionReport:
    """The loop with most operations."""
    loops = [region for region in program.regions if region.kind == "loop"]
    return max(loops, key=lambda region: region.operations)
