"""All published tables; `make bench` makes those that do not take long."""

from __future__ import annotations

import os
import platform
from collections.abc import Callable, Iterable, Iterator
from importlib.metadata import version
from pathlib import Path
from typing import Final

import click

import vividc
from benchmarks import (
    EFFORT,
    PATIENCE,
    cold,
    engines,
    formats,
    frames,
    gemm,
    graphics,
    kernels,
    large,
    mappers,
    npbench,
    paper,
    precision,
    quality,
    simd,
    splats,
    stages,
    start,
    steering,
)
from benchmarks.kernels import TABLES
from benchmarks.polybench import table as polybench
from benchmarks.polybench.suite import CASES, SIZES
from vividc.host.files import write_whole
from vividc.paper.scenes import METHODS


def machine() -> Iterator[str]:
    """What the figures were measured on."""
    packages = ("numba", "llvmlite", "ortools", "numpy")
    python = platform.python_version()
    yield f"- machine: {platform.machine()}, {os.cpu_count()} cores, Python {python}"
    versions = ", ".join(f"{package} {version(package)}" for package in packages)
    yield f"- vividc {vividc.__version__}, {versions}"


SEARCHED: Final = f"- mappings: `--effort {EFFORT}`"
"""Of tables of cycles."""


ENGINES = "engines"
QUALITY = "quality"
MAPPERS = "mappers"
PAPER = "paper"
POLYBENCH = "polybench"
NPBENCH = "npbench"
FRAMES = "frames"
GEMM = "gemm"
SIMD = "simd"
PRECISION = "precision"
FORMATS = "formats"
LARGE = "large"
GRAPHICS = "graphics"
START = "start"
COLD = "cold"
STAGES = "stages"
STEERING = "steering"
SPLATS = "splats"
SEARCHED_FOR = (*TABLES, ENGINES, FRAMES, GRAPHICS, LARGE, PRECISION, SIMD)
DEFAULT = (*TABLES, ENGINES, FRAMES, QUALITY, FORMATS, GEMM, SIMD, PRECISION)
CHOICES = (
    *DEFAULT,
    GRAPHICS,
    LARGE,
    SPLATS,
    PAPER,
    MAPPERS,
    POLYBENCH,
    NPBENCH,
    START,
    COLD,
    STAGES,
    STEERING,
)
"""What is not made by default takes long: it is made by name."""
MODULES = {
    ENGINES: engines,
    FRAMES: frames,
    QUALITY: quality,
    FORMATS: formats,
    SIMD: simd,
    GRAPHICS: graphics,
    LARGE: large,
    SPLATS: splats,
    START: start,
    COLD: cold,
    STAGES: stages,
    STEERING: steering,
}
ROWS: dict[str, Callable[[str, float], Iterator[str]]] = {
    ENGINES: engines.rows,
    FRAMES: lambda fabric, _: frames.rows(fabric),
    GRAPHICS: lambda fabric, _: graphics.rows(fabric),
    LARGE: lambda *_: large.rows(),
    START: start.rows,
    COLD: lambda fabric, _: cold.rows(fabric),
    STAGES: stages.rows,
    STEERING: lambda *_: steering.rows(),
    SPLATS: lambda fabric, _: splats.rows(fabric),
    QUALITY: lambda *_: quality.rows(),
    FORMATS: lambda *_: formats.rows(),
    SIMD: simd.rows,
}
PLACES = {
    QUALITY: ("float32 on the host",),
    FRAMES: ("vivid",),
    FORMATS: ("any fabric",),
    GRAPHICS: ("vivid",),
    LARGE: ("vivid",),
    START: ("vivid-tile",),
    COLD: ("vivid-tile",),
    STAGES: ("vivid",),
    STEERING: ("vivid",),
    SPLATS: ("vivid",),
}
"""Where tables are made that `--fabric` has no say in."""


def lines_of(table: str, fabric: str, time_limit_s: float) -> Iterator[str]:
    """A table on one fabric, its header first."""
    if table in MODULES:
        yield from MODULES[table].HEADER.splitlines()
        yield from ROWS[table](fabric, time_limit_s)
        return
    yield from kernels.lines(table, fabric, time_limit_s)


