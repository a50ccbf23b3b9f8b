"""The `vividc` command: finds its sub-commands, turns every error into a message and an exit code.

Exit codes: 0 done, 1 internal error, 2 wrong usage or input, 3 proved infeasible, 4 time limit,
5 mismatch against the reference, 130 interrupted.
"""

from __future__ import annotations

import importlib
import os
import traceback
import warnings
from typing import Any, Final, TextIO

import click

from vividc.errors import InternalError, VividcError

INTERRUPTED: Final = 130
_COMMANDS: Final = {
    "compile": "Compile a kernel for a fabric and write the program.",
    "simulate": "Run a program on the machine, cycle by cycle.",
    "map": "Map a dataflow graph and say what was proved.",
    "disasm": "Print what each PE does in each context of a program.",
}
_DEBUG: Final = "VIVIDC_DEBUG"


class _Commands(click.Group):
    """Imports a command when it is asked for: `--help` waits for no compiler and no solver."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(_COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in _COMMANDS:
            return None
        command = importlib.import_module(f"vividc.cli.{cmd_name}_command").command
        assert isinstance(command, click.Command)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(_COMMANDS.items()))

    def invoke(self, ctx: click.Context) -> Any:
        with warnings.catch_warnings():
            warnings.simplefilter("default")
            warnings.showwarning = _show_warning
            return self._guarded(ctx)

    def _guarded(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except (click.ClickException, click.exceptions.Exit):
            raise
        except (click.Abort, KeyboardInterrupt):
            _fail(ctx, "interrupted", INTERRUPTED)
        except (VividcError, InternalError) as error:
            _print_traceback(error)
            _fail(ctx, str(error), error.exit_code)
        except BrokenPipeError:
            raise
        except Exception as error:  # the outermost frame: whatever arrives here is a bug
            _print_traceback(error)
            internal = InternalError(f"{type(error).__name__}: {error} ({_origin(error)})")
            _fail(ctx, str(internal), internal.exit_code)


def _fail(ctx: click.Context, message: str, exit_code: int) -> None:
    click.echo(f"vividc: {message}", err=True)
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
    click.echo(f"vividc: warning: {message}", err=True)


@click.command(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="vividc", prog_name="vividc")
def main() -> None:
    """Compile kernels and dataflow graphs for a CGRA, and simulate them cycle by cycle."""
