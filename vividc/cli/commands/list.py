"""`vividc list`: what can be named, with a line on each."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

import click

from vividc import arch
from vividc.arch.yaml.layers import family_base, shipped_text
from vividc.cli import options
from vividc.cli.reports.report import print_json, print_table
from vividc.errors import KernelError
from vividc.machine.opcodes import OPCODES
from vividc.mapper.registry import BUILT_IN, mapper_names

SCHEMA = "vividc.list/1"

Row = dict[str, object]


def _fabrics(files: tuple[Path, ...]) -> Iterator[Row]:
    for name in arch.preset_names():
        yield {"name": name, "what": _first_sentence(shipped_text("presets", name))}
    for name in arch.family_names():
        yield {"name": name, "what": _first_sentence(shipped_text("presets", family_base(name)))}


def _accelerators(files: tuple[Path, ...]) -> Iterator[Row]:
    for name in arch.accelerator_names():
        yield {"name": name, "what": _first_sentence(shipped_text("accelerators", name))}


def _first_sentence(text: str) -> str:
    """Of the comment at the start of a YAML text."""
    lines = []
    for line in text.splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.removeprefix("#").strip())
    return re.split(r"(?<=\.)\s", " ".join(lines), maxsplit=1)[0].rstrip(".")


def _mappers(files: tuple[Path, ...]) -> Iterator[Row]:
    for name in mapper_names():
        what = inspect.getdoc(BUILT_IN[name]) if name in BUILT_IN else "of another package"
        yield {"name": name, "what": " ".join((what or "").split("\n\n")[0].split()).rstrip(".")}


def _opcodes(files: tuple[Path, ...]) -> Iterator[Row]:
    for op, info in OPCODES.items():
        yield {
            "name": op.value,
            "operands": ", ".join(kind.value for kind in info.operands),
            "result": info.result.value,
            "latency class": info.latency_class.value,
        }


def _kernels(files: tuple[Path, ...]) -> Iterator[Row]:
    from vividc.cli.kernels import kernels_of  # noqa: PLC0415 - loads numba

    if not files:
        raise KernelError(
            "no file is named whose kernels are to be listed",
            loc="kernels",
            hint="vividc list kernels FILE.py ...",
        )
    for file in files:
        for kernel in kernels_of(file):
            text = repr(kernel).removeprefix("<kernel ").removesuffix(">")
            yield {"name": f"{file}:{kernel.name}", "signature": text}


_LISTS: Final[dict[str, Callable[[tuple[Path, ...]], Iterator[Row]]]] = {
    "fabrics": _fabrics,
    "accelerators": _accelerators,
    "mappers": _mappers,
    "opcodes": _opcodes,
    "kernels": _kernels,
}


@click.command("list")
@click.argument("what", type=click.Choice([*_LISTS]))
@click.argument("files", nargs=-1, type=click.Path(path_type=Path))
@options.as_json
def command(what: str, files: tuple[Path, ...], as_json: bool) -> None:
    """List fabrics, accelerators, mappers, opcodes, or the kernels of files."""
    if files and what != "kernels":
        raise click.UsageError(f"{what} are of no file: leave {files[0]} out")
    rows = list(_LISTS[what](files))
    if as_json:
        print_json(SCHEMA, {what: rows})
        return
    columns = tuple(rows[0]) if rows else ("name",)
    print_table(what.capitalize(), columns, ([*row.values()] for row in rows))
