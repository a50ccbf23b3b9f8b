"""How far long work is, on stderr: on a terminal in place, in a notebook below its cell, elsewhere
by lines at intervals.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any, Final

import click
from rich.console import Console
from rich.text import Text

from vividc.errors import demand_type, printable
from vividc.host import watch

Tell = Callable[..., None]

_LOG_S: Final = 15.0
"""Seconds from one line of a log to the next."""

_NOTEBOOK_S: Final = 0.25
"""Seconds from one text of a notebook to the next: each is a message to the browser."""


@contextmanager
def progress(title: str = "working") -> Iterator[Tell]:
    """Show how far the work inside is.

    What `compile`, `map_dfg`, `simulate`, functions of `jit` and the renderers would tell a
    `progress` of their own is shown: on a terminal and in a notebook in place, in a log by a line
    each 15 seconds.

    Parameters
    ----------
    title
        What the work is, in a few words; it is shown until there is more to say.

    Yields
    ------
    A callback that shows what it is given: text, cycles as an int, a share as a float.

    Raises
    ------
    VividcError
        `title` is no text.
    """
    demand_type(title, str, "the title", 'give a few words: vividc.progress("compiling gemm")')
    with _showing(title) as tell, watch.told(tell):
        yield tell


@contextmanager
def _showing(title: str) -> Iterator[Tell]:
    display = _notebook()
    if display is not None:
        yield from _below_the_cell(title, display)
    elif sys.stderr.isatty():
        with Console(stderr=True).status(Text(printable(title))) as status:
            yield lambda *state: status.update(Text(_state(*state)))
    else:
        yield _logged(title)


def _state(*state: object) -> str:
    """A state of the work for people."""
    words = []
    for part in state:
        if isinstance(part, int):
            words.append(f"{part:,} cycles")
        else:
            words.append(f"{part:.0%}" if isinstance(part, float) else str(part))
    return printable(" ".join(words))


def _logged(title: str) -> Tell:
    """A line at intervals, with the seconds since the start."""
    began = said = time.monotonic()

    def log(*state: object) -> None:
        nonlocal said
        now = time.monotonic()
        if now - said >= _LOG_S:
            said = now
            click.echo(f"{printable(title)}, {now - began:.0f} s: {_state(*state)}", err=True)

    return log


def _notebook() -> Callable[..., Any] | None:
    """IPython's `display` where it runs for a notebook."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    if getattr(shell, "kernel", None) is None:
        return None
    display: Callable[..., Any] = import_module("IPython.display").display
    return display


def _below_the_cell(title: str, display: Callable[..., Any]) -> Iterator[Tell]:
    """One text of the cell's output, which is changed in place; in the end how long it took."""
    began = said = time.monotonic()
    place = display({"text/plain": f"{printable(title)} ..."}, raw=True, display_id=True)

    def write(what: str) -> None:
        line = f"{printable(title)}, {time.monotonic() - began:.0f} s: {what}"
        place.update({"text/plain": line}, raw=True)

    def tell(*state: object) -> None:
        nonlocal said
        if time.monotonic() - said >= _NOTEBOOK_S:
            said = time.monotonic()
            write(_state(*state))

    ended = "stopped"
    try:
        yield tell
        ended = "done"
    finally:
        write(ended)
