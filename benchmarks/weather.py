"""`python -m benchmarks.weather`: are figures the same on an idle machine and on a busy one?

The kernels of the tables, matrix products, and a small frame of each method, are compiled with an
empty cache and simulated, twice: as the machine is, and beside processes that do nothing but count.
Words and cycles must be equal; the command ends with 1 where they are not.
"""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final, get_args

import click
import numpy as np

import vividc
from benchmarks import EFFORT, PATIENCE, c_kernels, general, render_kernels
from benchmarks.paper import SCENES
from benchmarks.quality import MODELS
from benchmarks.workloads import WORKLOADS, Workload
from vividc.gemm import Layer, mlp_job
from vividc.gemm.layer import Apart
from vividc.paper.scenes import METHODS, MIC
from vividc.render import read_scene, read_views, scaled_camera
from vividc.render.array import ArrayOptions, render_array

KERNELS: Final[dict[str, tuple[Workload, ...]]] = {
    "kernels": (*WORKLOADS, *general.WORKLOADS),
    "render": render_kernels.WORKLOADS,
    "c_kernels": c_kernels.WORKLOADS,
}
PRODUCTS: Final = "products"
GROUPS: Final = (*KERNELS, PRODUCTS, *METHODS)
HEADER: Final = (
    "| case | cycles | beside {busy} processes | same words | stopped by clock | s | s beside |\n"
    "|---|---|---|---|---|---|---|"
)


@dataclass(frozen=True)
class Case:
    """What one run found; `words`: a hash of the configuration, or of a frame's stages."""

    name: str
    cycles: int
    words: str
    hurried: bool
    seconds: float


def cases(group: str, fabric: str, time_limit_s: float, size: int) -> Iterator[Case]:
    """The cases of a group, in this process."""
    if group in KERNELS:
        for workload in KERNELS[group]:
            yield _kernel(workload, fabric, time_limit_s)
    elif group == PRODUCTS:
        yield from _products()
    else:
        yield _frame(group, size)


def _kernel(workload: Workload, fabric: str, time_limit_s: float) -> Case:
    start = time.perf_counter()
    program = vividc.compile(
        workload.kernel(), fabric=fabric, time_limit_s=time_limit_s, effort=EFFORT
    )
    seconds = time.perf_counter() - start
    cycles = vividc.simulate(program, *workload.fresh()).cycles
    words = hashlib.sha256(program.words.tobytes() + program.images.tobytes()).hexdigest()
    return Case(workload.name, cycles, words[:12], program.hurried, round(seconds, 1))


def _frame(method: str, size: int) -> Case:
    path = SCENES.models()[MIC][method]
    _, scene = read_scene(path)
    camera = scaled_camera(read_views(path.parent / MODELS[path.name])[0].camera, size, size)
    start = time.perf_counter()
    frame = render_array(scene, camera, ArrayOptions())
    seconds = time.perf_counter() - start
    stages = repr([(stage.name, stage.cycles, stage.jobs, stage.runs) for stage in frame.stages])
    words = hashlib.sha256(stages.encode() + frame.image.tobytes()).hexdigest()[:12]
    name = f"{method}, {size}x{size}"
    return Case(name, int(frame.cycles), words, bool(frame.late), round(seconds, 1))


def _products() -> Iterator[Case]:
    """Networks whose activations the tiles compute: what a user calls, with no more patience."""
    rng = np.random.default_rng(1)
    x, first, last = (
        rng.standard_normal(shape, np.float32) for shape in ((64, 32), (32, 48), (48, 16))
    )
    for activation in get_args(Apart):
        for mode in ("tpu-unified", "tpu-partitioned"):
            start = time.perf_counter()
            layers = [Layer(first, activation="relu"), Layer(last, activation=activation)]
            with vividc.patient(1):
                run = mlp_job(x, layers, mode=mode)
            seconds = round(time.perf_counter() - start, 1)
            account = hashlib.sha256(repr(run.job.events).encode() + run.values.tobytes())
            name = f"two layers, {activation}, {mode}"
            yield Case(name, int(run.job.cycles), account.hexdigest()[:12], False, seconds)


@contextmanager
def _busy(count: int) -> Iterator[None]:
    """So many processes at work."""
    spawn = multiprocessing.get_context("spawn")
    workers = [spawn.Process(target=_count, daemon=True) for _ in range(count)]
    for worker in workers:
        worker.start()
    try:
        yield
    finally:
        for worker in workers:
            worker.kill()


def _count() -> None:
    number = 0
    while True:
        number += 1


def _apart(group: str, arguments: Sequence[str]) -> list[Case]:
    """The cases of a group, in a process with an empty cache."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, "-m", "benchmarks.weather", "--group", group, "--child", *arguments],
            env={**os.environ, "VIVIDC_CACHE_DIR": str(Path(folder).resolve())},
            stdout=subprocess.PIPE,
            check=True,
            text=True,
        )
    return [Case(**json.loads(line)) for line in done.stdout.splitlines()]


@click.command()
@click.option("--group", "groups", type=click.Choice(GROUPS), multiple=True, default=GROUPS)
@click.option("--fabric", default="vivid-tile", show_default=True, help="Of the kernels.")
@click.option("--time-limit", default=60.0, show_default=True, help="Seconds a kernel.")
@click.option("--size", default=32, show_default=True, help="Side of the frames.")
@click.option("--busy", default=4, show_default=True, help="Processes at work beside.")
@click.option("--child", is_flag=True, hidden=True)
def main(
    groups: tuple[str, ...], fabric: str, time_limit: float, size: int, busy: int, child: bool
) -> None:
    """Compile and run everything twice; exit code 1 where two runs differ."""
    if child:
        with vividc.patient(PATIENCE):
            for case in cases(groups[0], fabric, time_limit, size):
                print(json.dumps(asdict(case)), flush=True)
        return
    arguments = ("--fabric", fabric, "--time-limit", str(time_limit), "--size", str(size))
    click.echo(HEADER.format(busy=busy))
    wrong = 0
    for group in groups:
        alone = _apart(group, arguments)
        with _busy(busy):
            beside = _apart(group, arguments)
        for one, other in zip(alone, beside, strict=True):
            same = (one.cycles, one.words) == (other.cycles, other.words)
            wrong += not same
            click.echo(_line(one, other, same))
    click.echo(f"\nsame: {'no, ' + str(wrong) + ' differ' if wrong else 'all'}")
    sys.exit(min(wrong, 1))


def _line(one: Case, other: Case, same: bool) -> str:
    clock = one.hurried or other.hurried
    return (
        f"| {one.name} | {one.cycles:,} | {other.cycles:,} | {'yes' if same else 'NO'} "
        f"| {'yes' if clock else '-'} | {one.seconds:.1f} | {other.seconds:.1f} |"
    )


if __name__ == "__main__":
    main()
