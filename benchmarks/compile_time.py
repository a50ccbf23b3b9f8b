"""How long the frontend and planning take for each kernel of `kernels/`, beside another checkout.

`python benchmarks/compile_time.py --against FOLDER` measures this checkout and that of another
commit by turns, each in a process of its own.
"""

from __future__ import annotations

import gc
import json
import os
import re
import subprocess
import sys
import time
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from functools import cache
from importlib import util
from pathlib import Path
from statistics import geometric_mean

import click

from vividc import KernelFunction, arch, load_ll
from vividc.arch.fabric import Fabric
from vividc.compiler.planning import options as planning
from vividc.compiler.planning.choose import choose
from vividc.compiler.planning.estimate import Estimator
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.pipeline import PassOptions, optimize_kernel
from vividc.frontend import lower as frontend
from vividc.ssa.ir import Function
from vividc.ssa.rewrite.contract import contract

_LOOPS = getattr(planning, "LoopOptions", None) or planning.TransformOptions
"""The other checkout may be older than the name."""

ROOT = Path(__file__).resolve().parents[1]
FABRIC = "vivid-tile"
TITLE = "Compile time of frontend and planning"
NOTES = (
    "Milliseconds of processor time, in turn for both commits; the least of {repeats} counts.",
    "Frontend: from LLVM's text to SSA, without numba and LLVM (of a C kernel, whose LLVM runs in",
    "another process, from the file). Planning: loop transformations are chosen, the function is",
    "normalised and cut into graphs, and the passes run on them. Mapping is not measured.",
)
WITHOUT_NESTS = (
    "Nests of affine loops keep their loops (`--without-nests`), as commits before them do."
)
NAMED = ("sort_by_network", "march_rays")
_DEFINED = re.compile(r"^define (?!internal|private).*@([\w.]+)\(", re.MULTILINE)
_DECORATED = re.compile(r"^@(?:vividc\.)?kernel\b", re.MULTILINE)
Times = tuple[float, float]


@dataclass(frozen=True)
class Row:
    """Least seconds of (frontend, planning) before and now."""

    kernel: str
    before: Times
    now: Times

    def text(self) -> str:
        """A line of the table."""
        cells = [
            f"{1000 * t:.1f}" for pair in zip(self.before, self.now, strict=True) for t in pair
        ]
        ratio = sum(self.now) / sum(self.before)
        return f"| {' | '.join((self.kernel, *cells, f'{ratio:.2f}'))} |"


HEADER = (
    "| kernel | frontend before | now | planning before | now | both, now / before |\n"
    "|---|---|---|---|---|---|"
)


def files(root: Path) -> Iterator[str]:
    """Files of kernels, by their paths in a checkout."""
    for file in sorted((root / "kernels").rglob("*")):
        python = file.suffix == ".py" and _DECORATED.search(file.read_text())
        if python or file.suffix == ".ll":
            yield file.relative_to(root).as_posix()


class Bench:
    """Compiles the kernels of one checkout, which is the one that `vividc` is imported from;
    `nests`: affine ones are restructured, if that checkout does it at all.
    """

    def __init__(self, *, nests: bool = True) -> None:
        # What numba and LLVM give is the same each time, and is not measured.
        for name in ("numba_module", "optimised_ir"):
            setattr(frontend, name, cache(getattr(frontend, name)))
        warnings.simplefilter("ignore")
        loaded = arch.load(FABRIC)
        assert isinstance(loaded, Fabric)
        self.fabric = loaded
        known = {field.name for field in fields(_LOOPS)}
        self._loops = _LOOPS() if nests or "restructure" not in known else _LOOPS(restructure=False)

    def kernels(self, file: str) -> list[str]:
        """Names of the kernels that a file defines."""
        path = ROOT / file
        if path.suffix == ".ll":
            return _DEFINED.findall(path.read_text())
        found = vars(self._module(path)).items()
        kernels = [(name, one) for name, one in found if isinstance(one, KernelFunction)]
        return [name for name, one in kernels if Path(one.file) == path]

    def measure(self, file: str, name: str) -> Times:
        """Seconds of processor time for the frontend and for planning."""
        self._lowered(ROOT / file, name)  # what numba and LLVM give is known from here on
        gc.collect()
        began = time.process_time()
        function, parallel = self._lowered(ROOT / file, name)
        lowered = time.process_time()
        self._plan(function, parallel)
        return lowered - began, time.process_time() - lowered

    @cache  # noqa: B019 - one bench a process
    def _module(self, path: Path) -> object:
        spec = util.spec_from_file_location(path.stem, path)
        assert spec is not None
        assert spec.loader is not None
        module = util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module

    def _lowered(self, path: Path, name: str) -> tuple[Function, frozenset[int]]:
        if path.suffix == ".ll":
            return load_ll(path, name).lower(), frozenset()
        kernel = getattr(self._module(path), name)
        given = kernel.signature
        args = kernel.py_func, name, kernel.params, given.args, given.return_type, kernel.loc
        return frontend.lower(*args), kernel.prange_lines

    def _plan(self, function: Function, parallel: frozenset[int]) -> None:
        options = PassOptions(contract=False)
        estimator = Estimator(self.fabric, options)
        plan = choose(contract(function), estimator, self._loops, parallel)
        state = plan.stages[-1].state
        function = estimator.prepared(state.function, state.hints)
        if hasattr(estimator, "optimized_kernel"):
            estimator.optimized_kernel(estimator.built(function))
        else:  # commits before it
            optimize_kernel(build_kernel(function), options)


