"""Options to look between the stages of a compilation, and what they print."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import Any, Final

import click
from rich.console import Console
from rich.table import Table

from vividc.cli.files import make_folder
from vividc.compiler.passes import STAGES, problems_of, text_of
from vividc.errors import InternalError, printable
from vividc.host.files import write_whole
from vividc.host.watch import Watch, watching

ALL = "all"
_NAMES = tuple(dict.fromkeys(stage.name for stage in STAGES))


class Stopped(Exception):
    """Raised after the stage at which a compilation is to stop."""


@dataclass(slots=True)
class End:
    """Whether a compilation stopped at the stage that was asked for."""

    stopped: bool = False


@dataclass(frozen=True, slots=True)
class Look:
    """What a user wants to see between stages."""

    after: tuple[str, ...]
    folder: Path | None
    stop: str | None
    verify: bool
    time: bool

    @property
    def prints(self) -> bool:
        """Whether more than the result is printed."""
        return bool(self.after and self.folder is None) or self.time

    @contextmanager
    def watching(self) -> Iterator[End]:
        """Watch the stages inside, and stop after the one asked for."""
        end = End()
        if not (self.after or self.stop or self.verify or self.time):
            yield end
            return
        watch = Watch(_Printer(self))
        try:
            with watching(watch):
                yield end
        except Stopped:
            end.stopped = True
        finally:
            if self.time:
                _print_times(watch.seconds)


class _Printer:
    """Prints or writes what stages leave, numbered."""

    def __init__(self, look: Look) -> None:
        self._look = look
        self._count = 0

    def __call__(self, name: str, made: object) -> None:
        look = self._look
        problems = problems_of(made) if look.verify else []
        if problems:
            raise InternalError(f"{name} broke an invariant: {'; '.join(problems)}")
        if name in look.after or ALL in look.after:
            self._show(name, text_of(made))
        if name == look.stop:
            raise Stopped

    def _show(self, name: str, text: str) -> None:
        if self._look.folder is None:
            click.echo(f"# after {name}\n{printable_lines(text)}")
            return
        path = self._look.folder / f"{self._count:03}-{name}.txt"
        self._count += 1
        write_whole(path, text.encode())


def printable_lines(text: str) -> str:
    """A text whose names come from a user's file, for a terminal."""
    return "\n".join(printable(line) for line in text.split("\n"))


def _print_times(seconds: dict[str, float]) -> None:
    table = Table("stage", "s", title="seconds by stage")
    for name in sorted(seconds, key=_NAMES.index):
        table.add_row(name, f"{seconds[name]:.3f}")
    Console(stderr=True).print(table)


_OPTIONS: Final = (
    click.option(
        "--print-after",
        type=click.Choice((ALL, *_NAMES)),
        multiple=True,
        metavar="STAGE",
        help="Print the output of this stage, or of `all` (`vividc opt --list`).",
    ),
    click.option(
        "--print-to",
        type=click.Path(path_type=Path, file_okay=False),
        metavar="FOLDER",
        help="Write that to files in this folder instead.",
    ),
    click.option(
        "--stop-after",
        type=click.Choice(_NAMES),
        metavar="STAGE",
        help="Stop after this stage.",
    ),
    click.option("--verify-each", is_flag=True, help="Check invariants after each stage."),
    click.option("--time-passes", is_flag=True, help="Print the seconds of each stage."),
)


def look_options(command: Callable[..., None]) -> Callable[..., None]:
    """Adds the options; the command gets one `look`."""

    @wraps(command)
    def with_look(
        print_after: tuple[str, ...],
        print_to: Path | None,
        stop_after: str | None,
        verify_each: bool,
        time_passes: bool,
        **rest: Any,
    ) -> None:
        if print_to is not None:
            make_folder(print_to, "--print-to")
        if print_to is not None and not print_after:
            print_after = (ALL,)
        command(look=Look(print_after, print_to, stop_after, verify_each, time_passes), **rest)

    for option in reversed(_OPTIONS):
        option(with_look)
    return with_look
