"""Options that several commands share."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

from vividc.cli import completion
from vividc.mapper import EFFORT_LEVELS, EffortLevel

Command = TypeVar("Command", bound=Callable[..., Any])


def finite(_ctx: click.Context, _param: click.Parameter, value: float) -> float:
    """Refuse what is not a finite number from 0 on."""
    if not math.isfinite(value) or value < 0:
        raise click.BadParameter(f"{value} is not a finite number from 0 on.")
    return value


def positive(ctx: click.Context, param: click.Parameter, value: float) -> float:
    """Refuse what is not a positive, finite number."""
    if finite(ctx, param, value) == 0:
        raise click.BadParameter("0 is not a positive number.")
    return value


def node(_ctx: click.Context, _param: click.Parameter, value: float | None) -> float | None:
    """Refuse a node that energies and areas cannot be scaled to."""
    if value is not None and not _NODES_NM[0] <= value <= _NODES_NM[1]:
        raise click.BadParameter(f"{value} is not a node from {_NODES_NM[0]} to {_NODES_NM[1]} nm.")
    return value


def formats(_: click.Context, __: click.Parameter, values: tuple[str, ...]) -> dict[str, str]:
    """A format by function, from FUNCTION=FORMAT; `vividc.compile` says which there are."""
    chosen: dict[str, str] = {}
    for value in values:
        name, equals, fmt = value.partition("=")
        if not (name and equals and fmt):
            raise click.BadParameter(f"{value!r} is not FUNCTION=FORMAT, as in exp=fp8")
        if chosen.setdefault(name, fmt) != fmt:
            raise click.BadParameter(f"{name} is given twice")
    return chosen


def sizes(
    _: click.Context, __: click.Parameter, values: tuple[str, ...]
) -> dict[str, int | tuple[int, ...]] | None:
    """Shapes and integers by parameter, from NAME=SIZE[xSIZE...]; None: nothing is known."""
    known: dict[str, int | tuple[int, ...]] = {}
    for part in (part for value in values for part in value.split(",")):
        match = _SIZE.fullmatch(part)
        if match is None:
            raise click.BadParameter(f"{part!r} is not NAME=SIZE, as in A=20x30 or n=16")
        numbers = tuple(map(int, match["size"].split("x")))
        size = numbers if len(numbers) > 1 else numbers[0]
        if known.setdefault(match["name"], size) != size:
            raise click.BadParameter(f"{match['name']} is given twice")
    return known or None


def window(
    _ctx: click.Context, _param: click.Parameter, value: str | None
) -> tuple[int, int] | None:
    """A first cycle and the one after the last, from FIRST:END; None: not given."""
    if value is None:
        return None
    first, _, end = value.partition(":")
    if not (first.isdecimal() and end.isdecimal()) or int(first) >= int(end):
        raise click.BadParameter(f"{value!r} is not FIRST:END with FIRST below END, as 0:1000.")
    return int(first), int(end)


_SIZE = re.compile(r"(?P<name>[^=]+)=(?P<size>-?\d{1,20}|\d{1,9}(x\d{1,9})+)", re.ASCII)
_NODES_NM = (7, 45)
FILE = click.Path(path_type=Path, dir_okay=False)
FOLDER = click.Path(path_type=Path, file_okay=False)


fabric = click.option(
    "--fabric",
    default="vivid-tile",
    metavar="F",
    help="Name of a fabric (vivid-tile, mesh-4x4, ...) or a YAML file.",
    shell_complete=completion.fabric,
)
mapper = click.option(
    "--mapper",
    default="auto",
    metavar="M",
    help="Name of the mapper.",
    shell_complete=completion.mapper,
)
time_limit = click.option(
    "--time-limit",
    "time_limit_s",
    type=float,
    callback=positive,
    default=60.0,
    metavar="S",
    help="Wall time for the whole command, in seconds.",
)


def effort(default: EffortLevel) -> Callable[[Command], Command]:
    """The option that says where a search stops; commands differ in its default."""
    return click.option(
        "--effort",
        type=click.Choice(EFFORT_LEVELS),
        default=default,
        show_default=True,
        help="Stop a search at the first good mapping, where more work rarely pays, where none is "
        "expected to, or once every smaller II is refuted; the time limit ends it in any case.",
    )


as_json = click.option("--json", "as_json", is_flag=True, help="Print one JSON object to stdout.")