def serve(*, nests: bool) -> None:
    """Answers requests, a line each: a file's kernels, or the seconds of one of them."""
    bench = Bench(nests=nests)
    for line in sys.stdin:
        request = json.loads(line)
        answer = bench.kernels(*request) if len(request) == 1 else bench.measure(*request)
        print(json.dumps(answer), flush=True)


class Worker:
    """`serve` in a process of its own, with the package of a checkout."""

    def __init__(self, root: Path, *, nests: bool) -> None:
        self.process = subprocess.Popen(
            [sys.executable, __file__, "--serve", *(() if nests else ("--without-nests",))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, "PYTHONPATH": str(root)},
        )

    def ask(self, *request: str) -> list[object]:
        """The answer to one request."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        print(json.dumps(request), file=self.process.stdin, flush=True)
        answer: list[object] = json.loads(self.process.stdout.readline())
        return answer


def rows(against: Path, repeats: int, only: Sequence[str], *, nests: bool) -> Iterator[Row]:
    """A row a kernel, as they are measured."""
    before, now = Worker(against, nests=nests), Worker(ROOT, nests=nests)
    for file in files(ROOT):
        for name in map(str, now.ask(file)):
            if only and name not in only:
                continue
            times = [(before.ask(file, name), now.ask(file, name)) for _ in range(repeats)]
            least = [
                (min(float(t[0]) for t in one), min(float(t[1]) for t in one))
                for one in zip(*times, strict=True)
            ]
            yield Row(name, least[0], least[1])


def summary(measured: Sequence[Row]) -> Iterator[str]:
    """Geometric means of now / before."""
    named = [*NAMED, ""]
    yield "| of what | frontend | planning | both |\n|---|---|---|---|"
    for wanted in named:
        some = [row for row in measured if wanted in ("", row.kernel)]
        if not some:
            continue
        shares = [
            geometric_mean(row.now[part] / row.before[part] for row in some) for part in (0, 1)
        ]
        shares.append(geometric_mean(sum(row.now) / sum(row.before) for row in some))
        what = wanted or f"geometric mean of {len(some)} kernels"
        yield f"| {what} | {' | '.join(f'{share:.2f}' for share in shares)} |"


@click.command()
@click.option("--against", type=click.Path(path_type=Path, exists=True, file_okay=False))
@click.option("--repeats", default=3, show_default=True)
@click.option("--kernel", "only", multiple=True, help="Only these; default: all.")
@click.option("--without-nests", is_flag=True, help="Restructure no nests of affine loops.")
@click.option("--serve", "serving", is_flag=True, hidden=True)
@click.option("-o", "--output", type=click.Path(path_type=Path, dir_okay=False), default=None)
def main(
    against: Path | None,
    repeats: int,
    only: tuple[str, ...],
    without_nests: bool,
    serving: bool,
    output: Path | None,
) -> None:
    """Print the table, and write it to the file OUTPUT."""
    nests = not without_nests
    if serving:
        serve(nests=nests)
        return
    measured = []
    click.echo(HEADER)
    for row in rows((against or ROOT).resolve(), repeats, only, nests=nests):
        measured.append(row)
        click.echo(row.text())
    means = "\n".join(summary(measured))
    click.echo(f"\n{means}")
    if output is not None:
        told = NOTES if nests else (*NOTES, WITHOUT_NESTS)
        notes = "\n".join(told).format(repeats=repeats)
        table = "\n".join([HEADER, *(row.text() for row in measured)])
        output.write_text(f"# {TITLE}\n\n{notes}\n\n{means}\n\n{table}\n")


if __name__ == "__main__":
    main()
