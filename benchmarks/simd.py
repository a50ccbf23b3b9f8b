"""Threads of a tile: kernels with a parallel loop, one to eight of its iterations side by side.

The blend is of real blocks of the scene `mic`; each row's words are compared with those of one
thread, bit by bit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

import vividc
from benchmarks import EFFORT
from benchmarks.workloads import Arguments, Workload
from vividc import arch
from vividc.errors import VividcError
from vividc.render import Gaussians, read_scene, read_views, scaled_camera
from vividc.render.crop import Crop
from vividc.render.splat.blocks import cut_small_launches
from vividc.render.splat.splat import tile_lists

TITLE = "Threads of a tile"
NOTES = (
    "`kernels/threads.py`: iterations of the loop over `prange` run as threads of one tile.",
    "Numbers are compiled without other transformations; `1, auto` with all but threads, `auto`",
    "with what the planner chooses by itself. Operations and II are of the hot loop; the steady",
    "speed-up is of the cycles that an iteration of a thread takes in it, the speed-up of all",
    "simulated cycles, both against one thread without transformations. The blends are of real",
    "blocks of `scenes/mic` at 800x800 (view 0), each with the splats that can be seen in it: the",
    "longest list and a middle one. `same`: every word that is written is that of one thread.",
)
HEADER = (
    "| kernel | threads | operations | II | bound | status | steady speed-up | simulated cycles "
    "| speed-up | same | transformations |\n"
    "|---|---|---|---|---|---|---|---|---|---|---|"
)
FORMS: tuple[tuple[int | None, str], ...] = (
    *((1, "none"), (2, "none"), (4, "none")),
    *((1, "auto"), (None, "auto")),
)
"""Threads that are asked for, and what is done with loops otherwise."""
_MIC = Path(__file__).resolve().parents[1] / "scenes" / "mic"
_FILE = "threads"
_SIZE = 800


def rows(fabric: str, time_limit_s: float) -> Iterator[str]:
    """Yield the lines of the table, as they are measured."""
    for workload in WORKLOADS:
        yield from _rows(workload, fabric, time_limit_s)


@dataclass(frozen=True, slots=True)
class _Measured:
    """What one program took: its hot loop, cycles, and the words that it wrote."""

    program: vividc.Program
    cycles: int
    words: bytes


def _rows(workload: Workload, fabric: str, time_limit_s: float) -> Iterator[str]:
    first: _Measured | None = None
    for count, mode in FORMS:
        label = str(count) if mode == "none" else "auto" if count is None else f"{count}, auto"
        try:
            found = _measure(workload, fabric, time_limit_s, count, mode)
        except VividcError as error:
            yield f"| {workload.name} | {label} | {error.reason} |" + " |" * 8
            continue
        first = first or found
        steady = _hot(first.program).ii * (count or 0) / _hot(found.program).ii
        shown = f"{steady:.2f}" if mode == "none" else ""
        yield _row(f"{workload.name} | {label}", shown, found, first)


def _measure(
    workload: Workload, fabric: str, time_limit_s: float, count: int | None, mode: str
) -> _Measured:
    name = workload.name.split(",", maxsplit=1)[0]
    program = _compiled(name, fabric, time_limit_s, count, mode)
    arguments = workload.fresh()
    result = vividc.simulate(program, *arguments)
    words = b"".join(a.tobytes() for a in arguments if isinstance(a, np.ndarray))
    return _Measured(program, result.cycles, words)


@cache
def _compiled(
    name: str, fabric: str, time_limit_s: float, count: int | None, mode: str
) -> vividc.Program:
    return vividc.compile(
        Workload(name, lambda _: (), _FILE).kernel(),
        fabric=fabric,
        effort=EFFORT,
        time_limit_s=time_limit_s,
        loops=vividc.LoopOptions(auto=mode == "auto", threads=count),
    )


def _row(name: str, steady: str, found: _Measured, first: _Measured) -> str:
    loop = _hot(found.program)
    done = ", ".join(
        f"{item.kind} by {item.factor}" if item.factor else item.kind
        for report in found.program.loops
        for item in report.transforms
        if item.chosen
    )
    cells = (
        *(name, loop.operations, loop.ii, loop.lower_bound, loop.status, steady),
        *(f"{found.cycles:,}", f"{first.cycles / found.cycles:.2f}"),
        "yes" if found.words == first.words else "NO",
        done or "-",
    )
    return f"| {' | '.join(map(str, cells))} |"


def _hot(program: vividc.Program) -> vividc.program.RegionReport:
    loops = [region for region in program.regions if region.kind == "loop"]
    return max(loops or program.regions, key=lambda region: region.operations)


def _block(rank: float) -> Callable[[np.random.Generator], Arguments]:
    """Arguments of the blend of a block of `mic`, by the length of its list among all of them."""

    def arguments(_: np.random.Generator) -> Arguments:
        _, scene = read_scene(_MIC / "mic_3dgs_sh3.ply")
        assert isinstance(scene, Gaussians)
        camera = scaled_camera(read_views(_MIC / "ref_gs.npz")[0].camera, _SIZE, _SIZE)
        words = arch.load("vivid-tile").scratchpad.size_bytes // 4
        launches = cut_small_launches(tile_lists(scene, camera), Crop(0, 0, _SIZE, _SIZE), words)
        whole = [item for item in launches if item.block.pixels == 64 and len(item.splats)]  # noqa: PLR2004
        whole.sort(key=lambda item: len(item.splats))
        return tuple(whole[int(rank * (len(whole) - 1))].arguments().values())

    return arguments


def _march(rng: np.random.Generator) -> Arguments:
    """64 rays through a ball of 20 in a grid of 16^3 cells; most of it is empty."""
    side, count = 16, 64
    cells = np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), -1).reshape(-1, 3)
    ball = ((cells - 7.5) ** 2).sum(1) < 20  # noqa: PLR2004
    origins = np.column_stack([rng.uniform(2, 14, (count, 2)), np.full(count, 0.5)])
    directions = np.column_stack([rng.uniform(-0.1, 0.1, (count, 2)), np.ones(count)])
    spans = np.column_stack([np.zeros(count), rng.uniform(5, 14, count)])
    return (
        *(a.astype(np.float32) for a in (origins, directions, spans)),
        ball.astype(np.uint8),
        np.where(ball, rng.uniform(0.2, 0.9, side**3), 0).astype(np.float32),
        np.int32(side),
        np.float32(0.25),
        np.zeros((count, 2), np.float32),
    )


def _dense(rng: np.random.Generator) -> Arguments:
    inputs, weights = (
        rng.standard_normal(size).astype(np.float32) for size in ((16, 32), (32, 32))
    )
    bias = rng.standard_normal(32).astype(np.float32)
    return inputs, weights, bias, np.zeros((16, 32), np.float32)


def _fir(rng: np.random.Generator) -> Arguments:
    signal, taps = (rng.integers(-99, 99, size, dtype=np.int32) for size in (271, 16))
    return signal, taps, np.zeros(256, np.int32)


def _encoding(rng: np.random.Generator) -> Arguments:
    x = rng.uniform(-3, 3, 100).astype(np.float32)
    return x, np.int32(10), np.zeros((100, 20), np.float32)


def _escape(_: np.random.Generator) -> Arguments:
    grid = np.meshgrid(np.linspace(-2, 0.6, 16), np.linspace(-1.2, 1.2, 16))
    real, imaginary = (axis.ravel().astype(np.float32) for axis in grid)
    return real, imaginary, np.int32(60), np.zeros(256, np.int32)


WORKLOADS = (
    Workload("march", _march, _FILE),
    Workload("escape_time", _escape, _FILE),
    Workload("dense_relu_samples", _dense, _FILE),
    Workload("fir_outputs", _fir, _FILE),
    Workload("frequency_encoding", _encoding, _FILE),
    Workload("gs_blend_rows, longest list", _block(1.0), _FILE),
    Workload("gs_blend_rows, middle list", _block(0.5), _FILE),
)
