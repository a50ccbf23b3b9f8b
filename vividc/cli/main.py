"""The `vividc` command and its sub-commands; every error becomes a message and an exit code.

Exit codes: 0 done, 1 internal error, 2 wrong usage or input, 3 proved infeasible, 4 time limit,
5 mismatch against the reference, 130 interrupted.
"""

from __future__ import annotations

import errno
import os
import sys
import traceback
import warnings
from contextlib import suppress
from importlib import import_module
from typing import Any, Final, NoReturn, TextIO

import click

from vividc import __version__
from vividc.cli.say import say
from vividc.errors import InternalError, VividcError, VividcWarning
from vividc.host.watch import heard
from vividc_main import loading

INTERRUPTED: Final = 130
_NO_PROCESS: Final = ("can't start new thread", os.strerror(errno.EAGAIN))
"""What Python and C++ libraries say when a user may start no more processes."""
_NO_PROCESS_MESSAGE: Final = "a thread or a process cannot be started"
_NO_PROCESS_HINT: Final = "hint: allow more of them (ulimit -u)"
_DEBUG: Final = "VIVIDC_DEBUG"


_COMMANDS: Final = {
    "area": "Print the area of a tile, or of an accelerator's tiles, with the kind of each figure.",
    "compile": "Compile a kernel for a fabric and write the program.",
    "disasm": "Print what each PE does in each context of a program.",
    "list": "List fabrics, accelerators, mappers, opcodes, or the kernels of files.",
    "map": "Map a dataflow graph (JSON, DOT, Morpher XML or text form) and say what was proved.",
    "opt": "Run passes on a function in SSA form or on a dataflow graph.",
    "render": "Render SCENE (3DGS .ply; npz of KiloNeRF, Instant-NGP, TensoRF) and compare with "
    "the truth.",
    "reproduce": "Measure the paper's tables and figures, and write them beside the paper's as one "
    "HTML page.",
    "simulate": "Run a program on the machine, cycle by cycle.",
    "verify": "Check a file that `vividc map -o` wrote: mapping, bounds and what they prove.",
    "view": "Show a program, and a run of it, as one HTML page that works offline.",
}
"""What lists of commands say of each, as its module does; that takes a second or more to load."""


class _Later(click.Command):
    """A command whose module is not loaded."""

    def load(self) -> click.Command:
        """The command itself."""
        with loading():
            module = import_module(f"vividc.cli.commands.{self.name}")
        command: click.Command = module.command
        return command


class _Commands(click.Group):
    """Loads a command when it runs, and turns what it raises into one message and an exit code."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        name, command, rest = super().resolve_command(ctx, args)
        return name, command.load() if isinstance(command, _Later) else command, rest

    def main(self, *args: Any, **extra: Any) -> Any:
        _open_closed_streams()
        try:
            return super().main(*args, **extra)
        except OSError as error:  # a page of help, or what was still to be flushed
            if error.errno != errno.ENOSPC:
                raise
            _give_up_stdout(error)

    def make_context(self, *args: Any, **extra: Any) -> click.Context:
        try:
            return super().make_context(*args, **extra)
        except KeyboardInterrupt:
            say("vividc: interrupted", err=True)
            raise click.exceptions.Exit(INTERRUPTED) from None

    def invoke(self, ctx: click.Context) -> Any:
        with warnings.catch_warnings():
            warnings.simplefilter("always", VividcWarning)
            warnings.showwarning = _show_warning
            with heard() as interrupts:
                return self._guarded(ctx, interrupts)

    def _guarded(self, ctx: click.Context, interrupts: list[BaseException]) -> Any:
        try:
            result = super().invoke(ctx)
            sys.stdout.flush()  # a full device is told of here, and not by the interpreter's end
            return result
        except (click.ClickException, click.exceptions.Exit):
            raise
        except (click.Abort, KeyboardInterrupt):
            _fail(ctx, "interrupted", INTERRUPTED)
        except (VividcError, InternalError) as error:
            _print_traceback(error)
            _fail(ctx, str(error), error.exit_code)
        except BrokenPipeError:
            raise
        except MemoryError as error:
            _print_traceback(error)
            _fail(ctx, _no_memory(error), VividcError.exit_code)
        except OSError as error:
            if error.errno == errno.ENOSPC:
                _give_up_stdout(error)
            self._unforeseen(ctx, error, interrupts)
        except Exception as error:  # the outermost frame: whatever arrives here is a bug
            self._unforeseen(ctx, error, interrupts)

    def _unforeseen(
        self, ctx: click.Context, error: Exception, interrupts: list[BaseException]
    ) -> None:
        if interrupts:
            _fail(ctx, "interrupted", INTERRUPTED)
        _print_traceback(error)
        if any(text in str(error) for text in _NO_PROCESS):
            _fail(ctx, f"{_NO_PROCESS_MESSAGE}: {error}\n{_NO_PROCESS_HINT}", VividcError.exit_code)
        internal = InternalError(f"{type(error).__name__}: {error} ({_origin(error)})")
        _fail(ctx, str(internal), internal.exit_code)


def _no_memory(error: MemoryError) -> str:
    what = f": {error}" if str(error) else ""
    return f"not enough memory{what}\nhint: the input is too large for this computer, or damaged"


def _give_up_stdout(error: OSError) -> NoReturn:
    """Say that output was lost, and leave without flushing the buffer again."""
    say(f"vividc: standard output: {error.strerror}", err=True)
    with suppress(OSError):
        sys.stderr.flush()
    os._exit(VividcError.exit_code)


def _open_closed_streams() -> None:
    """What is printed to a stream that the shell closed (`>&-`) goes nowhere: files are written,
    and the exit code tells the rest.
    """
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115 - to the end


def _fail(ctx: click.Context, message: str, exit_code: int) -> None:
    say(f"vividc: {message}", err=True)
    ctx.exit(exit_code)


def _print_traceback(error: BaseException) -> None:
    if os.environ.get(_DEBUG) == "1":
        traceback.print_exception(error)


def _origin(error: BaseException) -> str:
    frames = traceback.extract_tb(error.__traceback__)
    place = f"{frames[-1].filename}:{frames[-1].lineno}" if frames else "unknown place"
    return f"at {place}; {_DEBUG}=1 shows the traceback"


def _show_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    say(f"vividc: warning: {message}", err=True)


_SETTINGS: Final = {"help_option_names": ["-h", "--help"], "show_default": True}


@click.command(cls=_Commands, context_settings=_SETTINGS)
@click.version_option(__version__, prog_name="vividc")
def main() -> None:
    """Compile kernels and dataflow graphs for a CGRA, and simulate them cycle by cycle."""


for _name, _help in _COMMANDS.items():
    main.add_command(_Later(_name, help=_help))
