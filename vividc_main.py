"""The script `vividc`, and how modules load: an interrupt meanwhile is one line and exit code 130.

Outside the package, so that nothing is loaded before it says so.
"""

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

_INTERRUPTED = 130
_WRONG_INPUT = 2
_MOST = 300
_NUMBAS_SETTINGS = ".numba_config.yaml"


def _leave(_signal: int, _frame: FrameType | None) -> None:
    """End at once: an exception could be swallowed or dressed up by a module that is loading."""
    os.write(2, b"vividc: interrupted\n")
    os._exit(_INTERRUPTED)


@contextmanager
def loading() -> Iterator[None]:
    """Around imports of a command's modules: of the commands, not of what they run later."""
    before = signal.getsignal(signal.SIGINT)
    if before is signal.default_int_handler:  # else: ignored
        signal.signal(signal.SIGINT, _leave)
    try:
        yield
    except Exception as error:
        if not os.path.exists(_NUMBAS_SETTINGS):
            raise
        what = " ".join(f"{type(error).__name__}: {error}".split())[:_MOST]
        sys.stderr.write(f"vividc: {_NUMBAS_SETTINGS}: numba cannot read its settings: {what}\n")
        sys.stderr.write("hint: repair or remove the file; it is in the current folder\n")
        sys.exit(_WRONG_INPUT)
    finally:
        if signal.getsignal(signal.SIGINT) is _leave:
            signal.signal(signal.SIGINT, signal.default_int_handler)


def main() -> None:
    """Run the command line."""
    with loading():
        from vividc.cli.main import main as command  # noqa: PLC0415 - under the handler
    command(prog_name="vividc")
