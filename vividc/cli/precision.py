"""The option `--precision FUNCTION=FORMAT`."""

from __future__ import annotations

import click


def formats(_: click.Context, __: click.Parameter, values: tuple[str, ...]) -> dict[str, str]:
    """A format by function; `vividc.compile` says which there are."""
    chosen: dict[str, str] = {}
    for value in values:
        name, equals, fmt = value.partition("=")
        if not (name and equals and fmt):
            raise click.BadParameter(f"{value!r} is not FUNCTION=FORMAT, as in exp=fp8")
        if chosen.setdefault(name, fmt) != fmt:
            raise click.BadParameter(f"{name} is given twice")
    return chosen
