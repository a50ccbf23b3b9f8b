"""What commands print: one JSON object for programs, tables for people, and progress."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Final

import click
import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

from vividc.errors import printable

Plain = None | bool | int | float | str | list["Plain"] | dict[str, "Plain"]
_FILE_WIDTH: Final = 120


def print_json(schema: str, body: Mapping[str, object]) -> None:
    """Print one JSON object to stdout; `schema` names its form and version."""
    click.echo(json.dumps({"schema": schema, **_plain_mapping(body)}, allow_nan=False))


def plain(value: object) -> Plain:
    """`value` as JSON can hold it: dataclasses become objects, and NaN or infinities text."""
    if isinstance(value, np.generic | Enum):
        return plain(value.item() if isinstance(value, np.generic) else value.value)
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if value is None or isinstance(value, bool | int | float | str):
        return value
    return _plain_container(value)


def print_table(
    title: str,
    columns: Sequence[str],
    rows: Iterable[Sequence[object]],
    *,
    numeric: Collection[str] = (),
) -> None:
    """Print a table to stdout.

    Parameters
    ----------
    numeric
        Names of the right-aligned columns.
    """
    assert {*numeric} <= {*columns}, "a column that is not there cannot be aligned"
    table = Table(title=Text(printable(title), style="bold"), title_justify="left")
    for column in columns:
        table.add_column(column, justify="right" if column in numeric else "left")
    for row in rows:
        table.add_row(*(Text("-" if cell is None else printable(str(cell))) for cell in row))
    _console().print(table)


def percent(fraction: float) -> str:
    """A share for people."""
    return f"{100 * fraction:.0f} %"


def _plain_container(value: object) -> Plain:
    if isinstance(value, Mapping):
        return _plain_mapping(value)
    if is_dataclass(value) and not isinstance(value, type):
        return {item.name: plain(getattr(value, item.name)) for item in fields(value)}
    if isinstance(value, Iterable):
        return [plain(item) for item in value]
    return str(value)


def _plain_mapping(values: Mapping[object, object] | Mapping[str, object]) -> dict[str, Plain]:
    return {str(plain(key)): plain(value) for key, value in values.items()}


def _console() -> Console:
    width = None if sys.stdout.isatty() else _FILE_WIDTH
    return Console(file=sys.stdout, width=width, highlight=False, markup=False)