@click.command()
@click.option("--table", "tables", type=click.Choice(CHOICES), multiple=True, default=DEFAULT)
@click.option("--fabric", "fabrics", multiple=True, default=("vivid-tile", "vivid-tile-unit"))
@click.option("--mapper", "chosen", multiple=True, help="Of the mappers' table; default: all.")
@click.option(
    "--method",
    "methods",
    type=click.Choice(METHODS),
    multiple=True,
    help="Of the paper's tables; default: all.",
)
@click.option(
    "--size",
    "sizes",
    type=click.IntRange(11),
    multiple=True,
    help=f"Sides of the paper's tables, the last for its figures; default: {paper.SIZES}.",
)
@click.option(
    "--suites",
    type=click.Path(path_type=Path, file_okay=False, exists=True),
    help="Folder with a copy of NPBench.",
)
@click.option("--time-limit", default=60.0, show_default=True, help="Seconds of mapping a kernel.")
@click.option(
    "--only", default="", help="Kernels of polybench or npbench, as gemm,lu; default: all."
)
@click.option(
    "--sizes",
    "scales",
    type=click.Choice(SIZES),
    multiple=True,
    default=SIZES,
    help="Of polybench; default: all.",
)
@click.option("--jobs", default=1, show_default=True, help="Kernels of polybench at once.")
@click.option(
    "--step", default="", help="Name of a step of polybench's progress; default: the last."
)
@click.option(
    "--known-sizes", is_flag=True, help="Compile polybench for its sizes only, into its own table."
)
@click.option(
    "--reassociate", is_flag=True, help="Let polybench sum floats in any order, in its own table."
)
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False), default=None)
def main(  # noqa: PLR0913, PLR0917 - an option each
    tables: tuple[str, ...],
    fabrics: tuple[str, ...],
    chosen: tuple[str, ...],
    methods: tuple[str, ...],
    sizes: tuple[int, ...],
    suites: Path | None,
    time_limit: float,
    only: str,
    scales: tuple[str, ...],
    jobs: int,
    step: str,
    known_sizes: bool,
    reassociate: bool,
    output: Path | None,
) -> None:
    """Print the tables, and write each to a Markdown file of its name in the folder OUTPUT."""
    if output is not None:
        output.mkdir(parents=True, exist_ok=True)
    with vividc.patient(PATIENCE):
        for table in tables:
            if table == GEMM:
                _print_own(GEMM, gemm.TITLE, [*gemm.NOTES, "", *gemm.rows()], output)
                continue
            if table == PRECISION:
                lines = [*precision.NOTES, "", *precision.rows()]
                _print_own(PRECISION, precision.TITLE, lines, output)
                continue
            if table == MAPPERS:
                _print_mappers(fabrics, chosen, time_limit, output)
                continue
            if table == PAPER:
                _print_paper(methods, sizes, output)
                continue
            if table == NPBENCH:
                if suites is None:
                    raise click.UsageError("--table npbench needs --suites DIR, a copy of NPBench")
                names = tuple(name for name in only.split(",") if name)
                _print_own(NPBENCH, npbench.TITLE, npbench.lines(suites, names), output)
                continue
            if table == POLYBENCH:
                names = tuple(name for name in only.split(",") if name)
                wanted = polybench.Wanted(names, scales, jobs, step, known_sizes, reassociate)
                _print_polybench(wanted, output)
                continue
            _print_table(table, fabrics, time_limit, output)


