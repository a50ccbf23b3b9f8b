"""Text for people."""

from __future__ import annotations

import click

from vividc.errors import printable


def say(text: str, *, err: bool = False) -> None:
    """Print text for people; of the characters that a terminal obeys only line ends are left."""
    click.echo("\n".join(printable(line) for line in text.split("\n")), err=err)
