"""How fast the engines run: tile-cycles a second of both, of native code on one core and on two."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np

import vividc
from benchmarks import EFFORT, general
from benchmarks.workloads import WORKLOADS, Arguments, Workload
from vividc.sim import Launch, NativeEngine, ReferenceEngine
from vividc.sim.bind import bind

HEADER = (
    "| kernel | hot loop's II | cycles a launch | reference (cycles/s) | native, 1 core "
    "| / reference | native, 2 threads | first use s | native code ready s |\n"
    "|---|---|---|---|---|---|---|---|---|"
)
TITLE = "Tile-cycles per second of the engines"
NOTES = (
    "Both engines count everything: cycles, stalls, operations, words on links and in registers,",
    "accesses. `gs_blend` blends 800 faint splats over 240 pixels, which is its steady state; the",
    "others have the inputs of `kernels.md`: where a launch is short, its fixed cost of some 50",
    "microseconds shows, and as most of it is Python's, a second thread gains nothing there.",
    "First use: from words to machine code in the process; ready: the same when the code is known.",
    "Best of three measurements: seconds of processor time on one core, wall time of two threads",
    "and in the last two columns.",
    "",
    "What limits `gs_blend`: some 110 instructions a tile-cycle, for 12 operations. Every float",
    "operation is followed by a test for NaN, every load by tests of its array and its iteration,",
    "and 80 results are handed on to later bodies, more than the processor has registers for.",
)
MEASURED_S = 0.5
REPEATS = 3
SPLATS = 800
PIXELS = (15, 16)


def _faint_splats(rng: np.random.Generator) -> Arguments:
    """As many Gaussians and pixels as fit the scratchpad, so faint that no pixel ends early."""
    columns, rows = PIXELS

    def floats(low: float, high: float) -> np.ndarray:
        return rng.uniform(low, high, SPLATS).astype(np.float32)

    return (
        *(floats(-4, 12) for _ in range(2)),
        *(floats(0.05, 0.1), floats(-0.01, 0.01), floats(0.05, 0.1)),
        floats(0.005, 0.01),
        *(floats(0, 1) for _ in range(3)),
        np.zeros(4 * columns * rows, np.float32),
        *(np.int32(value) for value in (0, 0, columns, rows, SPLATS)),
    )


KERNELS = ("gs_blend", "saxpy", "fir", "relu_gemv", "count_until")
MORE_KERNELS = ("gemm_rows", "crc32_table", "bubble_sort", "mandelbrot")


def workloads() -> Iterator[Workload]:
    """The kernels of the table."""
    yield Workload("gs_blend", _faint_splats)
    yield from (w for w in WORKLOADS if w.name in KERNELS and w.name != "gs_blend")
    yield from (w for w in general.WORKLOADS if w.name in MORE_KERNELS)


def rows(fabric: str, time_limit_s: float) -> Iterator[str]:
    """The lines of the table."""
    for workload in workloads():
        program = vividc.compile(
            workload.kernel(), fabric=fabric, time_limit_s=time_limit_s, effort=EFFORT
        )
        yield row(workload, program)


def row(workload: Workload, program: vividc.Program) -> str:
    """One line of the table."""
    bound = bind(program, workload.fresh(), {})
    launch = Launch(bound.memory, bound.inputs, 1 << 40, bound.extents)
    start = time.perf_counter()
    engine = NativeEngine(program)
    first_s = time.perf_counter() - start
    start = time.perf_counter()
    NativeEngine(program)
    again_s = time.perf_counter() - start
    cycles = engine.run(launch).cycles
    reference = ReferenceEngine(program)
    slow = _rate(lambda: reference.run(launch).cycles, time.thread_time)
    fast = _rate(lambda: engine.run(launch).cycles, time.thread_time)
    with ThreadPoolExecutor(2) as pool:
        both = _rate(
            lambda: sum(pool.map(lambda _: _long(engine, launch), range(2))), time.perf_counter
        )
    loops = [region.ii for region in program.regions if region.kind == "loop"]
    return (
        f"| {workload.name} | {loops[-1]} | {cycles:,} | {slow:,.0f} | {fast / 1e6:.1f} M "
        f"| {fast / slow:,.0f} | {both / 1e6:.1f} M | {first_s:.2f} | {again_s:.3f} |"
    )


def _long(engine: NativeEngine, launch: Launch) -> int:
    """Cycles of launches for a while: what a thread does between two barriers."""
    end = time.perf_counter() + MEASURED_S
    cycles = 0
    while time.perf_counter() < end:
        cycles += engine.run(launch).cycles
    return cycles


def _rate(run: Callable[[], int], clock: Callable[[], float]) -> float:
    """Cycles a second of this clock, the best of some measurements."""
    best = 0.0
    for _ in range(REPEATS):
        cycles, start = 0, clock()
        while clock() - start < MEASURED_S:
            cycles += run()
        best = max(best, cycles / (clock() - start))
    return best