def _print_table(
    table: str, fabrics: tuple[str, ...], time_limit: float, output: Path | None
) -> None:
    """A table with a row a kernel or a frame, on each fabric."""
    title = MODULES[table].TITLE if table in MODULES else TABLES[table][0]
    on = " ".join(f"--fabric {fabric}" for fabric in fabrics)
    command = f"python -m benchmarks --table {table}"
    command += "" if table in PLACES else f" {on} --time-limit {time_limit:g}"
    made = f"`{command}` (`make bench`)" if table in DEFAULT else f"`{command}`"
    lines = [f"# {title}", "", f"Made by {made}.", "", *machine()]
    lines += [SEARCHED, ""] if table in SEARCHED_FOR else [""]
    notes = MODULES[table].NOTES if table in MODULES else kernels.NOTES
    lines += [*notes, ""]
    for fabric in PLACES.get(table, fabrics):
        lines += [f"## {fabric}", ""]
        click.echo("\n".join(lines[-2:]))
        for line in lines_of(table, fabric, time_limit):
            lines.append(line)
            click.echo(line)
            if output is not None:  # after each row: an interrupted run keeps what it has
                text = "\n".join([*lines, ""])
                write_whole(output / f"{table}.md", text.encode())
        lines.append("")


def _print_own(table: str, title: str, body: Iterable[str], output: Path | None) -> None:
    """A table that is made for fabrics of its own."""
    command = f"python -m benchmarks --table {table}"
    made = f"`{command}` (`make bench`)" if table in DEFAULT else f"`{command} --suites DIR`"
    lines = [f"# {title}", "", f"Made by {made}.", "", *machine()]
    lines += [SEARCHED, ""] if table in SEARCHED_FOR else [""]
    click.echo("\n".join(lines))
    for line in body:  # some take long
        lines.append(line)
        click.echo(line)
    if output is not None:
        write_whole(output / f"{table}.md", "\n".join([*lines, ""]).encode())


def _print_paper(methods: tuple[str, ...], sizes: tuple[int, ...], output: Path | None) -> None:
    """The paper's tables: they go on where an earlier run stopped."""
    asked = "".join(f" --method {method}" for method in methods)
    asked += "".join(f" --size {size}" for size in sizes)
    command = f"python -m benchmarks --table {PAPER}{asked} -o benchmarks"
    head = [f"# {paper.TITLE}", "", f"Made by `{command}`.", "", *machine(), "", *paper.NOTES, ""]
    body: list[str] = []
    for body in paper.sections(methods, sizes, output):
        if output is not None:
            text = "\n".join([*head, *body, ""])
            write_whole(output / f"{PAPER}.md", text.encode())
    click.echo("\n".join([*head, *body]))


def _print_polybench(wanted: polybench.Wanted, output: Path | None) -> None:
    """PolyBench: it goes on where an earlier run stopped."""
    unknown = set(wanted.only) - set(CASES)
    if unknown:
        raise click.BadParameter(f"{', '.join(sorted(unknown))}: not of {', '.join(CASES)}")
    command = f"python -m benchmarks --table {POLYBENCH} -o benchmarks"
    made = f"Made by `{command}`."
    head = [f"# {polybench.TITLE}", "", made, "", *machine(), SEARCHED, ""]
    body: list[str] = []
    for body in polybench.sections(wanted, output):
        if output is not None:
            text = "\n".join([*head, *polybench.NOTES, "", *body, ""])
            write_whole(output / f"{POLYBENCH}.md", text.encode())
    click.echo("\n".join([*head, *polybench.NOTES, "", *body]))


def _print_mappers(
    fabrics: tuple[str, ...], chosen: tuple[str, ...], time_limit: float, output: Path | None
) -> None:
    """The table of mappers: it goes on where an earlier run stopped."""
    on = " ".join(f"--fabric {fabric}" for fabric in fabrics)
    by = "".join(f" --mapper {mapper}" for mapper in chosen)
    command = f"python -m benchmarks --table {MAPPERS} {on}{by} --time-limit {time_limit:g}"
    head = [f"# {mappers.TITLE}", "", f"Made by `{command} -o benchmarks`.", "", *machine(), ""]
    body: list[str] = []
    for body in mappers.sections(fabrics, chosen, time_limit, output):
        if output is not None:
            text = "\n".join([*head, *mappers.NOTES, "", *body])
            write_whole(output / f"{MAPPERS}.md", text.encode())
    click.echo("\n".join([*head, *mappers.NOTES, "", *body]))


if __name__ == "__main__":
    main()
