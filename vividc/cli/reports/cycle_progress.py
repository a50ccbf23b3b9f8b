"""The progress of a long simulation on a terminal: cycles so far, and cycles per second."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn, TimeElapsedColumn
from rich.text import Text


class _Rate(ProgressColumn):
    """Cycles a second, since the start."""

    def render(self, task: Task) -> Text:
        return Text(rate(task.completed, task.elapsed or 0.0))


def rate(cycles: float, seconds: float) -> str:
    """Cycles a second, for people."""
    if seconds <= 0 or cycles <= 0:
        return ""
    return f"{cycles / seconds:,.0f} cycles/s"


@contextmanager
def cycle_progress(
    start: str, console: Console | None = None
) -> Iterator[Callable[[int], None] | None]:
    """A callback that takes the cycles so far and shows a bar on stderr; None unless stderr is a
    terminal. How many cycles there will be nobody knows, so the bar only says that it goes on.
    """
    if console is None and not sys.stderr.isatty():
        yield None
        return
    shown = console or Console(stderr=True)
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(bar_width=24),
        TextColumn("{task.fields[cycles]} cycles"),
        _Rate(),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=shown, transient=True) as bar:
        task = bar.add_task(start, total=None, cycles="0")
        yield lambda cycles: bar.update(task, completed=cycles, cycles=f"{cycles:,}")
