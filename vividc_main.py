"""The script `vividc`: an interrupt while the modules load is one line and exit code 130.

Outside the package, because importing anything in it runs `vividc/__init__`, which loads
compilers and solvers for a second or more; `python -m vividc` begins there, and calls this first.
"""

import os
import signal
import sys
from types import FrameType

_INTERRUPTED = 130
_WRONG_INPUT = 2
_MOST = 300
_NUMBAS_SETTINGS = ".numba_config.yaml"


def _leave(_signal: int, _frame: FrameType | None) -> None:
    """End at once: an exception could be swallowed or dressed up by a module that is loading."""
    os.write(2, b"vividc: interrupted\n")
    os._exit(_INTERRUPTED)


def leave_on_interrupt() -> None:
    """From now until `main` has loaded all modules."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # else: ignored
        signal.signal(signal.SIGINT, _leave)


def main() -> None:
    """Run the command line."""
    leave_on_interrupt()
    try:
        from vividc.cli.main import main as command  # noqa: PLC0415 - under the handler
    except Exception as error:
        if not os.path.exists(_NUMBAS_SETTINGS):
            raise
        what = " ".join(f"{type(error).__name__}: {error}".split())[:_MOST]
        sys.stderr.write(f"vividc: {_NUMBAS_SETTINGS}: numba cannot read its settings: {what}\n")
        sys.stderr.write("hint: repair or remove the file; it is in the current folder\n")
        sys.exit(_WRONG_INPUT)

    if signal.getsignal(signal.SIGINT) is _leave:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    command(prog_name="vividc")
