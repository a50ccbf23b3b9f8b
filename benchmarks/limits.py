"""The table of time limits: hard kernels, each compiled under several limits in a process of its
own, with the time each takes and how it ends.

`python -m benchmarks.limits` prints it, on a machine with nothing else to do; elsewhere `--cpu`
lets time pass only while the compiler computes. `--only`, `--limit`, `--large` and `--fresh` narrow
it down. A row that is over its limit makes the exit code 1.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import click

from benchmarks.hard_kernels import FAMILIES

HEADER = "| kernel | size | limit s | time s | CPU s | end | notes |\n|---|---|---|---|---|---|---|"
LIMITS = (1.0, 5.0, 10.0, 30.0)
_CHILD = "--child"
_BY_CPU = "VIVIDC_BENCHMARK_CPU"
_PATIENCE, _PATIENCE_S = 8.0, 300.0
"""A child is ended after so many times its limit, and so many seconds."""
_SHOWN = 90


@dataclass(frozen=True)
class Row:
    """How a compilation went: seconds of wall time and of CPU time, and the end."""

    took_s: float
    cpu_s: float = 0.0
    end: str = ""
    notes: str = ""

    def is_within(self, limit_s: float) -> bool:
        """Whether it kept to its limit: a tenth and a second more are allowed."""
        return self.took_s <= 1.1 * limit_s + 1.0


def measured(text: str, limit_s: float, cache: Path) -> Row:
    """Compiles a kernel in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"hard.{'ll' if text.startswith('define') else 'py'}"
        path.write_text(text)
        command = (sys.executable, "-m", "benchmarks.limits", _CHILD, str(path), str(limit_s))
        environment = {**os.environ, "VIVIDC_CACHE_DIR": str(cache)}
        patience_s = _PATIENCE * limit_s + _PATIENCE_S
        try:
            done = subprocess.run(
                command, capture_output=True, env=environment, timeout=patience_s, check=False
            )
        except subprocess.TimeoutExpired:
            return Row(patience_s, end="was ended")
    lines = done.stdout.decode().splitlines()
    if not lines:
        return Row(0.0, end=f"crashed: {done.stderr.decode()[-300:]!r}")
    return Row(**json.loads(lines[-1]))


def child(path: str, limit_s: float) -> None:
    """Compiles a kernel and prints its row as JSON."""
    import vividc  # noqa: PLC0415 - its time is not the compilation's
    from vividc.cli.kernels import load_kernel  # noqa: PLC0415

    warnings.simplefilter("ignore")
    clock = time.perf_counter
    if os.environ.get(_BY_CPU):
        clock = time.monotonic = time.process_time
    start, cpu, notes = clock(), time.process_time(), ""
    try:
        program = vividc.compile(load_kernel(path), time_limit_s=limit_s)
        kinds = [region.kind for region in program.regions]
        length = sum(region.ii for region in program.regions)
        end = f"{kinds.count('loop')} loops of {len(kinds)} regions, {length} contexts"
        late = [text for text in program.warnings if "too long" in text]
        notes = f"{len(late)} warnings of the time" if late else ""
    except vividc.VividcError as error:
        end = f"exit code {error.exit_code}: {error.reason[:_SHOWN]}"
    took_s, cpu_s = clock() - start, time.process_time() - cpu
    print(json.dumps(asdict(Row(took_s, cpu_s, end, notes))))


def rows(
    families: tuple[str, ...], limits: tuple[float, ...], *, fresh: bool, large: bool
) -> Iterator[tuple[str, bool]]:
    """Lines of the table as they are measured, and whether each kept to its limit."""
    with tempfile.TemporaryDirectory() as kept:
        for family in families:
            make, sizes = FAMILIES[family]
            for size in sizes[-1:] if large else sizes:
                for limit_s in limits:
                    with tempfile.TemporaryDirectory() as empty:
                        cache = os.environ.get("VIVIDC_CACHE_DIR", kept)
                        row = measured(make(size), limit_s, Path(empty if fresh else cache))
                    within = row.is_within(limit_s)
                    took = f"{row.took_s:.1f}{'' if within else ' **over**'}"
                    times = f"{limit_s:g} | {took} | {row.cpu_s:.1f}"
                    yield f"| {family} | {size:,} | {times} | {row.end} | {row.notes} |", within


@click.command()
@click.option("--only", multiple=True, type=click.Choice(tuple(FAMILIES)), help="This family.")
@click.option("--limit", "limits", multiple=True, type=float, help="This limit in seconds.")
@click.option("--fresh", is_flag=True, help="An empty cache for each row.")
@click.option("--cpu", is_flag=True, help="Time passes only while the compiler computes.")
@click.option("--large", is_flag=True, help="The largest size of each family only.")
def main(
    only: tuple[str, ...], limits: tuple[float, ...], fresh: bool, cpu: bool, large: bool
) -> None:
    """Print the table of time limits."""
    os.environ[_BY_CPU] = "1" if cpu else ""
    click.echo(HEADER)
    over = 0
    for line, within in rows(only or tuple(FAMILIES), limits or LIMITS, fresh=fresh, large=large):
        click.echo(line)
        over += not within
    sys.exit(over > 0)


if __name__ == "__main__":
    if sys.argv[1:2] == [_CHILD]:
        child(sys.argv[2], float(sys.argv[3]))
    else:
        main()
